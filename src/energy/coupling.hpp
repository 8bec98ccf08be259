// Coupling of stretching and bending in laminates whose stack is not symmetric.
//
// Symbols   B, A     coupling stiffness in material axes [N], rest area [m^2]
//           e        elastic membrane strain (membrane.hpp), of the groups together, corrected for chords; a quadratic form of
//                    displacements d_i = u_i - u_0:  e_r = 1/2 sum_ij Q^r_ij d_i.d_j + sum_i c^r_i.d_i - off_r
//           k        elastic curvature n.k'(x) - kappa' (bending.hpp),  k'_r = a_r + sum_i B'_ri u_i,  a = r + kappa0 N_s
//   W = -A e.B k,    so that N = A e - B k, M = D k - B e with the energies of membrane and bending
// With p = B e, q = B k:  dW = -A (q.de + p.dk),   d2W = -A (q.d2e + de.B dk + dk.B de + p.d2k)
// Without its first and last part the tangent of the whole laminate is positive semidefinite. The last part and p.dk are those of
// the curved kernel with w = A p.a, c_i = A p.B'_i.
// At free sides, whose slopes minimise the energy, they follow e as well: the membrane then has the stiffness A - B (I - P) D^-1 B with
// P of free_side_projector() (membrane.cpp), and k here is that of slopes which do not.
// Source of A, B, D: Jones, Mechanics of Composite Materials, 2nd ed. (1999), chapter 4.
#pragma once

#include <vector>

#include "bending.hpp"
#include "sheet.hpp"
#include "term.hpp"

namespace voile::energy {

class CouplingTerm {
 public:
  static constexpr int most = 64;  ///< points of an element

  /// Triangle t with its bending element; `local_of`: local numbers of mesh points. Throws UserError for more than `most` points.
  void add(const Sheet& sheet, Index t, const BendingElement& bending, const std::vector<Index>& local_of, bool owned);
  /// Half the metric of the natural state of element e, and its curvature kappa' [1/m]. Needed once before any evaluation.
  void set_natural(Index e, const Vec3& metric, const Vec3& curvature);

  [[nodiscard]] Index size() const { return static_cast<Index>(elements_.size()); }
  [[nodiscard]] const Index* stencil(Index e) const { return points_.data() + elements_[e].first; }
  [[nodiscard]] int stencil_size(Index e) const { return elements_[e].count; }
  [[nodiscard]] bool owned(Index e) const { return elements_[e].owned; }

  [[nodiscard]] double energy(Index e, const Configuration& c) const;
  template <class Emit>
  void gradient(Index e, const Configuration& c, Emit&& emit) const {
    find_gradient(e, c);
    for (int i = 0; i < elements_[e].count; ++i) emit(i, force_[static_cast<std::size_t>(i)]);
  }
  /// Calls emit(i, j) for every block of hessian(), in its order.
  template <class Emit>
  void blocks(Index e, Emit&& emit) const {
    for (int i = 0; i < elements_[e].count; ++i)
      for (int j = 0; j < elements_[e].count; ++j) emit(i, j);
  }
  template <class Emit>
  void hessian(Index e, const Configuration& c, Emit&& emit) const {
    find_hessian(e, c);
    const int n = elements_[e].count;
    std::size_t at = 0;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) emit(i, j, hessian_[at++]);
  }

 private:
  struct Element {
    std::size_t first;  ///< of its points
    int count;
    bool owned;
    Mat3 coupling, start;    ///< A B, a
    Vec3 metric;             ///< half the metric of the start
    Vec3 strain, curvature;  ///< off, kappa'
  };
  using Weights = Eigen::Matrix<double, 3, Eigen::Dynamic>;
  struct Forms {
    std::array<Eigen::MatrixXd, 3> quadratic;  ///< Q^r
    std::array<Weights, 3> linear;             ///< c^r, a column for each point
    Weights curvature;                         ///< B'
  };

  void evaluate(Index e, const Configuration& c) const;
  void find_gradient(Index e, const Configuration& c) const;
  void find_hessian(Index e, const Configuration& c) const;
  /// The curved kernel at p: its numbers go to fields_.
  [[nodiscard]] CurvedBatch curved(Index e) const;

  std::vector<Index> points_;
  std::vector<Element> elements_;
  std::vector<Forms> forms_;
  // Of one evaluation
  mutable Vec3 strain_, curvature_, p_, q_;
  mutable std::vector<Vec3> d_, force_;
  mutable std::array<std::vector<Vec3>, 3> by_strain_, by_curvature_;  ///< de_r/du_i, dk_r/du_i
  mutable std::vector<Mat3> hessian_;
  mutable std::vector<double> fields_, blocks_;
  mutable std::vector<int> gather_;
};

}  // namespace voile::energy
