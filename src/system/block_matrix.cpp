#include "block_matrix.hpp"

#include <petscmat.h>

#include <algorithm>

#include "voile/errors.hpp"

namespace voile::system {

namespace {

const PetscInt* row_starts(Mat part) {
  const PetscInt* start = nullptr;
  if (part) VOILE_PETSC(MatSeqAIJGetCSRAndMemType(part, &start, nullptr, nullptr, nullptr));
  return start;
}

/// Adds factor times the values of one part of a matrix to those of a twin.
void add_part(Mat from, double factor, double* to) {
  if (!from) return;
  const double* values = nullptr;
  PetscInt rows = 0;
  VOILE_PETSC(MatGetLocalSize(from, &rows, nullptr));
  VOILE_PETSC(MatSeqAIJGetArrayRead(from, &values));
  const PetscInt count = row_starts(from)[rows];
  for (PetscInt i = 0; i < count; ++i) to[i] += factor * values[i];
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
    : pattern_(std::make_shared<const BlockPattern>(std::move(pattern))), comm_(comm) {
  const int rank = mpi::rank(comm);
  first_row_ = partition.owned_begin(rank);
  row_count_ = partition.owned_count(rank);
  create();
}

void BlockMatrix::create() {
  VOILE_PETSC(MatCreate(comm_, mat_.out()));
  VOILE_PETSC(MatSetSizes(mat_, 3 * row_count_, 3 * row_count_, PETSC_DETERMINE, PETSC_DETERMINE));
  VOILE_PETSC(MatSetBlockSize(mat_, 3));
  VOILE_PETSC(MatSetType(mat_, MATAIJ));
  preallocate();
}

void BlockMatrix::preallocate() {
  std::vector<PetscInt> inside, outside;
  rows_.clear();
  Row row;
  for (const auto& columns : *pattern_) {
    const auto first = std::lower_bound(columns.begin(), columns.end(), first_row_);
    const auto last = std::lower_bound(first, columns.end(), first_row_ + row_count_);
    row.before = static_cast<Index>(first - columns.begin());
    row.in = static_cast<Index>(last - first);
    const Index out = static_cast<Index>(columns.size()) - row.in;
    rows_.push_back(row);
    row.diagonal += 9 * row.in;
    row.off_diagonal += 9 * out;
    inside.insert(inside.end(), 3, 3 * row.in);
    outside.insert(outside.end(), 3, 3 * out);
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
  other.pattern_ = pattern_;
  other.comm_ = comm_;
  other.first_row_ = first_row_;
  other.row_count_ = row_count_;
  if (!mat_) {
    other.create();
    return other;
  }
  other.rows_ = rows_;
  VOILE_PETSC(MatDuplicate(mat_, MAT_DO_NOT_COPY_VALUES, other.mat_.out()));
  other.find_parts();
  return other;
}

void BlockMatrix::release() {
  mat_.reset();
  diagonal_ = off_diagonal_ = nullptr;
  open_values_ = {};
}

void BlockMatrix::find_parts() {
  PetscBool sequential = PETSC_FALSE;
  VOILE_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(static_cast<Mat>(mat_)), MATSEQAIJ, &sequential));
  if (sequential)
    diagonal_ = mat_;
  else
    VOILE_PETSC(MatMPIAIJGetSeqAIJ(mat_, &diagonal_, &off_diagonal_, nullptr));
}

Slot BlockMatrix::slot(Index local_row, Index column) const {
  const auto& columns = (*pattern_)[local_row];
  const auto found = std::lower_bound(columns.begin(), columns.end(), column);
  if (found == columns.end() || *found != column) throw InternalError("matrix pattern lacks a block of an element");
  return slot_at(local_row, static_cast<Index>(found - columns.begin()));
}

BlockMatrix::Values BlockMatrix::open() {
  Values v;
  VOILE_PETSC(MatSeqAIJGetArray(diagonal_, &v.diagonal));
  if (off_diagonal_) VOILE_PETSC(MatSeqAIJGetArray(off_diagonal_, &v.off_diagonal));
  open_values_ = v;
  return v;
}

void BlockMatrix::clear() const {
  if (rows_.empty()) return;
  const Row& last = rows_.back();
  const Index out = static_cast<Index>(pattern_->back().size()) - last.in;
  std::fill_n(open_values_.diagonal, last.diagonal + 9 * last.in, 0.0);
  if (off_diagonal_) std::fill_n(open_values_.off_diagonal, last.off_diagonal + 9 * out, 0.0);
}

void BlockMatrix::copy_values_from(const BlockMatrix& other) const {
  if (!extended_) {
    copy_part(other.diagonal_, open_values_.diagonal);
    copy_part(other.off_diagonal_, open_values_.off_diagonal);
    return;
  }
  clear();
  add_values_from(other, 1.0);
}

void BlockMatrix::add_values_from(const BlockMatrix& other, double factor) const {
  if (!extended_) {
    add_part(other.diagonal_, factor, open_values_.diagonal);
    add_part(other.off_diagonal_, factor, open_values_.off_diagonal);
    return;
  }
  const auto [inside, outside] = other.read();
  for (const auto& [from, to] : places_) {
    const double* source = from.offset >= 0 ? inside + from.offset : outside + ~from.offset;
    double* target = to.offset >= 0 ? open_values_.diagonal + to.offset : open_values_.off_diagonal + ~to.offset;
    for (int r = 0; r < 3; ++r, source += from.stride, target += to.stride)
      for (int c = 0; c < 3; ++c) target[c] += factor * source[c];
  }
}

/// The arrays stay where they are when they are given back.
std::pair<const double*, const double*> BlockMatrix::read() const {
  std::pair<const double*, const double*> values{nullptr, nullptr};
  for (auto [part, array] : {std::pair{diagonal_, &values.first}, std::pair{off_diagonal_, &values.second}}) {
    if (!part) continue;
    const double* taken = nullptr;
    VOILE_PETSC(MatSeqAIJGetArrayRead(part, &taken));
    *array = taken;
    VOILE_PETSC(MatSeqAIJRestoreArrayRead(part, &taken));
  }
  return values;
}

void BlockMatrix::extend(const BlockMatrix& base, BlockPattern pattern) {
  pattern_ = std::make_shared<const BlockPattern>(std::move(pattern));
  preallocate();
  extended_ = true;
  places_.clear();
  for (Index r = 0; r < row_count_; ++r)
    for (Index column : (*base.pattern_)[r]) places_.push_back({base.slot(r, column), slot(r, column)});
}

bool BlockMatrix::has(Index local_row, Index column) const {
  const auto& columns = (*pattern_)[local_row];
  return std::binary_search(columns.begin(), columns.end(), column);
}

void BlockMatrix::close() {
  ++version_;
  VOILE_PETSC(MatSeqAIJRestoreArray(diagonal_, &open_values_.diagonal));
  if (off_diagonal_) VOILE_PETSC(MatSeqAIJRestoreArray(off_diagonal_, &open_values_.off_diagonal));
  VOILE_PETSC(MatAssemblyBegin(mat_, MAT_FINAL_ASSEMBLY));
  VOILE_PETSC(MatAssemblyEnd(mat_, MAT_FINAL_ASSEMBLY));
}

}  // namespace voile::system
