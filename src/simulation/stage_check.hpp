// What is wrong or odd about a stage, before any work.
#pragma once

#include <string>
#include <vector>

#include "remesh/stage.hpp"
#include "system/model.hpp"

namespace voile::simulation {

/// Builds the model of a stage that is still to come, so that its mistakes show. Collective. Throws UserError.
void check_stage(const remesh::Stage& stage, const mesh::SurfaceMesh& mesh);

/// Throws UserError where an analysis needs a load that grows with the load factor, and none does. Collective.
void require_growth(const input::Case& c, system::Model& model);

/// What a user should know of a stage that begins with welded seams: they are where displacements begin anew, and with them
/// what counts from the start. Not collective.
[[nodiscard]] std::vector<std::string> counted_from_welds(const remesh::Stage& before, const remesh::Stage& now);

}  // namespace voile::simulation
