// Incomplete Cholesky factor without fill of a symmetric matrix of 3 x 3 blocks; private to src/solve.
//
// Symbols   A    matrix, symmetric, its block rows and columns in the order of elimination
//           W    unit lower triangular matrix of blocks, with the pattern of A's lower triangle
//           D    diagonal matrix of symmetric positive definite 3 x 3 blocks
//           P    = W D W^T, equal to A on the pattern of A; equal to A everywhere where elimination makes no fill
// A need not have such a factor even if it is positive definite: pivots D_i may come out indefinite. Then
// A + s diag(A) with growing s is factored in its place (T. A. Manteuffel, Math. Comput. 34 (1980) 473-497, with the
// blocks of the diagonal). P is positive definite whenever factor() succeeds.
#pragma once

#include <vector>

#include "block_pattern.hpp"
#include "lanes.hpp"

namespace voile::linear {

class IncompleteCholesky {
 public:
  /// Reads the pattern of both triangles of a matrix; `order` has the block rows in the order of elimination. False, and nothing
  /// else can be done, if these are not made of full blocks with all of the diagonal. Allocates; factor() and solve() do not.
  [[nodiscard]] bool read_pattern(const BlockPattern& pattern, std::vector<int> order);
  /// Factors the matrix of that pattern. Begins with the shift s = `shift`, for each failure takes the larger of four
  /// times the last and `first_shift`. False if the largest shift does not help, as with values that are not finite.
  [[nodiscard]] bool factor(const BlockPattern::Values& values, double shift, double first_shift);
  /// x = P^-1 b; both of three values per block row, may be the same.
  void solve(const double* b, double* x);

  /// s of the factor in force, and how many it took.
  [[nodiscard]] double shift() const { return shift_; }
  [[nodiscard]] int attempts() const { return attempts_; }
  [[nodiscard]] int block_rows() const { return static_cast<int>(row_starts_.size()) - 1; }
  /// Blocks below the diagonal.
  [[nodiscard]] long blocks() const { return static_cast<long>(columns_.size()); }

 private:
  /// Two blocks left of (i, k) in one column m: of row i, counted from its start, and of row k.
  struct Match {
    int in_row, other;
  };
  void find_matches();
  [[nodiscard]] bool factor_shifted(const BlockPattern::Values& values, double shift);
  [[nodiscard]] Rows eliminated(int at, const Rows& own) const;
  [[nodiscard]] Eigen::Map<Lanes> part(int i) { return Eigen::Map<Lanes>(x_.data() + 4 * i); }

  [[nodiscard]] bool read_row(const BlockPattern& pattern, int row);

  std::vector<int> order_, position_;                    ///< of elimination: rows, and the place of each in it
  std::vector<int> row_starts_, columns_;                ///< strictly lower blocks by rows, both numbered in that order
  std::vector<BlockPattern::Place> places_, diagonals_;  ///< of each block in the values, and of each on the diagonal
  std::vector<int> match_starts_;                        ///< of each block
  std::vector<Match> matches_;
  /// Blocks of W, by columns until all are there, then by rows, and of D^-1, nine floats each.
  std::vector<float> w_, inverse_;
  std::vector<double> row_;  ///< blocks of W D in the row at work
  std::vector<double> x_;    ///< solution, in the order of elimination, in lanes
  double shift_ = 0.0;
  bool hopeless_ = false;
  int attempts_ = 0;
};

}  // namespace voile::linear
