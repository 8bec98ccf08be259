// The undeformed sheet: patches, materials and element choices, from which every operator is built.
#pragma once

#include <vector>

#include "voile/energy/element_options.hpp"
#include "voile/energy/material.hpp"
#include "voile/mesh/patch.hpp"

namespace voile::energy {

/// Which material covers which triangle. Throws UserError for triangles covered by none or by two materials.
[[nodiscard]] std::vector<int> assign_materials(const mesh::SurfaceMesh& mesh, const std::vector<Material>& materials);

/// References patches and materials, which must outlive it.
class Sheet {
 public:
  Sheet(const mesh::PatchMesh& patches, const std::vector<Material>& materials, std::vector<int> material_of,
        const ElementOptions& options)
      : patches_(&patches), materials_(&materials), material_of_(std::move(material_of)), options_(options) {}

  [[nodiscard]] const mesh::PatchMesh& patches() const { return *patches_; }
  [[nodiscard]] const mesh::SurfaceMesh& mesh() const { return patches_->mesh(); }
  [[nodiscard]] const ElementOptions& options() const { return options_; }
  [[nodiscard]] const std::vector<Material>& materials() const { return *materials_; }
  [[nodiscard]] int material_index(Index t) const { return material_of_[t]; }
  [[nodiscard]] const Material& material(Index t) const { return (*materials_)[material_of_[t]]; }
  /// Material axes of triangle t; stresses and curvatures refer to them.
  [[nodiscard]] mesh::Frame frame(Index t) const { return patches_->frame(t, material(t).direction); }

 private:
  const mesh::PatchMesh* patches_;
  const std::vector<Material>* materials_;
  std::vector<int> material_of_;
  ElementOptions options_;
};

}  // namespace voile::energy
