#include "symmetric_blocks.hpp"

#include "voile/base/mpi.hpp"
#include "voile/base/types.hpp"

namespace voile::solve {

namespace {

PetscErrorCode multiply_shell(Mat shell, Vec x, Vec y) {
  void* context = nullptr;
  PetscFunctionBeginUser;
  PetscCall(MatShellGetContext(shell, &context));
  PetscCall(petsc::guarded([&] { static_cast<const SymmetricBlocks*>(context)->multiply(x, y); }));
  PetscFunctionReturn(0);
}

}  // namespace

bool SymmetricBlocks::read_pattern(Mat k) {
  PetscInt rows = 0;
  const PetscInt *starts = nullptr, *columns = nullptr;
  VOILE_PETSC(MatGetLocalSize(inside_, &rows, nullptr));
  VOILE_PETSC(MatSeqAIJGetCSRAndMemType(inside_, &starts, &columns, nullptr, nullptr));
  bool good = rows % 3 == 0;
  starts_.assign(1, 0);
  columns_.clear();
  places_.clear();
  strides_.clear();
  for (PetscInt i = 0; i < rows / 3 && good; ++i) {
    const PetscInt begin = starts[3 * i], stride = starts[3 * i + 1] - begin;
    bool has_diagonal = false;
    good = is_block_row(starts, columns, i);
    for (PetscInt at = begin; good && at < begin + stride && columns[at] <= 3 * i; at += 3) {
      has_diagonal = columns[at] == 3 * i;
      columns_.push_back(columns[at] / 3);
      places_.push_back(at);
    }
    good = good && has_diagonal;
    strides_.push_back(stride);
    starts_.push_back(static_cast<int>(columns_.size()));
  }
  MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(k));
  if (mpi::max(comm, good ? 0.0 : 1.0) > 0.0) return false;
  values_.resize(9 * columns_.size());
  PetscInt all_rows = 0;
  VOILE_PETSC(MatGetSize(k, &all_rows, nullptr));
  VOILE_PETSC(MatCreateShell(comm, rows, rows, all_rows, all_rows, this, shell_.out()));
  VOILE_PETSC(MatShellSetOperation(shell_, MATOP_MULT, reinterpret_cast<void (*)()>(multiply_shell)));
  return true;
}

bool SymmetricBlocks::take(Mat k, bool new_pattern) {
  const PetscInt* ghosts = nullptr;
  PetscBool sequential = PETSC_FALSE;
  VOILE_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(k), MATSEQAIJ, &sequential));
  inside_ = k;
  if (!sequential) VOILE_PETSC(MatMPIAIJGetSeqAIJ(k, &inside_, &outside_, &ghosts));
  if (new_pattern) {
    shell_.reset();
    if (!read_pattern(k)) return false;
    if (outside_) ghosts_.read(k, outside_, ghosts);
  }
  const double* from = nullptr;
  VOILE_PETSC(MatSeqAIJGetArrayRead(inside_, &from));
  double* to = values_.data();
  for (std::size_t i = 0; i < strides_.size(); ++i)
    for (int at = starts_[i]; at < starts_[i + 1]; ++at)
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) *to++ = from[places_[at] + r * strides_[i] + c];
  VOILE_PETSC(MatSeqAIJRestoreArrayRead(inside_, &from));
  return true;
}

void SymmetricBlocks::multiply_inside(const double* x, double* y) const {
  const double* a = values_.data();
  for (int i = 0; i + 1 < static_cast<int>(starts_.size()); ++i) {
    const double x0 = x[3 * i], x1 = x[3 * i + 1], x2 = x[3 * i + 2];
    double y0 = 0.0, y1 = 0.0, y2 = 0.0;
    const int last = starts_[i + 1] - 1;
    for (int at = starts_[i]; at < last; ++at, a += 9) {
      const double* u = x + 3 * columns_[at];
      double* v = y + 3 * columns_[at];
      y0 += a[0] * u[0] + a[1] * u[1] + a[2] * u[2];
      y1 += a[3] * u[0] + a[4] * u[1] + a[5] * u[2];
      y2 += a[6] * u[0] + a[7] * u[1] + a[8] * u[2];
      v[0] += a[0] * x0 + a[3] * x1 + a[6] * x2;
      v[1] += a[1] * x0 + a[4] * x1 + a[7] * x2;
      v[2] += a[2] * x0 + a[5] * x1 + a[8] * x2;
    }
    y[3 * i] = y0 + a[0] * x0 + a[1] * x1 + a[2] * x2;
    y[3 * i + 1] = y1 + a[3] * x0 + a[4] * x1 + a[5] * x2;
    y[3 * i + 2] = y2 + a[6] * x0 + a[7] * x1 + a[8] * x2;
    a += 9;
  }
}

void SymmetricBlocks::multiply(Vec x, Vec y) const {
  if (outside_) ghosts_.begin(x);
  {
    const petsc::ReadArray from(x);
    const petsc::WriteArray to(y);
    multiply_inside(from.data(), to.data());
  }
  if (!outside_) return;
  ghosts_.end(x);
  VOILE_PETSC(MatMultAdd(outside_, ghosts_.values, y, y));
}

}  // namespace voile::solve
