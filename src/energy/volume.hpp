// Volume under a surface: what a gas acts on.
//
// Symbols   O   a fixed point [m];  x_0, x_1, x_2  corners of an oriented triangle [m], counted from O below
//   V_t = x_0.(x_1 x x_2)/6,    dV_t/dx_0 = (x_1 x x_2)/6,    d2V_t/dx_0 dx_1 = -[x_2]x/6,   and so on in turn      [m^3]
// and what the triangle encloses beyond its plane (bulge.hpp). The sum over a closed surface does not depend on O. A hole is
// closed by triangles (c, a, b) from a point c to the edges of its rim, which are elements with two points; where c goes with
// the rim, its own share is added by system/gas.hpp.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "base/cross_matrix.hpp"
#include "bulge.hpp"
#include "term.hpp"

namespace voile::energy {

/// scale() times the volume.
class VolumeTerm {
 public:
  /// Oriented triangle of local points; `bulge` in local points, or plane.
  void add(const std::array<Index, 3>& points, bool owned, Bulge bulge = {}) {
    if (bulge.points.empty()) bulge.points.assign(points.begin(), points.end());
    elements_.push_back({std::move(bulge), -1, owned});
  }
  /// Triangle from centre number `cap` to two local points.
  void add_side(const std::array<Index, 2>& points, int cap, bool owned) {
    elements_.push_back({{{points.begin(), points.end()}, {}}, cap, owned});
  }
  /// O.
  void set_origin(const Vec3& origin) { origin_ = origin; }
  /// c, counted from O.
  void set_centres(std::vector<Vec3> centres) { centres_ = std::move(centres); }
  void set_scale(double scale) { scale_ = scale; }

  [[nodiscard]] Index size() const { return static_cast<Index>(elements_.size()); }
  [[nodiscard]] const Index* stencil(Index e) const { return elements_[e].bulge.points.data(); }
  [[nodiscard]] int stencil_size(Index e) const { return elements_[e].bulge.size(); }
  [[nodiscard]] bool owned(Index e) const { return elements_[e].owned; }
  /// Number of the centre, or -1: a triangle.
  [[nodiscard]] int cap(Index e) const { return elements_[e].cap; }

  [[nodiscard]] double energy(Index e, const Configuration& c) const {
    const std::array<Vec3, 3> x = corners(e, c);
    const Element& el = elements_[e];
    const double beyond = el.bulges() ? el.bulge.volume(el.positions(c)) : 0.0;
    return scale_ * (x[2].dot(Vec3(x[0].cross(x[1]))) / 6.0 + beyond);
  }
  template <class Emit>
  void gradient(Index e, const Configuration& c, Emit&& emit) const {
    const std::array<Vec3, 3> x = corners(e, c);
    const Element& el = elements_[e];
    for (int i = 0; i < std::min(3, stencil_size(e)); ++i)
      emit(i, Vec3(scale_ / 6.0 * x[(i + 1) % 3].cross(x[(i + 2) % 3])));
    if (el.bulges()) el.bulge.gradient(el.positions(c), [&](int i, const Vec3& area) { emit(i, Vec3(scale_ * area)); });
  }
  template <class Emit>
  void hessian(Index e, const Configuration& c, Emit&& emit) const {
    const std::array<Vec3, 3> x = corners(e, c);
    const auto plane = [&](int i, int j) {
      return Mat3((j == (i + 1) % 3 ? -scale_ : scale_) / 6.0 * cross_matrix(x[3 - i - j]));
    };
    const Element& el = elements_[e];
    if (!el.bulges()) return for_pairs(e, [&](int i, int j) { emit(i, j, plane(i, j)); });
    el.bulge.hessian(el.positions(c), [&](int i, int j, const Mat3& second) {
      const Mat3 beyond = scale_ * second;
      emit(i, j, i < 3 && j < 3 && i != j ? Mat3(beyond + plane(i, j)) : beyond);
    });
  }
  template <class Emit>
  void blocks(Index e, Emit&& emit) const {
    if (elements_[e].bulges())
      elements_[e].bulge.pairs(emit);
    else
      for_pairs(e, emit);
  }

 private:
  struct Element {
    Bulge bulge;  ///< without weights: the points alone
    int cap;
    bool owned;
    [[nodiscard]] bool bulges() const { return !bulge.weights.empty(); }
    [[nodiscard]] PointsOf positions(const Configuration& c) const { return {c.x, bulge.points.data()}; }
  };
  template <class F>
  void for_pairs(Index e, F&& f) const {
    const int n = stencil_size(e);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        if (i != j) f(i, j);
  }
  /// Counted from O; a centre is the third.
  [[nodiscard]] std::array<Vec3, 3> corners(Index e, const Configuration& c) const {
    const Element& el = elements_[e];
    const std::vector<Index>& p = el.bulge.points;
    return {Vec3(c.x[p[0]] - origin_), Vec3(c.x[p[1]] - origin_),
            el.cap < 0 ? Vec3(c.x[p[2]] - origin_) : centres_[static_cast<std::size_t>(el.cap)]};
  }

  Vec3 origin_ = Vec3::Zero();
  std::vector<Vec3> centres_;
  std::vector<Element> elements_;
  double scale_ = 1.0;
};

}  // namespace voile::energy
