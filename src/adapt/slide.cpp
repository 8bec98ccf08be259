#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "operations.hpp"

namespace voile::adapt {

namespace {

/// Distance from the chord, relative to it, below which a line is straight.
constexpr double on_chord = 1e-9;

/// The triangles on one side of a line through the vertex, and the line's ends there: u -> vertex -> w.
struct Bank {
  Fan fan;
  int u, w;               ///< of the fan's ring
  double fraction = 0.0;  ///< of the vertex on the chord from u to w
};

Bank make_bank(const Surface& s, const Star& star, int from, int count, bool starts_at_u) {
  Bank b{make_fan(s, star, from, count), starts_at_u ? 0 : count, starts_at_u ? count : 0};
  const Vec3 chord = b.fan.rest[b.w] - b.fan.rest[b.u];
  b.fraction = (b.fan.centre_rest - b.fan.rest[b.u]).dot(chord) / chord.squaredNorm();
  return b;
}

bool is_straight(const Surface& s, const Bank& b) {
  const Vec3 &u = b.fan.rest[b.u], &w = b.fan.rest[b.w];
  const double length = (w - u).norm();
  return (u + b.fraction * (w - u) - b.fan.centre_rest).norm() < on_chord * length &&
         s.first->curve_deviation(u, w) < on_chord * length;
}

/// What was at the ends and at the vertex, at a fraction of the chord; the vertex is at `at`.
template <typename T>
T between(const T& u, const T& v, const T& w, double at, double fraction) {
  if (fraction < at) return u + fraction / at * (v - u);
  return v + (fraction - at) / (1.0 - at) * (w - v);
}

bool shape_allows(const Bank& b, const Vec3& rest, double angle) {
  double before = std::numeric_limits<double>::infinity(), after = before;
  for (int i = 0; i + 1 < b.fan.size(); ++i) {
    before = std::min(before, smallest_angle(b.fan.centre_rest, b.fan.rest[i], b.fan.rest[i + 1], b.fan.normal));
    after = std::min(after, smallest_angle(rest, b.fan.rest[i], b.fan.rest[i + 1], b.fan.normal));
  }
  return after > 0.0 && after >= std::min(angle, before);
}

void move(Surface& s, const Star& star, const Bank& b, const Vec3& rest, double fraction) {
  const Index first = star.spokes[static_cast<std::size_t>(b.fan.triangles.front())],
              last = star.spokes[static_cast<std::size_t>(b.fan.triangles.back())];
  Vec2 texture = Vec2::Zero();
  if (!s.texture.empty()) {
    const Vec2 &begin = s.texture[prev(first)], &end = s.texture[last];
    texture =
        between<Vec2>(b.u == 0 ? begin : end, s.texture[next(first)], b.u == 0 ? end : begin, b.fraction, fraction);
  }
  for (int i : b.fan.triangles) {
    const Index c = next(star.spokes[i]);
    s.touched[c / 3] = 1;
    s.rest[c] = rest;
    if (!s.texture.empty()) s.texture[c] = texture;
  }
}

/// The spokes of a vertex on a line, of its ring.
struct Ends {
  int k, j;
};

Ends ends_of(const Surface& s, const Star& star) {
  if (!star.closed) return {0, star.triangles()};
  const int k = other_line(s, star, -1);
  return {k, other_line(s, star, k)};
}

std::vector<Bank> banks_of(const Surface& s, const Star& star, const Ends& ends) {
  const int n = star.triangles(), k = ends.k, j = ends.j;
  std::vector<Bank> banks{make_bank(s, star, k, j - k, true)};
  if (star.closed) banks.push_back(make_bank(s, star, j, n - (j - k), false));
  return banks;
}

/// Moves a vertex to a fraction of the chord of its first bank.
Outcome slide_to(Surface& s, const Star& star, const std::vector<Bank>& banks, double fraction, double angle) {
  const double at = banks[0].fraction;
  // On the other bank, whose side may be longer, at the same place of the line.
  const auto fraction_on = [&](const Bank& b) { return between(0.0, b.fraction, 1.0, at, fraction); };
  const auto rest_on = [&](const Bank& b) -> Vec3 {
    return b.fan.rest[b.u] + fraction_on(b) * (b.fan.rest[b.w] - b.fan.rest[b.u]);
  };
  for (const Bank& b : banks)
    if (!shape_allows(b, rest_on(b), angle)) return Outcome::quality;
  const Fan& fan = banks[0].fan;
  const Vec3 place = between<Vec3>(fan.place[banks[0].u], fan.centre_place, fan.place[banks[0].w], at, fraction);
  if (!s.allowed.empty()) {
    std::vector<Index> triangles;
    for (Index e : star.spokes) triangles.push_back(e / 3);
    const Surface::Budget budget = s.budget(triangles);
    double moved = 0.0;
    for (const Bank& b : banks) moved = std::max(moved, displacement(b.fan, b.fan.to_plane(rest_on(b)), place, -1));
    if (!(budget.moved + moved <= budget.allowed)) return Outcome::clearance;
    s.charge(triangles, budget, moved);
  }
  for (const Bank& b : banks) move(s, star, b, rest_on(b), fraction_on(b));
  s.place[star.vertex] = place;
  s.size[star.vertex] =
      s.size_at(rest_on(banks[0]), s.old_hint[star.spokes[static_cast<std::size_t>(fan.triangles[0])] / 3]);
  s.old[star.vertex] = no_index;
  ++s.counts.smoothed;
  return Outcome::done;
}

bool is_straight(const Surface& s, const std::vector<Bank>& banks) {
  return std::all_of(banks.begin(), banks.end(), [&](const Bank& b) { return is_straight(s, b); });
}

}  // namespace

Outcome try_slide(Surface& s, Index v, const Options& options) {
  if (s.fixed[v] || !s.on_feature[v]) return Outcome::feature;
  const Star star = star_of(s, v);
  const Ends ends = ends_of(s, star);
  const std::vector<Bank> banks = banks_of(s, star, ends);
  if (!is_straight(s, banks)) return Outcome::feature;
  const double at = banks[0].fraction, u = s.size[star.ring[ends.k]], w = s.size[star.ring[ends.j]];
  const double fraction = (u + s.size[v]) / (u + 2.0 * s.size[v] + w);
  if (std::abs(fraction - at) < 0.05 * std::min(at, 1.0 - at)) return Outcome::feature;
  return slide_to(s, star, banks, fraction, std::max(options.smallest_angle, good_angle));
}

Outcome try_slide_towards(Surface& s, Index v, Index end, double angle) {
  const Star star = star_of(s, v);
  const Ends ends = ends_of(s, star);
  const std::vector<Bank> banks = banks_of(s, star, ends);
  if (!is_straight(s, banks)) return Outcome::feature;
  const double at = banks[0].fraction;
  return slide_to(s, star, banks, star.ring[ends.k] == end ? 0.5 * at : 0.5 * (1.0 + at), angle);
}

}  // namespace voile::adapt
