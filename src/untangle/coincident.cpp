#include "coincident.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

namespace voile::untangle {

namespace {

/// Nearer than this fraction of the activation distance is on it.
constexpr double on_it = 1e-6;

Vec3 vertex_normal(const Tangle& tangle, Index p) {
  Vec3 sum = Vec3::Zero();
  for (Index f : tangle.faces_of_point[p]) sum += tangle.normal(f);
  return sum.normalized();
}

/// Half the way that point p of one piece goes from face f of another. [m]
Vec3 half_way(const Tangle& tangle, Index p, Index f, double distance) {
  const Surface& s = tangle.surface;
  const double way = 0.5 * (s.offset(s.body_of_point[p], s.faces[f].body) + distance);
  const bool first = tangle.pieces[p] < tangle.pieces[s.faces[f].points[0]];
  return first ? Vec3(-way * vertex_normal(tangle, p)) : Vec3(way * tangle.normal(f));
}

}  // namespace

void part_coincident(Tangle& tangle) {
  const Surface& s = tangle.surface;
  const double distance = wanted_gap * tangle.options.activation_distance;
  std::vector<Box> boxes(tangle.x.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) boxes[i].include(tangle.x[i]);
  const std::vector<char> all(static_cast<std::size_t>(s.sheet_points), 1);
  std::vector<Vec3> way(all.size(), Vec3::Zero());
  for (const Pair& pair : find_pairs(s, all_figures(s), boxes, all, on_it * tangle.options.activation_distance)) {
    const auto& [p, a, b, c] = pair.points;
    if (pair.kind != PairKind::point_triangle || !s.is_sheet(p) || !s.is_sheet(a)) continue;
    if (tangle.pieces[p] == tangle.pieces[a]) continue;
    const double apart = point_triangle({tangle.x[p], tangle.x[a], tangle.x[b], tangle.x[c]}).distance;
    if (apart > on_it * tangle.options.activation_distance) continue;
    for (Index f : tangle.faces_of_point[a])
      if (s.faces[f].points == std::array<Index, 3>{a, b, c}) {
        const Vec3 asked = half_way(tangle, p, f, distance);
        if (asked.norm() > way[p].norm()) way[p] = asked;
      }
  }
  for (std::size_t i = 0; i < way.size(); ++i) tangle.x[i] += tangle.free[i] * way[i];
}

}  // namespace voile::untangle
