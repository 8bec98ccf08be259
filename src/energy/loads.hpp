// Follower loads: forces that turn with the sheet. They have no potential in general, so they offer a force and its
// full, unsymmetric stiffness instead of an energy. Signs: the emitted "gradient" is minus the force, as for an energy.
//
// Follower pressure p on triangle (x0, x1, x2):   f_i = p/6 (x1-x0) x (x2-x0) on each vertex, and p dV/dx_i of what it
//   encloses beyond its plane (bulge.hpp)
// Follower edge moment M per rest length on the boundary side (a, b) with interior vertex c, rest length L0, n the normal of the
//   triangle:   f_i = M L0 w_i n,   w_i of its slope (edge_moment.hpp)
// Where there is no such slope:   m = (b-a) x (c-a),   w = M L0 |b-a|/|m| (couple M L0 over the altitude),   n = m/|m|,
//   alpha foot of c on (a, b),   f_c = -w n,   f_a = (1-alpha) w n,   f_b = alpha w n
// Positive moments lift the edge towards the positive side of the surface.
// Source: Bonet & Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2nd ed. (2008).
#pragma once

#include <array>
#include <vector>

#include "bulge.hpp"
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
  /// Moment [N m] on side (points[0], points[1]) with interior vertex points[2], local points. With the weights of its slope, which
  /// may reach further, and what a moment of 1 adds to the curvature of `triangle`; without weights a couple.
  struct Moment {
    std::vector<Index> points;
    std::vector<double> weights;
    double moment;
    Index triangle;
    Vec3 bend;
  };
  void add_moment(Moment moment, int factor, bool owned);
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
    if (el.turns()) {
      const Vec3 n = normal(el, c);
      for (int i = 0; i < el.bulge.size(); ++i) emit(i, Vec3(-scaled(el) * el.bulge.weights[i] * n));
      return;
    }
    const std::array<Vec3, 3> f = force(el, c);
    for (int i = 0; i < 3; ++i) emit(i, Vec3(-f[i]));
    if (el.bulges())
      el.bulge.gradient(el.positions(c), [&](int i, const Vec3& area) { emit(i, Vec3(-scaled(el) * area)); });
  }
  template <class Emit>
  void hessian(Index e, const Configuration& c, Emit&& emit) const {
    const Element& el = elements_[e];
    if (el.turns()) {
      const std::array<Mat3, 3> turn = normal_derivative(el, c);
      return el.bulge.pairs([&](int i, int j) {
        emit(i, j, j < 3 ? Mat3(-scaled(el) * el.bulge.weights[i] * turn[j]) : Mat3(Mat3::Zero()));
      });
    }
    std::array<std::array<Mat3, 3>, 3> k;
    stiffness(el, c, k);
    if (!el.bulges()) return el.bulge.pairs([&](int i, int j) { emit(i, j, Mat3(-k[i][j])); });
    el.bulge.hessian(el.positions(c), [&](int i, int j, const Mat3& second) {
      const Mat3 beyond = -scaled(el) * second;
      emit(i, j, i < 3 && j < 3 ? Mat3(beyond - k[i][j]) : beyond);
    });
  }
  template <class Emit>
  void blocks(Index e, Emit&& emit) const {
    elements_[e].bulge.pairs(emit);
  }

 private:
  struct Element {
    Bulge bulge;   ///< without weights: three points alone; of a moment the weights of its slope
    double value;  ///< pressure, or moment
    bool is_moment, owned;
    int factor;
    Index triangle = no_index;  ///< that a moment bends
    Vec3 bend = Vec3::Zero();
    [[nodiscard]] bool bulges() const { return !is_moment && !bulge.weights.empty(); }
    [[nodiscard]] bool turns() const { return is_moment && !bulge.weights.empty(); }
    [[nodiscard]] PointsOf positions(const Configuration& c) const { return {c.x, bulge.points.data()}; }
  };
  [[nodiscard]] double scaled(const Element& el) const {
    return factors_[static_cast<std::size_t>(el.factor)] * el.value;
  }
  /// n of the triangle, and dn/dx_j of its corners.
  [[nodiscard]] static Vec3 normal(const Element& el, const Configuration& c);
  [[nodiscard]] static std::array<Mat3, 3> normal_derivative(const Element& el, const Configuration& c);
  [[nodiscard]] std::array<Vec3, 3> force(const Element& el, const Configuration& c) const;
  /// k[i][j] = d f_i / d x_j.
  void stiffness(const Element& el, const Configuration& c, std::array<std::array<Mat3, 3>, 3>& k) const;

  std::vector<Element> elements_;
  std::vector<double> factors_{1.0, 1.0};
};

}  // namespace voile::energy
