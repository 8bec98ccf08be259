// Linear springs between two points.
//
// Symbols   k   stiffness [N/m];  L  length without force [m];  l = |x_1 - x_0|,  n = (x_1 - x_0)/l
//   W   = k/2 (l - L)^2,    dW/dx_1 = k (l - L) n = -dW/dx_0
// One that only pulls has W = 0 where l < L.
//   d2W/dx_1^2 = k [ n n^T + (1 - L/l) (I - n n^T) ];   the positive tangent leaves out a negative 1 - L/l
// Source: any textbook on trusses, e.g. Crisfield, Non-linear Finite Element Analysis of Solids and Structures 1
// (1991), chapter 3 (engineering strain). With L = 0 the energy is quadratic and n is not needed.
#pragma once

#include <algorithm>
#include <array>

#include "pair_term.hpp"

namespace voile::energy {

struct SpringElement {
  std::array<Index, 2> points;
  double stiffness, length;
  bool owned, only_pulls;
};

class SpringTerm : public PairTerm<SpringElement> {
 public:
  /// Between two local points; stiffness >= 0 [N/m], length >= 0 [m].
  void add(const std::array<Index, 2>& points, double stiffness, double length, bool owned, bool only_pulls = false) {
    elements_.push_back({points, stiffness, length, owned, only_pulls});
  }

  void set(Index e, double stiffness, double length) {
    elements_[e].stiffness = stiffness;
    elements_[e].length = length;
  }

  [[nodiscard]] double energy(Index e, const Configuration& c) const {
    double stretch = between(e, c).norm() - elements_[e].length;
    if (elements_[e].only_pulls) stretch = std::max(stretch, 0.0);
    return 0.5 * elements_[e].stiffness * stretch * stretch;
  }
  template <class Emit>
  void gradient(Index e, const Configuration& c, Emit&& emit) const {
    const SpringElement& el = elements_[e];
    const Vec3 d = between(e, c), f = el.stiffness * across(el, d) * d;
    emit_forces(f, emit);
  }
  template <class Emit>
  void hessian(Index e, const Configuration& c, Emit&& emit) const {
    const SpringElement& el = elements_[e];
    const Vec3 d = c.tangent == Tangent::stress_alone ? between(e, {c.previous, c.previous_u}) : between(e, c);
    double side = across(el, between(e, c));
    if (c.tangent == Tangent::positive && side < 0.0) side = 0.0;
    Mat3 k = side * Mat3::Identity();
    if (el.length > 0.0 && d.squaredNorm() > 0.0 && !is_slack(el, d))
      k += (1.0 - side) / d.squaredNorm() * d * d.transpose();
    k *= el.stiffness;
    emit_blocks(k, emit);
  }

 private:
  /// 1 - L/l; a spring of no length that should have one has no direction, and no force.
  [[nodiscard]] static double across(const SpringElement& el, const Vec3& d) {
    if (el.length == 0.0) return 1.0;
    if (is_slack(el, d)) return 0.0;
    const double l = d.norm();
    return l > 0.0 ? 1.0 - el.length / l : 0.0;
  }
  [[nodiscard]] static bool is_slack(const SpringElement& el, const Vec3& d) {
    return el.only_pulls && d.norm() < el.length;
  }
};

}  // namespace voile::energy
