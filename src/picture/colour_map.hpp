// Colours for numbers: maps in which equal steps of the number are equal steps to the eye.
//
// A map is a curve in OKLab (B. Ottosson, 2020), a space in which distance is difference as seen, run through at constant speed.
// In the sequential map the lightness rises all the way; the diverging one is lightest at its middle and as dark at one end as
// at the other.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "image.hpp"

namespace voile::picture {

/// Lightness, green to red, blue to yellow.
using OkLab = Eigen::Vector3f;
[[nodiscard]] OkLab to_oklab(const Rgb& linear);
[[nodiscard]] Rgb from_oklab(const OkLab& lab);

class ColourMap {
 public:
  static ColourMap sequential();
  static ColourMap diverging();
  /// `t` 0 to 1; outside it the ends; NaN is grey.
  [[nodiscard]] Rgb operator()(float t) const;

 private:
  /// `pieces`: parts of the path, of equally many points, that get as many numbers each.
  ColourMap(const std::vector<OkLab>& path, std::size_t pieces);
  static constexpr std::size_t entries = 257;
  std::array<Rgb, entries> table_;
};

/// Colour number i of a list that tells neighbours apart, without end.
[[nodiscard]] Rgb category_colour(std::size_t i);

/// A range of numbers and its map: signed numbers get the diverging map, symmetric about zero. Signed are those of which
/// one sign reaches at least a fiftieth of what the other does.
struct ColourScale {
  double low = 0.0, high = 1.0;
  ColourMap map = ColourMap::sequential();
  [[nodiscard]] float place(double value) const;  ///< 0 to 1 inside the range
};
[[nodiscard]] ColourScale make_scale(double low, double high);

/// Round numbers inside a range, `count` or a few more or less, and their texts with as many digits as tell them apart.
[[nodiscard]] std::vector<std::pair<double, std::string>> ticks(double low, double high, int count);

}  // namespace voile::picture
