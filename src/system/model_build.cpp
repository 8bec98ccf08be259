#include "model_build.hpp"
#include "model_assembly.hpp"

#include <fmt/format.h>

#include <set>

#include "voile/base/error.hpp"

namespace voile::system {

namespace {

/// Ring fits reach at most this many rings of vertices beyond a triangle's neighbours.
constexpr int reach = 5;

/// Triangles within `reach` rings of a vertex that this rank owns.
std::vector<char> candidate_triangles(const mesh::SurfaceMesh& mesh, const std::vector<int>& vertex_rank, int rank) {
  std::vector<char> vertex(vertex_rank.size()), triangle(static_cast<std::size_t>(mesh.triangle_count()), 0);
  for (std::size_t v = 0; v < vertex.size(); ++v) vertex[v] = vertex_rank[v] == rank;
  for (int ring = 0; ring < reach; ++ring) {
    std::vector<char> grown = vertex;
    for (Index t = 0; t < mesh.triangle_count(); ++t) {
      const mesh::Triangle& v = mesh.triangles()[t];
      if (!vertex[v[0]] && !vertex[v[1]] && !vertex[v[2]]) continue;
      triangle[t] = 1;
      for (Index i : v) grown[i] = 1;
    }
    vertex.swap(grown);
  }
  return triangle;
}

/// Vertices whose unknowns a set of mesh points depends on, ascending.
template <class Points>
std::vector<Index> vertices_of(const mesh::PatchMesh& patches, const Points& points) {
  std::vector<Index> v;
  for (Index p : points) {
    if (patches.is_mirror(p)) {
      const mesh::MirrorPoint& m = patches.mirror(p);
      v.insert(v.end(), {m.apex, m.a, m.b});
    } else {
      v.push_back(p);
    }
  }
  std::sort(v.begin(), v.end());
  v.erase(std::unique(v.begin(), v.end()), v.end());
  return v;
}

/// Points of all elements of a triangle: the bending stencil and the membrane's.
std::vector<Index> stencil_points(const energy::Sheet& sheet, Index t, const energy::CurvatureOperator& op) {
  std::vector<Index> points = op.points;
  for (Index p : energy::MembraneTerm::stencil_of(sheet, t)) points.push_back(p);
  return points;
}

}  // namespace

Model::Model(MPI_Comm comm, const mesh::SurfaceMesh& mesh, ModelInput input)
    : comm_(comm),
      mesh_(&mesh),
      rank_(mpi::rank(comm)),
      materials_(std::move(input.materials)),
      supports_(std::move(input.supports)) {
  partition_ = mesh::make_partition(comm, mesh);
  Build build;
  mpi::on_all(comm, [&] {
    constraints_ = resolve_supports(mesh, supports_);
    patches_ = std::make_unique<mesh::PatchMesh>(mesh, constraints_.mirrors);
    sheet_ = std::make_unique<energy::Sheet>(*patches_, materials_, energy::assign_materials(mesh, materials_),
                                             input.element);
    number_points(build);
  });
  BlockPattern pattern;
  mpi::on_all(comm, [&] { pattern = make_pattern(build); });
  bending_ = BlockMatrix(comm, partition_, std::move(pattern));
  tangent_ = bending_.twin();
  membrane_.term = energy::MembraneTerm(*sheet_);
  mpi::on_all(comm, [&] { add_elements(build); });
  assemble_bending(build, input.springs);
  make_vectors();
  eliminated_ = base_eliminated_ = find_eliminated_entries(tangent_);
  build_mass(input.masses);
  mpi::on_all(comm, [&] { build_loads(input.loads, input.masses); });
  VOILE_PETSC(VecAssemblyBegin(dead_));
  VOILE_PETSC(VecAssemblyEnd(dead_));
  VOILE_PETSC(VecAssemblyBegin(constant_));
  VOILE_PETSC(VecAssemblyEnd(constant_));
  VOILE_PETSC(VecDuplicate(constant_, always_.out()));
  VOILE_PETSC(VecCopy(constant_, always_));
  locate(followers_);
  if (input.contact.active)
    mpi::on_all(comm, [&] {
      contact_ = std::make_unique<Contact>(comm, mesh, partition_, constraints_, std::move(input.contact));
    });
  for (BlockMatrix* m : {&bending_, &tangent_})
    VOILE_PETSC(MatSetOption(m->mat(), MAT_SYMMETRIC, m == &bending_ || symmetric() ? PETSC_TRUE : PETSC_FALSE));
  VOILE_PETSC(MatSetOption(tangent_.mat(), MAT_SYMMETRY_ETERNAL, symmetric() ? PETSC_TRUE : PETSC_FALSE));
}

Model::~Model() = default;

void Model::number_points(Build& build) {
  const std::vector<char> candidate = candidate_triangles(*mesh_, partition_.vertex_rank, rank_);
  energy::CurvatureBuilder curvature(*sheet_);
  std::vector<char> needed(static_cast<std::size_t>(patches_->point_count()), 0);
  for (Index t = 0; t < mesh_->triangle_count(); ++t) {
    if (!candidate[t]) continue;
    energy::CurvatureOperator op = curvature.build(t);
    const std::vector<Index> points = stencil_points(*sheet_, t, op);
    const std::vector<Index> vertices = vertices_of(*patches_, points);
    const bool touches =
        std::any_of(vertices.begin(), vertices.end(), [&](Index v) { return partition_.vertex_rank[v] == rank_; });
    // The owner of a triangle recovers its stresses even where none of its rows are its own.
    if (!touches && partition_.triangle_rank[t] != rank_) continue;
    for (Index p : points) needed[p] = 1;
    for (Index v : vertices) needed[v] = 1;
    build.items.push_back({t, std::move(op)});
  }
  local_of_.assign(needed.size(), no_index);
  const auto append = [&](Index point) {
    local_of_[point] = static_cast<Index>(point_of_.size());
    point_of_.push_back(point);
    rest_.push_back(patches_->rest(point));
  };
  owned_ = partition_.owned_count(rank_);
  for (Index r = 0; r < owned_; ++r) append(partition_.vertex_of[partition_.owned_begin(rank_) + r]);
  for (Index v = 0; v < mesh_->vertex_count(); ++v)
    if (needed[v] && local_of_[v] == no_index) append(v);
  local_vertices_ = static_cast<Index>(point_of_.size());
  for (Index p = mesh_->vertex_count(); p < patches_->point_count(); ++p)
    if (needed[p]) {
      append(p);
      const mesh::MirrorPoint& m = patches_->mirror(p);
      mirrors_.push_back({local_of_[m.apex], local_of_[m.a], local_of_[m.b], m.foot, m.reflection});
    }
  rotated_index_.assign(static_cast<std::size_t>(local_vertices_), no_index);
  for (Index i = 0; i < local_vertices_; ++i) {
    row_of_local_.push_back(partition_.row_of[point_of_[i]]);
    const auto support = constraints_.vertices.find(point_of_[i]);
    if (support == constraints_.vertices.end() || !support->second.rotated()) continue;
    rotated_index_[i] = static_cast<Index>(rotated_.size());
    rotated_.emplace_back(i, support->second.axes);
  }
}

BlockPattern Model::make_pattern(const Build& build) const {
  BlockPattern pattern(static_cast<std::size_t>(owned_));
  const auto tidy = [](std::vector<Index>& row) {
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
  };
  for (Index i = 0; i < owned_; ++i) pattern[i].push_back(row_of_local_[i]);
  for (const Build::Item& item : build.items) {
    const std::vector<Index> vertices = vertices_of(*patches_, stencil_points(*sheet_, item.triangle, item.curvature));
    for (Index v : vertices) {
      const Index local = local_of_[v];
      if (local >= owned_) continue;
      std::vector<Index>& row = pattern[local];
      for (Index w : vertices) row.push_back(partition_.row_of[w]);
      if (row.size() > 400) tidy(row);
    }
  }
  for (auto& row : pattern) tidy(row);
  return pattern;
}

void Model::add_elements(Build& build) {
  const auto to_local = [&](const auto& points, auto& local) {
    std::transform(points.begin(), points.end(), local.begin(), [&](Index p) { return local_of_[p]; });
  };
  for (Build::Item& item : build.items) {
    const bool owned = partition_.triangle_rank[item.triangle] == rank_;
    std::array<Index, energy::MembraneTerm::nodes> stencil{};
    to_local(energy::MembraneTerm::stencil_of(*sheet_, item.triangle), stencil);
    membrane_.term.add(*sheet_, item.triangle, stencil, owned);
    membrane_triangle_.push_back(item.triangle);
    const energy::BendingElement el = energy::make_bending_element(*sheet_, item.triangle, item.curvature);
    std::vector<Index> local(el.points.size());
    to_local(el.points, local);
    if (el.coupling.size() > 0) curved_.term.add(el, local, owned);
    if (!owned) continue;
    recovery_.push_back({item.triangle, recovery_points_.size(), static_cast<int>(local.size()), el.rest_curvature});
    for (std::size_t i = 0; i < local.size(); ++i) {
      recovery_points_.push_back(local[i]);
      recovery_weights_.push_back(el.operator_.col(static_cast<Eigen::Index>(i)));
    }
  }
  force_.resize(point_of_.size());
  locate(membrane_);
  locate(curved_);
}

void Model::assemble_bending(Build& build, const std::vector<Spring>& springs) {
  const petsc::EventScope scope(petsc::events().bending_assemble);
  if (std::any_of(materials_.begin(), materials_.end(), [](const auto& m) { return m.bending_damping > 0.0; }))
    damping_ = bending_.twin();
  const BlockMatrix::Values values = bending_.open();
  std::optional<BlockMatrix::Values> damping;
  if (damping_) damping.emplace(damping_->open());
  mpi::on_all(comm_, [&] {
    for (const Build::Item& item : build.items) {
      const energy::BendingElement el = energy::make_bending_element(*sheet_, item.triangle, item.curvature);
      const double own_damping = sheet_->material(item.triangle).bending_damping;
      for (std::size_t i = 0; i < el.points.size(); ++i)
        for (std::size_t j = 0; j < el.points.size(); ++j) {
          const Index p = local_of_[el.points[i]], q = local_of_[el.points[j]];
          const Mat3 block =
              el.stiffness(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) * Mat3::Identity();
          add_special(p, q, block, values);
          if (own_damping > 0.0) add_special(p, q, own_damping * block, *damping);
        }
    }
    any_spring_ = !springs.empty();
    add_springs(springs, values);
  });
  bending_.close();
  if (damping_) damping_->close();
  build.items.clear();
}

void Model::make_vectors() {
  VOILE_PETSC(VecCreateMPI(comm_, 3 * owned_, PETSC_DETERMINE, work_.out()));
  VOILE_PETSC(VecSetBlockSize(work_, 3));
  for (petsc::VecHandle* v :
       {&mass_, &dead_, &constant_, &sum_, &reference_, &coupling_, &load_coupling_, &prescribed_, &motion_}) {
    VOILE_PETSC(VecDuplicate(work_, v->out()));
    VOILE_PETSC(VecZeroEntries(*v));
  }
  VOILE_PETSC(VecCreateSeq(PETSC_COMM_SELF, 3 * local_vertices_, local_vector_.out()));
  petsc::IndexSetHandle from, to;
  VOILE_PETSC(ISCreateBlock(PETSC_COMM_SELF, 3, local_vertices_, row_of_local_.data(), PETSC_COPY_VALUES, from.out()));
  VOILE_PETSC(ISCreateStride(PETSC_COMM_SELF, 3 * local_vertices_, 0, 1, to.out()));
  VOILE_PETSC(VecScatterCreate(work_, from, local_vector_, to, scatter_.out()));
  for (auto* v : {&u_, &x_, &previous_u_, &previous_x_}) v->resize(point_of_.size());
  const petsc::WriteArray prescribed(prescribed_);
  for (Index i = 0; i < owned_; ++i) {
    const auto support = constraints_.vertices.find(point_of_[i]);
    if (support == constraints_.vertices.end()) continue;
    if (support->second.motion >= 0) movers_.push_back({i, support->second.motion});
    for (int k = 0; k < 3; ++k)
      if (support->second.fixed[k]) {
        fixed_.push_back(3 * i + k);
        prescribed[3 * i + k] = support->second.value[k];
      }
  }
  for (const auto& [v, support] : constraints_.vertices)
    has_prescribed_ |= support.value.squaredNorm() > 0.0 || support.motion >= 0;
}

Model::Eliminated Model::find_eliminated_entries(const BlockMatrix& matrix) const {
  Eliminated e;
  std::vector<char> fixed(3 * static_cast<std::size_t>(mesh_->vertex_count()), 0);
  for (const auto& [v, support] : constraints_.vertices)
    for (int k = 0; k < 3; ++k) fixed[3 * partition_.row_of[v] + k] = support.fixed[k];
  matrix.for_each_entry([&](bool inside, Index at, Index row, Index column) {
    if (!fixed[row] && !fixed[column]) return;
    if (row == column)
      e.unit.push_back(at);
    else
      (inside ? e.diagonal : e.off_diagonal).push_back(at);
  });
  return e;
}

void Model::build_mass(const std::vector<PointMass>& masses) {
  {
    const petsc::WriteArray mass(mass_);
    for (Index t = 0; t < mesh_->triangle_count(); ++t) {
      const double area = mesh_->area(t), density = sheet_->material(t).areal_density;
      total_area_ += area;
      for (Index v : mesh_->triangles()[t]) {
        const Index i = local_of_[v];
        if (i == no_index || i >= owned_) continue;
        for (int k = 0; k < 3; ++k) mass[3 * i + k] += (density > 0.0 ? density : 1.0) * area / 3.0;
      }
    }
  }
  mpi::on_all(comm_, [&] {
    const petsc::WriteArray mass(mass_);
    for (const PointMass& m : masses)
      for (Index v : mesh_->group(m.group).vertices) {
        const Index i = local_of_[v];
        if (i == no_index || i >= owned_) continue;
        for (int k = 0; k < 3; ++k) mass[3 * i + k] += m.mass;
        masses_.emplace_back(i, m.mass);
      }
  });
  const Index first = partition_.owned_begin(rank_);
  for (Index i = 0; i < owned_; ++i) mass_slots_.push_back(tangent_.slot(i, first + i));
}

}  // namespace voile::system
