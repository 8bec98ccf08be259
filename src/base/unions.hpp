// Sets of numbers that are joined two at a time.
// Source: R. E. Tarjan, J. ACM 22 (1975) 215-225.
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include "types.hpp"

namespace voile {

class Unions {
 public:
  /// Each number below n is a set of its own.
  explicit Unions(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), Index{0}); }
  /// The least number of its set.
  Index find(Index i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// Whether they were apart.
  bool join(Index a, Index b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }

 private:
  std::vector<Index> parent_;
};

}  // namespace voile
