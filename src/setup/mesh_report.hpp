// What is said of a mesh before anything is computed on it.
#pragma once

#include <string>
#include <vector>

#include "base/mpi.hpp"
#include "energy/element_options.hpp"
#include "input/case.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::energy {
class Sheet;
}  // namespace voile::energy

namespace voile::setup {

/// One value per triangle, on rank 0.
struct MeshQuality {
  std::vector<double> angle;               ///< smallest [degree]
  std::vector<double> aspect, unevenness;  ///< see mesh/quality.hpp
  std::vector<double> condition;           ///< of the six-point fit (energy/curvature.hpp)
  std::vector<double> area;                ///< [m^2]
  std::vector<double> fold;     ///< by slopes, over its creases: sum of sin^2(t/2) (side/height)^2, t the angle at rest
  bool large_rotations = true;  ///< the sheet may turn far: not in analyses that are linear
};

/// Whether any stage of a case lets the sheet turn far: not those that are linear, modal or buckling alone.
[[nodiscard]] bool is_nonlinear(const input::Case& c);

/// Measured by all ranks, each a part of the triangles. Collective.
[[nodiscard]] MeshQuality measure_quality(MPI_Comm comm, const mesh::SurfaceMesh& mesh,
                                          const energy::ElementOptions& element);

/// The lines "worst angle, aspect, condition" with places and a verdict.
[[nodiscard]] std::string quality_text(const mesh::SurfaceMesh& mesh, const MeshQuality& quality,
                                       const energy::ElementOptions& element);

/// What of it spoils results or convergence, with cause, place and remedy; empty for a good mesh.
[[nodiscard]] std::vector<std::string> quality_warnings(const mesh::SurfaceMesh& mesh, const MeshQuality& quality,
                                                        const energy::ElementOptions& element);

/// Where folds of the rest shape make bending too stiff, and what mends it; empty if they do not, or hardly.
[[nodiscard]] std::string fold_warning(const mesh::SurfaceMesh& mesh, const MeshQuality& quality,
                                       const energy::ElementOptions& element);

/// A mesh whose numbers look like millimetres beside materials in metres; empty if not, or if the case names its units.
[[nodiscard]] std::string unit_warning(const input::Case& c, const mesh::SurfaceMesh& mesh);

/// What of parts that pass through each other: contact sees them, or nothing does.
enum class Crossings { seen, noted };
/// What is legal but perhaps not meant: vertices that coincide, vertices that were merged.
[[nodiscard]] std::vector<std::string> mesh_notes(const mesh::SurfaceMesh& mesh, Crossings crossings);

/// Triangles that bend by angles at edges. Not collective.
[[nodiscard]] long angle_triangles(const energy::Sheet& sheet);

/// What was decided about the sheet: directions of materials that are made up, triangles that bend by angles beside folds.
[[nodiscard]] std::vector<std::string> sheet_notes(const energy::Sheet& sheet);

/// What the corrected membrane leaves uncorrected; empty if nothing.
[[nodiscard]] std::string uncorrected_text(long triangles);

/// "(x, y, z)" with four digits.
[[nodiscard]] std::string place_text(const Vec3& x);

}  // namespace voile::setup
