#include "discretisation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>

#include "base/mpi.hpp"
#include "energy/bulge.hpp"
#include "energy/curvature.hpp"
#include "energy/joint.hpp"
#include "energy/membrane.hpp"
#include "energy/notches.hpp"
#include "energy/sheet.hpp"
#include "hinges.hpp"
#include "mesh/patch.hpp"
#include "voile/errors.hpp"

namespace voile::system {

namespace {

/// Ring fits reach at most this many rings of vertices beyond a triangle's neighbours.
constexpr int reach = 5;

/// Triangles within `reach` rings of a vertex that this rank owns, also across the period of `ties`.
std::vector<char> candidate_triangles(const mesh::SurfaceMesh& mesh, const std::vector<int>& vertex_rank, int rank,
                                      const Ties& ties) {
  std::vector<char> vertex(vertex_rank.size()), triangle(static_cast<std::size_t>(mesh.triangle_count()), 0);
  for (std::size_t v = 0; v < vertex.size(); ++v) vertex[v] = vertex_rank[v] == rank;
  ties.spread(vertex);
  for (int ring = 0; ring < reach; ++ring) {
    std::vector<char> grown = vertex;
    for (Index t = 0; t < mesh.triangle_count(); ++t) {
      const mesh::Triangle& v = mesh.triangles()[t];
      if (!vertex[v[0]] && !vertex[v[1]] && !vertex[v[2]]) continue;
      triangle[t] = 1;
      for (Index i : v) grown[i] = 1;
    }
    vertex.swap(grown);
    ties.spread(vertex);
  }
  return triangle;
}

/// Per triangle, another number where other groups of temperatures are; empty if all hold everywhere.
std::vector<int> heated_zones(const mesh::SurfaceMesh& mesh, const std::vector<Temperature>& temperatures) {
  std::map<std::pair<int, std::size_t>, int> numbers;
  std::vector<int> zones;
  for (std::size_t k = 0; k < temperatures.size(); ++k) {
    if (temperatures[k].group.empty() || !temperatures[k].change.value) continue;
    zones.resize(static_cast<std::size_t>(mesh.triangle_count()), 0);
    for (const Index t : mesh.group(temperatures[k].group, 2).triangles) {
      int& zone = zones[static_cast<std::size_t>(t)];
      zone = numbers.try_emplace({zone, k}, static_cast<int>(numbers.size()) + 1).first->second;
    }
  }
  return zones;
}

}  // namespace

std::vector<Index> vertices_of(const mesh::PatchMesh& patches, const std::vector<Index>& points) {
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

std::vector<Index> stencil_points(const energy::Sheet& sheet, Index t, const energy::CurvatureOperator& op) {
  std::vector<Index> points = op.points;
  for (Index p : energy::MembraneTerm::stencil_of(sheet, t)) points.push_back(p);
  return points;
}

Discretisation::Discretisation(MPI_Comm comm, const mesh::SurfaceMesh& mesh, std::vector<energy::Material> materials,
                               const std::vector<Support>& supports, const Couplings& couplings,
                               const energy::ElementOptions& options, const Seams& seams,
                               const std::vector<RigidGroup>& rigid, const std::vector<PeriodicPair>& periodic)
    : mesh_(&mesh),
      rank_(mpi::rank(comm)),
      materials_(std::move(materials)),
      partition_(mesh::make_partition(comm, mesh)) {
  std::vector<char> needed;
  mpi::on_all(comm, [&] {
    constraints_ = resolve_supports(mesh, supports);
    prepare_bodies(rigid);
    resolve_periodic(mesh, periodic, supports, constraints_);
    make_patches();
    drawn_in_ = gathered_sheet(gathers(mesh, seams));
    if (std::vector<mesh::Gather> welded = gathers(mesh, {seams.rules, {}}); !drawn_in_.seams.empty()) {
      before_ = gathered_sheet(welded);
      draws_in_ = before_.seams != drawn_in_.seams;
    }
    std::vector<int> material_of = energy::assign_materials(mesh, materials_);
    add_allowances(mesh, seams.rules, materials_, material_of);
    sheet_ = std::make_unique<energy::Sheet>(sheet_patches(), materials_, std::move(material_of), options,
                                             bending_across_seams(mesh, seams.rules),
                                             heated_zones(mesh, couplings.temperatures));
    if (own_patches_) continue_sheet(options, couplings.temperatures);
    find_notches();
    joint_factors_ = bending_of_joints(mesh, seams.rules);
    needed = find_elements(couplings);
  });
  dofs_ = std::make_unique<Dofs>(comm, *patches_, partition_, constraints_, needed);
  for (Element& e : elements_)
    for (std::size_t i = 0; i < 3; ++i) e.points[i] = dofs_->local().local_of[mesh.triangles()[e.triangle][i]];
}

void Discretisation::make_patches() {
  auto own = std::make_unique<mesh::PatchMesh>(*mesh_, constraints_.mirrors);
  if (!constraints_.ties.any()) {
    patches_ = std::move(own);
    return;
  }
  own_patches_ = std::move(own);
  const mesh::ContinuedSurface& beyond = *constraints_.ties.sheet;
  patches_ = std::make_unique<mesh::PatchMesh>(*beyond.surface,
                                               continued_mirrors(beyond, constraints_.mirrors, constraints_.turned_by));
}

void Discretisation::continue_sheet(const energy::ElementOptions& options,
                                    const std::vector<Temperature>& temperatures) {
  const mesh::SurfaceMesh& mesh = patches_->mesh();
  continued_ =
      std::make_unique<energy::Sheet>(*patches_, materials_, energy::assign_materials(mesh, materials_), options,
                                      std::vector<energy::BendingSide>{}, heated_zones(mesh, temperatures));
}

void Discretisation::find_notches() {
  std::vector<Index> root;
  if (constraints_.ties.any()) {
    const std::vector<Index>& of = constraints_.ties.sheet->root;
    root.assign(of.begin(), of.begin() + mesh_->vertex_count());
  }
  std::vector<char> near = energy::near_notches(*sheet_, root);
  if (near.empty()) return;
  if (continued_) {
    std::vector<char> beyond;
    for (const Index t : constraints_.ties.sheet->original) beyond.push_back(near[static_cast<std::size_t>(t)]);
    continued_->set_notches(std::move(beyond));
  }
  sheet_->set_notches(std::move(near));
}

Discretisation::GatheredSheet Discretisation::gathered_sheet(const std::vector<mesh::Gather>& seams) const {
  GatheredSheet sheet;
  std::optional<mesh::Gathered> gathered = mesh::gathered(*mesh_, seams);
  if (!gathered) return sheet;
  sheet.seams = std::move(gathered->seams);
  sheet.mesh = std::make_unique<mesh::SurfaceMesh>(std::move(gathered->mesh));
  sheet.patches = std::make_unique<mesh::PatchMesh>(*sheet.mesh, constraints_.mirrors);
  return sheet;
}

double Discretisation::mean_area() const {
  double area = 0.0;
  for (Index t = 0; t < mesh_->triangle_count(); ++t) area += mesh_->area(t);
  return area / mesh_->triangle_count();
}

Discretisation::~Discretisation() = default;

energy::Bulge Discretisation::bulge(std::size_t k, const mesh::Triangle& corners) const {
  energy::Bulge bulge = energy::make_bulge(element_sheet(), elements_[k].triangle, corners, curvatures_.at(k));
  for (Index& p : bulge.points) p = dofs_->local().local_of[p];
  return bulge;
}

std::vector<energy::CurvatureOperator> Discretisation::take_curvatures() {
  return std::move(curvatures_);
}

Discretisation::Joints Discretisation::take_joints() {
  return std::move(joints_);
}

void Discretisation::prepare_bodies(const std::vector<RigidGroup>& rigid) {
  if (rigid.empty()) return;
  resolve_rigid_groups(*mesh_, rigid, constraints_);
  body_of_.assign(static_cast<std::size_t>(mesh_->vertex_count()), no_index);
  double membrane = 0.0;
  for (const energy::Material& m : materials_) membrane = std::max(membrane, m.membrane(0, 0));
  for (std::size_t b = 0; b < constraints_.bodies.size(); ++b) {
    constraints_.bodies[b].stiffness = membrane;
    for (const Index v : constraints_.bodies[b].members) body_of_[v] = static_cast<Index>(b);
  }
}

std::vector<Index> Discretisation::unknowns_of(const std::vector<Index>& points) const {
  if (constraints_.ties.any()) return constraints_.ties.unknowns_of(vertices_of(*patches_, points));
  if (body_of_.empty()) return vertices_of(*patches_, points);
  std::vector<Index> plain, unknowns;
  std::vector<char> bodies(constraints_.bodies.size(), 0);
  for (const Index p : points)
    if (p >= patches_->point_count())
      bodies[static_cast<std::size_t>((p - patches_->point_count()) / RigidBody::frame_points)] = 1;
    else
      plain.push_back(p);
  for (const Index v : vertices_of(*patches_, plain))
    if (body_of_[v] != no_index)
      bodies[static_cast<std::size_t>(body_of_[v])] = 1;
    else
      unknowns.push_back(v);
  for (std::size_t b = 0; b < bodies.size(); ++b)
    if (bodies[b])
      unknowns.insert(unknowns.end(), constraints_.bodies[b].carriers.begin(), constraints_.bodies[b].carriers.end());
  std::sort(unknowns.begin(), unknowns.end());
  return unknowns;
}

bool Discretisation::is_on_body(const std::vector<Index>& points) const {
  if (body_of_.empty()) return false;
  return std::any_of(points.begin(), points.end(),
                     [&](Index p) { return p < mesh_->vertex_count() && body_of_[p] != no_index; });
}

/// Springs between the slopes of edges and the bodies that hold them.
void Discretisation::find_rigid_slopes(energy::CurvatureBuilder& curvature, std::vector<char>& needed) {
  Index first = patches_->point_count();
  for (const RigidBody& body : constraints_.bodies) {
    energy::RigidFrame frame{};
    for (int k = 0; k < RigidBody::frame_points; ++k) {
      frame.points[static_cast<std::size_t>(k)] = first++;
      frame.start[static_cast<std::size_t>(k)] = body.frame_point(k);
    }
    std::map<Index, std::vector<int>> sides;
    for (const mesh::TriangleSide& s : body.slopes) sides[s.triangle].push_back(s.side);
    for (const auto& [t, held] : sides) {
      add_joint(energy::make_rigid_slopes(*sheet_, curvature, t, held, frame), owns(t), needed);
    }
  }
}

/// A hinge turns an edge whose slope nothing holds, on a ground that stays.
void Discretisation::require_free(const mesh::Segment& edge, const mesh::TriangleSide& side) const {
  const bool held = patches_->apex(side.triangle, side.side) != no_index;
  if (!held && !(is_on_body({edge[0]}) && is_on_body({edge[1]}))) return;
  const Vec3 x = 0.5 * (mesh_->positions()[edge[0]] + mesh_->positions()[edge[1]]);
  throw UserError(
      fmt::format("[[hinge]]: a {} the edge at ({:.4g}, {:.4g}, {:.4g}) m, {}",
                  held ? "[[support]] holds the slope of" : "[[rigid]] group has", x[0], x[1], x[2],
                  held ? "so a hinge there does nothing; use type = \"hinged\", or take the edge out of the group"
                       : "and a hinge knows no ground that moves; take the edge out of one of the groups"));
}

/// Springs between the slopes of edges on the boundary and the ground.
void Discretisation::find_grounded_slopes(energy::CurvatureBuilder& curvature,
                                          const std::map<Index, HingedEdge>& hinges, const std::vector<char>& candidate,
                                          std::vector<char>& needed) {
  std::map<Index, energy::GroundedSides> by_triangle;
  for (const auto& [number, hinge] : hinges) {
    const auto& [t, s] = hinge.at.side;
    if (!on_boundary(*mesh_, number)) continue;
    require_free(hinge.at.edge, hinge.at.side);
    constraints_.elastic.push_back(hinge.at.side);
    energy::GroundedSides& on = by_triangle[t];
    on.sides.push_back(s);
    on.stiffness.push_back(hinge.stiffness);
    on.joints.push_back(number);
  }
  if (!by_triangle.empty() && sheet_->options().bending == energy::BendingOperator::six_node)
    throw UserError(
        fmt::format("[element] type = \"{}\" holds no slope, and a [[hinge]] lies on the boundary; use \"corrected\"",
                    energy::element_types[energy::type_of(sheet_->options())].name));
  for (const auto& [t, grounded] : by_triangle) {
    if (!candidate[t] && !owns(t)) continue;
    add_joint(energy::make_grounded_slopes(*sheet_, curvature, t, grounded), owns(t), needed);
  }
}

/// Keeps it where this rank has rows of it, or counts it.
void Discretisation::add_joint(energy::JointElement element, bool is_owned, std::vector<char>& needed) {
  const std::vector<Index> vertices = unknowns_of(element.points);
  if (!touches(vertices) && !is_owned) return;
  for (const Index p : element.points) needed[p] = 1;
  for (const Index v : vertices) needed[v] = 1;
  joints_.elements.push_back(std::move(element));
  joints_.owned.push_back(is_owned);
}

bool Discretisation::touches(const std::vector<Index>& vertices) const {
  return std::any_of(vertices.begin(), vertices.end(), [&](Index v) { return partition_.vertex_rank[v] == rank_; });
}

/// The joints of this rank, and the points that they use.
void Discretisation::find_joints(energy::CurvatureBuilder& curvature, const std::map<Index, HingedEdge>& hinges,
                                 const std::vector<char>& candidate, std::vector<char>& needed) {
  const std::vector<mesh::Joint>& joints = mesh_->joints();
  energy::JointStiffness stiffness{std::vector(joints.size(), std::numeric_limits<double>::infinity()), joint_factors_};
  for (const auto& [number, hinge] : hinges)
    if (!on_boundary(*mesh_, number)) {
      stiffness.hinges[static_cast<std::size_t>(number)] = hinge.stiffness;
      for (const mesh::TriangleSide& side : joints[static_cast<std::size_t>(number)].sides)
        require_free(hinge.at.edge, side);
    }
  if (joints.empty()) return;
  if (sheet_->options().bending == energy::BendingOperator::six_node)
    throw UserError(fmt::format(
        "[element] type = \"{}\" cannot join sheets, and {} joins some: {} edges of three or more triangles, or "
        "of two that cannot be oriented alike, or hinges; use \"corrected\"",
        energy::element_types[energy::type_of(sheet_->options())].name, mesh_->source(), joints.size()));
  for (const std::vector<Index>& cluster : energy::joint_clusters(*sheet_)) {
    const bool near = std::any_of(cluster.begin(), cluster.end(), [&](Index j) {
      const auto& sides = joints[static_cast<std::size_t>(j)].sides;
      return std::any_of(sides.begin(), sides.end(),
                         [&](const mesh::TriangleSide& s) { return candidate[s.triangle]; });
    });
    const bool is_owned = owns(joints[static_cast<std::size_t>(cluster.front())].sides.front().triangle);
    if (!near && !is_owned) continue;
    add_joint(energy::make_joint_element(*sheet_, curvature, cluster, stiffness), is_owned, needed);
  }
}

/// Rank of each vertex; that of a carrier knows all around its body or curve.
std::vector<int> Discretisation::holders() const {
  std::vector<int> holder = partition_.vertex_rank;
  for (const RigidBody& body : constraints_.bodies)
    for (const Index carrier : body.carriers)
      if (partition_.vertex_rank[carrier] == rank_)
        for (const Index v : body.members) holder[v] = rank_;
  const Ties& ties = constraints_.ties;
  for (std::size_t i = 0; i < ties.carriers.size(); ++i)
    for (Index v = 0; partition_.vertex_rank[ties.carriers[i]] == rank_ && v < mesh_->vertex_count(); ++v)
      if (ties.periods(v, i) != 0) holder[v] = rank_;
  return holder;
}

/// Marks what a rank needs to know for these points.
void Discretisation::need(const std::vector<Index>& points, std::vector<char>& needed) const {
  for (const Index p : points) needed[p] = 1;
  for (const Index v : unknowns_of(points)) needed[v] = 1;
  if (constraints_.ties.any())
    for (const Index v : vertices_of(*patches_, points)) needed[v] = 1;
}

/// The elements of this rank, and the points that they use.
std::vector<char> Discretisation::find_elements(const Couplings& couplings) {
  const std::vector<char> candidate = candidate_triangles(*mesh_, holders(), rank_, constraints_.ties);
  energy::CurvatureBuilder curvature(element_sheet());
  const std::size_t frames = RigidBody::frame_points * constraints_.bodies.size();
  std::vector<char> needed(static_cast<std::size_t>(patches_->point_count()) + frames, 0);
  for (const RigidBody& body : constraints_.bodies)
    for (const Index carrier : body.carriers) needed[carrier] = 1;
  for (Index v = 0; constraints_.ties.any() && v < mesh_->vertex_count(); ++v)
    if (owns_vertex(v)) need({v}, needed);
  for (Index t = 0; t < mesh_->triangle_count(); ++t) {
    if (!candidate[t]) continue;
    energy::CurvatureOperator op = curvature.build(t);
    const std::vector<Index> points = stencil_points(element_sheet(), t, op);
    // The owner of a triangle recovers its stresses even where none of its rows are its own.
    if (!has_rows_of(points) && !owns(t)) continue;
    need(points, needed);
    elements_.push_back({t, {}, owns(t)});
    curvatures_.push_back(std::move(op));
  }
  const std::map<Index, HingedEdge> hinges = hinged_edges(*mesh_, couplings.hinges);
  find_joints(curvature, hinges, candidate, needed);
  find_grounded_slopes(curvature, hinges, candidate, needed);
  find_rigid_slopes(curvature, needed);
  for (const Spring& spring : couplings.springs)
    for (const auto& [v, w] : pairs_of(*mesh_, spring))
      if (has_rows_of({v, w}) || owns_vertex(v)) needed[v] = needed[w] = 1;
  for (const mesh::Seam& seam : mesh_->data().seams)
    for (const auto& [v, w] : seam.pairs)
      if (partition_.vertex_rank[v] == rank_ || partition_.vertex_rank[w] == rank_) needed[v] = needed[w] = 1;
  return needed;
}

}  // namespace voile::system
