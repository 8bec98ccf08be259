// What does not change with the state: bending stiffness, damping and mass.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "voile/base/petsc.hpp"
#include "voile/system/block_matrix.hpp"
#include "voile/system/block_product.hpp"
#include "voile/system/discretisation.hpp"
#include "voile/system/tangent.hpp"

namespace voile::system {

class ConstantMatrices {
 public:
  ConstantMatrices() = default;
  /// Zero matrices of this pattern, and the mass. Collective. Throws UserError for unknown groups.
  ConstantMatrices(const Discretisation& on, BlockPattern pattern, const std::vector<PointMass>& masses);

  /// The constant bending stiffness, with the springs to the ground, without elimination. [N/m]
  [[nodiscard]] Mat bending() const { return bending_.mat(); }
  /// Whether a material damps bending: the sum over the materials of their bending damping times their bending stiffness
  /// [N s/m], without elimination.
  [[nodiscard]] bool has_damping() const { return damping_.has_value(); }
  /// y = K_b x, and y = C_b x, with the matrices above. Collective.
  void multiply_bending(Vec x, Vec y) const { bending_product_.multiply(bending_, x, y); }
  void multiply_damping(Vec x, Vec y) const { damping_product_.multiply(*damping_, x, y); }
  /// Lumped mass per unknown: areal density (1 kg/m^2 where the material has none) times a third of the triangles. [kg]
  [[nodiscard]] Vec mass() const { return mass_; }
  /// Consistent mass of linear triangles, m/12 (1 + delta_ij) per pair of corners, with the density that each material
  /// has and zero rows and columns where the displacement is fixed. The pattern is the tangent's. Collective. [kg]
  [[nodiscard]] BlockMatrix consistent_mass() const;

  // For the model, which fills them
  [[nodiscard]] BlockMatrix& bending_blocks() { return bending_; }
  [[nodiscard]] std::optional<BlockMatrix>& damping_blocks() { return damping_; }

 private:
  void lump(const std::vector<PointMass>& masses);

  const Discretisation* on_ = nullptr;
  BlockMatrix bending_;
  std::optional<BlockMatrix> damping_;
  mutable BlockProduct bending_product_, damping_product_;
  petsc::VecHandle mass_;
  std::vector<std::pair<Index, double>> masses_;  ///< of owned vertices, besides the sheet's [kg]
};

}  // namespace voile::system
