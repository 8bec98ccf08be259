#include "rigid_aggregates.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/mpi.hpp"
#include "linear_solver.hpp"
#include "mesh/partition.hpp"

namespace voile::solve {

namespace {

constexpr int motions = 6;

/// The sequential part of k with the rank's own rows and columns.
struct OwnPart {
  const PetscInt *starts = nullptr, *columns = nullptr;
  PetscInt blocks = 0;
  explicit OwnPart(Mat k) {
    Mat part = nullptr;
    VOILE_PETSC(MatGetDiagonalBlock(k, &part));
    VOILE_PETSC(MatGetLocalSize(part, &blocks, nullptr));
    blocks /= 3;
    VOILE_PETSC(MatSeqAIJGetCSRAndMemType(part, &starts, &columns, nullptr, nullptr));
  }
};

void assemble(Mat m) {
  VOILE_PETSC(MatAssemblyBegin(m, MAT_FINAL_ASSEMBLY));
  VOILE_PETSC(MatAssemblyEnd(m, MAT_FINAL_ASSEMBLY));
}

petsc::MatHandle matrix(MPI_Comm comm, PetscInt rows, PetscInt columns, const std::vector<PetscInt>& counts) {
  petsc::MatHandle m;
  VOILE_PETSC(MatCreate(comm, m.out()));
  VOILE_PETSC(MatSetSizes(m, rows, columns, PETSC_DETERMINE, PETSC_DETERMINE));
  VOILE_PETSC(MatSetType(m, MATAIJ));
  std::vector<PetscInt> inside;  // no more than there are columns
  for (const PetscInt n : counts) inside.push_back(std::min(n, columns));
  VOILE_PETSC(MatSeqAIJSetPreallocation(m, 0, counts.data()));
  VOILE_PETSC(MatMPIAIJSetPreallocation(m, 0, inside.data(), 0, counts.data()));
  return m;
}

/// The mean over a vertex and those that it couples to.
petsc::MatHandle averaging(Mat k) {
  PetscInt begin = 0, end = 0;
  VOILE_PETSC(MatGetOwnershipRange(k, &begin, &end));
  std::vector<PetscInt> counts, columns;
  for (PetscInt row = begin; row < end; row += 3) {
    PetscInt count = 0;
    VOILE_PETSC(MatGetRow(k, row, &count, nullptr, nullptr));
    counts.push_back(count / 3);
    VOILE_PETSC(MatRestoreRow(k, row, &count, nullptr, nullptr));
  }
  petsc::MatHandle s =
      matrix(PetscObjectComm(reinterpret_cast<PetscObject>(k)), (end - begin) / 3, (end - begin) / 3, counts);
  std::vector<double> values;
  for (PetscInt row = begin; row < end; row += 3) {
    PetscInt count = 0;
    const PetscInt* of_row = nullptr;
    VOILE_PETSC(MatGetRow(k, row, &count, &of_row, nullptr));
    columns.clear();
    for (PetscInt at = 0; at < count; at += 3) columns.push_back(of_row[at] / 3);
    VOILE_PETSC(MatRestoreRow(k, row, &count, &of_row, nullptr));
    values.assign(columns.size(), 1.0 / static_cast<double>(columns.size()));
    const PetscInt vertex = row / 3;
    VOILE_PETSC(MatSetValues(s, 1, &vertex, static_cast<PetscInt>(columns.size()), columns.data(), values.data(),
                             INSERT_VALUES));
  }
  assemble(s);
  return s;
}

/// Whether a row has nothing but its diagonal, as that of a displacement that is fixed.
bool is_fixed(Mat k, PetscInt row) {
  PetscInt count = 0;
  const PetscInt* columns = nullptr;
  const double* values = nullptr;
  VOILE_PETSC(MatGetRow(k, row, &count, &columns, &values));
  bool fixed = true;
  for (PetscInt at = 0; at < count; ++at) fixed = fixed && (columns[at] == row || values[at] == 0.0);
  VOILE_PETSC(MatRestoreRow(k, row, &count, &columns, &values));
  return fixed;
}

}  // namespace

std::vector<int> divide_own_rows(Mat k, int vertices) {
  const OwnPart own(k);
  const int parts = own.blocks > 0 ? std::max(1, static_cast<int>(std::lround(1.0 * own.blocks / vertices))) : 0;
  if (parts <= 1) return std::vector<int>(static_cast<std::size_t>(own.blocks), 0);
  std::vector<int> start{0}, adjacent;
  for (PetscInt i = 0; i < own.blocks; ++i) {
    for (PetscInt at = own.starts[3 * i]; at < own.starts[3 * i + 1]; at += 3)
      if (own.columns[at] != 3 * i) adjacent.push_back(own.columns[at] / 3);
    start.push_back(static_cast<int>(adjacent.size()));
  }
  std::vector<int> part = mesh::divide_graph(std::move(start), std::move(adjacent), parts);
  std::vector<int> number(static_cast<std::size_t>(parts), 0);  // without those that stay empty
  for (const int p : part) number[p] = 1;
  int used = 0;
  for (int& n : number) n = n > 0 ? used++ : -1;
  for (int& p : part) p = number[p];
  return part;
}

void RigidAggregates::read_pattern(Mat k, int vertices, int smoothing) {
  MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(k));
  aggregate_ = divide_own_rows(k, vertices);
  own_ = aggregate_.empty() ? 0 : *std::max_element(aggregate_.begin(), aggregate_.end()) + 1;
  const auto counts = mpi::gather_to_all(comm, {static_cast<double>(own_)});
  first_ = aggregates_ = 0;
  for (int r = 0; r < static_cast<int>(counts.size()); ++r) {
    if (r < mpi::rank(comm)) first_ += static_cast<int>(counts[r][0]);
    aggregates_ += static_cast<int>(counts[r][0]);
  }
  for (int& a : aggregate_) a += first_;
  const auto rows = static_cast<PetscInt>(aggregate_.size());
  fractions_ = matrix(comm, rows, own_, std::vector<PetscInt>(aggregate_.size(), 1));
  PetscInt row = 0;
  VOILE_PETSC(MatGetOwnershipRange(fractions_, &row, nullptr));
  for (const int a : aggregate_) {
    VOILE_PETSC(MatSetValue(fractions_, row, a, 1.0, INSERT_VALUES));
    ++row;
  }
  assemble(fractions_);
  const petsc::MatHandle mean = averaging(k);
  for (int n = 0; n < smoothing; ++n) {
    petsc::MatHandle smooth;
    VOILE_PETSC(MatMatMult(mean, fractions_, MAT_INITIAL_MATRIX, PETSC_DEFAULT, smooth.out()));
    VOILE_PETSC(MatProductClear(smooth));
    fractions_ = std::move(smooth);
  }
}

void RigidAggregates::find_centres(const std::vector<double>& places) {
  MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(static_cast<Mat>(fractions_)));
  std::vector<double> sums(4 * static_cast<std::size_t>(aggregates_), 0.0);
  for (std::size_t v = 0; v < aggregate_.size(); ++v) {
    double* sum = sums.data() + 4 * aggregate_[v];
    for (std::size_t i = 0; i < 3; ++i) sum[i] += places[3 * v + i];
    sum[3] += 1.0;
  }
  mpi::sum(comm, sums);
  centres_.clear();
  for (std::size_t a = 0; a < sums.size(); a += 4)
    for (std::size_t i = 0; i < 3; ++i) centres_.push_back(sums[a + i] / sums[a + 3]);
  double square = 0.0;
  for (std::size_t v = 0; v < aggregate_.size(); ++v)
    for (std::size_t i = 0; i < 3; ++i)
      square += std::pow(places[3 * v + i] - centres_[3 * static_cast<std::size_t>(aggregate_[v]) + i], 2);
  size_ = std::sqrt(mpi::sum(comm, square) / static_cast<double>(mpi::sum(comm, static_cast<long>(aggregate_.size()))));
  if (!(size_ > 0.0)) size_ = 1.0;
}

/// Row 3v + i, column 6a + m: fraction of a at v times component i of motion m about the centre of a.
void RigidAggregates::fill(Mat k, const std::vector<double>& places) {
  PetscInt begin = 0, end = 0;
  VOILE_PETSC(MatGetOwnershipRange(fractions_, &begin, &end));
  std::vector<PetscInt> counts;
  for (PetscInt v = begin; v < end; ++v) {
    PetscInt count = 0;
    VOILE_PETSC(MatGetRow(fractions_, v, &count, nullptr, nullptr));
    counts.insert(counts.end(), 3, 3 * count);
    VOILE_PETSC(MatRestoreRow(fractions_, v, &count, nullptr, nullptr));
  }
  z_ = matrix(PetscObjectComm(reinterpret_cast<PetscObject>(k)), 3 * (end - begin), motions * own_, counts);
  for (PetscInt v = begin; v < end; ++v) {
    PetscInt count = 0;
    const PetscInt* of = nullptr;
    const double* fraction = nullptr;
    VOILE_PETSC(MatGetRow(fractions_, v, &count, &of, &fraction));
    for (PetscInt i = 0; i < 3; ++i) {
      const PetscInt row = 3 * v + i, next = (i + 1) % 3, after = (i + 2) % 3;
      if (is_fixed(k, row)) continue;
      for (PetscInt at = 0; at < count; ++at) {
        const auto arm = [&](PetscInt c) { return (places[3 * (v - begin) + c] - centres_[3 * of[at] + c]) / size_; };
        // e_next x d has component i equal to d_after, e_after x d has -d_next.
        const std::array<PetscInt, 3> columns{motions * of[at] + i, motions * of[at] + 3 + next,
                                              motions * of[at] + 3 + after};
        const std::array<double, 3> values{fraction[at], fraction[at] * arm(after), -fraction[at] * arm(next)};
        VOILE_PETSC(MatSetValues(z_, 1, &row, 3, columns.data(), values.data(), INSERT_VALUES));
      }
    }
    VOILE_PETSC(MatRestoreRow(fractions_, v, &count, &of, &fraction));
  }
  assemble(z_);
}

void RigidAggregates::take(Mat k, const std::vector<double>& places) {
  find_centres(places);
  fill(k, places);
  petsc::MatHandle e;
  {
    petsc::MatHandle kz;  // not by MatPtAP, which keeps it
    VOILE_PETSC(MatMatMult(k, z_, MAT_INITIAL_MATRIX, PETSC_DEFAULT, kz.out()));
    VOILE_PETSC(MatTransposeMatMult(z_, kz, MAT_INITIAL_MATRIX, PETSC_DEFAULT, e.out()));
    VOILE_PETSC(MatProductClear(e));
  }
  VOILE_PETSC(MatCreateVecs(z_, c_.out(), nullptr));
  VOILE_PETSC(VecDuplicate(c_, y_.out()));
  // Motions of vertices that are all fixed have no stiffness.
  double largest = 0.0;
  VOILE_PETSC(MatGetDiagonal(e, c_));
  VOILE_PETSC(VecMax(c_, nullptr, &largest));
  {
    PetscInt count = 0;
    VOILE_PETSC(VecGetLocalSize(c_, &count));
    const petsc::WriteArray diagonal(c_);
    for (PetscInt i = 0; i < count; ++i)
      if (!(diagonal[i] > 1e-14 * largest)) diagonal[i] = largest;
  }
  VOILE_PETSC(MatSetOption(e, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
  VOILE_PETSC(MatDiagonalSet(e, c_, INSERT_VALUES));
  VOILE_PETSC(MatSetOption(e, MAT_SYMMETRIC, PETSC_TRUE));
  PC pc = nullptr;
  Mat factor = nullptr;
  VOILE_PETSC(KSPCreate(PetscObjectComm(reinterpret_cast<PetscObject>(k)), coarse_.out()));
  VOILE_PETSC(KSPSetType(coarse_, KSPPREONLY));
  VOILE_PETSC(KSPSetOperators(coarse_, e, e));
  VOILE_PETSC(KSPGetPC(coarse_, &pc));
  VOILE_PETSC(PCSetType(pc, PCCHOLESKY));
  VOILE_PETSC(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  VOILE_PETSC(PCFactorSetUpMatSolverType(pc));
  VOILE_PETSC(PCFactorGetMatrix(pc, &factor));
  VOILE_PETSC(MatMumpsSetIcntl(factor, mumps_workspace_percent, 100));
  VOILE_PETSC(KSPSetUp(coarse_));
}

bool RigidAggregates::factored() const {
  PC pc = nullptr;
  PCFailedReason reason = PC_NOERROR;
  VOILE_PETSC(KSPGetPC(coarse_, &pc));
  VOILE_PETSC(PCGetFailedReason(pc, &reason));
  return reason == PC_NOERROR;
}

void RigidAggregates::solve(Vec b, Vec x) {
  VOILE_PETSC(MatMultTranspose(z_, b, y_));
  VOILE_PETSC(KSPSolve(coarse_, y_, c_));
  VOILE_PETSC(MatMult(z_, c_, x));
}

}  // namespace voile::solve
