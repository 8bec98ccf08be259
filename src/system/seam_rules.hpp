// What seams do to the fabric beside them: how it bends across, and the strips that are folded back (allowances).
//
// Symbols   f   factor of the bending energy across a welded seam: 0 a hinge, 1 as the fabric elsewhere
//           w   width of the strip of the same fabric that lies along each side of a seam, inside of it      [m]
//           A_T rest area of triangle T, a_T the part of it that strips cover (counted as often as they do)  [m^2]
// Triangle T has 1 + a_T/A_T layers, which are not glued together: membrane stiffness A, bending stiffness D and mass
// per area are those of the fabric times that. Strips end where their panel ends; mass grows by exactly what they weigh.
#pragma once

#include <string>
#include <vector>

#include "energy/sheet.hpp"
#include "mesh/gathers.hpp"

namespace voile::system {

struct SeamRule {
  std::string seam{};         ///< name, in which `*` stands for a text; empty: of all seams that no other rule names
  double bending = 1.0;       ///< f
  double allowance = 0.0;     ///< w [m]
  double gather_from = 1.25;  ///< ratio of lengths from which on the longer side is gathered (mesh/gathers.hpp)
  double gather_width = 0.0;  ///< of the gathered rows [m]; 0: that of three rows of the cells that there are
};

/// What is known of the seams of a mesh.
struct Seams {
  std::vector<SeamRule> rules;
  std::vector<std::string> pulled;  ///< open ones that are pulled together; "all": every one
};

/// Sides of welded seams whose factor is not 1, each from both triangles. Not collective.
[[nodiscard]] std::vector<energy::BendingSide> bending_across_seams(const mesh::SurfaceMesh& mesh,
                                                                    const std::vector<SeamRule>& rules);

/// f of the rule of a seam.
[[nodiscard]] double bending_of(const std::string& seam, const std::vector<SeamRule>& rules);

/// w of the rule of a seam [m].
[[nodiscard]] double allowance_of(const std::string& seam, const std::vector<SeamRule>& rules);

/// Factor of each of mesh.joints(), not below `least_factor`, with which a hinge's edge still has an angle; the least where several
/// seams run along it. Not collective.
[[nodiscard]] std::vector<double> bending_of_joints(const mesh::SurfaceMesh& mesh, const std::vector<SeamRule>& rules);
inline constexpr double least_factor = 1e-9;

/// Area of the strips in each triangle [m^2], of open and welded seams; empty if no rule has an allowance. Not collective.
/// Throws UserError if an allowance is wider than its piece all along the seam.
[[nodiscard]] std::vector<double> allowance_areas(const mesh::SurfaceMesh& mesh, const std::vector<SeamRule>& rules);

/// The seams whose longer side is gathered: those that are welded or pulled together. Not collective.
[[nodiscard]] std::vector<mesh::Gather> gathers(const mesh::SurfaceMesh& mesh, const Seams& seams);

/// The rules with a width of the gathered rows for each seam that is gathered, open or welded: that of three rows of the
/// first mesh, so that every later one gathers the same fabric. Not collective.
[[nodiscard]] std::vector<SeamRule> with_gather_widths(std::vector<SeamRule> rules, const mesh::SurfaceMesh& first);

/// Appends the materials of triangles that strips cover, and has `material_of` name them. Not collective.
void add_allowances(const mesh::SurfaceMesh& mesh, const std::vector<SeamRule>& rules,
                    std::vector<energy::Material>& materials, std::vector<int>& material_of);

}  // namespace voile::system
