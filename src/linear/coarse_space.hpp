// Coarse level of a preconditioner: translations of aggregates of vertices, taken out of the residual before and out of
// the solution after another preconditioner has been at work; private to src/solve.
//
// Symbols   A    symmetric matrix of 3 x 3 blocks, distributed by block rows
//           Z    block rows of fractions of aggregates (times the 3 x 3 identity), which sum to one: of a vertex, how many of its
//                neighbours and itself each aggregate has (one averaging of the indicator, as in smoothed aggregation)
//           E    = Z^T A Z, dense, on every rank
//           Q    = Z E^-1 Z^T
//           M    the other preconditioner
// Together   P = (I - Q A) M (I - A Q) + Q, symmetric, and positive definite if A and M are: the balancing or "BNN"
// preconditioner (J. Mandel, Comm. Numer. Methods Eng. 9 (1993) 233-241; J. M. Tang et al., J. Sci. Comput. 39 (2009) 340-370).
// Incomplete factors are good at neighbours and bad at what whole regions do together, as in the plane of a stiff sheet.
#pragma once

#include <petscmat.h>

#include <Eigen/Cholesky>
#include <array>
#include <cstddef>
#include <vector>

#include "base/mpi.hpp"

namespace voile::linear {

class CoarseSpace {
 public:
  /// For matrices with the pattern of a, seqaij or mpiaij: about that many aggregates in all, one at least per rank. False,
  /// on all ranks, if a is not made of full blocks. Collective.
  [[nodiscard]] bool read_pattern(Mat a, int aggregates);
  /// A Z and E of a matrix of that pattern. False, on all ranks, if E is not positive definite: then neither is a. Collective.
  [[nodiscard]] bool take(Mat a);

  /// r = (I - A Q) b; both of three values per own block row, may be the same. Collective.
  void project(const double* b, double* r);
  /// x = (I - Q A) x + Q b, with b that of the last project(). Collective.
  void correct(double* x);

  [[nodiscard]] int aggregates() const { return aggregates_; }

 private:
  /// The fractions of one vertex; those not used are zero.
  static constexpr int most = 3;
  struct Shares {
    int aggregate[most];
    double fraction[most];
  };
  /// Where a block of A goes in its row of A Z.
  struct Target {
    int slot;
    double fraction;
  };
  /// A part of the matrix on this rank: columns of its own, or of others.
  struct Part {
    Mat mat = nullptr;  ///< not owned
    const int *starts = nullptr, *columns = nullptr;
    int first_column = 0;  ///< of shares_
  };
  void find_parts(Mat a);
  [[nodiscard]] bool has_full_blocks() const;
  void number_aggregates(int wanted);
  void find_fractions(const std::vector<int>& aggregate);
  void find_targets();
  /// Row i of A Z into row_, from the values of the parts; `block` counts the blocks of A before it. That count after it.
  std::size_t sum_row(int i, const std::array<const double*, 2>& values, std::size_t block);
  void solve_coarse(const std::vector<double>& y, std::vector<double>& c) const;

  MPI_Comm comm_ = MPI_COMM_NULL;
  int block_rows_ = 0, aggregates_ = 0;
  std::vector<Part> parts_;
  const PetscInt* ghost_columns_ = nullptr;  ///< of the second part, in the whole matrix; not owned
  std::vector<int> aggregate_;               ///< of each own block row
  std::vector<Shares> fractions_;            ///< of own block rows, then of the columns of others
  std::vector<int> slot_starts_;             ///< of each block row of A Z
  std::vector<int> slots_;                   ///< aggregates of these
  std::vector<int> target_starts_;           ///< of each block, by rows, within a row by parts
  std::vector<Target> targets_;
  std::vector<float> az_;              ///< blocks of A Z, nine floats each, by rows
  std::vector<double> row_;            ///< of one block row at work
  std::vector<double> e_, y_, c_, d_;  ///< E, and vectors of three values per aggregate
  Eigen::LLT<Eigen::MatrixXd> factor_;
};

}  // namespace voile::linear
