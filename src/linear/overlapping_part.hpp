// What a rank's rows of a distributed matrix are joined to: its own block rows and those of its neighbours that they have entries
// in, as one matrix; private to src/solve.
//
// Symbols   A    distributed matrix of 3 x 3 blocks
//           R_p  restriction to the block rows of rank p and those of other ranks that they couple to
//           A_p  = R_p A R_p^T, in the order of A's numbers
// For additive Schwarz preconditioners with an overlap of one ring: sum_p R_p^T A_p^-1 R_p is symmetric positive definite if A
// is (B. Smith, P. Bjorstad and W. Gropp, Domain Decomposition, Cambridge 1996, chapter 1).
// Source: A. Toselli & O. Widlund, Domain Decomposition Methods (2005), 1.3.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "base/petsc.hpp"
#include "block_pattern.hpp"
#include "block_rows.hpp"

namespace voile::linear {

class OverlappingPart {
 public:
  /// That of A_p for an mpiaij matrix. Collective.
  [[nodiscard]] BlockPattern read_pattern(Mat a);
  /// Gives the values of a matrix with that pattern to `use`. Collective.
  void take(Mat a, const std::function<void(const BlockPattern::Values&)>& use);

  /// R_p b, three values per block row, valid until the next call; for writing as well. Collective.
  double* restricted(Vec b);
  /// x = sum_p R_p^T v_p with what the last restricted() has been overwritten by. Collective.
  void add_up(Vec x);

 private:
  void fetch_rows_of_others(Mat a, MatReuse reuse);

  struct DestroySubMatrices {
    void operator()(Mat* matrices) const { (void)MatDestroySubMatrices(1, &matrices); }
  };
  petsc::IndexSetHandle others_, all_;  ///< rows of A: of other ranks, and all of A_p
  std::unique_ptr<Mat, DestroySubMatrices> rows_of_others_;
  int own_ = 0, before_ = 0,
      ghosts_count_ = 0;  ///< scalar rows of this rank, of others, and of these the ones before its own
  std::vector<double> v_;
  GhostColumns ghosts_;
};

}  // namespace voile::linear
