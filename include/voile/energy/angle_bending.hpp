// Bending by the angles at the edges around a triangle (element.bending = "edge_angle"): what happens in the plane of the sheet
// bends nothing.
//
// Symbols   B        curvature operator of edge_slope (curvature.hpp), zero on affine maps of the unfolded patch
//           h_e      x_q less the affine map of triangle (a, b, p) at the place of q, of an inner edge e = (a, b) of the patch between p and q
//           H_e      height of q over e in the unfolded patch [m];  theta_e the angle at e (edge_angle.hpp)
//           D, A     bending stiffness [N m], rest area [m^2];  B', r as in bending.hpp
// Since the h_e vanish on affine maps and are as many as it takes, B = sum_e c_e h_e. Then
//   kappa = sum_e c_e H_e theta_e,   E = A/2 (kappa - kappa0).D (kappa - kappa0),   kappa0 the same at rest.
// Where the sheet is nearly flat h_e = H_e theta_e n, so that kappa = n.B x to first order: patch test and convergence are those of edge_slope.
// An arc of n equal steps turns by theta = s/R at each whatever its chords, so that kappa = 1/R: no cosine is lost in the sum of vectors of
// different directions, and no term of fourth order (chord_correction.hpp) is needed. E does not depend on strains that leave angles alone.
// The constant part of edge_slope stays in K_b, where damping and the start take it from; the term adds
//   E - A/2 (r + B'u).D (r + B'u).
#pragma once

#include <optional>
#include <vector>

#include "voile/energy/bending.hpp"
#include "voile/energy/edge_angle.hpp"

namespace voile::energy {

/// kappa of one triangle, in mesh point numbering.
struct EdgeAngles {
  struct Edge {
    std::array<Index, 4> points;  ///< a, b, p, q
    Vec3 weight;                  ///< c_e H_e [1/m]
  };
  std::vector<Edge> edges;
  Vec3 rest = Vec3::Zero();  ///< kappa0
};

/// Between points of `bending`, the element of triangle t, whose operator without its correction for curved rest shapes is `op`. Nothing where its
/// edges do not make up B: fits over rings of a doubly curved rest shape, whose unfolding depends on the way around a vertex, and beside seams whose sides
/// differ in length, where slopes of two scales are averaged.
[[nodiscard]] std::optional<EdgeAngles> make_edge_angles(const Sheet& sheet, Index t, const CurvatureOperator& op,
                                                         const BendingElement& bending);

class AngleBendingTerm {
 public:
  static constexpr int most = 64;

  /// `local`: the points of `bending` in local numbering, at most `most`. `stiffness`: A D.
  void add(const BendingElement& bending, const EdgeAngles& angles, const std::vector<Index>& local,
           const Mat3& stiffness, bool owned);

  [[nodiscard]] Index size() const { return static_cast<Index>(elements_.size()); }
  [[nodiscard]] const Index* stencil(Index e) const { return points_.data() + elements_[e].start; }
  [[nodiscard]] int stencil_size(Index e) const { return elements_[e].count; }
  [[nodiscard]] bool owned(Index e) const { return elements_[e].owned; }

  /// kappa - kappa0 [1/m].
  [[nodiscard]] Vec3 curvature(Index e, const Configuration& c) const;
  [[nodiscard]] const Vec3& rest_curvature(Index e) const { return elements_[e].rest; }

  [[nodiscard]] double energy(Index e, const Configuration& c) const;
  template <class Emit>
  void gradient(Index e, const Configuration& c, Emit&& emit) const {
    std::array<Vec3, most> g;
    gradient_of(e, c, g);
    for (int i = 0; i < elements_[e].count; ++i) emit(i, g[static_cast<std::size_t>(i)]);
  }
  template <class Emit>
  void hessian(Index e, const Configuration& c, Emit&& emit) const {
    Upper k;
    hessian_of(e, c, k);
    std::size_t at = 0;
    for (int i = 0; i < elements_[e].count; ++i)
      for (int j = i; j < elements_[e].count; ++j, ++at) {
        emit(i, j, k[at]);
        if (j != i) emit(j, i, k[at].transpose());
      }
  }
  template <class Emit>
  void blocks(Index e, Emit&& emit) const {
    for (int i = 0; i < elements_[e].count; ++i)
      for (int j = i; j < elements_[e].count; ++j) {
        emit(i, j);
        if (j != i) emit(j, i);
      }
  }

 private:
  struct Element {
    std::size_t start, first_edge;
    int count, edges;
    bool owned;
    Mat3 stiffness;   ///< A D
    Vec3 rest;        ///< kappa0
    Mat3 start_bend;  ///< r
  };
  struct Edge {
    std::array<int, 4> at;  ///< in the stencil
    Vec3 weight;
  };
  using Upper = std::array<Mat3, most*(most + 1) / 2>;  ///< blocks of pairs i <= j, row by row

  [[nodiscard]] EdgePoints points_of(const Element& el, const Edge& edge, const Configuration& c) const;
  /// r + B'u.
  [[nodiscard]] Mat3 bend(const Element& el, const Configuration& c) const;
  void gradient_of(Index e, const Configuration& c, std::array<Vec3, most>& g) const;
  void hessian_of(Index e, const Configuration& c, Upper& k) const;
  void add_geometric(const Element& el, const Configuration& c, const Vec3& moment, Upper& k) const;

  std::vector<Element> elements_;
  std::vector<Edge> edges_;
  std::vector<Index> points_;
  std::vector<Vec3> weights_;  ///< B'_i
};

}  // namespace voile::energy
