// Linear springs of no length from a point to a place that moves by itself, such as one on an obstacle.
//
// Symbols   k   stiffness [N/m];  x   the point;  y   the place, given [m]
//   W = k/2 |x - y|^2,    dW/dx = k (x - y),    d2W/dx^2 = k I
// One whose place is not known yet has no energy.
#pragma once

#include <vector>

#include "term.hpp"

namespace voile::energy {

class AnchorTerm {
 public:
  /// At a local point that this rank owns; stiffness >= 0 [N/m].
  void add(Index point, double stiffness) { elements_.push_back({point, stiffness, Vec3::Zero(), false}); }
  /// Changes the place [m].
  void set_place(Index e, const Vec3& place) {
    elements_[e].place = place;
    elements_[e].placed = true;
  }

  [[nodiscard]] Index size() const { return static_cast<Index>(elements_.size()); }
  [[nodiscard]] const Index* stencil(Index e) const { return &elements_[e].point; }
  [[nodiscard]] int stencil_size(Index) const { return 1; }
  [[nodiscard]] bool owned(Index) const { return true; }

  [[nodiscard]] double energy(Index e, const Configuration& c) const {
    const Element& el = elements_[e];
    return 0.5 * stiffness(el) * (c.x[el.point] - el.place).squaredNorm();
  }
  template <class Emit>
  void gradient(Index e, const Configuration& c, Emit&& emit) const {
    const Element& el = elements_[e];
    emit(0, Vec3(stiffness(el) * (c.x[el.point] - el.place)));
  }
  template <class Emit>
  void hessian(Index e, const Configuration&, Emit&& emit) const {
    emit(0, 0, Mat3(stiffness(elements_[e]) * Mat3::Identity()));
  }
  template <class Emit>
  void blocks(Index, Emit&& emit) const {
    emit(0, 0);
  }

 private:
  struct Element {
    Index point;
    double stiffness;
    Vec3 place;
    bool placed;
  };
  [[nodiscard]] static double stiffness(const Element& el) { return el.placed ? el.stiffness : 0.0; }

  std::vector<Element> elements_;
};

}  // namespace voile::energy
