#include "drape_shape.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voile::cli {

namespace {

constexpr double whole_turn = 2.0 * std::numbers::pi;
constexpr std::size_t directions = 3600;
constexpr double least_of_range = 0.1, least_height = 3e-4;  // [m]

/// Largest r of one edge in each direction that it covers.
void cover(const Vec3& a, const Vec3& b, std::vector<double>& radius) {
  const double step = whole_turn / static_cast<double>(radius.size());
  const double from = std::atan2(a.y(), a.x());
  const double turn = std::remainder(std::atan2(b.y(), b.x()) - from, whole_turn);
  const double low = turn >= 0.0 ? from : from + turn, high = turn >= 0.0 ? from + turn : from;
  const double ex = b.x() - a.x(), ey = b.y() - a.y();
  const auto count = static_cast<long>(radius.size());
  for (auto k = static_cast<long>(std::ceil(low / step)); static_cast<double>(k) * step <= high; ++k) {
    const double c = std::cos(static_cast<double>(k) * step), s = std::sin(static_cast<double>(k) * step);
    const double across = ex * s - ey * c;
    double r = std::max(std::hypot(a.x(), a.y()), std::hypot(b.x(), b.y()));
    if (std::abs(across) > 1e-12 * std::hypot(ex, ey)) r = std::min(r, (ex * a.y() - ey * a.x()) / across);
    double& at = radius[static_cast<std::size_t>(((k % count) + count) % count)];
    at = std::max(at, r);
  }
}

double area_of(const std::vector<double>& radius) {
  double sum = 0.0;
  for (const double r : radius) sum += 0.5 * r * r;
  return sum * whole_turn / static_cast<double>(radius.size());
}

/// Standard deviation over mean.
template <class Number>
double variation(const std::vector<DrapeFold>& folds, const Number& number) {
  if (folds.empty()) return 0.0;
  double mean = 0.0, square = 0.0;
  const auto count = static_cast<double>(folds.size());
  for (const DrapeFold& f : folds) mean += number(f) / count;
  for (const DrapeFold& f : folds) square += std::pow(number(f) - mean, 2) / count;
  return std::sqrt(square) / mean;
}

}  // namespace

std::vector<double> shadow_radius(const std::vector<mesh::Triangle>& triangles, const std::vector<Vec3>& places,
                                  std::size_t count) {
  std::vector<double> radius(count, 0.0);
  for (const mesh::Triangle& t : triangles)
    for (std::size_t i = 0; i < 3; ++i) cover(places[t[i]], places[t[(i + 1) % 3]], radius);
  return radius;
}

std::vector<DrapeFold> folds_of(const std::vector<double>& radius) {
  std::vector<DrapeFold> folds;
  if (radius.empty()) return folds;
  const auto [least, most] = std::minmax_element(radius.begin(), radius.end());
  const double threshold = std::max(least_of_range * (*most - *least), least_height);
  const std::size_t n = radius.size(), begin = static_cast<std::size_t>(least - radius.begin());
  const auto r = [&](std::size_t k) { return radius[(begin + k) % n]; };
  std::vector<std::size_t> tops, bottoms{0};  // alternating, from the lowest point round to it
  std::size_t extreme = 0;
  bool rises = true;
  for (std::size_t k = 1; k <= n; ++k) {
    if (rises ? r(k) > r(extreme) : r(k) < r(extreme)) extreme = k;
    if (rises && r(extreme) - r(bottoms.back()) <= threshold && r(k) < r(bottoms.back())) bottoms.back() = extreme = k;
    const double back = rises ? r(extreme) - r(k) : r(k) - r(extreme);
    if (back <= threshold) continue;
    (rises ? tops : bottoms).push_back(extreme);
    extreme = k;
    rises = !rises;
  }
  if (bottoms.size() == tops.size()) bottoms.push_back(n);
  const double step = whole_turn / static_cast<double>(n);
  for (std::size_t k = 0; k < tops.size() && k + 1 < bottoms.size(); ++k)
    folds.push_back({std::fmod(static_cast<double>(begin + tops[k]) * step, whole_turn),
                     r(tops[k]) - 0.5 * (r(bottoms[k]) + r(bottoms[k + 1])),
                     static_cast<double>(bottoms[k + 1] - bottoms[k]) * step});
  std::sort(folds.begin(), folds.end(), [](const DrapeFold& a, const DrapeFold& b) { return a.angle < b.angle; });
  return folds;
}

DrapeShape drape_shape(const std::vector<mesh::Triangle>& triangles, const std::vector<Vec3>& flat,
                       const std::vector<Vec3>& places, double support_radius) {
  DrapeShape shape;
  shape.radius = shadow_radius(triangles, places, directions);
  const double support = std::numbers::pi * support_radius * support_radius;
  shape.coefficient =
      (area_of(shape.radius) - support) / (area_of(shadow_radius(triangles, flat, directions)) - support);
  shape.folds = folds_of(shape.radius);
  shape.amplitude_variation = variation(shape.folds, [](const DrapeFold& f) { return f.amplitude; });
  shape.wavelength_variation = variation(shape.folds, [](const DrapeFold& f) { return f.wavelength; });
  return shape;
}

}  // namespace voile::cli
