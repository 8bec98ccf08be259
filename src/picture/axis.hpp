// An axis of a diagram: its range, its scale, its numbers; private to src/picture.
#pragma once

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "plot.hpp"

namespace voile::picture {

/// Values run from `low` to `high` over pixels from `begin` to `end`. On a logarithmic scale `low` and `high` are decimal
/// logarithms.
class Axis {
 public:
  explicit Axis(const AxisOptions& options) : options_(options) {}

  /// Whether a value can be drawn: a number, and positive if the scale is logarithmic.
  [[nodiscard]] bool can_show(double value) const;
  /// Makes the range hold a value that can be shown.
  void add(double value);
  [[nodiscard]] bool empty() const { return !(low <= high); }
  /// A margin, but not beyond a zero that is near; or the range that was asked for. Throws UserError if double precision does not
  /// resolve it.
  void finish();
  /// Makes the range wider about its middle.
  void widen_to(double width);
  [[nodiscard]] double place(double value) const;
  /// Places [pixels] and texts, about `count` of them.
  [[nodiscard]] std::vector<std::pair<double, std::string>> numbers(int count) const;
  [[nodiscard]] double width() const { return high - low; }
  [[nodiscard]] double pixels() const;

  double low = std::numeric_limits<double>::infinity(), high = -low, begin = 0.0, end = 1.0;

 private:
  [[nodiscard]] double scaled(double value) const;
  [[nodiscard]] bool resolved() const;
  [[nodiscard]] double at(double scaled) const { return begin + (end - begin) * (scaled - low) / (high - low); }

  const AxisOptions& options_;
};

}  // namespace voile::picture
