#include "dxf_slits.hpp"

#include <algorithm>

namespace voile::pattern {

namespace {

/// Fraction of the extent by which the sides of a slit differ at its mouth; and of its length, beyond which it has a shape.
constexpr double mouth = 2e-4, mouth_of_length = 0.05;

struct Ends {
  Vec2 start, end;
};

double extent(const std::vector<Ends>& all) {
  if (all.empty()) return 0.0;
  Vec2 low = all.front().start, high = low;
  for (const Ends& e : all) {
    low = low.cwiseMin(e.start).cwiseMin(e.end);
    high = high.cwiseMax(e.start).cwiseMax(e.end);
  }
  return (high - low).norm();
}

std::vector<Ends> ends_of(const std::vector<Curve>& curves) {
  std::vector<Ends> all;
  for (const Curve& c : curves) all.push_back({c.start(), c.end()});
  return all;
}

/// The curve turned and scaled until it begins at x and ends where it did.
Curve begun_at(const Curve& c, const Vec2& x) {
  const Vec2 end = c.end(), was = c.start() - end, is = x - end;
  const double square = was.squaredNorm();
  if (square == 0.0) return c;
  const double real = was.dot(is) / square, imaginary = cross(was, is) / square;
  Mat2 m;
  m << real, -imaginary, imaginary, real;
  const Vec2 shift = end - m * end;
  return c.mapped(m, shift);
}

}  // namespace

void take_out_double_lines(std::vector<Curve>& curves, std::vector<Vec2>& slits) {
  const std::vector<Ends> ends = ends_of(curves);
  double longest = 0.0;
  for (std::size_t k = 0; k < curves.size(); ++k)
    longest = std::max({longest, (ends[k].start - ends[k].end).norm(), curves[k].length()});
  const double near = same_place * longest;
  const auto same = [near](const Vec2& a, const Vec2& b) { return (a - b).norm() <= near; };
  std::vector<bool> taken(curves.size());
  const auto meets_others = [&](const Vec2& x, std::size_t i, std::size_t k) {
    for (std::size_t other = 0; other < ends.size(); ++other)
      if (other != i && other != k && !taken[other] && (same(ends[other].start, x) || same(ends[other].end, x)))
        return true;
    return false;
  };
  for (std::size_t i = 0; i < curves.size(); ++i) {
    if (taken[i] || !curves[i].is_line()) continue;
    for (std::size_t k = i + 1; k < curves.size(); ++k) {
      if (taken[k] || !curves[k].is_line()) continue;
      const bool there_and_back = same(ends[i].start, ends[k].end) && same(ends[i].end, ends[k].start);
      const bool there_twice = same(ends[i].start, ends[k].start) && same(ends[i].end, ends[k].end);
      if (!there_and_back && !there_twice) continue;
      const bool at_start = meets_others(ends[i].start, i, k), at_end = meets_others(ends[i].end, i, k);
      if (at_start == at_end) continue;
      slits.push_back(at_start ? ends[i].start : ends[i].end);
      taken[i] = taken[k] = true;
      break;
    }
  }
  std::size_t kept = 0;
  for (std::size_t k = 0; k < curves.size(); ++k)
    if (!taken[k]) std::swap(curves[kept++], curves[k]);
  curves.erase(curves.begin() + static_cast<std::ptrdiff_t>(kept), curves.end());
}

void take_out_slits(std::vector<Curve>& outline, std::vector<Vec2>& slits) {
  const double wide = mouth * extent(ends_of(outline));
  const auto is_slit = [wide](const Curve& out, const Curve& back) {
    if (!out.is_line() || !back.is_line()) return false;
    const double gap = (back.end() - out.start()).norm();
    const Vec2 there = out.end() - out.start(), here = back.end() - back.start();
    return gap <= wide && gap <= mouth_of_length * out.length() && there.dot(here) < 0.0;
  };
  for (std::size_t k = 0; k < outline.size() && outline.size() > 3;) {
    const std::size_t n = outline.size(), back = (k + 1) % n, next = (k + 2) % n;
    if (!is_slit(outline[k], outline[back])) {
      ++k;
      continue;
    }
    const Vec2 begin = outline[k].start();
    slits.push_back(begin);
    outline[next] = begun_at(outline[next], begin);
    for (const std::size_t gone : {std::max(k, back), std::min(k, back)})
      outline.erase(outline.begin() + static_cast<std::ptrdiff_t>(gone));
    k = k > 1 ? k - 2 : 0;  // a slit of several lines a side closes from its tip
  }
}

}  // namespace voile::pattern
