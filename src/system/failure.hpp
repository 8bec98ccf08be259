// How near the plies of a sheet are to failure.
#pragma once

#include <vector>

#include "energy/layer_stress.hpp"
#include "recovery.hpp"

namespace voile::system {

struct FailureFields {
  std::vector<double> index,
      ply;  ///< per triangle: the largest index of its plies, and its ply from 1; 0 without strengths
  energy::LayerFailure first;  ///< of all triangles
  Index triangle = no_index;   ///< where; no_index: nothing is stressed
};

/// Whether a material has strengths. Not collective.
[[nodiscard]] bool has_strengths(const energy::Sheet& sheet);
/// Strain, curvature and temperature of a triangle from the fields. Not collective.
[[nodiscard]] energy::SheetState sheet_state(const TriangleFields& fields, std::size_t triangle);
/// From gathered fields: on rank 0.
[[nodiscard]] FailureFields failure_fields(const energy::Sheet& sheet, const TriangleFields& fields);

}  // namespace voile::system
