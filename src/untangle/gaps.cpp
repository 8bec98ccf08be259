#include "gaps.hpp"

#include <algorithm>
#include <limits>

namespace voile::untangle {

namespace {

/// Over the pairs that are too near: widening one gap may narrow another.
constexpr int passes = 3;

}  // namespace

Gaps::Gaps(Tangle& tangle, const std::vector<Plane>& planes)
    : tangle_(tangle),
      planes_(planes),
      least_(least_gap * tangle.options.activation_distance),
      wanted_(wanted_gap * tangle.options.activation_distance),
      has_faces_(tangle.surface.bodies.size(), false) {
  for (const Face& face : tangle.surface.faces) has_faces_[face.body] = true;
}

std::vector<Pair> Gaps::near_pairs() const {
  const std::vector<Vec3>& x = tangle_.x;
  std::vector<Box> boxes(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) boxes[i].include(x[i]);
  return find_pairs(tangle_.surface, all_figures(tangle_.surface), boxes,
                    std::vector<char>(static_cast<std::size_t>(tangle_.surface.sheet_points), 1),
                    tangle_.options.activation_distance);
}

Closest Gaps::closest_of(const Pair& pair) const {
  std::array<Vec3, 4> p;
  for (int i = 0; i < 4; ++i) p[i] = pair.points[i] == no_index ? Vec3(Vec3::Zero()) : tangle_.x[pair.points[i]];
  return closest(pair.kind, p);
}

double Gaps::plane_gap(const Plane& p, Index i) const {
  return p.normal.dot(tangle_.x[i]) - p.level - tangle_.surface.offset(p.body, tangle_.surface.body_of_point[i]);
}

bool Gaps::plane_acts(const Plane& p, Index i) const {
  return tangle_.surface.rules[p.body][tangle_.surface.body_of_point[i]].touch;
}

void Gaps::widen_planes() {
  for (const Plane& p : planes_)
    for (Index i = 0; i < tangle_.surface.sheet_points; ++i) {
      const double gap = plane_gap(p, i);
      if (plane_acts(p, i) && gap < least_)
        tangle_.fraction({i, no_index, no_index, no_index}, Vec4::UnitX(), (wanted_ - gap) * p.normal,
                         [&](Index v, const Vec3& d) { tangle_.x[v] += d; });
    }
}

void Gaps::widen_pair(const Pair& pair) {
  const Closest near = closest_of(pair);
  const double gap = near.distance - pair.fraction * tangle_.surface.offset(pair.body_a, pair.body_b);
  if (gap < pair.fraction * least_ && near.distance > 0.0)
    tangle_.fraction(pair.points, near.c, (pair.fraction * wanted_ - gap) / near.distance * near.w,
                     [&](Index v, const Vec3& d) { tangle_.x[v] += d; });
}

void Gaps::widen(bool all) {
  const std::vector<Pair> pairs = near_pairs();
  for (int pass = 0; pass < passes; ++pass) {
    widen_planes();
    for (const Pair& pair : pairs)
      if (all || tells_inside(pair)) widen_pair(pair);
  }
}

double Gaps::smallest() const {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Pair& pair : near_pairs()) {
    const double offset = pair.fraction * tangle_.surface.offset(pair.body_a, pair.body_b);
    smallest = std::min(smallest, (closest_of(pair).distance - offset) / pair.fraction);
  }
  for (const Plane& p : planes_)
    for (Index i = 0; i < tangle_.surface.sheet_points; ++i)
      if (plane_acts(p, i)) smallest = std::min(smallest, plane_gap(p, i));
  return smallest;
}

}  // namespace voile::untangle
