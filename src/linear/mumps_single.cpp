#include "mumps_single.hpp"

#include <metis.h>
#include <smumps_c.h>

#include <algorithm>
#include <vector>
#ifdef __SSE__
#include <xmmintrin.h>
#endif

#include "base/mpi.hpp"
#include "base/petsc.hpp"
#include "linear_solver.hpp"
#include "voile/errors.hpp"

namespace voile::linear {

namespace {

enum Job { begin = -1, end = -2, analyse = 1, factorise = 2, back_substitute = 3 };
/// ICNTL(14): what a rank needs depends on the others' pace, and is known beforehand without them.
constexpr int sequential_workspace = 10, first_workspace = 100, most_workspace = 6400;
constexpr int lacks_integers = -8, lacks_reals = -9;
constexpr int no_scaling = 0, iterated_scaling = 7;  ///< ICNTL(8)
/// From so many rows on blocks of low rank save more than they cost, and how exact they are.
constexpr PetscInt low_rank_rows = 60000;
constexpr float low_rank = 1e-7F;

/// Numbers too small for normal single precision count as zero while it lives. A flat sheet's factor is full of them, since
/// nothing couples its directions but round-off, and processors that compute them in microcode take ten times as long.
class FlushToZero {
#ifdef __SSE__
 public:
  FlushToZero() : before_(_mm_getcsr()) {
    _mm_setcsr(before_ | flush_results | denormals_are_zero);
  }
  ~FlushToZero() {
    _mm_setcsr(before_);
  }
  FlushToZero(const FlushToZero&) = delete;
  FlushToZero& operator=(const FlushToZero&) = delete;

 private:
  static constexpr unsigned flush_results = 0x8000, denormals_are_zero = 0x0040;  ///< bits of MXCSR
  unsigned before_;
#endif
};

/// The two parts of this rank's rows; the second has its own numbers of columns.
struct Parts {
  Mat diagonal = nullptr, off_diagonal = nullptr;
  const PetscInt* column_of = nullptr;
  PetscInt first_row = 0, first_column = 0;
  explicit Parts(Mat k) {
    PetscBool sequential = PETSC_FALSE;
    VOILE_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(k), MATSEQAIJ, &sequential));
    if (sequential)
      diagonal = k;
    else
      VOILE_PETSC(MatMPIAIJGetSeqAIJ(k, &diagonal, &off_diagonal, &column_of));
    VOILE_PETSC(MatGetOwnershipRange(k, &first_row, nullptr));
    VOILE_PETSC(MatGetOwnershipRangeColumn(k, &first_column, nullptr));
  }
  /// Calls f(row, column, value) for every entry of this rank in the lower triangle; global numbers.
  template <class F>
  void for_lower(F&& f) const {
    for (Mat part : {diagonal, off_diagonal}) {
      if (!part) continue;
      PetscInt local_rows = 0;
      const PetscInt *starts = nullptr, *local_columns = nullptr;
      const double* values = nullptr;
      VOILE_PETSC(MatGetLocalSize(part, &local_rows, nullptr));
      VOILE_PETSC(MatSeqAIJGetCSRAndMemType(part, &starts, &local_columns, nullptr, nullptr));
      VOILE_PETSC(MatSeqAIJGetArrayRead(part, &values));
      for (PetscInt r = 0; r < local_rows; ++r)
        for (PetscInt at = starts[r]; at < starts[r + 1]; ++at) {
          const PetscInt c = local_columns[at], column = part == diagonal ? first_column + c : column_of[c];
          if (column <= first_row + r) f(first_row + r, column, values[at]);
        }
      VOILE_PETSC(MatSeqAIJRestoreArrayRead(part, &values));
    }
  }
};

/// Position of each row in the order of elimination, rows of a block together; empty if METIS fails.
std::vector<MUMPS_INT> nested_dissection(Index blocks, int block_size, const std::vector<Index>& edges) {
  std::vector<idx_t> start(static_cast<std::size_t>(blocks) + 1, 0), neighbours(edges.size()), order(start.size()),
      position(start.size());
  for (Index b : edges) ++start[static_cast<std::size_t>(b) + 1];
  for (std::size_t b = 0; b + 1 < start.size(); ++b) start[b + 1] += start[b];
  std::vector<idx_t> next(start);
  for (std::size_t e = 0; e + 1 < edges.size(); e += 2) {
    neighbours[static_cast<std::size_t>(next[edges[e]]++)] = edges[e + 1];
    neighbours[static_cast<std::size_t>(next[edges[e + 1]]++)] = edges[e];
  }
  idx_t count = blocks;
  if (METIS_NodeND(&count, start.data(), neighbours.data(), nullptr, nullptr, order.data(), position.data()) !=
      METIS_OK)
    return {};
  std::vector<MUMPS_INT> rows;
  for (Index b = 0; b < blocks; ++b)
    for (int k = 0; k < block_size; ++k)
      rows.push_back(static_cast<MUMPS_INT>(position[static_cast<std::size_t>(b)] * block_size + k + 1));
  return rows;
}

}  // namespace

struct SingleFactor::Impl {
  MPI_Comm comm;
  SMUMPS_STRUC_C mumps{};
  std::vector<MUMPS_INT> rows, columns;  ///< of this rank's entries, from 1
  std::vector<float> values, right_side;
  petsc::ScatterHandle to_root;
  petsc::VecHandle on_root;

  explicit Impl(MPI_Comm c) : comm(c) {
    mumps.sym = 1;  // positive definite where it counts: no pivoting
    mumps.par = 1;
    mumps.comm_fortran = mpi::fortran_handle(comm);
    run(begin);
    for (int k : {1, 2, 3}) control(k) = -1;  // no output
    control(4) = 0;
    control(13) = 1;  // no ScaLAPACK, which would stop at a negative pivot and not count it
    control(14) = mpi::size(comm) == 1 ? sequential_workspace : first_workspace;
    control(18) = 3;  // every rank has its entries
    control(28) = 1;
  }
  ~Impl() { run(end); }

  void run(Job job) {
    [[maybe_unused]] const FlushToZero scope;
    mumps.job = job;
    smumps_c(&mumps);
  }
  MUMPS_INT& control(int number) { return mumps.icntl[number - 1]; }
  [[nodiscard]] int answer(int number) const { return mumps.infog[number - 1]; }

  void read_pattern(Mat k);
  void order(PetscInt size, int block_size);
  void read_values(Mat k, double shift);
};

/// Analysis in nested-dissection order, on rank 0, which knows the graph of the blocks.
void SingleFactor::Impl::order(PetscInt size, int block_size) {
  std::vector<Index> edges;
  for (std::size_t e = 0; e < rows.size(); ++e) {
    const Index r = rows[e] - 1, c = columns[e] - 1;
    if (r % block_size == 0 && c % block_size == 0 && r != c)
      edges.insert(edges.end(), {r / block_size, c / block_size});
  }
  edges = mpi::gather_to_root(comm, edges);
  std::vector<MUMPS_INT> position;
  if (mpi::rank(comm) == 0) position = nested_dissection(static_cast<Index>(size) / block_size, block_size, edges);
  control(7) = mpi::max(comm, position.empty() ? 0.0 : 1.0) > 0.0 ? 1 : 7;
  mumps.perm_in = position.empty() ? nullptr : position.data();
  run(analyse);
  mumps.perm_in = nullptr;
}

void SingleFactor::Impl::read_pattern(Mat k) {
  const Parts parts(k);
  PetscInt size = 0, block_size = 1;
  std::size_t count = 0;
  VOILE_PETSC(MatGetSize(k, &size, nullptr));
  VOILE_PETSC(MatGetBlockSize(k, &block_size));
  parts.for_lower([&](PetscInt, PetscInt, double) { ++count; });
  for (auto* v : {&rows, &columns}) {
    v->clear();
    v->reserve(count);
  }
  parts.for_lower([&](PetscInt row, PetscInt column, double) {
    rows.push_back(static_cast<MUMPS_INT>(row + 1));
    columns.push_back(static_cast<MUMPS_INT>(column + 1));
  });
  values.resize(count);
  control(35) = size >= low_rank_rows ? 2 : 0;
  mumps.cntl[7 - 1] = low_rank;
  mumps.n = static_cast<MUMPS_INT>(size);
  mumps.nnz_loc = static_cast<MUMPS_INT8>(rows.size());
  mumps.irn_loc = rows.data();
  mumps.jcn_loc = columns.data();
  mumps.a_loc = values.data();
  order(size, static_cast<int>(block_size));
}

void SingleFactor::Impl::read_values(Mat k, double shift) {
  auto value = values.begin();
  Parts(k).for_lower([&](PetscInt row, PetscInt column, double entry) {
    *value++ = static_cast<float>(row == column ? (1.0 + shift) * entry : entry);
  });
  // What is dropped, and what a shift has to outweigh, is small against each row alone if these are scaled.
  control(8) = shift > 0.0 || control(35) > 0 ? iterated_scaling : no_scaling;
}

SingleFactor::SingleFactor(MPI_Comm comm) : impl_(std::make_unique<Impl>(comm)) {}
SingleFactor::~SingleFactor() = default;

bool SingleFactor::factor(Mat k, bool new_pattern, double shift) {
  Impl& f = *impl_;
  if (new_pattern) f.read_pattern(k);
  check_mumps_room(f.answer(1), f.answer(2));
  if (f.answer(1) < 0 && new_pattern) return false;
  f.read_values(k, shift);
  for (;;) {
    f.run(factorise);
    const int code = f.answer(1);
    check_mumps_room(code, f.answer(2));
    if (code != lacks_integers && code != lacks_reals) return code >= 0;
    if (f.control(14) >= most_workspace) return false;
    f.control(14) *= 2;
  }
}

void SingleFactor::solve(Vec b, Vec x) {
  Impl& f = *impl_;
  if (!f.on_root) VOILE_PETSC(VecScatterCreateToZero(b, f.to_root.out(), f.on_root.out()));
  VOILE_PETSC(VecScatterBegin(f.to_root, b, f.on_root, INSERT_VALUES, SCATTER_FORWARD));
  VOILE_PETSC(VecScatterEnd(f.to_root, b, f.on_root, INSERT_VALUES, SCATTER_FORWARD));
  PetscInt count = 0;
  VOILE_PETSC(VecGetLocalSize(f.on_root, &count));
  {
    const petsc::WriteArray full(f.on_root);
    f.right_side.assign(full.data(), full.data() + count);
    f.mumps.rhs = f.right_side.data();
    f.run(back_substitute);
    std::copy(f.right_side.begin(), f.right_side.end(), full.data());
  }
  VOILE_PETSC(VecScatterBegin(f.to_root, f.on_root, x, INSERT_VALUES, SCATTER_REVERSE));
  VOILE_PETSC(VecScatterEnd(f.to_root, f.on_root, x, INSERT_VALUES, SCATTER_REVERSE));
}

void SingleFactor::forget_matrix() {
  impl_->rows = impl_->columns = std::vector<MUMPS_INT>();  // not {}, which keeps the room
  impl_->values = std::vector<float>();
}

void SingleFactor::keep_on_disk(bool on_disk) {
  impl_->control(22) = on_disk ? 1 : 0;
}

bool SingleFactor::compressed() const {
  return impl_->mumps.icntl[35 - 1] > 0;
}
long SingleFactor::negative_pivots() const {
  return impl_->answer(12);
}
int SingleFactor::error() const {
  return impl_->answer(1);
}

}  // namespace voile::linear
