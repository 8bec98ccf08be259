#include "contact_scene.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "base/mpi.hpp"
#include "contact/neighbours.hpp"
#include "mesh/weld.hpp"
#include "voile/errors.hpp"

namespace voile::system {

namespace {

/// Of an obstacle with its points at these places [m].
double smallest_extent(const contact::Obstacle& o, const std::vector<Vec3>& places) {
  if (o.shape != contact::Obstacle::Shape::mesh) return 2.0 * o.radius;
  Vec3 low = places.front(), high = low;
  for (const Vec3& x : places) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  return (high - low).minCoeff();
}

using contact::ContactSet;

/// Of the triangles that may be too low for the activation distance: a few slivers are exempt, a whole mesh is not.
constexpr double most_narrow = 0.5;

/// Parts of the sheet that rules name, then the obstacles.
struct Bodies {
  std::vector<contact::Body> list;
  std::size_t sheets = 0;
  std::vector<int> of_triangle, of_vertex;
};

Bodies make_bodies(const mesh::SurfaceMesh& mesh, const ContactInput& input) {
  Bodies b{{{"sheet", input.thickness}},
           0,
           std::vector<int>(static_cast<std::size_t>(mesh.triangle_count()), 0),
           std::vector<int>(static_cast<std::size_t>(mesh.vertex_count()), -1)};
  const auto named = [](const std::string& name) { return [&name](const auto& x) { return x.name == name; }; };
  for (const ContactRule& r : input.rules)
    for (const std::string* name : {&r.first, &r.second}) {
      if (std::any_of(input.obstacles.begin(), input.obstacles.end(), named(*name)) ||
          std::any_of(b.list.begin(), b.list.end(), named(*name)))
        continue;
      if (!mesh.has_group(*name))
        throw UserError(
            fmt::format("[[contact_rule]]: there is no obstacle, physical surface or curve '{}'; correct the name, or "
                        "name the group in the mesh",
                        *name));
      const mesh::Group& group = mesh.group(*name);
      if (group.dimension == 0)
        throw UserError(fmt::format("[[contact_rule]]: '{}' is a physical point; name a surface or a curve", *name));
      for (Index t : group.triangles) b.of_triangle[t] = static_cast<int>(b.list.size());
      if (group.dimension == 1)
        for (Index v : group.vertices) b.of_vertex[v] = static_cast<int>(b.list.size());
      b.list.push_back({*name, input.thickness});
    }
  b.sheets = b.list.size();
  for (const contact::Obstacle& o : input.obstacles) b.list.push_back({o.name, o.thickness + 2.0 * o.radius});
  return b;
}

void set_general_rules(const ContactInput& input, std::size_t sheets, contact::Surface& s) {
  for (std::size_t i = 0; i < s.bodies.size(); ++i)
    for (std::size_t j = 0; j < s.bodies.size(); ++j)
      s.rules[i][j] = i < sheets && j < sheets
                          ? contact::Rule{input.self, input.friction}
                          : contact::Rule{i < sheets || j < sheets, input.obstacles[std::max(i, j) - sheets].friction};
}

/// Whether sheets meet at joints. Where one is parted it lies as it would whole.
bool branches(const mesh::SurfaceMesh& mesh) {
  const auto is_among = [](const std::vector<mesh::Segment>& edges, const mesh::Segment& edge) {
    return std::binary_search(edges.begin(), edges.end(), edge);
  };
  return std::any_of(mesh.joints().begin(), mesh.joints().end(), [&](const mesh::Joint& j) {
    return j.sides.size() > 2 || !(is_among(mesh.data().hinges, j.edge) || is_among(mesh.data().borders, j.edge));
  });
}

}  // namespace

ContactScene::ContactScene(const Dofs& dofs, ContactInput input) : dofs_(&dofs), input_(std::move(input)) {
  const mesh::SurfaceMesh& mesh = dofs.mesh();
  Bodies bodies = make_bodies(mesh, input_);
  const std::size_t sheets = bodies.sheets;
  contact::Surface surface = contact::make_surface(mesh, std::move(bodies.list), bodies.of_triangle, bodies.of_vertex);
  obstacles_.emplace(input_.obstacles, static_cast<int>(sheets), surface);
  set_general_rules(input_, sheets, surface);
  surface.joined = mesh::joined_vertices(mesh.data());
  // Layers that a seam has joined lay apart before, so nothing but what meets in the seam is nearer than contact reaches.
  if (lacks_room() || (input_.self && branches(mesh) && !mesh.has_charts()))
    surface.neighbours = contact::find_neighbours(surface, input_.options.distance);
  std::vector<char> owned(static_cast<std::size_t>(mesh.vertex_count()));
  for (Index i = 0; i < dofs.local().owned; ++i) owned[dofs.local().point_of[i]] = 1;
  set_ = std::make_unique<ContactSet>(std::move(surface), obstacles_->planes(), input_.options, std::move(owned));
  set_rules();

  VOILE_PETSC(VecScatterCreateToAll(dofs.create_vector(), to_all_.out(), all_.out()));
  for (std::vector<Vec3>* v : {&points_.now, &points_.end, &points_.start}) *v = set_->surface().rest;
  if (mpi::size(dofs.comm()) > 1)
    halo_ = std::make_unique<ContactHalo>(dofs.comm(), mesh, dofs.partition(),
                                          std::vector{&points_.now, &points_.end, &points_.start});
  set_time(0.0);
}

void ContactScene::set_rules() {
  for (const ContactRule& r : input_.rules) {
    const int i = body(r.first), j = body(r.second);
    for (contact::Rule* rule : {&set_->rule(i, j), &set_->rule(j, i)}) {
      if (r.ignore) rule->touch = false;
      if (r.friction) rule->friction = *r.friction;
    }
  }
}

bool ContactScene::lacks_room() {
  const mesh::SurfaceMesh& mesh = dofs_->mesh();
  double least = std::numeric_limits<double>::infinity();
  Index narrow = 0, count = 0;
  const double reach = input_.options.distance + input_.thickness;
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    double longest = 0.0;
    for (int s = 0; s < 3; ++s)
      longest = std::max(longest, (mesh.rest_corner(t, s) - mesh.rest_corner(t, (s + 1) % 3)).norm());
    const double height = 2.0 * mesh.area(t) / longest;
    count += reach < contact::room_between_neighbours * height ? 0 : 1;
    if (height < least) {
      least = height;
      narrow = t;
    }
  }
  if (!input_.self || count == 0) return false;
  const long tag = mesh.data().triangle_tags.empty() ? narrow : static_cast<long>(mesh.data().triangle_tags[narrow]);
  if (static_cast<double>(count) > most_narrow * mesh.triangle_count())
    throw UserError(fmt::format(
        "[contact]: distance + thickness = {:.4g} m is too much for this mesh: {} of {} triangles are less high than "
        "{:.4g} m, triangle {} only {:.4g} m, and neighbours would push each other; make the sum smaller (less than "
        "{:.4g} m keeps it whole everywhere), or the mesh coarser",
        reach, count, mesh.triangle_count(), reach / contact::room_between_neighbours, tag, least,
        contact::room_between_neighbours * least));
  const Vec3 place = (mesh.start_corner(narrow, 0) + mesh.start_corner(narrow, 1) + mesh.start_corner(narrow, 2)) / 3.0;
  input_.notes.push_back(fmt::format(
      "[contact]: {} of {} triangles are less high than distance + thickness = {:.4g} m asks for ({:.4g} m), the "
      "lowest "
      "is triangle {} near ({:.4g}, {:.4g}, {:.4g}) with {:.4g} m: neighbours there feel each other from {} of their "
      "distance at rest only",
      count, mesh.triangle_count(), reach, reach / contact::room_between_neighbours, tag, place[0], place[1], place[2],
      least, contact::room_between_neighbours));
  return true;
}

int ContactScene::body(const std::string& name) const {
  const auto& bodies = set_->surface().bodies;
  const auto at = std::find_if(bodies.begin(), bodies.end(), [&](const contact::Body& b) { return b.name == name; });
  if (at == bodies.end()) throw InternalError("a contact rule names no body");
  return static_cast<int>(at - bodies.begin());
}

// ---- time ----------------------------------------------------------------------------------------------------------

void ContactScene::set_time(double time) {
  time_ = time;
  place_obstacles(time, points_.now, set_->planes());
  carry();
}

void ContactScene::hold_obstacles(bool still) {
  if (held_) start_time_ = *held_;  // nothing has moved since
  held_ = still ? std::optional(time_) : std::nullopt;
}

void ContactScene::place_obstacles(double time, std::vector<Vec3>& x, std::vector<contact::Plane>& planes) const {
  obstacles_->place(held_.value_or(time), x, planes);
}

double ContactScene::way_of_obstacles(double before, double now, double cell, double cells) const {
  std::vector<Vec3> from = points_.now, to = from;
  std::vector<contact::Plane> planes = set_->planes(), then = planes;
  place_obstacles(before, from, then);
  place_obstacles(now, to, planes);
  double most = 0.0;
  for (std::size_t k = 0; k < obstacles_->size(); ++k) {
    const std::vector<Vec3> a = obstacles_->points(k, from), b = obstacles_->points(k, to);
    double way = 0.0;
    for (std::size_t p = 0; p < a.size(); ++p) way = std::max(way, (b[p] - a[p]).norm());
    if (way > 0.0)
      most = std::max(most, way / std::min(cells * cell, std::max(cell, smallest_extent((*obstacles_)[k], a))));
  }
  const mesh::SurfaceMesh& sheet = dofs_->mesh();
  for (std::size_t k = 0; k < planes.size(); ++k)
    for (const Vec3& x : sheet.positions()) {
      const double way = (planes[k].normal - then[k].normal).dot(x) - (planes[k].level - then[k].level);
      most = std::max(most, std::abs(way) / (cells * cell));
    }
  return most;
}

void ContactScene::begin_step() {
  start_time_ = time_;
  points_.start = points_.now;
}

std::vector<contact::Plane> ContactScene::planes_at_start() const {
  std::vector<contact::Plane> planes = set_->planes();
  std::vector<Vec3> places = points_.start;
  place_obstacles(start_time_, places, planes);
  return planes;
}

void ContactScene::lag_friction(double slip) {
  set_->lag_friction(points_.now, points_.start, slip);
  carry();
}

void ContactScene::carry() {
  const auto displacement = [this](int b, const Vec3& place) -> std::optional<Vec3> {
    return held_ ? Vec3(Vec3::Zero()) : obstacles_->displacement(b, place, start_time_, time_);
  };
  set_->carry(displacement, points_.start, points_.now);
}

// ---- positions -----------------------------------------------------------------------------------------------------

void ContactScene::locate(Vec a, std::vector<Vec3>& x) const {
  const LocalPoints& local = dofs_->local();
  {
    const petsc::ReadArray values(a);
    for (Index i = 0; i < local.owned; ++i) {
      const Index v = local.point_of[i];
      x[v] = dofs_->mesh().positions()[v] + dofs_->to_global(v, Eigen::Map<const Vec3>(values.data() + 3 * i));
    }
  }
  if (halo_) halo_->update(x);
}

bool ContactScene::cover(const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
  const petsc::EventScope scope(petsc::events().contact_find);
  return set_->cover(from, to, halo_.get());
}

void ContactScene::take(Vec a) {
  locate(a, points_.now);
  cover(points_.now, points_.now);
}

std::vector<Vec3> ContactScene::positions(Vec a) const {
  std::vector<Vec3> x = points_.now;
  VOILE_PETSC(VecScatterBegin(to_all_, a, all_, INSERT_VALUES, SCATTER_FORWARD));
  VOILE_PETSC(VecScatterEnd(to_all_, a, all_, INSERT_VALUES, SCATTER_FORWARD));
  const petsc::ReadArray values(all_);
  const mesh::SurfaceMesh& mesh = dofs_->mesh();
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3 u = Eigen::Map<const Vec3>(values.data() + 3 * dofs_->partition().row_of[v]);
    x[v] = mesh.positions()[v] + dofs_->to_global(v, u);
  }
  return x;
}

// ---- reports -------------------------------------------------------------------------------------------------------

std::vector<Vec3> obstacle_points(const ContactScene& scene, std::size_t k) {
  return scene.obstacles().points(k, scene.points().now);
}

std::string words(const ContactScene& scene, const contact::Pair& pair) {
  const std::vector<contact::Body>& bodies = scene.set().surface().bodies;
  const Vec3& x = scene.points().now[pair.points[0]];
  return fmt::format("{} against {} near ({:.4g}, {:.4g}, {:.4g})", bodies[pair.body_a].name, bodies[pair.body_b].name,
                     x[0], x[1], x[2]);
}

ContactReport report(ContactScene& scene, Vec a) {
  scene.take(a);
  const MPI_Comm comm = scene.dofs().comm();
  const contact::ContactState own = scene.set().state(scene.points().now);
  ContactReport r;
  const long candidates = static_cast<long>(scene.set().candidates().pairs().size());
  r.pairs = mpi::sum(comm, own.pairs);
  r.most_pairs = std::lround(mpi::max(comm, static_cast<double>(own.pairs)));
  r.candidates = mpi::sum(comm, candidates);
  r.most_candidates = std::lround(mpi::max(comm, static_cast<double>(candidates)));
  r.gap = -mpi::max(comm, -own.gap);
  r.nearest = mpi::first_text(comm, own.pairs > 0 && own.gap == r.gap ? words(scene, own.nearest) : "");
  return r;
}

std::vector<double> gaps(const ContactScene& scene, Vec a, double limit) {
  std::vector<double> gaps = scene.set().gaps_within(scene.positions(a), limit);
  mpi::min(scene.dofs().comm(), gaps);
  return gaps;
}

}  // namespace voile::system
