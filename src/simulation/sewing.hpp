// Seams between the stages of a run: closed in one, welded before the next.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "mesh/surface_mesh.hpp"
#include "results/checkpoint.hpp"
#include "stages.hpp"

namespace voile::simulation {

/// Why the seams of a stage cannot be welded at its end, and what lies between their sides; empty if they can, on every rank.
/// Collective.
[[nodiscard]] std::string open_seam_text(const input::Case& c, const system::Model& model, const system::State& state);

/// The mesh of the case as each stage finds it, seams of earlier ones closed where their sides begin: for what depends
/// on the rest shape only. Not collective.
[[nodiscard]] std::vector<std::shared_ptr<const mesh::SurfaceMesh>> stage_meshes(
    const std::vector<Stage>& stages, const std::shared_ptr<const mesh::SurfaceMesh>& first);

/// Before a stage: closes the seams that earlier ones have pulled together and that are open yet, in the mesh and in the
/// state, which then counts displacements from where it is. A stage that closes seams begins so too. Mass and momentum
/// stay. Returns the seams it has closed. Collective. Throws UserError if the seams are too wide.
std::vector<std::string> weld_before(const Stage& stage, Origin origin, std::shared_ptr<const mesh::SurfaceMesh>& mesh,
                                     results::Checkpoint& state);

}  // namespace voile::simulation
