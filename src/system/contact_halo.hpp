// Which points of other ranks a rank must know for its contact pairs, and their positions.
//
// Each rank says where its triangles are, by a few boxes; every rank then sends its points of triangles that come into
// these boxes. What is sent grows with what is near, not with the mesh; the boxes of all ranks are known to all, 16 to
// each. Points are named by their number in the mesh.
#pragma once

#include <vector>

#include "base/mpi.hpp"
#include "base/petsc.hpp"
#include "contact/candidates.hpp"
#include "mesh/partition.hpp"

namespace voile::system {

class ContactHalo : public contact::Peers {
 public:
  /// `arrays`, positions of all points each, must outlive it: ghosts that exchange() makes known are known in all of them.
  /// The first ghosts are the points of triangles that hold own points. Collective.
  ContactHalo(MPI_Comm comm, const mesh::SurfaceMesh& mesh, const mesh::Partition& partition,
              std::vector<std::vector<Vec3>*> arrays);

  [[nodiscard]] contact::Departure sum(const contact::Departure& own) override;
  void exchange(contact::Candidates& candidates) override;
  /// Fills in the positions of ghosts from their owners. Collective.
  void update(std::vector<Vec3>& x) const;

 private:
  /// Numbers of points that a rank tells each of the others.
  using Lists = std::vector<std::vector<Index>>;
  /// From now on ghosts are the points that others send: what this rank sends them. Returns the ghosts, ascending.
  std::vector<Index> connect(const Lists& to);
  [[nodiscard]] std::vector<std::vector<contact::Box>> gather_regions(const std::vector<contact::Box>& own) const;
  void tell(contact::Candidates& candidates) const;

  MPI_Comm comm_;
  PetscInt points_;  ///< of the mesh
  std::vector<std::vector<Vec3>*> arrays_;
  int rank_, ranks_;
  Lists always_;  ///< own points of triangles that hold points of another rank, too
  petsc::StarForestHandle forest_;
  mpi::Doubles position_{3}, box_{6};
};

}  // namespace voile::system
