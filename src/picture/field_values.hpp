// One number per vertex or triangle out of a field of results.
#pragma once

#include <string>
#include <vector>

#include "recording.hpp"

namespace voile::picture {

/// NAME or NAME:COMPONENT.
struct FieldChoice {
  std::string name, component;
};
[[nodiscard]] FieldChoice parse_field(const std::string& text);

struct FieldValues {
  std::string label;  ///< e.g. "membrane_force, larger [N/m]"
  std::vector<float> values;
  bool on_triangles = false;
};

/// Names of the numbers of a field, "" if it has one: x, y, z of vectors on vertices; 11, 22, 12 of tensors of the surface, on
/// triangles or recovered at vertices; larger, smaller and angle (or thickness) of principal values; 1 to n of others.
[[nodiscard]] std::vector<std::string> entry_names(const results::Field& field);

/// Components below of a field of a step that has it; of `membrane_strain` also warp and weft, along the threads.
[[nodiscard]] FieldValues field_values(const Recording& recording, const Moment& moment, const FieldChoice& choice);
/// Components: x, y, z, magnitude of vectors on vertices (default: magnitude); 11, 22, 12, larger, smaller of tensors of
/// the surface (default: larger, in size); of principal stresses larger, smaller, angle; 1 to n of others.
/// Throws UserError with the components there are.
[[nodiscard]] FieldValues field_values(const results::Field& field, const std::string& component);

}  // namespace voile::picture
