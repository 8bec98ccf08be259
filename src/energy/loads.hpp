// Follower loads: forces that turn with the sheet. They have no potential in general, so they offer a force and its
// full, unsymmetric stiffness instead of an energy. Signs: the emitted "gradient" is minus the force, as for an energy.
//
// Follower pressure p on triangle (x0, x1, x2):   f_i = p/6 (x1-x0) x (x2-x0) on each vertex, and p dV/dx_i of what it
//   encloses beyond its plane (bulge.hpp)
// Follower edge moment M per rest length on the boundary side (a, b) of rest length L0, whose slope is g = sum_i w_i x_i
// (edge_moment.hpp):   e = b-a,   c = g x e,   V = c |e|/|c|^2,   beta = -g.e/e.e,   f_i = M L0 (w_i + s_i beta) V
//   with s = -1 at a, 1 at b: a couple M L0 about e. Where the slope is not free, g runs from the corner across to a.
// Positive moments lift the edge towards the positive side of the surface.
// Source: Bonet & Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2nd ed. (2008).
#pragma once

#include <array>
#include <vector>

#include "bulge.hpp"
#include "edge_moment.hpp"
#include "term.hpp"

namespace voile::energy {

/// What moments on its edges add to the curvature of a triangle, in material axes [1/m].
struct EdgeBend {
  Index triangle;
  Vec3 curvature;
};

/// Triangles under follower pressure or boundary triangles under a follower moment; the first three points are theirs.
class FollowerTerm {
 public:
  /// Pressure [Pa] at load factor 1 on the triangle with these local points; `bulge` in local points, or plane.
  void add_pressure(const std::array<Index, 3>& points, double pressure, int factor, bool owned, Bulge bulge = {});
  /// Moment [N m] on side (points[0], points[1]) of `triangle` at load factor 1; local points.
  void add_moment(EdgeMoment on, Index triangle, double moment, int factor, bool owned);
  /// At the factors in force, of owned triangles.
  [[nodiscard]] std::vector<EdgeBend> edge_bends() const;
  /// Factors by number: 0 the load factor, 1 that of constant loads, more with a history of their own.
  static constexpr int load_factor = 0, constant = 1;
  /// Number of a new factor.
  [[nodiscard]] int add_factor() {
    factors_.push_back(0.0);
    return static_cast<int>(factors_.size()) - 1;
  }
  void set_factor(int number, double value) { factors_[static_cast<std::size_t>(number)] = value; }

  [[nodiscard]] Index size() const { return static_cast<Index>(elements_.size()); }
  [[nodiscard]] const Index* stencil(Index e) const { return elements_[e].bulge.points.data(); }
  [[nodiscard]] int stencil_size(Index e) const { return elements_[e].bulge.size(); }
  [[nodiscard]] bool owned(Index e) const { return elements_[e].owned; }

  template <class Emit>
  void gradient(Index e, const Configuration& c, Emit&& emit) const {
    const Element& el = elements_[e];
    if (el.is_moment) {
      const Couple couple(el, c);
      for (int i = 0; i < el.bulge.size(); ++i) emit(i, Vec3(-scaled(el) * couple.arm(el, i) * couple.lift));
      return;
    }
    const Vec3 f = pressure_force(el, c);
    for (int i = 0; i < 3; ++i) emit(i, Vec3(-f));
    if (el.bulges())
      el.bulge.gradient(el.positions(c), [&](int i, const Vec3& area) { emit(i, Vec3(-scaled(el) * area)); });
  }
  template <class Emit>
  void hessian(Index e, const Configuration& c, Emit&& emit) const {
    const Element& el = elements_[e];
    if (el.is_moment) {
      const Couple couple(el, c);
      for (int j = 0; j < el.bulge.size(); ++j) {
        const Mat3 lift = couple.lift_derivative(el, j);
        const Vec3 foot = couple.foot_derivative(el, j);
        for (int i = 0; i < el.bulge.size(); ++i)
          emit(i, j, Mat3(-scaled(el) * (couple.arm(el, i) * lift + Couple::end(i) * couple.lift * foot.transpose())));
      }
      return;
    }
    const std::array<Mat3, 3> k = pressure_stiffness(el, c);
    if (!el.bulges()) return el.bulge.pairs([&](int i, int j) { emit(i, j, Mat3(-k[j])); });
    el.bulge.hessian(el.positions(c), [&](int i, int j, const Mat3& second) {
      const Mat3 beyond = -scaled(el) * second;
      emit(i, j, i < 3 && j < 3 ? Mat3(beyond - k[j]) : beyond);
    });
  }
  template <class Emit>
  void blocks(Index e, Emit&& emit) const {
    const Element& el = elements_[e];
    if (!el.is_moment) return el.bulge.pairs(emit);
    for (int j = 0; j < el.bulge.size(); ++j)
      for (int i = 0; i < el.bulge.size(); ++i) emit(i, j);
  }

 private:
  struct Element {
    Bulge bulge;   ///< without weights: three points alone; of a moment the w_i
    double value;  ///< pressure, or moment
    bool is_moment, owned;
    int factor;
    Index triangle = no_index;  ///< that a moment bends
    Vec3 bend = Vec3::Zero();
    [[nodiscard]] bool bulges() const { return !is_moment && !bulge.weights.empty(); }
    [[nodiscard]] PointsOf positions(const Configuration& c) const { return {c.x, bulge.points.data()}; }
  };
  [[nodiscard]] double scaled(const Element& el) const {
    return factors_[static_cast<std::size_t>(el.factor)] * el.value;
  }
  /// e, g, c, V and beta of a moment.
  struct Couple {
    Vec3 edge, slope, about, lift;
    double foot;
    Couple(const Element& el, const Configuration& c);
    /// s_i; w_i + s_i beta.
    [[nodiscard]] static double end(int i) { return i == 0 ? -1.0 : i == 1 ? 1.0 : 0.0; }
    [[nodiscard]] double arm(const Element& el, int i) const { return el.bulge.weights[i] + end(i) * foot; }
    /// dV/dx_j and dbeta/dx_j.
    [[nodiscard]] Mat3 lift_derivative(const Element& el, int j) const;
    [[nodiscard]] Vec3 foot_derivative(const Element& el, int j) const;
  };
  [[nodiscard]] Vec3 pressure_force(const Element& el, const Configuration& c) const;
  /// k[j] = d f / d x_j of each corner's force under pressure.
  [[nodiscard]] std::array<Mat3, 3> pressure_stiffness(const Element& el, const Configuration& c) const;

  std::vector<Element> elements_;
  std::vector<double> factors_{1.0, 1.0};
};

}  // namespace voile::energy
