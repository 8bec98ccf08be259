// Points sorted along a line in no special direction, so that rows of a regular mesh do not fall together.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "base/types.hpp"

namespace voile::mesh {

class SortedPoints {
 public:
  /// Of places `x` [m], those with the given numbers. Not collective.
  SortedPoints(const std::vector<Vec3>& x, const std::vector<Index>& numbers) {
    for (const Index v : numbers) order_.emplace_back(line().dot(x[v]), v);
    std::sort(order_.begin(), order_.end());
  }

  /// Calls f(number) for all points that can lie within `distance` [m] of the convex hull of `corners`, and others.
  template <class Corners, class F>
  void each_near(const Corners& corners, double distance, const F& f) const {
    double low = line().dot(corners[0]), high = low;
    for (const Vec3& c : corners) {
      low = std::min(low, line().dot(c));
      high = std::max(high, line().dot(c));
    }
    for (auto at = std::lower_bound(order_.begin(), order_.end(), std::pair(low - distance, Index{0}));
         at != order_.end() && at->first <= high + distance; ++at)
      f(at->second);
  }

 private:
  static Vec3 line() { return {0.4867, 0.6314, 0.6037}; }  // not longer than 1: what is near is near along it

  std::vector<std::pair<double, Index>> order_;
};

}  // namespace voile::mesh
