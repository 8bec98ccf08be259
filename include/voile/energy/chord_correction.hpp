// What straight chords feign in the strain of a bent membrane, and its removal; and what bending loses when chords are no
// longer longer than they should be.
//
// Symbols   E_r      strain of the six-node membrane or of the triangle alone, r = 11, 22, 2 x 12:
//                    E_r = 1/2 sum_ij Q^r_ij x_i.x_j - rest
//           K_B      how the surface bends across the patch, seven vectors (patch_cubic.hpp); the first three are the second
//                    derivatives at the centroid; their normal parts at rest are kappa0_B
//           k_c      sum_B s_cB K_B, bend along chord c from p_i to p_j times its squared length, at its middle [m]
// If the surface bends without stretching, |x_i - x_j|^2 = |p_i - p_j|^2 - |k_c|^2 / 12 to the sixth order in the chord, so that
//   E_r + 1/2 sum_c W_rc (|k_c|^2 - |k_c at rest|^2),   W_rc = -Q^r_ij / 12
// is free of it. Zero beside a crease.
// Second differences of an arc by the angle t per cell are too small by the factor 1 - t^2/12 once its length is right (by half of
// that if its chords have the length of the arc, as in the uncorrected membrane). So the energy has the term
//   A (q_D - q_D at rest) (q_S - q_S at rest),   q_D = sum_AB D_AB K_A.K_B,   q_S = sum_AB R_AB K_A.K_B = trace of k S k
// with S the mean of the squared sides of the cells around (chord_forms.hpp): it is of fourth order in the curvature.
#pragma once

#include <array>
#include <vector>

#include "voile/energy/patch_cubic.hpp"
#include "voile/energy/term.hpp"

namespace voile::energy {

/// The chords of a patch and what each adds to the strains of its triangle.
struct Chords {
  static constexpr int count = 12;
  using Share = Eigen::Matrix<double, 3, count>;
  Eigen::Matrix<double, bend_vectors, count> along;  ///< s_c [m^2]
  std::array<Share, 2> share;                        ///< W_rc of the mean strain and of the triangle's own [1/m^2]
};

/// `quadratic`: Q^r of the two strains; all shares are zero beside a crease.
[[nodiscard]] Chords make_chords(const Sheet& sheet, Index t, const PatchCubic& cubic,
                                 const std::array<std::array<Eigen::Matrix<double, 6, 6>, 3>, 2>& quadratic);

/// The correction of a number of triangles. Stencils: the six nodes of the membrane, then the other points of the cubic.
class ChordCorrection {
 public:
  static constexpr int nodes = 6, most = 64;
  using Form = Eigen::Matrix<double, bend_vectors, bend_vectors>;
  enum Strain { mean, own };

  /// A triangle as it is added; points in one numbering of the caller's.
  struct Input {
    const PatchCubic& cubic;
    const Chords& chords;
    Mat3 stiffness, trace;         ///< A D and R; zero: no term of fourth order
    std::array<Index, nodes> six;  ///< the membrane's nodes
    std::vector<Index> of_cubic;   ///< of the cubic, in its order
  };
  /// A triangle with more points than `most` is left uncorrected: one whose cubic is that of a bending element of so many.
  void add(const Input& input);
  [[nodiscard]] const Index* stencil(Index e) const { return points_.data() + elements_[e].start; }
  [[nodiscard]] int stencil_size(Index e) const { return elements_[e].count; }
  [[nodiscard]] bool left_out(Index e) const { return elements_[e].left_out; }
  /// B'_i of point i of the stencil.
  [[nodiscard]] const BendWeights& weight(Index e, int i) const { return weights_[elements_[e].start + i]; }

  /// sum_i u_i B'_iB, column B.
  [[nodiscard]] Bends change(Index e, const Vec3* u) const;
  /// The same of the step from c.previous to c.x.
  [[nodiscard]] Bends step(Index e, const Configuration& c) const;
  /// k_c, column c; x, y, z and a zero, with which a column fills a register.
  struct ChordBends {
    Eigen::Matrix<double, 4, Chords::count> now, change;
  };
  /// `change`: of the displacements from the start.
  [[nodiscard]] ChordBends along_chords(Index e, const Bends& change) const;
  /// To be added to E.
  [[nodiscard]] Vec3 strain(Index e, Strain which, const ChordBends& bends) const;
  /// dE_r/dK_B, column B.
  using Slopes = std::array<Eigen::Matrix<double, 4, bend_vectors>, 3>;
  [[nodiscard]] Slopes slopes(Index e, Strain which, const ChordBends& bends) const;
  /// sum_r n_r dE_r/dK_B, column B.
  [[nodiscard]] Bends pull(Index e, Strain which, const ChordBends& bends, const Vec3& n) const;
  /// The part of the strain of second order in a step by `change`.
  [[nodiscard]] Vec3 quadratic(Index e, Strain which, const Bends& change) const;
  /// Derivatives sum_r n_r d2E_r/dK_A dK_B, the same number for x, y and z; `positive`: without their negative part.
  [[nodiscard]] Form geometric(Index e, Strain which, const Vec3& n, bool positive) const;

  /// The term of fourth order W.
  [[nodiscard]] double energy(Index e, const Bends& change) const;
  /// dW/dK_B, column B.
  [[nodiscard]] Bends pull(Index e, const Bends& change) const;
  /// d2W/dK_A dK_B = form_AB I + sum_k first^k_A second^k_B^T.
  struct Curvature {
    Form form;
    std::array<Bends, 2> first, second;
  };
  [[nodiscard]] Curvature curvature(Index e, const Bends& change, bool positive) const;

 private:
  struct Element {
    std::size_t start;
    int count;
    bool left_out;
    Chords chords;
    Bends start_bends;                 ///< K at the start
    std::array<Vec3, 2> start_strain;  ///< of the correction
    Mat3 stiffness, trace;
    double start_bending, start_trace;  ///< A (q_D - q_D at rest) and q_S - q_S at rest at the start
  };
  /// A (q_D - ...) and q_S - ..., and half their derivatives by K_1..3.
  struct Invariants {
    double bending, trace;
    Mat3 of_bending, of_trace;
  };
  [[nodiscard]] static Invariants invariants(const Element& el, const Bends& change);

  std::vector<Element> elements_;
  std::vector<Index> points_;
  std::vector<BendWeights> weights_;
};

}  // namespace voile::energy
