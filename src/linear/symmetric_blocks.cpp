#include "symmetric_blocks.hpp"

#include "base/mpi.hpp"
#include "base/types.hpp"

namespace voile::linear {

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
  values_.resize(9 * columns_.size() + 1);  // one more, since lanes are read by fours
  x_.resize(4 * strides_.size());
  y_.resize(4 * strides_.size());
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
  const int rows = static_cast<int>(strides_.size());
  const double* a = values_.data();
  for (int i = 0; i < rows; ++i) Eigen::Map<Lanes>(x_.data() + 4 * i) << x[3 * i], x[3 * i + 1], x[3 * i + 2], 0.0;
  for (int i = 0; i < rows; ++i) {
    const Lanes own = lanes(x_.data() + 4 * i);
    Lanes sum[3] = {Lanes::Zero(), Lanes::Zero(), Lanes::Zero()};
    const int last = starts_[i + 1] - 1;
    for (int at = starts_[i]; at < last; ++at, a += 9) {
      const Lanes u = lanes(x_.data() + 4 * columns_[at]);
      Eigen::Map<Lanes> v(y_.data() + 4 * columns_[at]);
      const Lanes row[3] = {lanes(a), lanes(a + 3), lanes(a + 6)};
      for (int r = 0; r < 3; ++r) sum[r] += row[r].cwiseProduct(u);
      v += own[0] * row[0] + own[1] * row[1] + own[2] * row[2];
    }
    for (int r = 0; r < 3; ++r, a += 3) sum[r] += lanes(a).cwiseProduct(own);
    Eigen::Map<Lanes>(y_.data() + 4 * i) << total(sum[0]), total(sum[1]), total(sum[2]), 0.0;
  }
  for (int i = 0; i < rows; ++i)
    for (int k = 0; k < 3; ++k) y[3 * i + k] = y_[4 * static_cast<std::size_t>(i) + static_cast<std::size_t>(k)];
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

}  // namespace voile::linear
