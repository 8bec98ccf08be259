#include "voile/system/block_matrix.hpp"

#include <petscmat.h>

#include <algorithm>

#include "voile/base/error.hpp"

namespace voile::system {

namespace {

const PetscInt* row_starts(Mat part) {
  const PetscInt* start = nullptr;
  if (part) VOILE_PETSC(MatSeqAIJGetCSRAndMemType(part, &start, nullptr, nullptr, nullptr));
  return start;
}

/// Adds factor times the values of one part of a matrix to `to`, each at its place there (empty: the same).
void add_part(Mat from, double factor, const std::vector<Index>& place, double* to) {
  if (!from) return;
  const double* values = nullptr;
  const PetscInt* starts = row_starts(from);
  PetscInt rows = 0;
  VOILE_PETSC(MatGetLocalSize(from, &rows, nullptr));
  VOILE_PETSC(MatSeqAIJGetArrayRead(from, &values));
  const PetscInt count = starts[rows];
  if (place.empty())
    for (PetscInt i = 0; i < count; ++i) to[i] += factor * values[i];
  else
    for (PetscInt i = 0; i < count; ++i) to[place[i]] += factor * values[i];
  VOILE_PETSC(MatSeqAIJRestoreArrayRead(from, &values));
}

void copy_part(Mat from, double* to) {
  if (!from) return;
  const double* values = nullptr;
  PetscInt rows = 0;
  VOILE_PETSC(MatGetLocalSize(from, &rows, nullptr));
  VOILE_PETSC(MatSeqAIJGetArrayRead(from, &values));
  std::copy(values, values + row_starts(from)[rows], to);
  VOILE_PETSC(MatSeqAIJRestoreArrayRead(from, &values));
}

}  // namespace

BlockMatrix::BlockMatrix(MPI_Comm comm, const mesh::Partition& partition, BlockPattern pattern)
    : pattern_(std::make_shared<const BlockPattern>(std::move(pattern))) {
  const int rank = mpi::rank(comm);
  first_row_ = partition.owned_begin(rank);
  row_count_ = partition.owned_count(rank);
  VOILE_PETSC(MatCreate(comm, mat_.out()));
  VOILE_PETSC(MatSetSizes(mat_, 3 * row_count_, 3 * row_count_, PETSC_DETERMINE, PETSC_DETERMINE));
  VOILE_PETSC(MatSetBlockSize(mat_, 3));
  VOILE_PETSC(MatSetType(mat_, MATAIJ));
  preallocate();
}

void BlockMatrix::preallocate() {
  std::vector<PetscInt> inside, outside;
  for (const auto& columns : *pattern_) {
    PetscInt in = 0;
    for (Index c : columns) in += c >= first_row_ && c < first_row_ + row_count_ ? 1 : 0;
    for (int i = 0; i < 3; ++i) {
      inside.push_back(3 * in);
      outside.push_back(3 * (static_cast<PetscInt>(columns.size()) - in));
    }
  }
  VOILE_PETSC(MatSeqAIJSetPreallocation(mat_, 0, inside.data()));
  VOILE_PETSC(MatMPIAIJSetPreallocation(mat_, 0, inside.data(), 0, outside.data()));
  std::vector<double> zeros;
  for (Index r = 0; r < row_count_; ++r) {
    const auto& columns = (*pattern_)[r];
    zeros.assign(9 * columns.size(), 0.0);
    const PetscInt row = first_row_ + r;
    VOILE_PETSC(MatSetValuesBlocked(mat_, 1, &row, static_cast<PetscInt>(columns.size()), columns.data(), zeros.data(),
                                    INSERT_VALUES));
  }
  VOILE_PETSC(MatAssemblyBegin(mat_, MAT_FINAL_ASSEMBLY));
  VOILE_PETSC(MatAssemblyEnd(mat_, MAT_FINAL_ASSEMBLY));
  find_parts();
}

BlockMatrix BlockMatrix::twin() const {
  BlockMatrix other;
  VOILE_PETSC(MatDuplicate(mat_, MAT_DO_NOT_COPY_VALUES, other.mat_.out()));
  other.pattern_ = pattern_;
  other.first_row_ = first_row_;
  other.row_count_ = row_count_;
  other.find_parts();
  return other;
}

void BlockMatrix::find_parts() {
  PetscBool sequential = PETSC_FALSE;
  VOILE_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(static_cast<Mat>(mat_)), MATSEQAIJ, &sequential));
  if (sequential)
    diagonal_ = mat_;
  else
    VOILE_PETSC(MatMPIAIJGetSeqAIJ(mat_, &diagonal_, &off_diagonal_, nullptr));
  diagonal_rows_ = row_starts(diagonal_);
  off_diagonal_rows_ = row_starts(off_diagonal_);
}

Slot BlockMatrix::slot(Index local_row, Index column) const {
  const auto& columns = (*pattern_)[local_row];
  const auto found = std::lower_bound(columns.begin(), columns.end(), column);
  if (found == columns.end() || *found != column) throw InternalError("matrix pattern lacks a block of an element");
  const auto first = std::lower_bound(columns.begin(), columns.end(), first_row_);
  const auto last = std::lower_bound(first, columns.end(), first_row_ + row_count_);
  const bool inside = found >= first && found < last;
  // PETSc stores both parts by rows with ascending columns, so a block's place follows from counts alone.
  const Index in = static_cast<Index>(last - first), out = static_cast<Index>(columns.size()) - in;
  const Index position = static_cast<Index>(inside          ? found - first
                                            : found < first ? found - columns.begin()
                                                            : (found - columns.begin()) - in);
  const Index offset = (inside ? diagonal_rows_ : off_diagonal_rows_)[3 * local_row] + 3 * position;
  return {inside ? offset : ~offset, 3 * (inside ? in : out)};
}

BlockMatrix::Values BlockMatrix::open() {
  Values v;
  VOILE_PETSC(MatSeqAIJGetArray(diagonal_, &v.diagonal));
  if (off_diagonal_) VOILE_PETSC(MatSeqAIJGetArray(off_diagonal_, &v.off_diagonal));
  open_values_ = v;
  return v;
}

void BlockMatrix::copy_values_from(const BlockMatrix& other) const {
  if (!extended_) {
    copy_part(other.diagonal_, open_values_.diagonal);
    copy_part(other.off_diagonal_, open_values_.off_diagonal);
    return;
  }
  std::fill_n(open_values_.diagonal, diagonal_rows_[3 * row_count_], 0.0);
  if (off_diagonal_) std::fill_n(open_values_.off_diagonal, off_diagonal_rows_[3 * row_count_], 0.0);
  add_values_from(other, 1.0);
}

void BlockMatrix::add_values_from(const BlockMatrix& other, double factor) const {
  add_part(other.diagonal_, factor, diagonal_place_, open_values_.diagonal);
  add_part(other.off_diagonal_, factor, off_diagonal_place_, open_values_.off_diagonal);
}

void BlockMatrix::extend(const BlockMatrix& base, BlockPattern pattern) {
  pattern_ = std::make_shared<const BlockPattern>(std::move(pattern));
  preallocate();
  extended_ = true;
  diagonal_place_.clear();
  off_diagonal_place_.clear();
  base.for_each_entry([&](bool inside, Index at, Index row, Index column) {
    const Slot s = slot(row / 3 - first_row_, column / 3);
    const Index offset = s.offset >= 0 ? s.offset : ~s.offset;
    auto& place = inside ? diagonal_place_ : off_diagonal_place_;
    if (static_cast<std::size_t>(at) >= place.size()) place.resize(static_cast<std::size_t>(at) + 1);
    place[static_cast<std::size_t>(at)] = offset + row % 3 * s.stride + column % 3;
  });
}

bool BlockMatrix::has(Index local_row, Index column) const {
  const auto& columns = (*pattern_)[local_row];
  return std::binary_search(columns.begin(), columns.end(), column);
}

void BlockMatrix::close() {
  VOILE_PETSC(MatSeqAIJRestoreArray(diagonal_, &open_values_.diagonal));
  if (off_diagonal_) VOILE_PETSC(MatSeqAIJRestoreArray(off_diagonal_, &open_values_.off_diagonal));
  VOILE_PETSC(MatAssemblyBegin(mat_, MAT_FINAL_ASSEMBLY));
  VOILE_PETSC(MatAssemblyEnd(mat_, MAT_FINAL_ASSEMBLY));
}

}  // namespace voile::system
