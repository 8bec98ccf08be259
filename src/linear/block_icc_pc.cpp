#include "block_icc_pc.hpp"

#include <petsc/private/pcimpl.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "base/mpi.hpp"
#include "base/petsc.hpp"
#include "coarse_space.hpp"
#include "incomplete_cholesky.hpp"
#include "overlapping_part.hpp"

namespace voile::linear {

namespace {

/// The coarse matrix is dense and on every rank.
constexpr int most_aggregates = 2000;

/// The type's own data (pc->data).
struct BlockIcc {
  IncompleteCholesky factor;
  OverlappingPart overlapping;
  CoarseSpace coarse;
  bool overlap = true;                           ///< option
  bool overlaps = false;                         ///< on this number of ranks
  int aggregates = 0;                            ///< option; 0: no coarse level
  bool coarse_fits = false, use_coarse = false;  ///< the pattern, and the matrix at hand
  double shift = 0.0, first_shift = 1e-2;        ///< options
  std::string ordering = MATORDERINGRCM;         ///< option
  bool more_shifts = true;
  double largest_shift = 0.0;  ///< over the ranks, of the last matrix
  long matrices = 0, patterns = 0, shifted = 0;
};

BlockIcc& data(PC pc) {
  return *static_cast<BlockIcc*>(pc->data);
}

/// Block rows in the order of elimination. In which order matters: that of a mesh generator, which goes to and fro, has cost 2.5 times the
/// iterations.
PetscErrorCode order_blocks(const BlockPattern& pattern, const std::string& type, std::vector<int>& order) {
  petsc::MatHandle graph;
  petsc::IndexSetHandle rows, columns;
  std::vector<double> ones(pattern.columns.size(), 1.0);
  const PetscInt* row = nullptr;
  PetscFunctionBeginUser;
  PetscCall(MatCreateSeqAIJWithArrays(PETSC_COMM_SELF, pattern.rows(), pattern.rows(),
                                      const_cast<int*>(pattern.starts.data()), const_cast<int*>(pattern.columns.data()),
                                      ones.data(), graph.out()));
  PetscCall(MatGetOrdering(graph, type.c_str(), rows.out(), columns.out()));
  PetscCall(ISGetIndices(rows, &row));
  order.assign(row, row + pattern.rows());
  PetscCall(ISRestoreIndices(rows, &row));
  PetscFunctionReturn(0);
}

/// The blocks of a sequential matrix.
PetscErrorCode read_blocks(Mat part, BlockPattern& pattern) {
  PetscInt rows = 0;
  const PetscInt *starts = nullptr, *columns = nullptr;
  PetscFunctionBeginUser;
  PetscCall(MatGetLocalSize(part, &rows, nullptr));
  PetscCall(MatSeqAIJGetCSRAndMemType(part, &starts, &columns, nullptr, nullptr));
  pattern.full = rows % 3 == 0;
  pattern.reserve(rows / 3, starts[rows] / 9);
  for (int i = 0; i < rows / 3 && pattern.full; ++i, pattern.end_row()) pattern.add(0, starts, columns, i);
  PetscFunctionReturn(0);
}

PetscErrorCode read_pattern(PC pc, Mat part) {
  BlockIcc& d = data(pc);
  MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(pc));
  BlockPattern pattern;
  std::vector<int> order;
  PetscBool sequential = PETSC_FALSE;
  bool good = false;
  PetscFunctionBeginUser;
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc->pmat), MATSEQAIJ, &sequential));
  d.overlaps = d.overlap && !sequential;
  if (d.overlaps)
    PetscCall(petsc::guarded([&] { pattern = d.overlapping.read_pattern(pc->pmat); }));
  else
    PetscCall(read_blocks(part, pattern));
  if (pattern.full) PetscCall(order_blocks(pattern, d.ordering, order));
  PetscCall(petsc::guarded([&] {
    const bool own = d.factor.read_pattern(pattern, std::move(order));
    good = mpi::max(comm, own ? 0.0 : 1.0) == 0.0;
  }));
  if (!good) SETERRQ(comm, PETSC_ERR_SUP, "-pc_type %s is for matrices of full 3 x 3 blocks", block_icc_pc_type);
  if (d.aggregates > 0)
    PetscCall(petsc::guarded([&] { d.coarse_fits = d.coarse.read_pattern(pc->pmat, d.aggregates); }));
  ++d.patterns;
  PetscFunctionReturn(0);
}

/// Of this rank's part; whether it has come out.
PetscErrorCode factor(BlockIcc& d, Mat a, Mat part, bool* good) {
  const double* values = nullptr;
  const auto use = [&](const BlockPattern::Values& v) {
    *good = d.factor.factor(v, d.shift, d.more_shifts ? d.first_shift : HUGE_VAL);
  };
  PetscFunctionBeginUser;
  if (d.overlaps) {
    PetscCall(petsc::guarded([&] { d.overlapping.take(a, use); }));
    PetscFunctionReturn(0);
  }
  PetscCall(MatSeqAIJGetArrayRead(part, &values));
  use({values, nullptr, nullptr});
  PetscCall(MatSeqAIJRestoreArrayRead(part, &values));
  PetscFunctionReturn(0);
}

PetscErrorCode set_up(PC pc) {
  BlockIcc& d = data(pc);
  Mat part = nullptr;
  PetscBool is_aij = PETSC_FALSE;
  bool good = false;
  PetscFunctionBeginUser;
  const petsc::EventScope scope(petsc::events().incomplete_factor);
  PetscCall(MatGetDiagonalBlock(pc->pmat, &part));
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(part), MATSEQAIJ, &is_aij));
  if (!is_aij)
    SETERRQ(PetscObjectComm(reinterpret_cast<PetscObject>(pc)), PETSC_ERR_SUP,
            "-pc_type %s is for matrices of type aij", block_icc_pc_type);
  if (!pc->setupcalled || pc->flag != SAME_NONZERO_PATTERN) PetscCall(read_pattern(pc, part));
  PetscCall(factor(d, pc->pmat, part, &good));
  d.use_coarse = false;
  if (d.coarse_fits) PetscCall(petsc::guarded([&] { d.use_coarse = d.coarse.take(pc->pmat); }));
  // Largest over the ranks: whether it failed, whether it took a shift, and which.
  std::vector<double> worst{good ? 0.0 : -1.0, d.factor.attempts() > 1 ? -1.0 : 0.0, -d.factor.shift()};
  PetscCall(petsc::guarded([&] { mpi::min(PetscObjectComm(reinterpret_cast<PetscObject>(pc)), worst); }));
  ++d.matrices;
  d.shifted += worst[1] < 0.0 ? 1 : 0;
  d.largest_shift = -worst[2];
  if (worst[1] < 0.0) PetscCall(PetscInfo(pc, "incomplete factor with %g of the diagonal added\n", d.largest_shift));
  pc->failedreason = worst[0] < 0.0 ? PC_FACTOR_NUMERIC_ZEROPIVOT : PC_NOERROR;
  PetscFunctionReturn(0);
}

/// x = P^-1 b without the coarse level; may be the same.
void solve_parts(BlockIcc& d, Vec b, Vec x) {
  if (d.overlaps) {
    double* v = d.overlapping.restricted(b);
    d.factor.solve(v, v);
    d.overlapping.add_up(x);
  } else if (b == x) {
    const petsc::WriteArray to(x);
    d.factor.solve(to.data(), to.data());
  } else {
    const petsc::ReadArray from(b);
    const petsc::WriteArray to(x);
    d.factor.solve(from.data(), to.data());
  }
}

PetscErrorCode apply(PC pc, Vec b, Vec x) {
  PetscFunctionBeginUser;
  PetscCall(petsc::guarded([&] {
    BlockIcc& d = data(pc);
    if (!d.use_coarse) return solve_parts(d, b, x);
    {
      const petsc::ReadArray from(b);
      const petsc::WriteArray to(x);
      d.coarse.project(from.data(), to.data());
    }
    solve_parts(d, x, x);
    const petsc::WriteArray to(x);
    d.coarse.correct(to.data());
  }));
  PetscFunctionReturn(0);
}

PetscErrorCode ask_options(PC pc, PetscOptionItems* PetscOptionsObject) {
  BlockIcc& d = data(pc);
  PetscFunctionBeginUser;
  PetscOptionsHeadBegin(PetscOptionsObject, "Incomplete Cholesky factor of 3 x 3 blocks");
  PetscCall(PetscOptionsReal("-pc_block_icc_shift", "Fraction of the diagonal blocks to add from the start", nullptr,
                             d.shift, &d.shift, nullptr));
  PetscCall(PetscOptionsReal("-pc_block_icc_first_shift", "The same after the first failure; then four times more each",
                             nullptr, d.first_shift, &d.first_shift, nullptr));
  PetscCall(PetscOptionsInt("-pc_block_icc_aggregates", "Aggregates of the coarse level, 0 for none", nullptr,
                            d.aggregates, &d.aggregates, nullptr));
  PetscBool overlap = d.overlap ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(PetscOptionsBool("-pc_block_icc_overlap", "Factor each rank's part with the next vertices of other ranks",
                             nullptr, overlap, &overlap, nullptr));
  d.overlap = overlap;
  char type[64] = {};
  PetscBool given = PETSC_FALSE;
  PetscCall(PetscOptionsFList("-pc_block_icc_ordering_type", "Order of elimination", "MatGetOrdering", MatOrderingList,
                              d.ordering.c_str(), type, sizeof type, &given));
  if (given) d.ordering = type;
  PetscOptionsHeadEnd();
  if (d.shift < 0.0 || !(d.first_shift > 0.0) || d.aggregates < 0 || d.aggregates > most_aggregates)
    SETERRQ(PetscObjectComm(reinterpret_cast<PetscObject>(pc)), PETSC_ERR_USER_INPUT,
            "-pc_block_icc_shift must be >= 0, -pc_block_icc_first_shift > 0 and -pc_block_icc_aggregates in 0 to %d",
            most_aggregates);
  PetscFunctionReturn(0);
}

PetscErrorCode reset(PC pc) {
  PetscFunctionBeginUser;
  BlockIcc& d = data(pc);
  d.factor = IncompleteCholesky{};
  d.overlapping = OverlappingPart{};
  d.coarse = CoarseSpace{};
  d.coarse_fits = d.use_coarse = false;
  PetscFunctionReturn(0);
}

PetscErrorCode destroy(PC pc) {
  PetscFunctionBeginUser;
  delete static_cast<BlockIcc*>(pc->data);
  pc->data = nullptr;
  PetscFunctionReturn(0);
}

PetscErrorCode view(PC pc, PetscViewer viewer) {
  const BlockIcc& d = data(pc);
  PetscFunctionBeginUser;
  PetscCall(PetscViewerASCIIPrintf(viewer, "  incomplete Cholesky of 3 x 3 blocks without fill, by ranks%s, order %s\n",
                                   d.overlaps ? " with an overlap of one vertex" : "", d.ordering.c_str()));
  PetscCall(PetscViewerASCIIPrintf(viewer, "  matrices %ld with %ld patterns, of them %ld with a shift, the last %g\n",
                                   d.matrices, d.patterns, d.shifted, d.largest_shift));
  if (d.coarse_fits)
    PetscCall(PetscViewerASCIIPrintf(viewer, "  coarse level: translations of %d aggregates\n", d.coarse.aggregates()));
  PetscFunctionReturn(0);
}

PetscErrorCode create(PC pc) {
  PetscFunctionBeginUser;
  pc->data = new BlockIcc;
  pc->ops->setup = set_up;
  pc->ops->apply = apply;
  pc->ops->applytranspose = apply;
  pc->ops->setfromoptions = ask_options;
  pc->ops->reset = reset;
  pc->ops->destroy = destroy;
  pc->ops->view = view;
  PetscFunctionReturn(0);
}

}  // namespace

void register_block_icc_pc() {
  static bool done = false;
  if (!done) VOILE_PETSC(PCRegister(block_icc_pc_type, create));
  done = true;
}

void set_block_icc_shift(PC pc, double shift) {
  data(pc).shift = shift;
}

void set_block_icc_aggregates(PC pc, int aggregates) {
  data(pc).aggregates = aggregates;
}

void allow_block_icc_shifts(PC pc, bool allowed) {
  data(pc).more_shifts = allowed;
}

double block_icc_shift(PC pc) {
  return data(pc).largest_shift;
}

long block_icc_shifted(PC pc) {
  return data(pc).shifted;
}

}  // namespace voile::linear
