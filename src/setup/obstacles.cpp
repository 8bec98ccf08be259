#include "obstacles.hpp"
#include "key_frames.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "base/bytes.hpp"
#include "base/child_process.hpp"
#include "base/mpi.hpp"
#include "base/text.hpp"
#include "formats/mesh_file.hpp"
#include "formats/message.hpp"
#include "formats/triangle_file.hpp"
#include "system/contact.hpp"
#include "voile/errors.hpp"

namespace voile::setup {

namespace {

using Shape = contact::Obstacle::Shape;

/// Divisions of a tessellated primitive; the check sees it a thousandth of its radius too small.
constexpr int refinement = 4;
/// Of a cylinder's facets, in activation distances.
constexpr double largest_sagitta = 0.1;
/// Side of the square that stands for a half-space, in extents of the sheet.
constexpr double square_side = 1.5;

std::vector<double> flat(const std::vector<Vec3>& points) {
  std::vector<double> values;
  for (const Vec3& x : points) values.insert(values.end(), x.begin(), x.end());
  return values;
}

std::vector<Vec3> points_of(const std::vector<double>& values) {
  std::vector<Vec3> points;
  for (std::size_t i = 0; i + 2 < values.size(); i += 3) points.emplace_back(values[i], values[i + 1], values[i + 2]);
  return points;
}

void read_shape(MPI_Comm comm, const input::ObstacleSection& section, contact::Obstacle& o) {
  std::vector<double> coordinates;
  std::vector<Index> corners;
  mpi::on_root(comm, [&] {
    const geometry::TriangleSoup soup = formats::read_triangles(section.file);
    coordinates = flat(soup.positions);
    for (const mesh::Triangle& t : soup.triangles) corners.insert(corners.end(), t.begin(), t.end());
  });
  mpi::broadcast(comm, coordinates);
  mpi::broadcast(comm, corners);
  o.points = points_of(coordinates);
  for (Vec3& x : o.points) x *= section.scale;
  formats::check_coordinates(section.file.string(), o.points);
  section.placement.apply(o.points);
  formats::check_coordinates(section.file.string() + ", put in place by rotate and translate", o.points);
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
    o.triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
}

/// A cylinder that deviates from the true one by less than contact can tell.
void tessellate(const input::ObstacleSection& section, double activation_distance, contact::Obstacle& o) {
  geometry::TriangleSoup soup =
      geometry::cylinder_surface(section.point, section.end, o.radius, largest_sagitta * activation_distance);
  o.points = std::move(soup.positions);
  o.triangles = std::move(soup.triangles);
  o.radius = 0.0;  // the triangles are where the surface is
}

/// A part of a plane, below the middle of the sheet.
geometry::TriangleSoup square(const contact::Obstacle& plane, const mesh::SurfaceMesh& sheet) {
  Vec3 low = sheet.positions().front(), high = low;
  for (const Vec3& x : sheet.positions()) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  const Vec3 normal = plane.normal.normalized(), middle = 0.5 * (low + high);
  const Vec3 centre = middle - normal.dot(middle - plane.points.front()) * normal;
  const double half = 0.5 * square_side * sheet.extent();
  const Vec3 u = half * normal.unitOrthogonal(), v = normal.cross(u);
  return {{centre - u - v, centre + u - v, centre + u + v, centre - u + v}, {{0, 1, 2}, {0, 2, 3}}};
}

geometry::TriangleSoup surface_at_rest(const contact::Obstacle& o, const mesh::SurfaceMesh& sheet) {
  switch (o.shape) {
    case Shape::sphere:
      return geometry::sphere_surface(o.points[0], o.radius, refinement);
    case Shape::capsule:
      return geometry::capsule_surface(o.points[0], o.points[1], o.radius, refinement);
    case Shape::plane:
      return square(o, sheet);
    default:
      return {o.points, o.triangles};
  }
}

/// Powers of what describes a primitive must be numbers; those read from files are checked there.
void check_size(const contact::Obstacle& o) {
  constexpr double largest = 1e100;
  double size = std::max(o.radius, o.thickness);
  for (const Vec3& x : o.points) size = std::max(size, x.cwiseAbs().maxCoeff());
  if (!(size <= largest))
    throw UserError(fmt::format(
        "[[obstacle]] '{}': {:g} m is no number to compute with; check its point, end, radius and thickness", o.name,
        size));
}

/// A body that nobody could wear the garment on.
void note_size(const input::Case& c, const contact::Obstacle& o, std::vector<std::string>& notes) {
  constexpr double smallest = 0.05, greatest = 50.0;
  if (c.panels.empty() || o.triangles.empty()) return;
  Vec3 low = o.points.front(), high = low;
  for (const Vec3& x : o.points) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  const double size = (high - low).maxCoeff();
  if (size < smallest || size > greatest)
    notes.push_back(
        fmt::format("[[obstacle]] '{}' measures {:.4g} m, which is no size of a body: if its file is in other units, "
                    "give it the key "
                    "scale: 0.001 for millimetres, 0.01 for centimetres",
                    o.name, size));
}

/// While seams are closed fabric may slide more easily.
void limit_friction(double most, system::ContactInput& input) {
  input.friction = std::min(input.friction, most);
  for (contact::Obstacle& o : input.obstacles) o.friction = std::min(o.friction, most);
  for (auto& rule : input.rules)
    if (rule.friction) rule.friction = std::min(*rule.friction, most);
}

}  // namespace

std::vector<Vec3> vertices_at_start(const input::ObstacleSection& section) {
  contact::Obstacle o = section.shape;
  std::vector<std::string> notes;  // said when the obstacle itself is read
  read_shape(PETSC_COMM_SELF, section, o);
  if (!section.frames.empty()) {
    read_frames(PETSC_COMM_SELF, section, 0.0, o, notes);
    return o.frames(0.0);
  }
  if (o.motion)
    for (Vec3& x : o.points) x += o.motion(x, 0.0);
  return o.points;
}

system::ContactInput contact_input(MPI_Comm comm, const input::Case& c, KnownObstacles& known) {
  system::ContactInput input = c.contact.input;
  for (std::size_t i = 0; i < c.obstacles.size(); ++i) {
    const input::ObstacleSection& section = c.obstacles[i];
    if (const auto at = known.find(section.shape.name); at != known.end()) {
      input.obstacles.push_back(at->second);
      continue;
    }
    contact::Obstacle o = section.shape;
    o.number = static_cast<int>(c.stage.obstacles.empty() ? i : c.stage.obstacles[i]);
    if (section.type == input::ObstacleSection::Type::mesh) read_shape(comm, section, o);
    if (section.type == input::ObstacleSection::Type::cylinder) tessellate(section, input.options.distance, o);
    if (!section.frames.empty()) read_frames(comm, section, c.time.options.end_time, o, input.notes);
    check_size(o);
    note_size(c, o, input.notes);
    known.emplace(o.name, o);
    input.obstacles.push_back(std::move(o));
  }
  for (const input::RuleSection& r : c.contact_rules)
    input.rules.push_back(
        {r.first, r.second, std::isnan(r.friction) ? std::nullopt : std::optional<double>(r.friction), r.ignore});
  if (!c.stage.sew.empty() && !std::isnan(c.sewing.friction)) limit_friction(c.sewing.friction, input);
  return input;
}

IntersectionCheck::IntersectionCheck(const system::Contact& contact) : contact_(contact) {}

IntersectionCheck::Triangles IntersectionCheck::triangles_at(const std::vector<Vec3>& x) const {
  const contact::Surface& s = contact_.scene().set().surface();
  Triangles all;
  all.positions = x;
  for (const contact::Face& f : s.faces) {
    all.triangles.push_back(f.points);
    all.body.push_back(f.body);
  }
  const auto add = [&](const geometry::TriangleSoup& soup, Index body) {
    const auto first = static_cast<Index>(all.positions.size());
    all.positions.insert(all.positions.end(), soup.positions.begin(), soup.positions.end());
    for (const mesh::Triangle& t : soup.triangles) {
      all.triangles.push_back({first + t[0], first + t[1], first + t[2]});
      all.body.push_back(body);
    }
  };
  std::size_t at = static_cast<std::size_t>(s.sheet_points);
  for (const contact::Obstacle& o : contact_.scene().input().obstacles) {
    if (o.shape == Shape::plane) continue;
    const Index body = s.body_of_point[at];
    if (o.shape == Shape::sphere) add(geometry::sphere_surface(x[at], o.radius, refinement), body);
    if (o.shape == Shape::capsule) add(geometry::capsule_surface(x[at], x[at + 1], o.radius, refinement), body);
    at += o.points.size();
  }
  return all;
}

std::vector<geometry::TrianglePair> IntersectionCheck::find_by_ranks(const std::vector<Vec3>& positions) const {
  MPI_Comm comm = contact_.scene().dofs().comm();
  std::vector<Index> own;
  mpi::on_all(comm, [&] {
    for (const auto& [i, j] : find(positions, geometry::Share{mpi::rank(comm), mpi::size(comm)}))
      own.insert(own.end(), {i, j});
  });
  std::vector<Index> all = mpi::gather_to_root(comm, own);
  mpi::broadcast(comm, all);
  std::vector<geometry::TrianglePair> pairs;
  for (std::size_t k = 0; k < all.size(); k += 2) pairs.emplace_back(all[k], all[k + 1]);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

std::vector<geometry::TrianglePair> IntersectionCheck::find(const std::vector<Vec3>& positions,
                                                            geometry::Share fraction) const {
  const Triangles all = triangles_at(positions);
  const auto& rules = contact_.scene().set().surface().rules;
  std::vector<geometry::TrianglePair> pairs = geometry::intersecting_triangles(
      all.positions, all.triangles, all.body, [&](Index a, Index b) { return !rules[a][b].touch; }, fraction);
  const auto is_given_way = [&](Index i, Index j) {
    return system::passes(contact_, all.triangles[static_cast<std::size_t>(i)], all.body[static_cast<std::size_t>(j)]);
  };
  const contact::Surface& s = contact_.scene().set().surface();
  const auto are_sewn = [&](Index i, Index j) {  // they will share a vertex
    for (const Index p : all.triangles[static_cast<std::size_t>(i)])
      for (const Index q : all.triangles[static_cast<std::size_t>(j)])
        if (p != q && s.same(p, q)) return true;
    return false;
  };
  if (!s.joined.empty()) std::erase_if(pairs, [&](const auto& p) { return are_sewn(p.first, p.second); });
  std::erase_if(pairs,
                [&](const auto& p) { return is_given_way(p.first, p.second) || is_given_way(p.second, p.first); });
  return pairs;
}

void IntersectionCheck::draw(const Triangles& all, const std::vector<geometry::TrianglePair>& pairs,
                             const std::filesystem::path& file) const {
  const mesh::SurfaceMesh& sheet = contact_.scene().dofs().mesh();
  std::vector<Index> piece(all.triangles.size(), no_index);
  for (Index t = 0; t < sheet.triangle_count(); ++t) piece[t] = all.body[static_cast<std::size_t>(t)];
  Index number = 0;
  for (const mesh::Group& g : sheet.groups()) {
    if (g.dimension != 2) continue;
    for (const Index t : g.triangles) piece[t] = number;
    ++number;
  }
  std::vector<std::uint8_t> hit(all.triangles.size(), 0);
  for (const auto& [i, j] : pairs) hit[static_cast<std::size_t>(i)] = hit[static_cast<std::size_t>(j)] = 1;
  ByteWriter out;
  out.put(all.positions);
  out.put(all.triangles);
  out.put(piece);
  out.put(hit);
  try {
    const formats::Message message(out.take());
    const std::string picture = std::filesystem::path(file).replace_extension(".png").string();
    (void)run_beside(picture, "voile-picture", {"tangle", message.path(), picture});
  } catch (const UserError&) {  // no room, no program: what matters is in the file
  }
}

std::string IntersectionCheck::report(const std::vector<Vec3>& positions,
                                      const std::vector<geometry::TrianglePair>& pairs,
                                      const std::filesystem::path& file) const {
  const Triangles all = triangles_at(positions);
  if (!file.empty()) {
    geometry::write_pairs(file, all.positions, all.triangles, all.body, pairs);
    draw(all, pairs, file);
  }
  const std::vector<contact::Body>& bodies_of_contact = contact_.scene().set().surface().bodies;
  const auto known = static_cast<Index>(bodies_of_contact.size());
  const mesh::SurfaceMesh& sheet = contact_.scene().dofs().mesh();
  std::vector<std::string> panels;
  std::vector<Index> panel_of(static_cast<std::size_t>(sheet.triangle_count()), no_index);
  if (!sheet.data().rest.empty())
    for (const mesh::Group& g : sheet.groups()) {
      if (g.dimension != 2) continue;
      for (const Index t : g.triangles) panel_of[t] = static_cast<Index>(panels.size());
      panels.push_back(g.name);
    }
  // A panel of the sheet counts as a body of its own.
  const auto part_of = [&](Index t) {
    const bool in_panel = t < sheet.triangle_count() && panel_of[t] != no_index;
    return in_panel ? known + panel_of[t] : all.body[static_cast<std::size_t>(t)];
  };
  const auto name_of = [&](Index part) {
    return part < known ? bodies_of_contact[part].name : fmt::format("panel '{}'", panels[part - known]);
  };
  std::map<std::pair<Index, Index>, std::pair<int, Vec3>> by_bodies;
  for (const auto& [i, j] : pairs) {
    const auto bodies = std::minmax({part_of(i), part_of(j)});
    auto& [count, place] = by_bodies[{bodies.first, bodies.second}];
    if (count++ == 0) place = all.positions[all.triangles[static_cast<std::size_t>(i)][0]];
  }
  std::vector<std::string> texts;
  for (const auto& [bodies, found] : by_bodies)
    texts.push_back(fmt::format("{} pair(s) of {} and {}, first near ({:.4g}, {:.4g}, {:.4g})", found.first,
                                name_of(bodies.first), name_of(bodies.second), found.second[0], found.second[1],
                                found.second[2]));
  return join(texts, "; ");
}

ObstaclePicture::ObstaclePicture(const system::ContactInput& input, const mesh::SurfaceMesh& sheet) {
  for (const contact::Obstacle& o : input.obstacles) {
    const geometry::TriangleSoup soup = surface_at_rest(o, sheet);
    const auto first = static_cast<Index>(rest_.positions.size());
    first_.push_back(rest_.positions.size());
    rest_.positions.insert(rest_.positions.end(), soup.positions.begin(), soup.positions.end());
    for (const mesh::Triangle& t : soup.triangles)
      rest_.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    rest_.obstacle.resize(rest_.triangles.size(), static_cast<int>(rest_.names.size()));
    rest_.names.push_back(o.name);
    rest_.moves = rest_.moves || o.motion || o.frames;
  }
  first_.push_back(rest_.positions.size());
}

std::vector<Vec3> ObstaclePicture::positions(const system::ContactScene& scene) const {
  std::vector<Vec3> x = rest_.positions;
  for (std::size_t k = 0; k + 1 < first_.size(); ++k) {
    const contact::Obstacle& o = scene.input().obstacles[k];
    if (o.shape == Shape::mesh) {
      const std::vector<Vec3> now = system::obstacle_points(scene, k);
      std::copy(now.begin(), now.end(), x.begin() + static_cast<std::ptrdiff_t>(first_[k]));
    } else if (o.motion) {
      for (std::size_t i = first_[k]; i < first_[k + 1]; ++i) x[i] += o.motion(rest_.positions[i], scene.time());
    }
  }
  return x;
}

}  // namespace voile::setup
