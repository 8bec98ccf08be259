// Products with a matrix of 3x3 blocks that are multiples of the unit block, but for a few.
//
// Bending acts on x, y and z alike: K = k (x) I. PETSc's MAIJ multiplies by the scalars k, a ninth of what K has to read. The other
// blocks (of mirror points and of vertices with axes of their own) are a matrix beside it.
#pragma once

#include "voile/base/petsc.hpp"
#include "voile/system/block_matrix.hpp"

namespace voile::system {

class BlockProduct {
 public:
  /// y = K x, always of the same K, whose values are read anew after every BlockMatrix::close(). Collective.
  void multiply(const BlockMatrix& k, Vec x, Vec y);

 private:
  void read(const BlockMatrix& k);

  petsc::MatHandle product_;  ///< k (x) I
  petsc::MatHandle rest_;     ///< blocks that are no multiples; null if no rank has any
  long version_ = -1;
};

}  // namespace voile::system
