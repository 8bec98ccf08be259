#include <algorithm>
#include <limits>

#include "operations.hpp"
#include "undo.hpp"

namespace voile::adapt {

namespace {

/// Smallest angle [rad] while one end is half-way: what is as pointed as that goes.
constexpr double on_the_way = 0.02;
/// Smallest angle [rad] of what is made: with less, beside lines that stay finer than wanted, patches get near a conic.
constexpr double least_angle = 0.7 * good_angle;

/// Of the triangles and edges of a vertex that do not meet another one: smallest angle [rad], shortest and longest edge (L/h).
struct Left {
  double angle = std::numeric_limits<double>::infinity(), least = angle, most = 0.0;
};

Left left_at(const Surface& s, Index u, Index gone) {
  Left left;
  const Star star = star_of(s, u);
  const auto edge = [&](Index h) {
    left.least = std::min(left.least, s.metric_length(h));
    left.most = std::max(left.most, s.metric_length(h));
  };
  for (Index e : star.spokes) {
    if (s.dest(e) != gone) edge(e);
    if (s.twin[prev(e)] == no_index && s.apex(e) != gone) edge(prev(e));
    if (s.dest(e) == gone || s.apex(e) == gone) continue;
    const Vec3 &a = s.rest[e], &b = s.rest[next(e)], &c = s.rest[prev(e)];
    left.angle = std::min(left.angle, smallest_angle(a, b, c, (b - a).cross(c - a)));
  }
  return left;
}

Outcome move_half_way(Surface& s, const Star& star, Index v) {
  if (s.on_feature[star.vertex]) return try_slide_towards(s, star.vertex, v, on_the_way);
  const Fan fan = make_fan(s, star, 0, star.triangles());
  const auto k = std::find(star.ring.begin(), star.ring.end(), v) - star.ring.begin();
  return try_move(s, star, fan, 0.5 * (fan.centre + fan.plane[static_cast<std::size_t>(k)]), on_the_way);
}

/// Moves u half-way to v and removes v into it.
Outcome merge(Surface& s, Index u, Index v, double shortest, const Options& options) {
  const Star star = star_of(s, u);
  // What is shorter already may stay so.
  shortest = std::min(shortest, left_at(s, u, v).least);
  const MoveUndo undo(s, star);
  const Outcome moved = move_half_way(s, star, v);
  if (moved != Outcome::done) return moved;
  const Left left = left_at(s, u, v);
  Outcome outcome = Outcome::quality;
  if (left.angle >= least_angle && left.least >= shortest && left.most < options.longest_at_last) {
    const Star removed = star_of(s, v);
    const auto k = std::find(removed.ring.begin(), removed.ring.end(), u) - removed.ring.begin();
    Options at_last = options;
    at_last.longest_after = options.longest_at_last;
    outcome = try_collapse(s, removed, static_cast<int>(k), at_last, {true, least_angle});
  }
  if (outcome != Outcome::done) undo(s, star);
  return outcome;
}

}  // namespace

Outcome try_merge(Surface& s, Index h, const Options& options) {
  const Index o = s.origin(h), d = s.dest(h);
  if (s.fixed[o] || s.fixed[d] || s.on_feature[o] != s.on_feature[d]) return Outcome::feature;
  if (s.on_feature[o] && s.side_class[h] == 0) return Outcome::feature;
  const double length = s.metric_length(h);
  const Outcome first = merge(s, o, d, length, options);
  return first == Outcome::done ? first : merge(s, d, o, length, options);
}

}  // namespace voile::adapt
