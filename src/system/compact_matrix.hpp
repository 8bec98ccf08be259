// A constant matrix of 3x3 blocks that are multiples of the unit block, but for a few.
//
// Bending acts on x, y and z alike: K = k (x) I, of which only the scalars k are kept: a ninth of K. PETSc's MAIJ multiplies by them.
// The other blocks (of mirror points and of vertices with axes of their own) are a matrix beside it.
#pragma once

#include <utility>
#include <vector>

#include "base/petsc.hpp"
#include "block_matrix.hpp"

namespace voile::system {

class CompactMatrix {
 public:
  /// K becomes the closed values of k, which was never extended. Collective.
  void read(const BlockMatrix& k);
  /// y = K x. Collective.
  void multiply(Vec x, Vec y) const;
  /// Adds factor K to the open values of `target`, a twin of k or an extension of it. Not collective.
  void add_to(const BlockMatrix& target, const BlockMatrix::Values& values, double factor) const;

  /// Only that of blocks that are no multiples of the unit block.
  void add_others(const BlockMatrix& target, const BlockMatrix::Values& values, double factor) const {
    for (const Other& o : others_) values.add(target.slot(o.row, o.column), factor * o.block);
  }
  /// The scalars of the two parts of K, in the order of the blocks of the pattern; they stay where they are.
  [[nodiscard]] std::pair<const double*, const double*> scalars() const;

 private:
  petsc::MatHandle product_;  ///< k (x) I, with a scalar, which may be 0, for every block of the pattern
  petsc::MatHandle rest_;     ///< blocks that are no multiples; null if no rank has any
  struct Other {
    Index row, column;  ///< owned block row, global block column
    Mat3 block;
  };
  std::vector<Other> others_;  ///< the blocks of `rest_`
};

}  // namespace voile::system
