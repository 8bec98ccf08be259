#include "compact_matrix.hpp"

#include <petscmat.h>

#include <vector>

#include "base/mpi.hpp"

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

void CompactMatrix::read(const BlockMatrix& k) {
  MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(k.mat()));
  PetscInt begin = 0, end = 0;
  VOILE_PETSC(MatGetOwnershipRange(k.mat(), &begin, &end));
  const auto rows = static_cast<std::size_t>((end - begin) / 3);
  std::vector<PetscInt> counts[4];  // all blocks inside and outside, the others inside and outside
  for (auto& c : counts) c.assign(rows, 0);
  others_.clear();
  k.for_each_block([&](Index row, Index column, const Mat3& block) {
    const int part = 3 * column >= begin && 3 * column < end ? 0 : 1;
    ++counts[part][static_cast<std::size_t>(row)];
    if (is_multiple(block)) return;
    ++counts[2 + part][static_cast<std::size_t>(row)];
    others_.push_back({row, column, block});
  });
  const bool any = mpi::max(comm, others_.empty() ? 0.0 : 1.0) > 0.0;
  const petsc::MatHandle scalars = make(comm, k, 1, counts[0], counts[1]);
  rest_.reset();
  if (any) rest_ = make(comm, k, 3, counts[2], counts[3]);
  k.for_each_block([&](Index row, Index column, const Mat3& block) {
    const PetscInt i = begin / 3 + row;
    const double scalar = is_multiple(block) ? block(0, 0) : 0.0;
    VOILE_PETSC(MatSetValues(scalars, 1, &i, 1, &column, &scalar, INSERT_VALUES));
  });
  for (const Other& o : others_) {
    const PetscInt i = begin / 3 + o.row;
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> by_rows = o.block;
    VOILE_PETSC(MatSetValuesBlocked(rest_, 1, &i, 1, &o.column, by_rows.data(), INSERT_VALUES));
  }
  for (Mat m : {static_cast<Mat>(scalars), static_cast<Mat>(rest_)}) {
    if (!m) continue;
    VOILE_PETSC(MatAssemblyBegin(m, MAT_FINAL_ASSEMBLY));
    VOILE_PETSC(MatAssemblyEnd(m, MAT_FINAL_ASSEMBLY));
  }
  VOILE_PETSC(MatCreateMAIJ(scalars, 3, product_.out()));
}

void CompactMatrix::add_to(const BlockMatrix& target, const BlockMatrix::Values& values, double factor) const {
  const auto [diagonal, off_diagonal] = scalars();
  const double *inside = diagonal, *outside = off_diagonal;
  target.for_each_base_slot([&](Slot s) {  // in the order of the two parts
    double* at = s.offset >= 0 ? values.diagonal + s.offset : values.off_diagonal + ~s.offset;
    const double k = factor * (s.offset >= 0 ? *inside++ : *outside++);
    for (int i = 0; i < 3; ++i, at += s.stride) at[i] += k;
  });
  add_others(target, values, factor);
}

std::pair<const double*, const double*> CompactMatrix::scalars() const {
  Mat whole = nullptr, diagonal = nullptr, off_diagonal = nullptr;
  PetscBool sequential = PETSC_FALSE;
  VOILE_PETSC(MatMAIJGetAIJ(product_, &whole));
  VOILE_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(whole), MATSEQAIJ, &sequential));
  if (sequential)
    diagonal = whole;
  else
    VOILE_PETSC(MatMPIAIJGetSeqAIJ(whole, &diagonal, &off_diagonal, nullptr));
  const auto values_of = [](Mat part) {
    const double* values = nullptr;
    if (!part) return values;
    VOILE_PETSC(MatSeqAIJGetArrayRead(part, &values));
    const double* kept = values;
    VOILE_PETSC(MatSeqAIJRestoreArrayRead(part, &values));
    return kept;
  };
  return {values_of(diagonal), values_of(off_diagonal)};
}

void CompactMatrix::multiply(Vec x, Vec y) const {
  VOILE_PETSC(MatMult(product_, x, y));
  if (rest_) VOILE_PETSC(MatMultAdd(rest_, x, y, y));
}

}  // namespace voile::system
