#include "colour_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voile::picture {

namespace {

using Mat3f = Eigen::Matrix3f;

/// From linear sRGB to the responses of three cones, and from their cube roots to OKLab.
Mat3f cones() {
  Mat3f m;
  m << 0.4122214708F, 0.5363325363F, 0.0514459929F,  //
      0.2119034982F, 0.6806995451F, 0.1073969566F,   //
      0.0883024619F, 0.2817188376F, 0.6299787005F;
  return m;
}
Mat3f opponents() {
  Mat3f m;
  m << 0.2104542553F, 0.7936177850F, -0.0040720468F,  //
      1.9779984951F, -2.4285922050F, 0.4505937099F,   //
      0.0259040371F, 0.7827717662F, -0.8086757660F;
  return m;
}

OkLab lab(float lightness, float chroma, float hue_degrees) {
  const float h = hue_degrees * std::numbers::pi_v<float> / 180.0F;
  return {lightness, chroma * std::cos(h), chroma * std::sin(h)};
}

/// A smooth curve through control points (Catmull-Rom), sampled.
std::vector<OkLab> smooth(const std::vector<OkLab>& points) {
  constexpr int parts = 64;
  std::vector<OkLab> curve{points.front()};
  const auto last = static_cast<std::ptrdiff_t>(points.size()) - 1;
  const auto at = [&](std::ptrdiff_t i) -> const OkLab& {
    return points[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i, 0, last))];
  };
  for (std::ptrdiff_t i = 0; i < last; ++i)
    for (int k = 1; k <= parts; ++k) {
      const float t = static_cast<float>(k) / parts;
      const OkLab a = 0.5F * (at(i + 1) - at(i - 1)), b = 0.5F * (at(i + 2) - at(i));
      const OkLab d = at(i + 1) - at(i);
      curve.emplace_back(at(i) + t * (a + t * ((3.0F * d - 2.0F * a - b) + t * (a + b - 2.0F * d))));
    }
  return curve;
}

std::string number_text(double value, double step, double largest) {
  if (largest >= 1e5 || largest < 1e-3) {
    const int digits = 1 + static_cast<int>(std::ceil(std::log10(largest / step) - 1e-9));
    const std::string text = fmt::format("{:.{}g}", value, std::clamp(digits, 3, 15));
    return value == 0.0 ? "0" : text;
  }
  const int digits = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9);
  return fmt::format("{:.{}f}", std::abs(value) < 1e-9 * step ? 0.0 : value, digits);
}

}  // namespace

OkLab to_oklab(const Rgb& linear) {
  Eigen::Vector3f c = cones() * linear;
  for (int k = 0; k < 3; ++k) c[k] = std::cbrt(c[k]);
  return opponents() * c;
}

Rgb from_oklab(const OkLab& value) {
  static const Mat3f to_roots = opponents().inverse(), to_rgb = cones().inverse();
  const Eigen::Vector3f c = to_roots * value;
  return to_rgb * Eigen::Vector3f(c.array().cube());
}

ColourMap::ColourMap(const std::vector<OkLab>& path, std::size_t pieces) {
  const std::vector<OkLab> curve = smooth(path);
  const std::size_t samples = (curve.size() - 1) / pieces, steps = (entries - 1) / pieces;
  for (std::size_t piece = 0; piece < pieces; ++piece) {
    const OkLab* c = curve.data() + piece * samples;
    std::vector<float> length{0.0F};
    for (std::size_t i = 1; i <= samples; ++i) length.push_back(length.back() + (c[i] - c[i - 1]).norm());
    std::size_t at = 1;
    for (std::size_t i = 0; i <= steps; ++i) {
      const float along = length.back() * static_cast<float>(i) / static_cast<float>(steps);
      while (at < samples && length[at] < along) ++at;
      const float t = (along - length[at - 1]) / (length[at] - length[at - 1]);
      table_[piece * steps + i] = from_oklab(c[at - 1] + t * (c[at] - c[at - 1])).cwiseMax(0.0F).cwiseMin(1.0F);
    }
  }
}

ColourMap ColourMap::sequential() {
  return ColourMap({lab(0.28F, 0.10F, 305), lab(0.39F, 0.12F, 278), lab(0.50F, 0.10F, 238), lab(0.60F, 0.105F, 190),
                    lab(0.70F, 0.135F, 158), lab(0.80F, 0.165F, 125), lab(0.91F, 0.17F, 105)},
                   1);
}

ColourMap ColourMap::diverging() {
  return ColourMap({lab(0.38F, 0.11F, 262), lab(0.53F, 0.12F, 255), lab(0.72F, 0.085F, 245), lab(0.94F, 0.012F, 180),
                    lab(0.72F, 0.10F, 55), lab(0.53F, 0.145F, 35), lab(0.38F, 0.12F, 25)},
                   2);
}

Rgb ColourMap::operator()(float t) const {
  if (!(t == t)) return {0.35F, 0.35F, 0.35F};
  const float x = std::clamp(t, 0.0F, 1.0F) * static_cast<float>(entries - 1);
  const auto i = std::min(static_cast<std::size_t>(x), entries - 2);
  const float f = x - static_cast<float>(i);
  return (1.0F - f) * table_[i] + f * table_[i + 1];
}

Rgb category_colour(std::size_t i) {
  // Turning by the golden section never comes back to a hue.
  constexpr float turn = 137.508F;
  const float lightness = i % 2 == 0 ? 0.72F : 0.60F;
  return from_oklab(lab(lightness, 0.10F, 250.0F + turn * static_cast<float>(i))).cwiseMax(0.0F).cwiseMin(1.0F);
}

float ColourScale::place(double value) const {
  return high > low ? static_cast<float>((value - low) / (high - low)) : 0.0F;
}

ColourScale make_scale(double low, double high) {
  const double most = std::max(-low, high);
  // A little of the other sign, such as round-off, does not make numbers signed.
  if (std::min(-low, high) > 0.02 * most) {
    return {-most, most, ColourMap::diverging()};
  }
  return {low, high, ColourMap::sequential()};
}

std::vector<std::pair<double, std::string>> ticks(double low, double high, int count) {
  const double width = high - low;
  // Narrower than double precision resolves, steps would not move on.
  if (!(width > 1e-12 * std::max(std::abs(low), std::abs(high))) || !std::isfinite(width))
    return {{low, fmt::format("{:.4g}", low)}};
  const double raw = width / count, power = std::pow(10.0, std::floor(std::log10(raw)));
  const double step = power * (raw < 1.5 * power ? 1.0 : raw < 3.5 * power ? 2.0 : raw < 7.5 * power ? 5.0 : 10.0);
  std::vector<std::pair<double, std::string>> list;
  const double largest = std::max(std::abs(low), std::abs(high));
  for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * width; k += 1.0)
    list.emplace_back(k * step, number_text(k * step, step, largest));
  return list;
}

}  // namespace voile::picture
