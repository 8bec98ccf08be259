#include "operations.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace voile::adapt {

namespace {

/// By how much two angles must exceed 180 degrees, so that four points on a circle are left as they are [rad].
constexpr double delaunay_slack = 1e-3;

double angle_at(const Vec3& apex, const Vec3& a, const Vec3& b) {
  return std::atan2((a - apex).cross(b - apex).norm(), (a - apex).dot(b - apex));
}

/// The two triangles of an edge: a -> o -> d and b -> d -> o.
struct Quad {
  Vec3 a, b, o, d;
};

/// Departure of a vertex from its wanted number of edges.
int misfit(const Surface& s, Index e, int change) {
  const Surface::Valence v = s.valence(e);
  const int wanted = v.inside ? 6 : 4, off = v.edges + change - wanted;
  // Four and less cost twice: patches degenerate.
  return off * off + (v.inside && off < -1 ? 4 : 0);
}

bool lowers_misfit(const Surface& s, Index h) {
  const Index g = s.twin[h];
  int before = 0, after = 0;
  for (const Index e : {h, g}) {
    before += misfit(s, e, 0) + misfit(s, prev(e), 0);
    after += misfit(s, e, -1) + misfit(s, prev(e), 1);
  }
  return after < before;
}

/// Smallest angle that turning an edge may leave [rad].
double angle_left(double before, FlipRule rule, const Options& options) {
  if (rule == FlipRule::valence) return std::min(0.7 * good_angle, before);
  return rule == FlipRule::none ? std::min(options.smallest_angle, before) : std::min(good_angle, 0.99 * before);
}

bool rest_shape_allows(const Surface& s, const Quad& q, FlipRule rule, const Options& options) {
  const double pi = std::numbers::pi;
  if (angle_at(q.o, q.a, q.d) + angle_at(q.o, q.d, q.b) > 0.99 * pi ||
      angle_at(q.d, q.a, q.o) + angle_at(q.d, q.o, q.b) > 0.99 * pi)
    return false;
  const Vec3 normal = (q.o - q.a).cross(q.d - q.a) + (q.d - q.b).cross(q.o - q.b);
  const double after = std::min(smallest_angle(q.a, q.o, q.b, normal), smallest_angle(q.b, q.d, q.a, normal));
  const double before = std::min(smallest_angle(q.a, q.o, q.d, normal), smallest_angle(q.b, q.d, q.o, normal));
  if (after <= 0.0 || after < angle_left(before, rule, options)) return false;
  if (!s.first->curved()) return true;
  const Vec3 n1 = (q.o - q.a).cross(q.b - q.a).normalized(), n2 = (q.d - q.b).cross(q.a - q.b).normalized();
  return n1.dot(n2) >= std::cos(largest_rest_dihedral);
}

/// Dihedral angles in space: no fold is turned, none is made.
bool space_allows(const Quad& x, double limit) {
  const Vec3 n1 = (x.o - x.a).cross(x.d - x.a), n2 = (x.d - x.b).cross(x.o - x.b);
  if (n1.dot(n2) < std::cos(limit) * n1.norm() * n2.norm()) return false;
  const Vec3 m1 = (x.o - x.a).cross(x.b - x.a), m2 = (x.d - x.b).cross(x.a - x.b), mean = n1 + n2;
  return m1.dot(mean) > 1e-6 * m1.norm() * mean.norm() && m2.dot(mean) > 1e-6 * m2.norm() * mean.norm();
}

/// Distance in space of the two diagonals at the point where they cross at rest, unfolded [m].
double flip_displacement(const Quad& rest, const Quad& place) {
  const double length = (rest.d - rest.o).norm();
  const Vec3 along = (rest.d - rest.o) / length;
  const auto flat = [&](const Vec3& x, double side) {
    const double t = (x - rest.o).dot(along);
    return Vec2(t, side * (x - rest.o - t * along).norm());
  };
  const Vec2 a = flat(rest.a, 1.0), b = flat(rest.b, -1.0);
  const double g = a.y() / (a.y() - b.y()), f = (a.x() + g * (b.x() - a.x())) / length;
  return (place.a + g * (place.b - place.a) - place.o - f * (place.d - place.o)).norm();
}

Quad places_of(const Surface& s, Index h) {
  return {s.place[s.apex(h)], s.place[s.apex(s.twin[h])], s.place[s.origin(h)], s.place[s.dest(h)]};
}

bool valences_allow_flip(const Surface& s, Index h, FlipRule rule) {
  const int least = rule == FlipRule::valence ? 5 : 4;
  for (const Index e : {h, s.twin[h]}) {
    const Surface::Valence v = s.valence(e);
    if (v.edges - 1 < (v.inside ? least : s.fixed[s.origin(e)] ? 2 : 3)) return false;
  }
  return true;
}

}  // namespace

Outcome try_flip(Surface& s, Index h, const Options& options, FlipRule rule) {
  const Index g = s.twin[h];
  if (g == no_index || s.side_class[h] != 0 || s.locked(h)) return Outcome::feature;
  const Quad rest{s.rest[h], s.rest[g], s.rest[next(h)], s.rest[prev(h)]};
  if (rule == FlipRule::delaunay &&
      angle_at(rest.a, rest.o, rest.d) + angle_at(rest.b, rest.o, rest.d) < std::numbers::pi + delaunay_slack)
    return Outcome::feature;
  if (rule == FlipRule::valence && !lowers_misfit(s, h)) return Outcome::feature;
  if (!valences_allow_flip(s, h, rule) || s.joined(prev(h), s.apex(g)) || !s.can_join(s.apex(h), s.apex(g)) ||
      !rest_shape_allows(s, rest, rule, options))
    return Outcome::quality;
  if (rule == FlipRule::valence &&
      2.0 * (rest.b - rest.a).norm() > options.split * (s.size[s.apex(h)] + s.size[s.apex(g)]))
    return Outcome::quality;
  const Quad place = places_of(s, h);
  if (!space_allows(place, options.largest_flip)) return Outcome::quality;
  if (!s.allowed.empty()) {
    const std::vector<Index> triangles{h / 3, g / 3};
    const Surface::Budget budget = s.budget(triangles);
    const double moved = flip_displacement(rest, place);
    if (!(budget.moved + moved <= budget.allowed)) return Outcome::clearance;
    s.charge(triangles, budget, moved);
  }
  s.flip(h);
  return Outcome::done;
}

Outcome try_move(Surface& s, const Star& star, const Fan& fan, const Vec2& target, double angle) {
  Index hint = s.rest_hint[star.spokes[0] / 3];
  Vec3 rest = fan.origin + target.x() * fan.e1 + target.y() * fan.e2;
  if (s.first->curved()) {
    if (hint == no_index) hint = s.first->locate(fan.centre_rest, fan.normal);
    rest = s.first->on_surface(rest, hint);
  }
  double before = std::numeric_limits<double>::infinity(), after = before;
  for (int i = 0; i < fan.size(); ++i) {
    const int j = (i + 1) % fan.size();
    before = std::min(before, smallest_angle(fan.centre_rest, fan.rest[i], fan.rest[j], fan.normal));
    after = std::min(after, smallest_angle(rest, fan.rest[i], fan.rest[j], fan.normal));
  }
  if (after <= 0.0 || after < std::min(angle, before)) return Outcome::quality;
  const Vec2 plane = fan.to_plane(rest);
  const InFan in = locate(fan, fan.centre, plane);
  const auto mean = [&](const auto& centre, const auto& a, const auto& b) {
    return (in.weights[0] * centre + in.weights[1] * a + in.weights[2] * b).eval();
  };
  Vec3 place = mean(fan.centre_place, fan.place[in.i], fan.place[in.j]);
  // On a curved rest shape it stays as far off its triangles as it is there.
  if (s.first->curved() && !s.allowed.empty())
    place += s.carried(star.spokes[static_cast<std::size_t>(in.i)] / 3,
                       rest - mean(fan.centre_rest, fan.rest[in.i], fan.rest[in.j]));
  Vec2 texture = Vec2::Zero();
  if (!s.texture.empty()) {
    const Index e = star.spokes[static_cast<std::size_t>(in.i)];
    texture = mean(s.texture[next(e)], s.texture[prev(e)], s.texture[e]);
  }
  std::vector<Index> triangles;
  for (Index e : star.spokes) triangles.push_back(e / 3);
  if (!s.allowed.empty()) {
    const Surface::Budget budget = s.budget(triangles);
    const double moved = displacement(fan, plane, place, -1);
    if (!(budget.moved + moved <= budget.allowed)) return Outcome::clearance;
    s.charge(triangles, budget, moved);
  }
  for (Index e : star.spokes) {
    s.touched[e / 3] = 1;
    s.rest[next(e)] = rest;
    s.rest_hint[e / 3] = hint;
    if (!s.texture.empty()) s.texture[next(e)] = texture;
  }
  s.place[star.vertex] = place;
  s.size[star.vertex] = s.size_at(rest, s.old_hint[star.spokes[0] / 3]);
  s.old[star.vertex] = no_index;
  ++s.counts.smoothed;
  return Outcome::done;
}

Outcome try_smooth(Surface& s, Index v, const Options& options) {
  if (s.fixed[v] || s.on_feature[v]) return Outcome::feature;
  const Star star = star_of(s, v);
  const Fan fan = make_fan(s, star, 0, star.triangles());
  Vec2 sum = Vec2::Zero();
  double weights = 0.0, shortest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < fan.size(); ++i) {
    const int j = (i + 1) % fan.size();
    const Vec2 a = fan.plane[i] - fan.centre, b = fan.plane[j] - fan.centre;
    const double size = s.size[v] + s.size[star.ring[i]] + s.size[star.ring[j]];
    const double w = std::abs(a.x() * b.y() - a.y() * b.x()) / (size * size);
    sum += w * (fan.centre + fan.plane[i] + fan.plane[j]) / 3.0;
    weights += w;
    shortest = std::min(shortest, a.norm());
  }
  const Vec2 target = sum / weights;
  // What is nearly there stays: kept vertices are worth more than the last percent.
  if ((target - fan.centre).norm() < 0.05 * shortest) return Outcome::feature;
  return try_move(s, star, fan, target, std::max(options.smallest_angle, good_angle));
}

void count(Counts& counts, Outcome outcome) {
  if (outcome == Outcome::feature) ++counts.refused_by_feature;
  if (outcome == Outcome::quality) ++counts.refused_by_quality;
  if (outcome == Outcome::clearance) ++counts.refused_by_clearance;
}

}  // namespace voile::adapt
