// Solutions with a matrix whose change of low rank is kept apart (system/low_rank.hpp); private to src/solve.
//
// Symbols   K factored matrix;  B, S its change;  Z = K^-1 B,  G = B^T Z
//   (K + B S B^T)^-1 b = y - Z (I + S G)^-1 S B^T y,   y = K^-1 b                             (Sherman, Morrison, Woodbury)
//   n(K + B S B^T) = n(K) + n(-S^-1 - G) - n(-S^-1),   n the number of negative eigenvalues   (Haynsworth)
// Source: Golub & Van Loan, Matrix Computations, 4th ed. (2013), 2.1.4; Haynsworth, Linear Algebra Appl. 1 (1968) 73-81.
#pragma once

#include "system/low_rank.hpp"

namespace voile::linear {

class LowRankSolution {
 public:
  /// The matrix is another one: what was prepared counts no more.
  void forget() { ready_ = false; }
  /// Solves for Z with a PC that is a complete factor, unless that is done. Collective.
  void prepare(PC factor, const system::LowRankChange& change);
  /// Turns x = K^-1 b into the solution with the change. Collective.
  void correct(const system::LowRankChange& change, Vec x) const;
  /// n(K + B S B^T) - n(K). Not collective.
  [[nodiscard]] long more_negative(const system::LowRankChange& change) const;

 private:
  /// S in those units.
  [[nodiscard]] Eigen::MatrixXd weights_of(const system::LowRankChange& change) const;

  std::vector<petsc::VecHandle> z_;
  Eigen::VectorXd unit_;  ///< of the columns: root of the diagonal of G
  Eigen::MatrixXd g_;     ///< in these units
  bool ready_ = false;
};

}  // namespace voile::linear
