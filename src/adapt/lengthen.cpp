#include <algorithm>
#include <limits>
#include <numbers>

#include "repair.hpp"

namespace voile::adapt {

namespace {

constexpr int directions = 8, halvings = 3;
/// Of the wanted length: the first step of a search.
constexpr double first_step = 0.12;
/// Of the wanted length: what the shortest edge has to gain where it does not get as long as `shortest`.
constexpr double least_gain = 0.03;

/// Shortest and longest edge of a star, L/h, with its centre at a point of the plane.
struct Range {
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
};

Range range_at(const Surface& s, const Star& star, const Fan& fan, const Vec2& point) {
  Range range;
  for (int i = 0; i < fan.size(); ++i) {
    const double ratio = 2.0 * (fan.plane[i] - point).norm() / (s.size[star.vertex] + s.size[star.ring[fan.ring[i]]]);
    range.least = std::min(range.least, ratio);
    range.most = std::max(range.most, ratio);
  }
  return range;
}

}  // namespace

Outcome try_lengthen(Surface& s, Index v, const Options& options) {
  if (s.fixed[v] || s.on_feature[v]) return Outcome::feature;
  const Star star = star_of(s, v);
  const Fan fan = make_fan(s, star, 0, star.triangles());
  Vec2 best = fan.centre;
  const Range start = range_at(s, star, fan, best);
  Range reached = start;
  const double most = std::max(options.longest_after, start.most);
  double step = first_step * s.size[v];
  for (int left = halvings; left > 0 && reached.least < options.shortest;) {
    const Vec2 from = best;
    for (int k = 0; k < directions; ++k) {
      const double a = 2.0 * std::numbers::pi * k / directions;
      const Vec2 point = from + step * Vec2(std::cos(a), std::sin(a));
      const Range range = range_at(s, star, fan, point);
      if (range.least <= reached.least || range.most > most) continue;
      reached = range;
      best = point;
    }
    if (best == from) {
      step *= 0.5;
      --left;
    }
  }
  if (reached.least < std::min(options.shortest, start.least + least_gain)) return Outcome::quality;
  return try_move_well(s, star, fan, best, std::max(options.smallest_angle, good_angle));
}

}  // namespace voile::adapt
