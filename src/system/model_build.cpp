#include "model_build.hpp"

#include <fmt/format.h>

#include <cmath>
#include <set>

#include "voile/base/error.hpp"
#include "voile/base/mpi.hpp"

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
    : mesh_(&mesh),
      rank_(mpi::rank(comm)),
      materials_(std::move(input.materials)),
      supports_(std::move(input.supports)),
      motion_by_load_(input.motion_by_load),
      turns_now_(supports_.size(), Mat3::Identity()) {
  partition_ = mesh::make_partition(comm, mesh);
  Build build;
  std::vector<char> needed;
  mpi::on_all(comm, [&] {
    constraints_ = resolve_supports(mesh, supports_);
    patches_ = std::make_unique<mesh::PatchMesh>(mesh, constraints_.mirrors);
    sheet_ = std::make_unique<energy::Sheet>(*patches_, materials_, energy::assign_materials(mesh, materials_),
                                             input.element);
    needed = find_elements(build, input.springs);
  });
  dofs_ = std::make_unique<Dofs>(comm, *patches_, partition_, constraints_, needed);
  BlockPattern pattern;
  mpi::on_all(comm, [&] {
    build_terms(build, input.springs);
    pattern = make_pattern(build);
  });
  bending_ = BlockMatrix(comm, partition_, std::move(pattern));
  tangent_ = bending_.twin();
  assemble_bending(build, input.springs);
  make_vectors();
  close_start();
  if (turns_) {
    steady_bending_ = bending_.twin();
    (void)steady_bending_.open();
    steady_bending_.copy_values_from(bending_);
    steady_bending_.close();
    assemble_turning();
  }
  eliminated_ = base_eliminated_ = find_eliminated_entries(tangent_);
  build_mass(input.masses);
  mpi::on_all(comm, [&] { build_loads(input.loads, input.masses); });
  VOILE_PETSC(VecAssemblyBegin(dead_));
  VOILE_PETSC(VecAssemblyEnd(dead_));
  VOILE_PETSC(VecAssemblyBegin(constant_));
  VOILE_PETSC(VecAssemblyEnd(constant_));
  VOILE_PETSC(VecDuplicate(constant_, always_.out()));
  VOILE_PETSC(VecCopy(constant_, always_));
  if (input.contact.active)
    mpi::on_all(comm, [&] { contact_ = std::make_unique<Contact>(*dofs_, std::move(input.contact)); });
  for (BlockMatrix* m : {&bending_, &tangent_})
    VOILE_PETSC(MatSetOption(m->mat(), MAT_SYMMETRIC, m == &bending_ || symmetric() ? PETSC_TRUE : PETSC_FALSE));
  VOILE_PETSC(MatSetOption(tangent_.mat(), MAT_SYMMETRY_ETERNAL, symmetric() ? PETSC_TRUE : PETSC_FALSE));
}

Model::~Model() = default;

/// The elements of this rank, and the points that they use.
std::vector<char> Model::find_elements(Build& build, const std::vector<Spring>& springs) {
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
  for (const Spring& spring : springs)
    for (const auto& [v, w] : pairs_of(*mesh_, spring))
      if (partition_.vertex_rank[v] == rank_ || partition_.vertex_rank[w] == rank_) needed[v] = needed[w] = 1;
  return needed;
}

template <class Kernel>
ElementTerm<Kernel>& Model::add_term(double Energies::*part) {
  auto term = std::make_unique<ElementTerm<Kernel>>();
  ElementTerm<Kernel>& reference = *term;
  terms_.push_back({std::move(term), part});
  return reference;
}

/// Here a new term joins the potential.
void Model::build_terms(Build& build, const std::vector<Spring>& springs) {
  membrane_ = &add_term<energy::MembraneTerm>(&Energies::membrane);
  membrane_->kernel = energy::MembraneTerm(*sheet_);
  auto& curved = add_term<energy::CurvedBendingTerm>(&Energies::bending);
  const std::vector<Index>& local_of = dofs_->local().local_of;
  const auto to_local = [&](const auto& points, auto& local) {
    std::transform(points.begin(), points.end(), local.begin(), [&](Index p) { return local_of[p]; });
  };
  for (Build::Item& item : build.items) {
    const bool owned = partition_.triangle_rank[item.triangle] == rank_;
    std::array<Index, energy::MembraneTerm::nodes> stencil{};
    to_local(energy::MembraneTerm::stencil_of(*sheet_, item.triangle), stencil);
    membrane_->kernel.add(*sheet_, item.triangle, stencil, owned);
    elements_.push_back({item.triangle, {stencil[0], stencil[1], stencil[2]}, owned});
    const energy::BendingElement el = energy::make_bending_element(*sheet_, item.triangle, item.curvature);
    std::vector<Index> local(el.points.size());
    to_local(el.points, local);
    if (el.coupling.size() > 0) curved.kernel.add(el, local, owned);
    if (owned) recovery_.add(item.triangle, el, local, membrane_->kernel.size() - 1);
  }
  auto& ties = add_term<energy::SpringTerm>(&Energies::springs);
  for (const Spring& spring : springs) tie(spring, ties);
  for (auto* v : {&u_, &x_, &previous_u_, &previous_x_, &force_})
    v->assign(static_cast<std::size_t>(dofs_->local().count()), Vec3::Zero());
}

void Model::tie(const Spring& spring, ElementTerm<energy::SpringTerm>& ties) const {
  const LocalPoints& local = dofs_->local();
  for (const auto& [v, w] : pairs_of(*mesh_, spring)) {
    if (owned(v) == no_index && owned(w) == no_index) continue;
    const double length =
        std::isnan(spring.length) ? (mesh_->positions()[w] - mesh_->positions()[v]).norm() : spring.length;
    ties.kernel.add({local.local_of[v], local.local_of[w]}, spring.stiffness, length, owned(v) != no_index);
  }
}

BlockPattern Model::make_pattern(const Build& build) const {
  const LocalPoints& local = dofs_->local();
  BlockPattern pattern(static_cast<std::size_t>(local.owned));
  const auto tidy = [](std::vector<Index>& row) {
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
  };
  for (Index i = 0; i < local.owned; ++i) pattern[i].push_back(local.row_of[i]);
  const auto couple = [&](const std::vector<Index>& vertices) {
    for (Index v : vertices) {
      if (owned(v) == no_index) continue;
      std::vector<Index>& row = pattern[owned(v)];
      for (Index w : vertices) row.push_back(partition_.row_of[w]);
      if (row.size() > 400) tidy(row);
    }
  };
  for (const Build::Item& item : build.items)
    couple(vertices_of(*patches_, stencil_points(*sheet_, item.triangle, item.curvature)));
  for (const Counted& t : terms_)
    t.term->for_stencils([&](const Index* points, int count) {
      std::vector<Index> of(static_cast<std::size_t>(count));
      std::transform(points, points + count, of.begin(), [&](Index p) { return local.point_of[p]; });
      couple(vertices_of(*patches_, of));
    });
  for (auto& row : pattern) tidy(row);
  return pattern;
}

void Model::assemble_bending(Build& build, const std::vector<Spring>& springs) {
  const petsc::EventScope scope(petsc::events().bending_assemble);
  const std::vector<Index>& local_of = dofs_->local().local_of;
  if (std::any_of(materials_.begin(), materials_.end(), [](const auto& m) { return m.bending_damping > 0.0; }))
    damping_ = bending_.twin();
  const BlockMatrix::Values values = bending_.open();
  std::optional<BlockMatrix::Values> damping;
  if (damping_) damping.emplace(damping_->open());
  const auto is_turned = [&](Index p) {
    return patches_->is_mirror(p) && constraints_.turned_by[p - mesh_->vertex_count()] >= 0;
  };
  mpi::on_all(comm(), [&] {
    for (const Build::Item& item : build.items) {
      const energy::BendingElement el = energy::make_bending_element(*sheet_, item.triangle, item.curvature);
      const bool owned = partition_.triangle_rank[item.triangle] == rank_;
      if (std::any_of(el.points.begin(), el.points.end(), is_turned)) {  // without damping of their own
        TurningElement& turning = turning_.emplace_back();
        for (Index p : el.points) turning.points.push_back(local_of[p]);
        turning.stiffness = el.stiffness;
        turning.start_force = el.start_force;
        turning.owned = owned;
        if (owned) steady_offset_ += 2.0 * el.start_energy;
        continue;
      }
      take_start(el, owned);
      const double own_damping = sheet_->material(item.triangle).bending_damping;
      for (std::size_t i = 0; i < el.points.size(); ++i)
        for (std::size_t j = 0; j < el.points.size(); ++j) {
          const Index p = local_of[el.points[i]], q = local_of[el.points[j]];
          const Mat3 block =
              el.stiffness(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) * Mat3::Identity();
          add_block(*dofs_, bending_, p, q, block, values);
          if (own_damping > 0.0) add_block(*dofs_, *damping_, p, q, own_damping * block, *damping);
        }
    }
    any_spring_ = !springs.empty();
    add_springs(springs, values);
  });
  bending_.close();
  if (damping_) damping_->close();
  turns_ = std::any_of(constraints_.turned_by.begin(), constraints_.turned_by.end(), [](int s) { return s >= 0; });
  build.items.clear();
}

/// Collects what a bent start adds to the constant force and energy of bending.
void Model::take_start(const energy::BendingElement& element, bool owned) {
  for (Eigen::Index i = 0; i < element.start_force.rows(); ++i)
    force_[dofs_->local().local_of[element.points[static_cast<std::size_t>(i)]]] +=
        element.start_force.row(i).transpose();
  if (owned) steady_offset_ += 2.0 * element.start_energy;
}

void Model::close_start() {
  dofs_->add_forces(force_, steady_force_);
  VOILE_PETSC(VecCopy(steady_force_, bending_force_));
  steady_offset_ = bending_offset_ = mpi::sum(comm(), steady_offset_);
  count_energy_from(reference_);
}

void Model::make_vectors() {
  for (petsc::VecHandle* v : {&work_, &mass_, &dead_, &constant_, &sum_, &reference_, &coupling_, &load_coupling_,
                              &prescribed_, &motion_, &hold_, &steady_force_, &bending_force_})
    *v = dofs_->create_vector();
  const LocalPoints& local = dofs_->local();
  const petsc::WriteArray prescribed(prescribed_);
  for (Index i = 0; i < local.owned; ++i) {
    const auto support = constraints_.vertices.find(local.point_of[i]);
    if (support == constraints_.vertices.end()) continue;
    if (support->second.motion >= 0) movers_.push_back({i, support->second.motion});
    for (int k = 0; k < 3; ++k)
      if (support->second.fixed[k]) prescribed[3 * i + k] = support->second.value[k];
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
        const Index i = owned(v);
        if (i == no_index) continue;
        for (int k = 0; k < 3; ++k) mass[3 * i + k] += (density > 0.0 ? density : 1.0) * area / 3.0;
      }
    }
  }
  mpi::on_all(comm(), [&] {
    const petsc::WriteArray mass(mass_);
    for (const PointMass& m : masses)
      for (Index v : mesh_->group(m.group).vertices) {
        const Index i = owned(v);
        if (i == no_index) continue;
        for (int k = 0; k < 3; ++k) mass[3 * i + k] += m.mass;
        masses_.emplace_back(i, m.mass);
      }
  });
  for (Index i = 0; i < dofs_->local().owned; ++i) mass_slots_.push_back(tangent_.slot(i, dofs_->first_row() + i));
}

}  // namespace voile::system
