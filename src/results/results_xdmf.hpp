// XDMF over results.vtkhdf, for ParaViews that do not know the steps of VTKHDF; private to src/io.
//
// Each item is a hyperslab (begin, stride, count) of a dataset; the dataset may have grown beyond what the text says.
#pragma once

#include <string>
#include <vector>

#include "results_catalogue.hpp"

namespace voile::results {

/// The grid of a step.
[[nodiscard]] std::string xdmf_step(const Catalogue& c, std::size_t step);
/// The mesh at rest with groups and partition, for a file without steps.
[[nodiscard]] std::string xdmf_mesh(const Catalogue& c);
/// Obstacles at a step, or for `step` < 0 at rest.
[[nodiscard]] std::string xdmf_obstacles(const Catalogue& c, const ObstacleTriangles& obstacles, int step);
/// The text of a file of grids; `steps`: a temporal collection.
[[nodiscard]] std::string xdmf_file(const char* name, const std::vector<std::string>& grids, bool steps);

}  // namespace voile::results
