#include "voile/system/block_product.hpp"

#include <petscmat.h>

#include <vector>

#include "voile/base/mpi.hpp"

namespace voile::system {

namespace {

bool is_multiple(const Mat3& block) {
  return block == Mat3(block(0, 0) * Mat3::Identity());
}

/// Rows of blocks of size `block`, with room for so many blocks per row in the two parts.
petsc::MatHandle make(MPI_Comm comm, const BlockMatrix& k, PetscInt block, const std::vector<PetscInt>& inside,
                      const std::vector<PetscInt>& outside) {
  petsc::MatHandle m;
  PetscInt rows = 0;
  VOILE_PETSC(MatGetLocalSize(k.mat(), &rows, nullptr));
  rows = rows / 3 * block;
  VOILE_PETSC(MatCreate(comm, m.out()));
  VOILE_PETSC(MatSetSizes(m, rows, rows, PETSC_DETERMINE, PETSC_DETERMINE));
  VOILE_PETSC(MatSetBlockSize(m, block));
  VOILE_PETSC(MatSetType(m, MATAIJ));
  VOILE_PETSC(MatXAIJSetPreallocation(m, block, inside.data(), outside.data(), nullptr, nullptr));
  return m;
}

}  // namespace

void BlockProduct::read(const BlockMatrix& k) {
  MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(k.mat()));
  PetscInt begin = 0, end = 0;
  VOILE_PETSC(MatGetOwnershipRange(k.mat(), &begin, &end));
  const auto rows = static_cast<std::size_t>((end - begin) / 3);
  std::vector<PetscInt> counts[4];  // multiples inside and outside, the others inside and outside
  for (auto& c : counts) c.assign(rows, 0);
  double others = 0.0;
  k.for_each_block([&](Index row, Index column, const Mat3& block) {
    const bool multiple = is_multiple(block), inside = 3 * column >= begin && 3 * column < end;
    ++counts[(multiple ? 0 : 2) + (inside ? 0 : 1)][static_cast<std::size_t>(row)];
    others += multiple ? 0.0 : 1.0;
  });
  const bool any = mpi::max(comm, others) > 0.0;
  const petsc::MatHandle scalars = make(comm, k, 1, counts[0], counts[1]);
  rest_.reset();
  if (any) rest_ = make(comm, k, 3, counts[2], counts[3]);
  k.for_each_block([&](Index row, Index column, const Mat3& block) {
    const PetscInt i = begin / 3 + row, j = column;
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> by_rows = block;
    if (is_multiple(block))
      VOILE_PETSC(MatSetValues(scalars, 1, &i, 1, &j, by_rows.data(), INSERT_VALUES));
    else
      VOILE_PETSC(MatSetValuesBlocked(rest_, 1, &i, 1, &j, by_rows.data(), INSERT_VALUES));
  });
  for (Mat m : {static_cast<Mat>(scalars), static_cast<Mat>(rest_)}) {
    if (!m) continue;
    VOILE_PETSC(MatAssemblyBegin(m, MAT_FINAL_ASSEMBLY));
    VOILE_PETSC(MatAssemblyEnd(m, MAT_FINAL_ASSEMBLY));
  }
  VOILE_PETSC(MatCreateMAIJ(scalars, 3, product_.out()));
  version_ = k.version();
}

void BlockProduct::multiply(const BlockMatrix& k, Vec x, Vec y) {
  if (version_ != k.version()) read(k);
  VOILE_PETSC(MatMult(product_, x, y));
  if (rest_) VOILE_PETSC(MatMultAdd(rest_, x, y, y));
}

}  // namespace voile::system
