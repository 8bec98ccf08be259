// A symmetric AIJ matrix of 3 x 3 blocks for many products: of each rank's diagonal part the lower triangle only, which
// is half of what has to be read; private to src/solve.
#pragma once

#include <vector>

#include "base/petsc.hpp"
#include "block_rows.hpp"
#include "lanes.hpp"

namespace voile::linear {

class SymmetricBlocks {
 public:
  /// Copies k, seqaij or mpiaij, which must be symmetric; False, on all ranks, if it is not made of full blocks.
  /// `new_pattern`: the pattern may be another than at the last call. K must live as long as the product is used, as its
  /// off-diagonal part is not copied. Collective.
  [[nodiscard]] bool take(Mat k, bool new_pattern);
  /// The product as a matrix of type shell, owned by this object; the same one for one pattern.
  [[nodiscard]] Mat mat() const { return shell_; }
  /// y = K x. Collective.
  void multiply(Vec x, Vec y) const;

 private:
  [[nodiscard]] bool read_pattern(Mat k);
  void multiply_inside(const double* x, double* y) const;

  Mat inside_ = nullptr, outside_ = nullptr;              ///< parts of k, not owned
  std::vector<int> starts_, columns_, places_, strides_;  ///< of the blocks of the lower triangle, the diagonal last
  std::vector<double> values_;                            ///< nine per block, by rows
  mutable std::vector<double> x_, y_;                     ///< vectors of a product, in lanes
  petsc::MatHandle shell_;
  GhostColumns ghosts_;
};

}  // namespace voile::linear
