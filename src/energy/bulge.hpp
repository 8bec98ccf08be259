// What a bent triangle encloses beyond its plane: a pressure acts on the curved surface.
//
// Symbols   a    area vector of the plane triangle, (x_1 - x_0) x (x_2 - x_0)/2                                        [m^2]
//           k    sum over its sides l of l.K_.l, K second derivatives of the surface: k = sum_i m_i x_i                [m]
//   V = -a.k/24                                                                                                       [m^3]
// A side that bends by K lies l.K.l/8 beyond its chord at its middle, and a parabola over each side encloses a third of that
// times the area. On a sphere the error of the volume falls from second to fourth order. The m_i are constant. Only beside
// the corrected membrane: the chords of the others are too long by what a plane triangle encloses too little.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <utility>
#include <vector>

#include "base/cross_matrix.hpp"
#include "curvature.hpp"

namespace voile::energy {

/// Positions of points by their place in a stencil.
struct PointsOf {
  const Vec3* x;
  const Index* points;
  const Vec3& operator()(int i) const { return x[points[i]]; }
};

/// The corners first. Empty: plane.
struct Bulge {
  std::vector<Index> points;
  std::vector<double> weights;  ///< m_i

  /// V; positions(i) is x_i. [m^3]
  [[nodiscard]] double volume(const PointsOf& positions) const {
    const Vectors v = vectors(positions);
    return fraction * v.area.dot(v.bend);
  }
  /// Calls emit(i, dV/dx_i). [m^2]
  template <class Emit>
  void gradient(const PointsOf& positions, Emit&& emit) const;
  /// Calls emit(i, j, d2V/dx_i dx_j) for pairs with a corner, row by row. [m]
  template <class Emit>
  void hessian(const PointsOf& positions, Emit&& emit) const;
  /// Calls emit(i, j) for the same pairs.
  template <class Emit>
  void pairs(Emit&& emit) const {
    for (int i = 0; i < size(); ++i)
      for (int j = 0; j < (i < corners ? size() : corners); ++j) emit(i, j);
  }
  [[nodiscard]] int size() const { return static_cast<int>(points.size()); }

 private:
  static constexpr int corners = 3;
  static constexpr double fraction = -1.0 / 24.0;

  struct Vectors {
    Vec3 side, other, area, bend;  ///< x_1 - x_0, x_2 - x_0, a, k
  };
  [[nodiscard]] Vectors vectors(const PointsOf& positions) const {
    const Vec3& origin = positions(0);
    const Vec3 side = positions(1) - origin, other = positions(2) - origin;
    Vec3 bend = Vec3::Zero();
    for (int i = 0; i < size(); ++i) bend += weights[i] * (positions(i) - origin);
    return {side, other, 0.5 * side.cross(other), bend};
  }
};

/// Of triangle t with these corners, in any order; points in mesh numbering. Plane beside a crease, where
/// curvature is fitted beyond one, and with other membranes.
[[nodiscard]] Bulge make_bulge(const Sheet& sheet, Index t, const std::array<Index, 3>& corners,
                               const CurvatureOperator& op);

template <class Emit>
void Bulge::gradient(const PointsOf& positions, Emit&& emit) const {
  const Vectors v = vectors(positions);
  const Vec3 one = 0.5 * v.other.cross(v.bend), two = 0.5 * v.bend.cross(v.side);
  const std::array<Vec3, corners> at{Vec3(-one - two), one, two};
  for (int i = 0; i < size(); ++i) {
    const Vec3 through = weights[i] * v.area;
    emit(i, Vec3(fraction * (i < corners ? Vec3(through + at[i]) : through)));
  }
}

template <class Emit>
void Bulge::hessian(const PointsOf& positions, Emit&& emit) const {
  const Vectors v = vectors(positions);
  const Mat3 one = -0.5 * cross_matrix(v.other), two = 0.5 * cross_matrix(v.side), bend = 0.5 * cross_matrix(v.bend);
  const std::array<Mat3, corners> area{Mat3(-one - two), one, two};  // da/dx_i
  pairs([&](int i, int j) {
    Mat3 sum = Mat3::Zero();
    if (j < corners) sum += weights[i] * area[j];
    if (i < corners) sum += weights[j] * area[i].transpose();
    if (i < corners && j < corners && i != j) sum += j == (i + 1) % corners ? Mat3(-bend) : bend;
    emit(i, j, Mat3(fraction * sum));
  });
}

}  // namespace voile::energy
