// What it costs to fold the sheet back over a clamped or mirrored edge.
//
// Symbols   x_A, x_a, x_b  vertex opposite to the edge, and the ends of the edge                                     [m]
//           f              foot of the altitude of A on the edge, (1-alpha) a + alpha b at rest;  h altitude at rest [m]
//           m              unit vector out of the sheet, square to the edge in the plane that the clamp holds (turns with
//                          the clamp), or the normal of the plane of symmetry
//           l, D           length of the edge at rest [m], mean bending stiffness [N m]
//   s = c_0 + m.(x_A - f)/h   c_0 - cos of the angle theta by which the triangle is turned out of that plane (but for
//                          stretch), c_0 = cos 75 degrees
//   W = K max(0, s)^2,     K = 2 D l/h
// The constant bending matrix holds only the part of the slope square to the plane, sin theta: a sheet folded back by 180
// degrees satisfies it without energy. With W the energy of a fold, about D l/h (sin^2 theta + 2 max(0, c_0 - cos theta)^2),
// grows all the way to 180 degrees, where the fold is unstable. Up to 75 degrees W vanishes: cells that resolve a bend turn
// by less. Theory: docs/theory/patch.md (4).
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "term.hpp"

namespace voile::energy {

class MirrorFoldTerm {
 public:
  struct Edge {
    std::array<Index, 3> points;  ///< local A, a, b
    double foot = 0.0;            ///< alpha
    double height = 0.0;          ///< h [m]
    double stiffness = 0.0;       ///< K [J]
    Vec3 outward;                 ///< m at the start
    int support = -1;             ///< that turns m, or -1
    bool owned = false;
  };
  void add(const Edge& edge) {
    edges_.push_back(edge);
    outward_.push_back(edge.outward);
  }
  /// Turns the clamps: a rotation for each support.
  void turn(const std::vector<Mat3>& rotations) {
    for (std::size_t e = 0; e < edges_.size(); ++e)
      if (edges_[e].support >= 0)
        outward_[e] = rotations[static_cast<std::size_t>(edges_[e].support)] * edges_[e].outward;
  }

  [[nodiscard]] Index size() const { return static_cast<Index>(edges_.size()); }
  [[nodiscard]] const Index* stencil(Index e) const { return edges_[e].points.data(); }
  [[nodiscard]] int stencil_size(Index) const { return 3; }
  [[nodiscard]] bool owned(Index e) const { return edges_[e].owned; }

  [[nodiscard]] double energy(Index e, const Configuration& c) const {
    const double s = turned(e, c);
    return s > 0.0 ? edges_[e].stiffness * s * s : 0.0;
  }
  template <class Emit>
  void gradient(Index e, const Configuration& c, Emit&& emit) const {
    const double s = std::max(0.0, turned(e, c));
    const std::array<double, 3> w = weights(e);
    for (int a = 0; a < 3; ++a) emit(a, Vec3(2.0 * edges_[e].stiffness * s * w[a] * outward_[e]));
  }
  template <class Emit>
  void hessian(Index e, const Configuration& c, Emit&& emit) const {
    const double k = turned(e, c) > 0.0 ? 2.0 * edges_[e].stiffness : 0.0;
    const std::array<double, 3> w = weights(e);
    const Mat3 square = outward_[e] * outward_[e].transpose();
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) emit(a, b, Mat3(k * w[a] * w[b] * square));
  }
  template <class Emit>
  void blocks(Index, Emit&& emit) const {
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) emit(a, b);
  }

 private:
  static constexpr double free_cosine = 0.25881904510252074;  ///< c_0

  /// ds/dx = w m for A, a and b.
  [[nodiscard]] std::array<double, 3> weights(Index e) const {
    const Edge& edge = edges_[e];
    return {1.0 / edge.height, -(1.0 - edge.foot) / edge.height, -edge.foot / edge.height};
  }
  [[nodiscard]] double turned(Index e, const Configuration& c) const {
    const std::array<double, 3> w = weights(e);
    const std::array<Index, 3>& p = edges_[e].points;
    return free_cosine + outward_[e].dot(w[0] * c.x[p[0]] + w[1] * c.x[p[1]] + w[2] * c.x[p[2]]);
  }

  std::vector<Edge> edges_;
  std::vector<Vec3> outward_;  ///< m now
};

}  // namespace voile::energy
