#include "schwarz_pc.hpp"

#include <petsc/private/pcimpl.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "base/mpi.hpp"
#include "base/petsc.hpp"
#include "mumps_single.hpp"
#include "rigid_aggregates.hpp"

namespace voile::solve {

namespace {

struct Subdomain {
  std::vector<PetscInt> rows;  ///< of `local`
  petsc::IndexSetHandle global;
  std::unique_ptr<SingleFactor> factor;
  petsc::VecHandle b, x;
};

/// The type's own data (pc->data).
struct Schwarz {
  PetscInt vertices = 400, overlap = 1, aggregate = 50, smoothing = 3;  ///< options
  std::vector<double> places;
  std::vector<Subdomain> subdomains;
  RigidAggregates coarse;
  petsc::ScatterHandle to_local;  ///< rows of all subdomains of this rank
  petsc::VecHandle local_b, local_x, work, left;
  long matrices = 0, patterns = 0;
};

Schwarz& data(PC pc) {
  return *static_cast<Schwarz*>(pc->data);
}

PetscErrorCode set_places(PC pc, PetscInt dimension, PetscInt count, PetscReal* places) {
  PetscFunctionBeginUser;
  if (dimension == 3) data(pc).places.assign(places, places + 3 * static_cast<std::ptrdiff_t>(count));
  PetscFunctionReturn(0);
}

/// Rows of each subdomain in the whole matrix, with the overlap.
void divide(Schwarz& s, Mat k) {
  const std::vector<int> part = divide_own_rows(k, static_cast<int>(s.vertices));
  const int count = part.empty() ? 0 : *std::max_element(part.begin(), part.end()) + 1;
  PetscInt begin = 0;
  VOILE_PETSC(MatGetOwnershipRange(k, &begin, nullptr));
  std::vector<std::vector<PetscInt>> rows(static_cast<std::size_t>(count));
  for (std::size_t v = 0; v < part.size(); ++v)
    for (PetscInt i = 0; i < 3; ++i) rows[part[v]].push_back(begin + 3 * static_cast<PetscInt>(v) + i);
  std::vector<IS> sets(rows.size());
  for (std::size_t p = 0; p < rows.size(); ++p)
    VOILE_PETSC(ISCreateGeneral(PETSC_COMM_SELF, static_cast<PetscInt>(rows[p].size()), rows[p].data(),
                                PETSC_COPY_VALUES, &sets[p]));
  VOILE_PETSC(MatIncreaseOverlap(k, count, sets.data(), s.overlap));
  s.subdomains.clear();
  s.subdomains.resize(sets.size());
  for (std::size_t p = 0; p < sets.size(); ++p) {
    VOILE_PETSC(ISSort(sets[p]));
    *s.subdomains[p].global.out() = sets[p];
  }
}

/// Numbers the rows that this rank's subdomains have.
void find_local(Schwarz& s, Mat k) {
  std::vector<PetscInt> all;
  const auto for_rows = [](const Subdomain& d, auto&& f) {
    PetscInt count = 0;
    const PetscInt* rows = nullptr;
    VOILE_PETSC(ISGetLocalSize(d.global, &count));
    VOILE_PETSC(ISGetIndices(d.global, &rows));
    f(rows, rows + count);
    VOILE_PETSC(ISRestoreIndices(d.global, &rows));
  };
  for (const Subdomain& d : s.subdomains)
    for_rows(d, [&](const PetscInt* from, const PetscInt* to) { all.insert(all.end(), from, to); });
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  for (Subdomain& d : s.subdomains)
    for_rows(d, [&](const PetscInt* from, const PetscInt* to) {
      d.rows.clear();
      for (; from != to; ++from)
        d.rows.push_back(static_cast<PetscInt>(std::lower_bound(all.begin(), all.end(), *from) - all.begin()));
      VOILE_PETSC(VecCreateSeq(PETSC_COMM_SELF, static_cast<PetscInt>(d.rows.size()), d.b.out()));
      VOILE_PETSC(VecDuplicate(d.b, d.x.out()));
    });
  petsc::IndexSetHandle rows;
  const auto size = static_cast<PetscInt>(all.size());
  VOILE_PETSC(ISCreateGeneral(PETSC_COMM_SELF, size, all.data(), PETSC_COPY_VALUES, rows.out()));
  VOILE_PETSC(VecCreateSeq(PETSC_COMM_SELF, size, s.local_b.out()));
  VOILE_PETSC(VecDuplicate(s.local_b, s.local_x.out()));
  VOILE_PETSC(MatCreateVecs(k, s.work.out(), s.left.out()));
  VOILE_PETSC(VecScatterCreate(s.work, rows, s.local_b, nullptr, s.to_local.out()));
}

/// One subdomain after the other, so that no more than one matrix is there at a time; whether all have come out.
bool factor(Schwarz& s, Mat k) {
  const petsc::EventScope scope(petsc::events().factor_single);
  MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(k));
  const auto most = static_cast<std::size_t>(mpi::max(comm, static_cast<double>(s.subdomains.size())));
  bool good = true;
  for (std::size_t p = 0; p < most; ++p) {
    const bool mine = p < s.subdomains.size();
    IS rows = mine ? static_cast<IS>(s.subdomains[p].global) : nullptr;
    Mat* part = nullptr;
    VOILE_PETSC(MatCreateSubMatrices(k, mine ? 1 : 0, &rows, &rows, MAT_INITIAL_MATRIX, &part));
    if (mine) {
      Subdomain& d = s.subdomains[p];
      VOILE_PETSC(MatSetBlockSize(part[0], 3));
      d.factor = std::make_unique<SingleFactor>(PETSC_COMM_SELF);
      good = d.factor->factor(part[0], true) && good;
      d.factor->forget_matrix();
    }
    VOILE_PETSC(MatDestroySubMatrices(mine ? 1 : 0, &part));
  }
  return mpi::max(comm, good ? 0.0 : 1.0) == 0.0;
}

PetscErrorCode set_up(PC pc) {
  Schwarz& s = data(pc);
  PetscInt rows = 0, block = 1;
  bool good = false;
  PetscFunctionBeginUser;
  PetscCall(MatGetLocalSize(pc->pmat, &rows, nullptr));
  PetscCall(MatGetBlockSize(pc->pmat, &block));
  if (block != 3 || s.places.size() != static_cast<std::size_t>(rows))
    SETERRQ(PetscObjectComm(reinterpret_cast<PetscObject>(pc)), PETSC_ERR_SUP,
            "-pc_type %s is for matrices of 3 x 3 blocks of vertices whose places are known", schwarz_pc_type);
  PetscCall(petsc::guarded([&] {
    for (Subdomain& d : s.subdomains) d.factor.reset();
    if (!pc->setupcalled || pc->flag != SAME_NONZERO_PATTERN) {
      divide(s, pc->pmat);
      find_local(s, pc->pmat);
      s.coarse.read_pattern(pc->pmat, static_cast<int>(s.aggregate), static_cast<int>(s.smoothing));
      ++s.patterns;
    }
    s.coarse.take(pc->pmat, s.places);
    good = factor(s, pc->pmat) && s.coarse.factored();
  }));
  ++s.matrices;
  pc->failedreason = good ? PC_NOERROR : PC_FACTOR_NUMERIC_ZEROPIVOT;
  PetscFunctionReturn(0);
}

/// x = M b
void solve_parts(Schwarz& s, Vec b, Vec x) {
  VOILE_PETSC(VecScatterBegin(s.to_local, b, s.local_b, INSERT_VALUES, SCATTER_FORWARD));
  VOILE_PETSC(VecScatterEnd(s.to_local, b, s.local_b, INSERT_VALUES, SCATTER_FORWARD));
  VOILE_PETSC(VecZeroEntries(s.local_x));
  for (const Subdomain& d : s.subdomains) {
    {
      const petsc::ReadArray from(s.local_b);
      const petsc::WriteArray to(d.b);
      for (std::size_t i = 0; i < d.rows.size(); ++i) to[static_cast<PetscInt>(i)] = from[d.rows[i]];
    }
    d.factor->solve(d.b, d.x);
    const petsc::ReadArray from(d.x);
    const petsc::WriteArray to(s.local_x);
    for (std::size_t i = 0; i < d.rows.size(); ++i) to[d.rows[i]] += from[static_cast<PetscInt>(i)];
  }
  VOILE_PETSC(VecZeroEntries(x));
  VOILE_PETSC(VecScatterBegin(s.to_local, s.local_x, x, ADD_VALUES, SCATTER_REVERSE));
  VOILE_PETSC(VecScatterEnd(s.to_local, s.local_x, x, ADD_VALUES, SCATTER_REVERSE));
}

/// x = Q b + (I - Q A) M (I - A Q) b
PetscErrorCode apply(PC pc, Vec b, Vec x) {
  Schwarz& s = data(pc);
  PetscFunctionBeginUser;
  PetscCall(petsc::guarded([&] {
    s.coarse.solve(b, x);
    VOILE_PETSC(MatMult(pc->pmat, x, s.work));
    VOILE_PETSC(VecAYPX(s.work, -1.0, b));
    solve_parts(s, s.work, s.left);
    VOILE_PETSC(VecAXPY(x, 1.0, s.left));
    VOILE_PETSC(MatMult(pc->pmat, s.left, s.work));
    s.coarse.solve(s.work, s.left);
    VOILE_PETSC(VecAXPY(x, -1.0, s.left));
  }));
  PetscFunctionReturn(0);
}

PetscErrorCode ask_options(PC pc, PetscOptionItems* PetscOptionsObject) {
  Schwarz& s = data(pc);
  PetscFunctionBeginUser;
  PetscOptionsHeadBegin(PetscOptionsObject, "Overlapping subdomains and rigid motions of aggregates");
  PetscCall(PetscOptionsInt("-pc_schwarz_vertices", "Vertices of a subdomain, without the overlap", nullptr, s.vertices,
                            &s.vertices, nullptr));
  PetscCall(PetscOptionsInt("-pc_schwarz_overlap", "How often a subdomain takes in what it couples to", nullptr,
                            s.overlap, &s.overlap, nullptr));
  PetscCall(PetscOptionsInt("-pc_schwarz_aggregate", "Vertices of an aggregate of the coarse level", nullptr,
                            s.aggregate, &s.aggregate, nullptr));
  PetscCall(PetscOptionsInt("-pc_schwarz_smoothing", "How often the weights of aggregates are averaged", nullptr,
                            s.smoothing, &s.smoothing, nullptr));
  PetscOptionsHeadEnd();
  if (s.vertices < 1 || s.overlap < 0 || s.aggregate < 3 || s.smoothing < 0)
    SETERRQ(PetscObjectComm(reinterpret_cast<PetscObject>(pc)), PETSC_ERR_USER_INPUT,
            "-pc_schwarz_vertices must be >= 1, -pc_schwarz_aggregate >= 3, -pc_schwarz_overlap and _smoothing >= 0");
  PetscFunctionReturn(0);
}

PetscErrorCode reset(PC pc) {
  Schwarz& s = data(pc);
  PetscFunctionBeginUser;
  s.subdomains.clear();
  s.coarse = RigidAggregates{};
  s.to_local.reset();
  for (petsc::VecHandle* v : {&s.local_b, &s.local_x, &s.work, &s.left}) v->reset();
  PetscFunctionReturn(0);
}

PetscErrorCode destroy(PC pc) {
  PetscFunctionBeginUser;
  PetscCall(reset(pc));
  PetscCall(PetscObjectComposeFunction(reinterpret_cast<PetscObject>(pc), "PCSetCoordinates_C", nullptr));
  delete static_cast<Schwarz*>(pc->data);
  pc->data = nullptr;
  PetscFunctionReturn(0);
}

PetscErrorCode view(PC pc, PetscViewer viewer) {
  const Schwarz& s = data(pc);
  PetscFunctionBeginUser;
  PetscCall(PetscViewerASCIIPrintf(viewer, "  subdomains of %d vertices, %d on the first rank, overlap %d\n",
                                   static_cast<int>(s.vertices), static_cast<int>(s.subdomains.size()),
                                   static_cast<int>(s.overlap)));
  PetscCall(PetscViewerASCIIPrintf(viewer, "  rigid motions of %d aggregates, weights averaged %d times\n",
                                   s.coarse.aggregates(), static_cast<int>(s.smoothing)));
  PetscCall(PetscViewerASCIIPrintf(viewer, "  matrices %ld with %ld patterns\n", s.matrices, s.patterns));
  PetscFunctionReturn(0);
}

PetscErrorCode create(PC pc) {
  PetscFunctionBeginUser;
  pc->data = new Schwarz;
  pc->ops->setup = set_up;
  pc->ops->apply = apply;
  pc->ops->applytranspose = apply;
  pc->ops->setfromoptions = ask_options;
  pc->ops->reset = reset;
  pc->ops->destroy = destroy;
  pc->ops->view = view;
  PetscCall(PetscObjectComposeFunction(reinterpret_cast<PetscObject>(pc), "PCSetCoordinates_C", set_places));
  PetscFunctionReturn(0);
}

}  // namespace

void register_schwarz_pc() {
  static bool done = false;
  if (!done) VOILE_PETSC(PCRegister(schwarz_pc_type, create));
  done = true;
}

}  // namespace voile::solve
