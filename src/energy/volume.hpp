// Volume under a surface: what a gas acts on.
//
// Symbols   O   a fixed point [m];  x_0, x_1, x_2  corners of an oriented triangle [m], counted from O below
//   V_t = x_0.(x_1 x x_2)/6,    dV_t/dx_0 = (x_1 x x_2)/6,    d2V_t/dx_0 dx_1 = -[x_2]x/6,   and so on in turn      [m^3]
// The sum over a closed surface does not depend on O. A hole is closed by triangles (c, a, b) from a point c to the edges of its
// rim, which are elements with two points; where c goes with the rim, its own share is added by system/gas.hpp.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <utility>
#include <vector>

#include "base/cross_matrix.hpp"
#include "term.hpp"

namespace voile::energy {

/// scale() times the volume.
class VolumeTerm {
 public:
  /// Oriented triangle of local points.
  void add(const std::array<Index, 3>& points, bool owned) { elements_.push_back({points, -1, owned}); }
  /// Triangle from centre number `cap` to two local points.
  void add_side(const std::array<Index, 2>& points, int cap, bool owned) {
    elements_.push_back({{points[0], points[1], no_index}, cap, owned});
  }
  /// O.
  void set_origin(const Vec3& origin) { origin_ = origin; }
  /// c, counted from O.
  void set_centres(std::vector<Vec3> centres) { centres_ = std::move(centres); }
  void set_scale(double scale) { scale_ = scale; }

  [[nodiscard]] Index size() const { return static_cast<Index>(elements_.size()); }
  [[nodiscard]] const Index* stencil(Index e) const { return elements_[e].points.data(); }
  [[nodiscard]] int stencil_size(Index e) const { return elements_[e].cap < 0 ? 3 : 2; }
  [[nodiscard]] bool owned(Index e) const { return elements_[e].owned; }
  /// Number of the centre, or -1: a triangle.
  [[nodiscard]] int cap(Index e) const { return elements_[e].cap; }

  [[nodiscard]] double energy(Index e, const Configuration& c) const {
    const std::array<Vec3, 3> x = corners(e, c);
    return scale_ / 6.0 * x[2].dot(Vec3(x[0].cross(x[1])));
  }
  template <class Emit>
  void gradient(Index e, const Configuration& c, Emit&& emit) const {
    const std::array<Vec3, 3> x = corners(e, c);
    for (int i = 0; i < stencil_size(e); ++i) emit(i, Vec3(scale_ / 6.0 * x[(i + 1) % 3].cross(x[(i + 2) % 3])));
  }
  template <class Emit>
  void hessian(Index e, const Configuration& c, Emit&& emit) const {
    const std::array<Vec3, 3> x = corners(e, c);
    for_pairs(e, [&](int i, int j) {
      emit(i, j, Mat3((j == (i + 1) % 3 ? -scale_ : scale_) / 6.0 * cross_matrix(x[3 - i - j])));
    });
  }
  template <class Emit>
  void blocks(Index e, Emit&& emit) const {
    for_pairs(e, emit);
  }

 private:
  struct Element {
    std::array<Index, 3> points;
    int cap;
    bool owned;
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
    return {Vec3(c.x[el.points[0]] - origin_), Vec3(c.x[el.points[1]] - origin_),
            el.cap < 0 ? Vec3(c.x[el.points[2]] - origin_) : centres_[static_cast<std::size_t>(el.cap)]};
  }

  Vec3 origin_ = Vec3::Zero();
  std::vector<Vec3> centres_;
  std::vector<Element> elements_;
  double scale_ = 1.0;
};

}  // namespace voile::energy
