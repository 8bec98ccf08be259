#include "contact_halo.hpp"

#include <algorithm>

#include "base/mpi.hpp"

namespace voile::system {

using contact::Box;
using contact::Departure;

static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(Box) == 6 * sizeof(double));

ContactHalo::ContactHalo(MPI_Comm comm, const mesh::SurfaceMesh& mesh, const mesh::Partition& partition,
                         std::vector<std::vector<Vec3>*> arrays)
    : comm_(comm),
      points_(mesh.vertex_count()),
      arrays_(std::move(arrays)),
      rank_(mpi::rank(comm)),
      ranks_(mpi::size(comm)) {
  always_.resize(static_cast<std::size_t>(ranks_));
  for (const mesh::Triangle& t : mesh.triangles())
    for (Index p : t)
      for (Index q : t)
        if (partition.vertex_rank[p] == rank_ && partition.vertex_rank[q] != rank_)
          always_[partition.vertex_rank[q]].push_back(p);
  for (std::vector<Index>& list : always_) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  (void)connect(always_);
}

Departure ContactHalo::sum(const Departure& own) {
  const std::array<double, 5> all = mpi::sum(comm_, {own.points, own.left, own.excess, own.room, own.displacement});
  return {all[0], all[1], all[2], all[3], all[4]};
}

void ContactHalo::update(std::vector<Vec3>& x) const {
  VOILE_PETSC(PetscSFBcastBegin(forest_, position_, x.data(), x.data(), MPI_REPLACE));
  VOILE_PETSC(PetscSFBcastEnd(forest_, position_, x.data(), x.data(), MPI_REPLACE));
}

std::vector<Index> ContactHalo::connect(const Lists& to) {
  const Lists from = mpi::exchange(comm_, to);
  std::vector<std::pair<Index, PetscInt>> leaves;  // point, owner
  for (int r = 0; r < ranks_; ++r)
    for (Index p : from[r]) leaves.emplace_back(p, r);
  std::sort(leaves.begin(), leaves.end());
  std::vector<Index> ghosts;
  std::vector<PetscInt> local;
  std::vector<PetscSFNode> remote;
  for (const auto& [p, r] : leaves) {
    ghosts.push_back(p);
    local.push_back(p);
    remote.push_back({r, p});
  }
  VOILE_PETSC(PetscSFCreate(comm_, forest_.out()));
  VOILE_PETSC(PetscSFSetGraph(forest_, points_, static_cast<PetscInt>(leaves.size()), local.data(), PETSC_COPY_VALUES,
                              remote.data(), PETSC_COPY_VALUES));
  VOILE_PETSC(PetscSFSetUp(forest_));
  return ghosts;
}

std::vector<std::vector<Box>> ContactHalo::gather_regions(const std::vector<Box>& own) const {
  std::vector<double> values;
  for (const Box& b : own) {
    values.insert(values.end(), b.low.begin(), b.low.end());
    values.insert(values.end(), b.high.begin(), b.high.end());
  }
  std::vector<std::vector<Box>> regions;
  for (const std::vector<double>& of_rank : mpi::gather_to_all(comm_, values)) {
    std::vector<Box>& boxes = regions.emplace_back();
    for (std::size_t k = 0; k < of_rank.size(); k += 6)
      boxes.push_back(
          {Vec3(of_rank[k], of_rank[k + 1], of_rank[k + 2]), Vec3(of_rank[k + 3], of_rank[k + 4], of_rank[k + 5])});
  }
  return regions;
}

void ContactHalo::tell(contact::Candidates& candidates) const {
  Box* const boxes = candidates.boxes().data();
  char* const renewed = candidates.renewed().data();
  VOILE_PETSC(PetscSFBcastBegin(forest_, box_, boxes, boxes, MPI_REPLACE));
  VOILE_PETSC(PetscSFBcastEnd(forest_, box_, boxes, boxes, MPI_REPLACE));
  VOILE_PETSC(PetscSFBcastBegin(forest_, MPI_CHAR, renewed, renewed, MPI_REPLACE));
  VOILE_PETSC(PetscSFBcastEnd(forest_, MPI_CHAR, renewed, renewed, MPI_REPLACE));
}

void ContactHalo::exchange(contact::Candidates& candidates) {
  tell(candidates);  // of points that leave, too; and the boxes of own triangles need those of their points elsewhere
  const std::vector<std::vector<Box>> regions = gather_regions(candidates.region());
  Lists to = always_;
  for (int r = 0; r < ranks_; ++r) {
    if (r == rank_) continue;
    const std::vector<Index> near = candidates.points_within(regions[r]);
    std::vector<Index> both;
    std::set_union(to[r].begin(), to[r].end(), near.begin(), near.end(), std::back_inserter(both));
    to[r] = std::move(both);
  }
  candidates.see(connect(to));
  tell(candidates);
  for (std::vector<Vec3>* x : arrays_) update(*x);
}

}  // namespace voile::system
