// Air drag of a sheet in wind, linear within a time step. Theory: docs/theory/time-integration.md (2).
//
// Symbols   v         mean velocity of a triangle's vertices at the end of the step                          [m/s]
//           v_n, n_n  velocity and unit normal at its start;  w wind                                         [m/s]
//           A         rest area [m^2];  rho density of air [kg/m^3]
//           C_n, C_t  drag coefficients across and along the surface
//   force on the triangle  f = -B (v - w)
//   B = rho A/2 [ C_n |(w - v_n).n_n| n_n n_n^T + C_t |w - v_n| (I - n_n n_n^T) ]
// a third of it on each vertex. Speed and normal are those of the start of the step, so that the force has the
// potential 1/2 (v - w).B (v - w) over the step and can only take energy from a sheet in still air.
#pragma once

#include <array>
#include <vector>

#include "drag_options.hpp"
#include "term.hpp"

namespace voile::energy {

/// The "positions" of the configurations below are velocities of the local points, except in start_step.
class DragTerm {
 public:
  DragTerm() = default;
  explicit DragTerm(const DragOptions& options) : options_(options) {}
  void add(const std::array<Index, 3>& points, double area, bool owned);
  /// Takes speeds and normals from positions x and velocities v of the local points.
  void start_step(const Vec3* x, const Vec3* v);

  [[nodiscard]] Index size() const { return static_cast<Index>(elements_.size()); }
  [[nodiscard]] const Index* stencil(Index e) const { return elements_[e].points.data(); }
  [[nodiscard]] int stencil_size(Index) const { return 3; }
  [[nodiscard]] bool owned(Index e) const { return elements_[e].owned; }

  /// 1/2 (v - w).B (v - w) [W]
  [[nodiscard]] double energy(Index e, const Configuration& c) const {
    const Vec3 relative = velocity(e, c) - options_.wind;
    return 0.5 * relative.dot(elements_[e].drag * relative);
  }
  template <class Emit>
  void gradient(Index e, const Configuration& c, Emit&& emit) const {
    const Vec3 f = elements_[e].drag * (velocity(e, c) - options_.wind) / 3.0;
    for (int i = 0; i < 3; ++i) emit(i, f);
  }
  /// Derivative with respect to velocities.
  template <class Emit>
  void hessian(Index e, const Configuration&, Emit&& emit) const {
    const Mat3 k = elements_[e].drag * (scale_ / 9.0);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) emit(i, j, k);
  }
  template <class Emit>
  void blocks(Index, Emit&& emit) const {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) emit(i, j);
  }
  /// Factor on the Hessian: derivative of the velocity with respect to the position in a time step [1/s].
  void set_scale(double scale) { scale_ = scale; }

 private:
  struct Element {
    std::array<Index, 3> points;
    double area;
    bool owned;
    Mat3 drag = Mat3::Zero();  ///< B [kg/s]
  };
  [[nodiscard]] Vec3 velocity(Index e, const Configuration& c) const {
    const auto& p = elements_[e].points;
    return (c.x[p[0]] + c.x[p[1]] + c.x[p[2]]) / 3.0;
  }

  DragOptions options_;
  std::vector<Element> elements_;
  double scale_ = 1.0;
};

}  // namespace voile::energy
