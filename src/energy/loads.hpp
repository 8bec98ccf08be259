// Follower loads: forces that turn with the sheet. They have no potential in general, so they offer a force and its
// full, unsymmetric stiffness instead of an energy. Signs: the emitted "gradient" is minus the force, as for an energy.
//
// Follower pressure p on triangle (x0, x1, x2):   f_i = p/6 (x1-x0) x (x2-x0) on each vertex
// Follower edge moment M per rest length on the boundary side (a, b) with interior vertex c, rest length L0:
//   m = (b-a) x (c-a),   w = M L0 |b-a|/|m| (couple M L0 over the altitude),   n = m/|m|,   alpha foot of c on (a, b)
//   f_c = -w n,   f_a = (1-alpha) w n,   f_b = alpha w n
// Positive moments lift the edge towards the positive side of the surface.
// Source: Bonet & Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2nd ed. (2008).
#pragma once

#include <array>
#include <vector>

#include "term.hpp"

namespace voile::energy {

/// Triangles under follower pressure or boundary triangles under a follower moment; stencils of three local points.
class FollowerTerm {
 public:
  /// Pressure [Pa] at load factor 1 on the triangle with these local points.
  void add_pressure(const std::array<Index, 3>& points, double pressure, int factor, bool owned);
  /// Moment per rest length [N] on side (points[0], points[1]) with interior vertex points[2].
  void add_moment(const std::array<Index, 3>& points, double moment, double rest_length, int factor, bool owned);
  /// Factors by number: 0 the load factor, 1 that of constant loads, more with a history of their own.
  static constexpr int load_factor = 0, constant = 1;
  /// Number of a new factor.
  [[nodiscard]] int add_factor() {
    factors_.push_back(0.0);
    return static_cast<int>(factors_.size()) - 1;
  }
  void set_factor(int number, double value) { factors_[static_cast<std::size_t>(number)] = value; }

  [[nodiscard]] Index size() const { return static_cast<Index>(elements_.size()); }
  [[nodiscard]] const Index* stencil(Index e) const { return elements_[e].points.data(); }
  [[nodiscard]] int stencil_size(Index) const { return 3; }
  [[nodiscard]] bool owned(Index e) const { return elements_[e].owned; }

  template <class Emit>
  void gradient(Index e, const Configuration& c, Emit&& emit) const {
    const std::array<Vec3, 3> f = force(elements_[e], c);
    for (int i = 0; i < 3; ++i) emit(i, Vec3(-f[i]));
  }
  template <class Emit>
  void hessian(Index e, const Configuration& c, Emit&& emit) const {
    std::array<std::array<Mat3, 3>, 3> k;
    stiffness(elements_[e], c, k);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) emit(i, j, Mat3(-k[i][j]));
  }
  template <class Emit>
  void blocks(Index, Emit&& emit) const {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) emit(i, j);
  }

 private:
  struct Element {
    std::array<Index, 3> points;
    double value;  ///< pressure, or moment times rest length
    bool is_moment, owned;
    int factor;
  };
  [[nodiscard]] double scaled(const Element& el) const {
    return factors_[static_cast<std::size_t>(el.factor)] * el.value;
  }
  [[nodiscard]] std::array<Vec3, 3> force(const Element& el, const Configuration& c) const;
  /// k[i][j] = d f_i / d x_j.
  void stiffness(const Element& el, const Configuration& c, std::array<std::array<Mat3, 3>, 3>& k) const;

  std::vector<Element> elements_;
  std::vector<double> factors_{1.0, 1.0};
};

}  // namespace voile::energy
