// What straight chords feign in the strain of a bent membrane, and its removal.
//
// Symbols   E_r      mean strain of the six-node membrane, r = 11, 22, 2 x 12: E_r = 1/2 sum_ij Q^r_ij x_i.x_j - rest
//           k_A      curvature vectors k'(x) of the triangle, A = 11, 22, 2 x 12: kappa0_A N_s + r_A + sum_i B'_Ai u_i, see
//                    bending.hpp; kappa0 at rest [1/m]
//           l        p_j - p_i, chord between two points of the patch in the plane of the triangle [m]
//           S        1/24 sum over sides of l (x) l, averaged twice from triangles to vertices and back [m^2]
// If the surface bends without stretching, |x_i - x_j|^2 = |l|^2 - |l.k l|^2 / 12, so chords feign
//   E_r = -1/2 sum_AB T^r_AB (k_A.k_B - kappa0_A kappa0_B),  T^r = -1/24 sum_{i != j} Q^r_ij lam lam^T,
//   lam = (l1^2, l2^2, l1 l2).
// On even cells all triangles feign the same, E_ab = -k_ac S_cd k_bd, which the sheet makes up for at next to no energy and
// which keeps it from sharp folds; what differs from it locks. T^r here is without that part, and zero beside a crease.
// Corrected strain:  E_r + 1/2 sum_AB T^r_AB (k_A.k_B - kappa0_A kappa0_B)
#pragma once

#include <array>
#include <vector>

#include "voile/energy/bending.hpp"
#include "voile/energy/sheet.hpp"
#include "voile/energy/term.hpp"

namespace voile::energy {

/// T^r of the triangles of a sheet, which must outlive it.
class ChordForms {
 public:
  /// Passes over all triangles. Not collective.
  explicit ChordForms(const Sheet& sheet);
  /// From the Q^r of triangle t [1/m^2]; T^r [m^2].
  [[nodiscard]] std::array<Mat3, 3> of(Index t, const std::array<Eigen::Matrix<double, 6, 6>, 3>& q) const;

 private:
  const Sheet* sheet_;
  std::vector<Mat2> even_;  ///< S in the axes of each triangle
};

/// The correction of a number of triangles. Stencils: the six nodes of the membrane, then the other points of the bending.
class ChordCorrection {
 public:
  static constexpr int nodes = 6, most = 24;

  /// T^r of the two strains of an element: the mean one, and that of the triangle alone.
  using Forms = std::array<std::array<Mat3, 3>, 2>;
  enum Strain { mean, own };

  /// `six`: the membrane's nodes; `points`: the bending element's; in one numbering of the caller's. A bending element with
  /// more points than fit is left uncorrected.
  void add(const Forms& forms, const BendingElement& element, const std::array<Index, nodes>& six,
           const std::vector<Index>& points);
  [[nodiscard]] const Index* stencil(Index e) const { return points_.data() + elements_[e].start; }
  [[nodiscard]] int stencil_size(Index e) const { return elements_[e].count; }
  /// B'_i of point i of the stencil.
  [[nodiscard]] const Vec3& weight(Index e, int i) const { return weights_[elements_[e].start + i]; }

  /// sum_i u_i B'_Ai, column A [1/m].
  [[nodiscard]] Mat3 change(Index e, const Vec3* u) const;
  /// The same of the step from c.previous to c.x.
  [[nodiscard]] Mat3 step(Index e, const Configuration& c) const;
  struct Corrected {
    Vec3 strain;             ///< to be added to E
    std::array<Mat3, 3> by;  ///< dE_r/dk_A, column A
  };
  /// `change`: of the displacements from the start.
  [[nodiscard]] Corrected of(Index e, Strain which, const Mat3& change) const;
  /// The part of the strain of second order in a step by `change`.
  [[nodiscard]] Vec3 quadratic(Index e, Strain which, const Mat3& change) const;
  /// sum_r n_r T^r; `positive`: without its negative part.
  [[nodiscard]] Mat3 geometric(Index e, Strain which, const Vec3& n, bool positive) const;

 private:
  struct Element {
    std::size_t start;
    int count;
    Forms forms;                       ///< T^r
    Mat3 start_curvature;              ///< kappa0_A N_s + r_A, column A
    std::array<Vec3, 2> start_strain;  ///< 1/2 sum T^r_AB (k_A.k_B - kappa0_A kappa0_B) at the start
  };
  std::vector<Element> elements_;
  std::vector<Index> points_;
  std::vector<Vec3> weights_;
};

}  // namespace voile::energy
