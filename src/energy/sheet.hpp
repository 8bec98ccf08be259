// The undeformed sheet: patches, materials and element choices, from which every operator is built. Directions of
// materials live in the chart of each triangle.
#pragma once

#include <unordered_set>
#include <utility>
#include <vector>

#include "element_options.hpp"
#include "material.hpp"
#include "mesh/patch.hpp"

namespace voile::energy {

/// Which material covers which triangle. Throws UserError for triangles covered by none or by two materials.
[[nodiscard]] std::vector<int> assign_materials(const mesh::SurfaceMesh& mesh, const std::vector<Material>& materials);

/// Material axis 1 where it is not the projection of the material's direction: from texture coordinates, or where the
/// direction is nearly normal to the triangle (within 3 degrees) continued from neighbours of the same material,
/// unfolded across their common side.
struct MaterialAxes {
  std::vector<Vec3> of;  ///< per triangle, zero: project the material's direction; empty: all do
  Index continued = 0;   ///< triangles that take it from neighbours
};

/// Throws UserError where a material has a direction in texture coordinates but the mesh has none, and where a whole
/// connected part of a material is normal to its direction.
[[nodiscard]] MaterialAxes material_axes(const mesh::SurfaceMesh& mesh, const std::vector<Material>& materials,
                                         const std::vector<int>& material_of);

/// A side across which the sheet bends more or less easily than elsewhere: a seam.
struct BendingSide {
  mesh::TriangleSide side;
  double factor = 1.0;  ///< of the bending energy across it; 0: a hinge
};

/// References patches and materials, which must outlive it. Throws as material_axes() does.
class Sheet {
 public:
  /// `seams`: each side named from both of its triangles. `zones`: per triangle, another one where the temperature may jump;
  /// empty: nowhere.
  Sheet(const mesh::PatchMesh& patches, const std::vector<Material>& materials, std::vector<int> material_of,
        const ElementOptions& options, std::vector<BendingSide> seams = {}, std::vector<int> zones = {})
      : patches_(&patches),
        materials_(&materials),
        material_of_(std::move(material_of)),
        axes_(material_axes(patches.mesh(), materials, material_of_)),
        options_(options),
        seams_(std::move(seams)),
        zones_(std::move(zones)) {
    for (const BendingSide& s : seams_)
      if (s.factor < 1.0) folds_.insert(3 * s.side.triangle + s.side.side);
  }

  [[nodiscard]] const mesh::PatchMesh& patches() const { return *patches_; }
  [[nodiscard]] const mesh::SurfaceMesh& mesh() const { return patches_->mesh(); }
  [[nodiscard]] const ElementOptions& options() const { return options_; }
  [[nodiscard]] const std::vector<Material>& materials() const { return *materials_; }
  [[nodiscard]] int material_index(Index t) const { return material_of_[t]; }
  [[nodiscard]] const Material& material(Index t) const { return (*materials_)[material_of_[t]]; }
  /// Material axes of triangle t; stresses and curvatures refer to them.
  [[nodiscard]] mesh::Frame frame(Index t) const {
    const bool own = !axes_.of.empty() && axes_.of[static_cast<std::size_t>(t)] != Vec3::Zero();
    return patches_->frame(t, own ? std::optional<Vec3>(axes_.of[static_cast<std::size_t>(t)]) : material(t).direction);
  }
  /// Sides across which bending differs.
  [[nodiscard]] const std::vector<BendingSide>& seams() const { return seams_; }
  /// Whether the sheet folds at side s of t, so that no strain is averaged across it. It has a neighbour or mirror point.
  [[nodiscard]] bool is_crease(Index t, int s) const {
    return patches_->rest_dihedral(t, s) > options_.crease_angle || (!folds_.empty() && folds_.contains(3 * t + s));
  }
  /// Part of the sheet with a temperature of its own that triangle t is in.
  [[nodiscard]] int zone(Index t) const { return zones_.empty() ? 0 : zones_[static_cast<std::size_t>(t)]; }
  /// Per triangle, whether it lies beside such a notch (notches.hpp); empty: none does, as at first.
  void set_notches(std::vector<char> near) { notches_ = std::move(near); }
  /// Whether triangle t lies beside a notch that is small for the thickness there.
  [[nodiscard]] bool is_near_notch(Index t) const {
    return !notches_.empty() && notches_[static_cast<std::size_t>(t)] != 0;
  }
  /// Triangles whose material axis is continued from neighbours.
  [[nodiscard]] Index continued_axes() const { return axes_.continued; }

 private:
  const mesh::PatchMesh* patches_;
  const std::vector<Material>* materials_;
  std::vector<int> material_of_;
  MaterialAxes axes_;
  ElementOptions options_;
  std::vector<BendingSide> seams_;
  std::vector<int> zones_;
  std::vector<char> notches_;
  std::unordered_set<Index> folds_;  ///< 3 t + s of the sides that bend more easily
};

}  // namespace voile::energy
