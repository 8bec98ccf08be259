// What terms of two points have in common: elements with `points` and `owned`, and the form of their derivatives.
//
// The energy depends on d = x_1 - x_0 alone, so that forces are -f, f and blocks +-K, f and K its derivatives by d.
#pragma once

#include <array>
#include <vector>

#include "term.hpp"

namespace voile::energy {

template <class Element>
class PairTerm {
 public:
  [[nodiscard]] Index size() const { return static_cast<Index>(elements_.size()); }
  [[nodiscard]] const Index* stencil(Index e) const { return elements_[e].points.data(); }
  [[nodiscard]] int stencil_size(Index) const { return 2; }
  [[nodiscard]] bool owned(Index e) const { return elements_[e].owned; }
  template <class Emit>
  void blocks(Index, Emit&& emit) const {
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j) emit(i, j);
  }

 protected:
  [[nodiscard]] Vec3 between(Index e, const Configuration& c) const {
    return c.x[elements_[e].points[1]] - c.x[elements_[e].points[0]];
  }
  template <class Emit>
  static void emit_forces(const Vec3& f, Emit&& emit) {
    emit(0, Vec3(-f));
    emit(1, f);
  }
  template <class Emit>
  static void emit_blocks(const Mat3& k, Emit&& emit) {
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j) emit(i, j, i == j ? k : Mat3(-k));
  }

  std::vector<Element> elements_;
};

}  // namespace voile::energy
