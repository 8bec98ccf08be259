// How long edges should be: sizes of a remeshing, and where its limits are.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/mpi.hpp"
#include "input/expression.hpp"
#include "new_mesh.hpp"
#include "record/discretisation_error.hpp"
#include "remesher.hpp"
#include "setup/obstacle_sizes.hpp"
#include "system/contact.hpp"
#include "voile/errors.hpp"

namespace voile::remesh {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
/// Fractions of vertices with edges too long or too short, beyond what the last remeshing left, that ask for a new mesh.
constexpr double most_too_long = 0.02, most_too_short = 0.3;
/// The first one where a path or a drape ends: one sharp fold decides the shape, and there is no later look.
constexpr double most_too_long_at_end = 0.002;
/// Beside an obstacle: what is small pierces or creases a coarse sheet in one place.
constexpr double most_too_long_ahead = 0.002;
/// Looks in a row at the end of a path or a drape.
constexpr int most_looks_at_end = 6;
/// Of any mesh: every rank holds the whole of it.
constexpr double most_vertices = 5e6;
/// Edges of a new mesh over what is wanted, in the middle of remeshings seen (0.83 to 1.07): halves of what was too long.
constexpr double usual_ratio = 0.9;
/// Surfaces may come nearer by this fraction of their gap: both sides move, and half of the gap stays.
constexpr double fraction_of_gap = 0.25;
/// Gaps are looked for within so many activation distances; what is far from everything may move as if it were at this gap.
constexpr double gap_reach = 4.0;

/// Largest principal value of a curvature k11, k22, 2 k12, squared.
double largest_squared(const double* k) {
  const double mean = 0.5 * (k[0] + k[1]), radius = std::hypot(0.5 * (k[0] - k[1]), 0.5 * k[2]);
  return std::pow(std::abs(mean) + radius, 2);
}

/// To a per cent, so that decisions and smoothing do not see the last digits, in which other numbers of ranks differ. As
/// parts of the sheet's extent: the same in every unit.
double rounded(double size, double extent) {
  constexpr double steps = 100.0;
  return extent * std::exp(std::round(std::log(size / extent) * steps) / steps);
}

/// Vertices that a mesh of some sizes has, about: half of the triangles and half of the edges on the boundary.
struct VertexCount {
  double inside = 0.0, boundary = 0.0;  ///< inversely as the square of the sizes, and as the sizes
  double frozen = 0.0;                  ///< of triangles that stay, whatever the sizes
  [[nodiscard]] double all() const { return inside + boundary + frozen; }
  /// By which all sizes have to become larger for no more than `most`.
  [[nodiscard]] double factor_for(double most) const {
    const double room = std::max(most - frozen, 1.0);
    return std::max(1.0, (boundary + std::sqrt(boundary * boundary + 4.0 * room * inside)) / (2.0 * room));
  }
};

VertexCount vertices_of(const mesh::SurfaceMesh& mesh, const std::vector<double>& size,
                        const std::vector<char>& frozen) {
  VertexCount count;
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const mesh::Triangle& corners = mesh.triangles()[t];
    const bool stays = !frozen.empty() && frozen[t];
    double h = 0.0;
    for (Index v : corners) h += usual_ratio * size[v] / 3.0;
    (stays ? count.frozen : count.inside) += stays ? 0.5 : 0.5 * mesh.area(t) / (0.25 * std::numbers::sqrt3 * h * h);
    for (int s = 0; s < 3; ++s) {
      if (mesh.neighbour(t, s) != no_index) continue;
      const mesh::Segment e{corners[(s + 1) % 3], corners[(s + 2) % 3]};
      const double wanted = usual_ratio * (size[e[0]] + size[e[1]]);
      (stays ? count.frozen : count.boundary) += stays ? 0.5 : mesh.rest_length(e) / wanted;
    }
  }
  return count;
}

/// Per triangle whether it is to stay; empty if all may change.
std::vector<char> frozen_triangles(const input::RemeshSection& keys, const mesh::SurfaceMesh& mesh) {
  std::vector<char> frozen;
  if (!keys.frozen.empty()) frozen.assign(static_cast<std::size_t>(mesh.triangle_count()), 0);
  for (const std::string& name : keys.frozen)
    for (Index t : mesh.group(name, 2).triangles) frozen[t] = 1;
  return frozen;
}

/// Throws UserError for a mesh that no run would get to the end of, as where sizes are in another unit.
void check_count(const input::Case& c, double vertices) {
  if (vertices <= most_vertices) return;
  throw UserError(fmt::format(
      "{}: [remesh]: the sizes ask for a mesh of about {:.2g} vertices, more than {:.2g}; give a larger `smallest`, "
      "`size`, `background`, `angle` or `velocity` (in the unit of the mesh), or `max_vertices`",
      c.file.string(), vertices, most_vertices));
}

adapt::SizeOptions options_of(const Stage& stage, const mesh::SurfaceMesh& first) {
  const input::RemeshSection& k = stage.c.remesh;
  adapt::SizeOptions o;
  o.angle = k.angle;
  o.growth = k.growth;
  const double extent = first.extent();
  const double thickness = stage.c.contact.input.active ? stage.c.contact.input.thickness : 0.0;
  o.largest = k.largest > 0.0 ? k.largest : std::max(extent / 12.0, k.smallest);
  o.smallest = k.smallest > 0.0 ? k.smallest : std::min(std::max(extent / 200.0, 4.0 * thickness), o.largest);
  return o;
}

}  // namespace

/// Upper bounds on rank 0 from contact, velocity and the user's fields.
std::vector<double> Remesher::bounds(Epoch& epoch, const std::vector<double>& curvature_squared) {
  const system::Dofs& dofs = epoch.model().dofs();
  const mesh::SurfaceMesh& mesh = dofs.mesh();
  const auto vertices = static_cast<std::size_t>(mesh.vertex_count());
  std::vector<double> bound(vertices, infinite), velocity;
  const auto lower = [&](Index v, double h) { bound[v] = std::min(bound[v], h); };
  if (system::Contact* contact = epoch.model().contact(); contact && keys_.near_contact) {
    const double distance = contact->scene().input().options.distance;
    const double least = options_of(stage_, *first_).smallest;
    const std::vector<double> gaps = system::gaps(contact->scene(), epoch.state().u, distance);
    if (!curvature_squared.empty())
      for (Index t = 0; t < mesh.triangle_count(); ++t)
        for (Index v : mesh.triangles()[t])
          if (gaps[v] < distance)
            lower(v, std::max(least, std::sqrt(2.0 * distance / std::sqrt(curvature_squared[t] + 1e-300))));
  }
  if (keys_.velocity > 0.0 && epoch.state().v) velocity = dofs.gather(epoch.state().v);
  for (Index t = 0; t < mesh.triangle_count() && !velocity.empty(); ++t)
    for (int s = 0; s < 3; ++s) {
      const Index a = mesh.triangles()[t][s], b = mesh.triangles()[t][(s + 1) % 3];
      const double difference = (Eigen::Map<const Vec3>(&velocity[3 * static_cast<std::size_t>(a)]) -
                                 Eigen::Map<const Vec3>(&velocity[3 * static_cast<std::size_t>(b)]))
                                    .norm();
      if (difference <= 0.0) continue;
      const double h = keys_.velocity * mesh.rest_length({a, b}) / difference;
      lower(a, std::max(h, options_of(stage_, *first_).smallest));
      lower(b, std::max(h, options_of(stage_, *first_).smallest));
    }
  if (bound_)
    for (std::size_t v = 0; v < vertices; ++v) {
      const double h = bound_(mesh.positions()[v]);
      if (h > 0.0) bound[v] = std::min(bound[v], h);
    }
  mpi::on_root(dofs.comm(), [&] {
    if (!background_) return;
    const std::vector<double> sizes = background_->at(mesh.positions());
    for (std::size_t v = 0; v < vertices; ++v) bound[v] = std::min(bound[v], sizes[v]);
  });
  return bound;
}

/// Lowers the bounds where stress resultants are further from smooth ones than the case wants; on rank 0. Collective.
void Remesher::bound_by_error(Epoch& epoch, const system::TriangleFields& fields, std::vector<double>& bound) const {
  if (keys_.error == 0.0) return;
  const system::Model& model = epoch.model();
  record::DiscretisationError estimate;
  record::DiscretisationError::Densities error = estimate.judged(model, fields, {});
  mpi::on_root(model.dofs().comm(), [&] {
    if (estimate.last().whole == 0.0) return;  // also where there is nothing but round-off, as in a sheet that flies
    for (std::size_t t = 0; t < error.membrane.size(); ++t) error.membrane[t] += error.bending[t];
    const double stored = record::judged_energy(model.discretisation().sheet(), fields).whole;
    const std::vector<double> size = adapt::sizes_for_error(model.dofs().mesh(), error.membrane, stored, keys_.error);
    const double least = options_of(stage_, *first_).smallest;
    for (std::size_t v = 0; v < size.size(); ++v) bound[v] = std::min(bound[v], std::max(least, size[v]));
  });
}

/// In which the sheet may come to an obstacle before another mesh is made: that of two looks. [s]
double Remesher::time_ahead(const Epoch& epoch) const {
  if (!epoch.moves()) return 0.0;
  const double next = epoch.state().next_step;
  return 2.0 * every() * (next > 0.0 ? next : stage_.c.time.options.step);
}

/// What bends the sheet as soon as it gets there. Collective: rank 0 reads the frames of bodies for all.
std::vector<setup::Bend> Remesher::bends(Epoch& epoch) const {
  const system::Contact* contact = epoch.model().contact();
  if (!contact || !keys_.near_obstacles) return {};
  return setup::bends_of(contact->scene(), options_of(stage_, *first_), time_ahead(epoch));
}

/// Lowers the bounds beside bends; on rank 0. `velocity`: empty outside a motion.
void Remesher::bound_by_obstacles(const std::vector<setup::Bend>& bends, double ahead, const std::vector<Vec3>& places,
                                  const std::vector<double>& velocity, std::vector<double>& bound) {
  near_obstacle_.assign(places.size(), 0);
  const double largest = options_of(stage_, *first_).largest;
  std::vector<double> advance;
  for (const Vec3& v : as_points(velocity)) advance.push_back(ahead * v.norm());
  std::vector<double> near(places.size(), infinite);
  setup::bound_near(bends, places, advance, largest, near);
  for (std::size_t v = 0; v < near.size(); ++v) {
    near_obstacle_[v] = near[v] < largest ? 1 : 0;
    bound[v] = std::min(bound[v], near[v]);
  }
}

/// On rank 0.
std::vector<double> Remesher::wanted_sizes(Epoch& epoch) {
  system::Model& model = epoch.model();
  const mesh::SurfaceMesh& mesh = model.dofs().mesh();
  const system::TriangleFields fields = model.triangle_fields(epoch.state().u);
  std::vector<double> squared(fields.curvature.size() / 3);
  // Where a rest shape is made flat the change counts, but not that of a temperature, which is no shape.
  const auto is_heated = [&](std::size_t t) {
    return !fields.temperature.empty() && (fields.temperature[2 * t] != 0.0 || fields.temperature[2 * t + 1] != 0.0);
  };
  for (std::size_t t = 0; t < squared.size(); ++t) {
    squared[t] = largest_squared(&fields.whole_curvature[3 * t]);
    if (!is_heated(t)) squared[t] = std::max(squared[t], largest_squared(&fields.curvature[3 * t]));
  }
  std::vector<double> bound = bounds(epoch, squared), velocity;
  bound_by_error(epoch, fields, bound);
  const std::vector<double> u = model.dofs().gather(epoch.state().u);
  if (epoch.state().v) velocity = model.dofs().gather(epoch.state().v);
  const std::vector<setup::Bend> bends = this->bends(epoch);
  std::vector<double> size;
  mpi::on_root(model.dofs().comm(), [&] {
    std::vector<Vec3> places = mesh.positions();
    for (std::size_t v = 0; v < places.size(); ++v) places[v] += Eigen::Map<const Vec3>(&u[3 * v]);
    bound_by_obstacles(bends, time_ahead(epoch), places, velocity, bound);
    size = adapt::size_field(mesh, places, squared, bound, options_of(stage_, *first_));
    const std::vector<char> frozen = frozen_triangles(keys_, mesh);
    if (keys_.max_vertices > 0) {
      const double factor = vertices_of(mesh, size, frozen).factor_for(keys_.max_vertices);
      for (double& h : size) h *= factor;
    }
    check_count(stage_.c, vertices_of(mesh, size, frozen).all());
    for (double& h : size) h = rounded(h, first_->extent());
  });
  return size;
}

int Remesher::every() const {
  return keys_.every > 0 ? keys_.every : stage_.c.analysis == input::Analysis::dynamic ? 5 : 1;
}

bool Remesher::due(Epoch& epoch, bool finished) {
  const bool drapes = stage_.c.analysis == input::Analysis::drape,
             moves = stage_.c.analysis == input::Analysis::dynamic;
  if (drapes ? !finished : epoch.state().step % every() != 0 && !(finished && !moves)) return false;
  if (!drapes && epoch.state().step < epoch.state().remeshings.next_step) return false;
  if (finished && moves) return false;
  if (finished && ++at_end_ > most_looks_at_end) return false;
  const double begin = cpu_clock();
  size_ = wanted_sizes(epoch);
  std::vector<double> yes{0.0};
  mpi::on_root(epoch.model().dofs().comm(), [&] {
    const mesh::SurfaceMesh& mesh = epoch.model().dofs().mesh();
    const adapt::SizeMatch m = adapt::match(mesh, size_, changeable(mesh, {}));
    const system::Remeshings& left = epoch.state().remeshings;
    const double ahead = adapt::match(mesh, size_, changeable(mesh, near_obstacle_)).too_long;
    yes[0] = m.too_long > left.too_long + (finished ? most_too_long_at_end : most_too_long) ||
                     ahead > left.too_long + most_too_long_ahead || m.too_short > left.too_short + most_too_short
                 ? 1.0
                 : 0.0;
  });
  mpi::broadcast(epoch.model().dofs().comm(), yes);
  seconds_ += cpu_clock() - begin;
  return yes[0] > 0.0;
}

/// Vertices that lie in a triangle that may change, and are marked by `marked` if that is not empty; empty: all.
std::vector<char> Remesher::changeable(const mesh::SurfaceMesh& mesh, const std::vector<char>& marked) const {
  const std::vector<char> frozen = frozen_triangles(keys_, mesh);
  if (frozen.empty()) return marked;
  std::vector<char> may(static_cast<std::size_t>(mesh.vertex_count()), 0);
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    if (!frozen[t])
      for (Index v : mesh.triangles()[t]) may[v] = marked.empty() ? 1 : marked[v];
  return may;
}

adapt::Limits Remesher::limits(Epoch& epoch) const {
  const mesh::SurfaceMesh& mesh = epoch.model().dofs().mesh();
  adapt::Limits limits;
  limits.frozen = frozen_triangles(keys_, mesh);
  if (system::Contact* contact = epoch.model().contact()) {
    double reach = gap_reach * contact->scene().input().options.distance;
    // Every operation on a curved rest shape moves the surface by what cells lie off it, however small that distance is.
    if (curved_) reach = std::max(reach, std::sqrt(epoch.model().discretisation().mean_area()));
    limits.clearance = system::gaps(contact->scene(), epoch.state().u, reach);
    for (double& gap : limits.clearance) gap *= fraction_of_gap;
  }
  return limits;
}

void check_remesh(MPI_Comm comm, const input::Case& c, const mesh::SurfaceMesh& mesh) {
  if (!c.remesh.active) return;
  for (const std::string& name : c.remesh.frozen) {
    try {
      (void)mesh.group(name, 2);
    } catch (const UserError& e) {
      throw UserError(fmt::format("{}: [remesh] frozen: '{}': {}", c.file.string(), name, e.what()));
    }
  }
  if (!c.remesh.size.empty()) {
    const auto size = input::size_expression(c.remesh.size);
    for (const Vec3& x : mesh.positions())
      if (const double h = size(x); !(h > 0.0))
        throw UserError(
            fmt::format("{}: [remesh] size: '{}' is {:.3g} at ({:.4g}, {:.4g}, {:.4g}); a positive length is "
                        "needed everywhere, e.g. max(..., 0.01)",
                        c.file.string(), c.remesh.size, h, x.x(), x.y(), x.z()));
  }
  if (!c.remesh.background.empty()) mpi::on_root(comm, [&] { (void)setup::BackgroundSize(c).at(mesh.positions()); });
  const auto check = [&](const char* what, const std::string& group, const char* remedy) {
    if (group.empty() || mesh.group(group).dimension == 0) return;
    throw UserError(
        fmt::format("{}: [remesh]: the {} acts at every vertex of group '{}', and a new mesh has others; {}",
                    c.file.string(), what, group, remedy));
  };
  for (const system::Load& l : c.loads)
    if (l.kind == system::Load::Kind::point)
      check("[[load]] of type point", l.group, "use a physical point, or type = \"line\" or \"area\"");
  for (const system::PointMass& m : c.masses) check("[[mass]]", m.group, "use physical points");
  for (const system::Spring& s : c.springs)
    if (s.kind == system::Spring::Kind::point || s.kind == system::Spring::Kind::pair) {
      check("[[spring]]", s.group, "use physical points, or type = \"line\" or \"area\"");
      if (s.kind == system::Spring::Kind::pair) check("[[spring]]", s.to, "use physical points");
    }
}

namespace {

std::string vertex_group(const input::Probe& p) {
  return "probe " + p.name;
}

mesh::Group nearest(const input::Probe& p, const std::vector<Vec3>& positions) {
  const auto nearer = [&](const Vec3& a, const Vec3& b) {
    return (a - *p.point).squaredNorm() < (b - *p.point).squaredNorm();
  };
  const auto at = std::min_element(positions.begin(), positions.end(), nearer);
  mesh::Group group;
  group.name = vertex_group(p);
  group.vertices = {static_cast<Index>(at - positions.begin())};
  return group;
}

}  // namespace

void name_probes(const input::Case& c, mesh::MeshData& mesh) {
  for (const input::Probe& p : c.probes)
    if (p.point) mesh.groups.push_back(nearest(p, mesh.positions));
}

void rename_probes(const input::Case& c, const mesh::SurfaceMesh& first, mesh::MeshData& mesh) {
  const double same_place = 1e-9 * first.extent();
  for (const input::Probe& p : c.probes) {
    if (!p.point) continue;
    const Vec3& place = first.positions()[nearest(p, first.positions()).vertices[0]];
    const auto has_name = [&](const mesh::Group& g) { return g.name == vertex_group(p); };
    const auto group = std::find_if(mesh.groups.begin(), mesh.groups.end(), has_name);
    if (group != mesh.groups.end()) {
      if (group->vertices.size() == 1 && (mesh.positions[group->vertices[0]] - place).norm() <= same_place) continue;
      mesh.groups.erase(group);
    }
    if (first.has_group(vertex_group(p))) mesh.groups.push_back(nearest(p, mesh.positions));
  }
}

std::string remesh_outlook(const Stage& stage, const std::shared_ptr<const mesh::SurfaceMesh>& mesh, Epoch& epoch) {
  Remesher remesher(stage, mesh);
  const bool drapes = stage.c.analysis == input::Analysis::drape, due = remesher.due(epoch, drapes);
  const adapt::SizeOptions o = options_of(stage, *mesh);
  std::string text = "the start mesh suits the start";
  if (due)
    text = fmt::format("the start mesh {} one of about {:.0f} vertices",
                       drapes ? "would suit the start less than" : "is exchanged at once, for",
                       remesher.expected_vertices());
  if (drapes) text += "; it is not looked at before it has come to rest";
  return fmt::format("remeshing: edges of {:.3g} to {:.3g} m, {:.3g} degrees each; {}", o.smallest, o.largest,
                     o.angle * 180.0 / std::numbers::pi, text);
}

double Remesher::expected_vertices() const {
  return size_.empty() ? 0.0 : vertices_of(*first_, size_, frozen_triangles(keys_, *first_)).all();
}

}  // namespace voile::remesh
