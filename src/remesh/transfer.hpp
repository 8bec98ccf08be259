// What is remembered per vertex, on a new mesh.
#pragma once

#include <vector>

#include "adapt/remesh.hpp"
#include "results/checkpoint.hpp"
#include "system/model.hpp"

namespace voile::remesh {

/// Where new vertices come from, the same on every rank.
struct Origins {
  std::vector<Index> triangle;
  std::vector<double> weights;  ///< three each
  std::vector<Index> kept;      ///< the old vertex, if it is one
};

/// Tells all ranks what rank 0 has found. Collective.
[[nodiscard]] Origins origins_of(MPI_Comm comm, const adapt::Remeshed& from);

/// Gaps from which a start is let out, and obstacles that are ignored, per new vertex. Friction remembers nothing beyond a
/// step (contact/contact_set.hpp), so that there is nothing to carry. Not collective, as what follows.
void carry_contact(const mesh::SurfaceMesh& old_mesh, const Origins& from, results::Checkpoint& c);

/// Slips of yarns (system::Potential::slips), on rank 0, from the triangles of the old mesh to those of the new one, by place on the
/// rest shape: triangles that stay keep theirs, others take the mean at their corners of means over the triangles around.
void carry_slips(const mesh::SurfaceMesh& old_mesh, const mesh::SurfaceMesh& mesh, const adapt::Remeshed& from,
                 results::Checkpoint& c);

/// Places to which springs of new vertices pull are means of those of old ones, so that their forces stay. What is held
/// exactly takes hold anew, as what is left out here does. `model`: of the old mesh.
void carry_anchors(const system::Model& model, const mesh::SurfaceMesh& mesh, const Origins& from,
                   results::Checkpoint& c);

}  // namespace voile::remesh
