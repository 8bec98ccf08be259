// element.membrane = "auto": the membrane that a case is computed with; private to src/app.
//
// six_node_corrected where six_node would err by more than a share of 0.01 as the mesh, its thickness and the analysis let expect:
//   curved at rest   energy::locking_estimate(), in every analysis
//   flat             energy::rolled_up(), either part, only where rotations are large and folds are not what is looked for: in
//                    static analyses. Draped and moving cloth stays with six_node, whose folds are smoother and cost fewer iterations.
// Decided once for all stages, from the mesh of the case. Where a static case has six_node, flat sheets that could err by more than
// 0.05 so are told.
#pragma once

#include <string>

#include "voile/base/mpi.hpp"
#include "voile/input/case.hpp"
#include "voile/mesh/surface_mesh.hpp"

namespace voile::app {

/// As in the case file.
[[nodiscard]] const char* name(energy::MembraneOperator membrane);

struct MembraneChoice {
  energy::MembraneOperator membrane;
  /// What is chosen and why, or what is to be expected of the six_node that the case names; may be empty. On rank 0.
  std::string text;
};

/// Of a case as it stands in the file. `mesh`: that of the case. Collective. Throws UserError for materials that do not suit the mesh.
[[nodiscard]] MembraneChoice choose_membrane(MPI_Comm comm, const input::Case& c, const mesh::SurfaceMesh& mesh);

/// The case, stages included, with that membrane.
[[nodiscard]] input::Case with_membrane(input::Case c, energy::MembraneOperator membrane);

}  // namespace voile::app
