// Springs that pull the two sides of a seam together, with no more than a given force.
//
// Symbols   L  length down to which a spring pulls [m];  e = max(0, |x_1 - x_0| - L)  what it is too long by [m]
//           k  stiffness [N/m];  T  largest force [N];  l0 = T/k [m];  q = sqrt(1 + (e/l0)^2);  n  direction
//   W = T l0 (q - 1),    dW/de = k e / q < T,    d2W/de2 = k / q^3
//   d2W/dx_1^2 = d2W/de2 n n^T + (dW/de)/|x_1 - x_0| (I - n n^T): positive for every e
// In the tangent the secant k/q takes the place of k/q^3 beyond e = l0: where the force hardly grows any more, nothing but
// inertia would stop an increment, and it would go far beyond what is wanted.
// For small e it is a spring of stiffness k, for large e a constant force: what is in the way of a seam is not crushed,
// and what has to follow it is not torn.
// Theory: docs/theory/contact.md, sewing.
#pragma once

#include <array>
#include <cmath>

#include "pair_term.hpp"

namespace voile::energy {

struct SeamElement {
  std::array<Index, 2> points;
  double stiffness, force, length;
  bool owned;
};

class SeamTerm : public PairTerm<SeamElement> {
 public:
  /// Between two local points; stiffness [N/m], length [m] and force [N] > 0.
  void add(const std::array<Index, 2>& points, double stiffness, double force, double length, bool owned) {
    elements_.push_back({points, stiffness, force, length, owned});
  }
  /// Changes length [m], stiffness [N/m] and largest force [N].
  void set(Index e, double length, double stiffness, double force) {
    elements_[e].length = length;
    elements_[e].stiffness = stiffness;
    elements_[e].force = force;
  }

  [[nodiscard]] double energy(Index e, const Configuration& c) const {
    const SeamElement& el = elements_[e];
    const double s = excess(el, between(e, c).norm()) * el.stiffness / el.force;
    return el.force * el.force / el.stiffness * s * s / (1.0 + std::sqrt(1.0 + s * s));
  }
  /// dW/de [N]
  [[nodiscard]] double force(Index e, const Configuration& c) const {
    const double l = between(e, c).norm();
    return across(elements_[e], l) * l;
  }
  template <class Emit>
  void gradient(Index e, const Configuration& c, Emit&& emit) const {
    const SeamElement& el = elements_[e];
    const Vec3 d = between(e, c), f = across(el, d.norm()) * d;
    emit_forces(f, emit);
  }
  template <class Emit>
  void hessian(Index e, const Configuration& c, Emit&& emit) const {
    const SeamElement& el = elements_[e];
    const Vec3 d = between(e, c);
    const double l = d.norm(), side = across(el, l);
    Mat3 k = side * Mat3::Identity();
    if (l > 0.0 && l >= el.length) k += (along(el, l) - side) / (l * l) * d * d.transpose();
    emit_blocks(k, emit);
  }

 private:
  [[nodiscard]] static double excess(const SeamElement& el, double l) { return l > el.length ? l - el.length : 0.0; }
  /// q
  [[nodiscard]] static double softening(const SeamElement& el, double l) {
    const double s = excess(el, l) * el.stiffness / el.force;
    return std::sqrt(1.0 + s * s);
  }
  /// (dW/de) / l, with its limit where a spring of no length has none.
  [[nodiscard]] static double across(const SeamElement& el, double l) {
    const double fraction = el.length == 0.0 ? 1.0 : l > 0.0 ? excess(el, l) / l : 0.0;
    return el.stiffness * fraction / softening(el, l);
  }
  [[nodiscard]] static double along(const SeamElement& el, double l) {
    const double q = softening(el, l);
    return el.stiffness / (q * q > 2.0 ? q : q * q * q);
  }
};

}  // namespace voile::energy
