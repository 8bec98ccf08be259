#include "weave.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voile::picture {

namespace {

constexpr float pi = std::numbers::pi_v<float>;
constexpr float thread_radius = 0.46F;       // [distances of threads]: they leave a gap
constexpr float thread_flatness = 0.55F;     // height over width of a pressed thread
constexpr float crimp = 0.2F;                // of a thread, up and down [distances of threads]
constexpr float ply = 0.02F;                 // height of the plies that a thread is twisted of
constexpr float steepest = 1.5F;             // slope
constexpr float deepest_shade = 0.45F;       // light at the bottom of gaps
constexpr float gap_height = -0.35F;         // nothing is lower
constexpr int thread_texels = 32;            // of a thread
constexpr int most_taps = 8;                 // along the longer axis of a pixel
constexpr float wale = 1.0F, course = 0.8F;  // of a knit [distances of wales]
constexpr float leg_radius = 0.26F;

float wrapped(float x) {
  return x - std::floor(x);
}

/// Height of a thread of unit distance at `x` from its middle; below the gap outside.
float section(float x, float radius) {
  const float r = x / radius;
  return r * r < 1.0F ? thread_flatness * radius * std::sqrt(1.0F - r * r) : 2.0F * gap_height;
}

struct Point {
  float height, warp;
};

/// Whether the warp is on top where warp thread i and weft thread j cross.
bool warp_is_up(Weave weave, int i, int j) {
  if (weave == Weave::plain) return (i + j) % 2 == 0;
  return ((i - j) % 4 + 4) % 4 < 2;  // twill 2/2
}

/// Crimp of a thread between two crossings, 1 up to -1 down; `s`: from the middle of the one to the next.
float between_crossings(bool up, bool next, float s) {
  const float a = up ? 1.0F : -1.0F, b = next ? 1.0F : -1.0F;
  return a + (b - a) * 0.5F * (1.0F - std::cos(pi * s));
}

/// `x`, `y` across and along [distances of threads].
Point woven(Weave weave, bool back, float x, float y) {
  const auto up = [&](int i, int j) { return warp_is_up(weave, i, j) != back; };
  const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
  const auto crossing = [](float t) { return static_cast<int>(std::floor(t - 0.5F)); };
  const int k = crossing(y), m = crossing(x);
  const float rise = between_crossings(up(i, k), up(i, k + 1), y - 0.5F - static_cast<float>(k));
  const float fall = -between_crossings(up(m, j), up(m + 1, j), x - 0.5F - static_cast<float>(m));
  const float u = x - static_cast<float>(i) - 0.5F, v = y - static_cast<float>(j) - 0.5F;
  const float warp = section(u, thread_radius) + crimp * rise + ply * std::sin(2.0F * pi * (3.0F * u + 2.0F * y));
  const float weft = section(v, thread_radius) + crimp * fall + ply * std::sin(2.0F * pi * (3.0F * v - 2.0F * x));
  return {std::max({warp, weft, gap_height}), warp > weft ? 1.0F : 0.0F};
}

/// Stockinette: legs of loops that lean to each other on the right side, arcs of loops on the wrong side.
Point knitted(bool back, float x, float y) {
  float height = gap_height;
  const float v = y / course;
  for (int row = -1; row <= 1; ++row) {
    const float t = v - std::floor(v) - static_cast<float>(row);  // along the loop of that row, 0 to 1 in its course
    if (back) {
      // An arc, up in the middle of the wale and down at its sides.
      const float middle = 0.5F + 0.32F * std::cos(2.0F * pi * x), d = (t - middle) * course;
      height = std::max(height, section(d * 1.15F, leg_radius) + 0.1F * std::cos(2.0F * pi * x));
      continue;
    }
    if (t < -0.35F || t > 1.35F) continue;
    for (const float side : {-1.0F, 1.0F}) {
      const float middle = 0.5F + side * (0.09F + 0.26F * t), u = wrapped(x) - middle;
      const float d = (u - std::round(u)) * 0.9F;  // square to the leg, which leans
      height = std::max(height, section(d, leg_radius) + 0.12F * std::sin(pi * std::clamp(t, -0.5F, 1.5F)) +
                                    ply * std::sin(2.0F * pi * (4.0F * u + 3.0F * t * side)));
    }
  }
  return {height, back ? 0.0F : 1.0F};
}

Relief mixed(const Relief& a, const Relief& b, float t) {
  return {a.shade + t * (b.shade - a.shade), a.across + t * (b.across - a.across), a.along + t * (b.along - a.along),
          a.warp + t * (b.warp - a.warp)};
}

}  // namespace

Vec2f WeaveTile::repeat(Weave weave) {
  switch (weave) {
    case Weave::plain:
      return {2.0F, 2.0F};
    case Weave::twill:
      return {4.0F, 4.0F};
    case Weave::knit:
      break;
  }
  return {wale, course};
}

WeaveTile::WeaveTile(Weave weave, bool back)
    : size_(thread_texels * (weave == Weave::twill ? 4 : 2)) {  // powers of two
  const Vec2f whole = repeat(weave), cell = whole / static_cast<float>(size_);
  const auto n = static_cast<std::size_t>(size_);
  std::vector<Point> points(n * n);
  for (std::size_t row = 0; row < n; ++row)
    for (std::size_t column = 0; column < n; ++column) {
      const float x = (static_cast<float>(column) + 0.5F) * cell[0], y = (static_cast<float>(row) + 0.5F) * cell[1];
      points[row * n + column] = weave == Weave::knit ? knitted(back, x, y) : woven(weave, back, x, y);
    }
  const auto [low, high] = std::minmax_element(points.begin(), points.end(),
                                               [](const Point& a, const Point& b) { return a.height < b.height; });
  const float bottom = low->height, depth = high->height - low->height;
  const auto height = [&](std::size_t row, std::size_t column) { return points[row % n * n + column % n].height; };
  std::vector<Relief>& finest = levels_.emplace_back(n * n);
  float sum = 0.0F, across = 0.0F, along = 0.0F;
  for (std::size_t row = 0; row < n; ++row)
    for (std::size_t column = 0; column < n; ++column) {
      Relief& r = finest[row * n + column];
      r.across = (height(row, column + 1) - height(row, column + n - 1)) / (2.0F * cell[0]);
      r.along = (height(row + 1, column) - height(row + n - 1, column)) / (2.0F * cell[1]);
      r.across = std::clamp(r.across, -steepest, steepest);
      r.along = std::clamp(r.along, -steepest, steepest);
      r.warp = points[row * n + column].warp;
      r.shade = deepest_shade + (1.0F - deepest_shade) * (height(row, column) - bottom) / depth;
      sum += r.shade;
      across += r.across;
      along += r.along;
    }
  const auto count = static_cast<float>(n * n);
  for (Relief& r : finest) {
    r.shade *= count / sum;
    r.across -= across / count;
    r.along -= along / count;
  }
  add_levels();
}

void WeaveTile::add_levels() {
  for (std::size_t n = static_cast<std::size_t>(size_) / 2; n >= 1; n /= 2) {
    const std::vector<Relief>& fine = levels_.back();
    std::vector<Relief> coarse(n * n);
    for (std::size_t row = 0; row < n; ++row)
      for (std::size_t column = 0; column < n; ++column) {
        const std::size_t at = 4 * row * n + 2 * column;
        coarse[row * n + column] =
            mixed(mixed(fine[at], fine[at + 1], 0.5F), mixed(fine[at + 2 * n], fine[at + 2 * n + 1], 0.5F), 0.5F);
      }
    levels_.push_back(std::move(coarse));
  }
}

/// Linear between the four texels of a level that are round a place.
Relief WeaveTile::between(std::size_t level, const Vec2f& place) const {
  const std::vector<Relief>& texels = levels_[level];
  const int n = size_ >> level;
  const float x = place[0] * static_cast<float>(n) - 0.5F, y = place[1] * static_cast<float>(n) - 0.5F;
  const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
  const float s = x - static_cast<float>(i), t = y - static_cast<float>(j);
  const auto at = [&](int column, int row) -> const Relief& {
    return texels[static_cast<std::size_t>(row & (n - 1)) * static_cast<std::size_t>(n) +
                  static_cast<std::size_t>(column & (n - 1))];
  };
  return mixed(mixed(at(i, j), at(i + 1, j), s), mixed(at(i, j + 1), at(i + 1, j + 1), s), t);
}

Relief WeaveTile::at_level(float level, const Vec2f& place) const {
  const auto last = static_cast<float>(levels_.size() - 1);
  if (!(level < last)) return levels_.back().front();
  if (level <= 0.0F) return between(0, place);
  const auto below = static_cast<std::size_t>(level);
  return mixed(between(below, place), between(below + 1, place), level - static_cast<float>(below));
}

Relief WeaveTile::mean(const Vec2f& place, const Vec2f& u, const Vec2f& v) const {
  // Axes of the ellipse that u and v span: singular values of (u, v), and the direction of the longer one.
  const float uu = u.squaredNorm() + 1e-20F, vv = v.squaredNorm() + 1e-20F, uv = u.dot(v);
  const float angle = 0.5F * std::atan2(2.0F * uv, uu - vv);
  const Vec2f axis = std::cos(angle) * u + std::sin(angle) * v;
  const float longer = std::max(axis.norm(), 1e-10F);
  const float shorter = std::max(std::abs(u[0] * v[1] - u[1] * v[0]) / longer, longer / static_cast<float>(most_taps));
  const float level = std::log2(std::max(shorter * static_cast<float>(size_), 1e-6F));
  if (level >= static_cast<float>(levels_.size() - 1)) return levels_.back().front();
  const int taps = std::clamp(static_cast<int>(std::ceil(longer / shorter - 1e-3F)), 1, most_taps);
  const Vec2f from(wrapped(place[0]), wrapped(place[1]));
  Relief sum{0.0F, 0.0F, 0.0F, 0.0F};
  for (int k = 0; k < taps; ++k) {
    const float s = (static_cast<float>(k) + 0.5F) / static_cast<float>(taps) - 0.5F;
    const Relief r = at_level(level, from + s * axis);
    sum = mixed(sum, r, 1.0F / static_cast<float>(k + 1));
  }
  return sum;
}

}  // namespace voile::picture
