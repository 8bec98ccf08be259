#include "star.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace voile::adapt {

namespace {

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Shares at which the segments a-b and c-d cross, if they do.
std::optional<Vec2> crossing(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const Vec2 p = b - a, q = d - c;
  const double det = cross(p, q);
  if (std::abs(det) <= 1e-14 * p.norm() * q.norm()) return std::nullopt;
  const double u = cross(c - a, q) / det, v = cross(c - a, p) / det;
  constexpr double slack = 1e-9;
  if (u < -slack || u > 1.0 + slack || v < -slack || v > 1.0 + slack) return std::nullopt;
  return Vec2(u, v);
}

Vec3 interpolate(const Fan& fan, const Vec2& c, const Vec3& x, const Vec2& point) {
  const InFan in = locate(fan, c, point);
  return in.weights[0] * x + in.weights[1] * fan.place[in.i] + in.weights[2] * fan.place[in.j];
}

}  // namespace

Star star_of(const Surface& s, Index v) {
  Star star;
  star.vertex = v;
  const Index start = s.first_around(s.leaving[v]);
  star.closed = s.twin[start] != no_index;
  Index e = start;
  do {
    star.spokes.push_back(e);
    star.ring.push_back(s.dest(e));
    e = s.left(e);
  } while (e != no_index && e != start);
  if (!star.closed) star.ring.push_back(s.apex(star.spokes.back()));
  return star;
}

int other_line(const Surface& s, const Star& star, int k) {
  for (int i = 0; i < star.triangles(); ++i)
    if (i != k && s.side_class[star.spokes[i]] != 0) return i;
  return -1;
}

Fan make_fan(const Surface& s, const Star& star, int from, int count) {
  Fan fan;
  const int n = star.triangles();
  fan.closed = star.closed && count == n;
  Vec3 normal = Vec3::Zero();
  for (int k = 0; k < count; ++k) {
    const int i = (from + k) % n;
    const Index e = star.spokes[i];
    fan.triangles.push_back(i);
    fan.ring.push_back(i);
    fan.rest.push_back(s.rest[prev(e)]);
    const Vec3& c = s.rest[next(e)];
    normal += (s.rest[prev(e)] - c).cross(s.rest[e] - c);
    if (k + 1 < count || fan.closed) continue;
    fan.ring.push_back(star.closed ? (i + 1) % n : i + 1);
    fan.rest.push_back(s.rest[e]);
  }
  fan.normal = normal.normalized();
  fan.origin = fan.centre_rest = s.rest[next(star.spokes[from % n])];
  fan.centre_place = s.place[star.vertex];
  fan.e1 = fan.normal.unitOrthogonal();
  fan.e2 = fan.normal.cross(fan.e1);
  fan.centre = Vec2::Zero();
  for (int i = 0; i < fan.size(); ++i) {
    fan.plane.push_back(fan.to_plane(fan.rest[i]));
    fan.place.push_back(s.place[star.ring[fan.ring[i]]]);
  }
  return fan;
}

double displacement(const Fan& fan, const Vec2& centre, const Vec3& place, int at) {
  double largest = (interpolate(fan, centre, place, fan.centre) - fan.centre_place).norm();
  if (at < 0) largest = std::max(largest, (interpolate(fan, fan.centre, fan.centre_place, centre) - place).norm());
  for (int i = 0; i < fan.size(); ++i)
    for (int j = 0; j < fan.size(); ++j) {
      if (i == j || j == at || i == at) continue;
      const auto fractions = crossing(fan.centre, fan.plane[i], centre, fan.plane[j]);
      if (!fractions) continue;
      const Vec3 before = fan.centre_place + (*fractions)[0] * (fan.place[i] - fan.centre_place);
      const Vec3 after = place + (*fractions)[1] * (fan.place[j] - place);
      largest = std::max(largest, (after - before).norm());
    }
  return largest;
}

InFan locate(const Fan& fan, const Vec2& centre, const Vec2& point) {
  double best = -std::numeric_limits<double>::infinity();
  InFan found;
  const int n = fan.closed ? fan.size() : fan.size() - 1;
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % fan.size();
    const Vec2 a = fan.plane[i] - centre, b = fan.plane[j] - centre, p = point - centre;
    const double area = cross(a, b);
    if (!(area > 1e-14 * (a.squaredNorm() + b.squaredNorm()))) continue;  // where the centre is one of the ring
    const double u = cross(p, b) / area, v = cross(a, p) / area, inside = std::min({u, v, 1.0 - u - v});
    if (inside <= best) continue;
    best = inside;
    found = {i, j, Vec3(1.0 - u - v, u, v)};
  }
  return found;
}

double smallest_angle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& normal) {
  const Vec3 n = (b - a).cross(c - a);
  const double twice = n.norm();
  if (n.dot(normal) <= 0.0) return -1.0;
  const Vec3 ab = b - a, bc = c - b, ca = a - c;
  return std::min({std::atan2(twice, -ab.dot(ca)), std::atan2(twice, -bc.dot(ab)), std::atan2(twice, -ca.dot(bc))});
}

}  // namespace voile::adapt
