#include "seam_obstruction.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/text.hpp"
#include "contact/distance.hpp"
#include "contact/surface.hpp"

namespace voile::simulation {

namespace {

/// The straight way between two points of a seam.
struct Segment {
  Index from, to;
  Vec3 begin, end;
};

/// Whether a way passes through a triangle (Moeller and Trumbore, Fast, minimum storage ray/triangle intersection, 1997).
bool passes(const Segment& way, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 along = way.end - way.begin, e = b - a, f = c - a, p = along.cross(f);
  const double determinant = e.dot(p);
  if (determinant == 0.0) return false;
  const Vec3 from = way.begin - a, q = from.cross(e);
  const double u = from.dot(p) / determinant, v = along.dot(q) / determinant, t = f.dot(q) / determinant;
  return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0 && t <= 1.0;
}

/// What is in the way of one seam.
struct Obstruction {
  std::string seam;
  std::map<std::string, int> count;  ///< places by the name of what is there
  int open = 0, places = 0;          ///< open places; those at which something is
};

class Search {
 public:
  Search(const system::ContactScene& scene, const std::vector<Vec3>& positions)
      : surface_(scene.set().surface()), mesh_(scene.dofs().mesh()), x_(positions) {
    for (const mesh::Group& g : mesh_.groups())
      for (const Index t : g.triangles) piece_of_.insert({t, &g.name});
  }

  [[nodiscard]] Obstruction of(const mesh::Seam& seam, double gap) const {
    Obstruction all{seam.name, {}, 0, 0};
    for (const auto& [from, to] : seam.pairs) {
      const Segment way{from, to, x_[from], x_[to]};
      if ((way.end - way.begin).norm() <= gap) continue;
      const std::set<std::string> found = on(way);
      ++all.open;
      all.places += found.empty() ? 0 : 1;
      for (const std::string& name : found) ++all.count[name];
    }
    return all;
  }

 private:
  /// Names of what lies on a way.
  [[nodiscard]] std::set<std::string> on(const Segment& way) const {
    std::set<std::string> found;
    for (std::size_t f = 0; f < surface_.faces.size(); ++f) {
      const auto& [a, b, c] = surface_.faces[f].points;
      const auto is_end = [&](Index p) { return surface_.same(p, way.from) || surface_.same(p, way.to); };
      if (is_end(a) || is_end(b) || is_end(c)) continue;
      if (passes(way, x_[a], x_[b], x_[c])) found.insert(name_of(static_cast<Index>(f)));
    }
    for (const contact::Edge& e : surface_.edges)
      if (e.bare && !surface_.is_sheet(e.points[0]))
        add_if_near(contact::edge_edge({way.begin, way.end, x_[e.points[0]], x_[e.points[1]]}).distance, e.body, found);
    for (const Index p : surface_.bare_points)
      if (!surface_.is_sheet(p))
        add_if_near(contact::point_edge({x_[p], way.begin, way.end, Vec3::Zero()}).distance, surface_.body_of_point[p],
                    found);
    return found;
  }

  /// Balls and capsules are points and edges with a thickness.
  void add_if_near(double distance, int body, std::set<std::string>& found) const {
    if (distance < 0.5 * surface_.bodies[body].thickness) found.insert(obstacle(body));
  }
  [[nodiscard]] std::string obstacle(int body) const {
    return fmt::format("obstacle '{}'", surface_.bodies[body].name);
  }
  [[nodiscard]] std::string name_of(Index face) const {
    if (face >= surface_.sheet_faces) return obstacle(surface_.faces[face].body);
    const auto piece = piece_of_.find(face);
    return piece == piece_of_.end() ? "fabric" : fmt::format("piece '{}'", *piece->second);
  }

  const contact::Surface& surface_;
  const mesh::SurfaceMesh& mesh_;
  const std::vector<Vec3>& x_;
  std::map<Index, const std::string*> piece_of_;  ///< the first group that has a triangle
};

}  // namespace

std::string obstruction_text(const system::ContactScene& scene, const std::vector<Vec3>& positions,
                             const std::vector<std::string>& seams, double gap) {
  const Search search(scene, positions);
  Obstruction largest;
  for (const mesh::Seam& seam : scene.dofs().mesh().data().seams) {
    if (std::find(seams.begin(), seams.end(), seam.name) == seams.end()) continue;
    Obstruction now = search.of(seam, gap);
    if (now.places > largest.places) largest = std::move(now);
  }
  if (largest.places == 0) return "";
  std::vector<std::string> names;
  for (const auto& [name, times] : largest.count)
    names.push_back(fmt::format("{} (at {} of {})", name, times, largest.open));
  return fmt::format(
      "; between the two sides of seam '{}', at its {} open places, lies {}: lead the pieces round that from the start",
      largest.seam, largest.open, join(names, ", "));
}

}  // namespace voile::simulation
