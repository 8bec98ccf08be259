// A symmetric change of low rank of a sparse matrix, kept apart from it so that it stays sparse.
//
// Symbols   K   sparse matrix;  B columns, as many as the rank r;  S symmetric r x r
//   K + B S B^T
// Source: G.H. Golub & C.F. Van Loan, Matrix Computations, 4th ed. (2013), 2.1.4 (Sherman, Morrison, Woodbury).
#pragma once

#include <vector>

#include "base/petsc.hpp"
#include "base/types.hpp"

namespace voile::system {

struct LowRankChange {
  std::vector<petsc::VecHandle> columns;  ///< B
  Eigen::MatrixXd weights;                ///< S

  [[nodiscard]] bool empty() const { return columns.empty(); }
  void clear();
  /// Adds a column and a row and column of weights, zero but for the diagonal. Not collective.
  void add(petsc::VecHandle column, double weight);
  /// B^T x. Collective.
  [[nodiscard]] Eigen::VectorXd products(Vec x) const;
  /// y += B S B^T x. Collective.
  void multiply_add(Vec x, Vec y) const;
};

}  // namespace voile::system
