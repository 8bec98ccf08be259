// What does not change with the state: bending stiffness, damping and mass.
// Theory: docs/theory/curvature.md, docs/theory/time-integration.md.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "base/petsc.hpp"
#include "block_matrix.hpp"
#include "compact_matrix.hpp"
#include "discretisation.hpp"
#include "tangent.hpp"

namespace voile::system {

class ConstantMatrices {
 public:
  ConstantMatrices() = default;
  /// Zero matrices of this pattern, and the mass. Collective. Throws UserError for unknown groups.
  ConstantMatrices(const Discretisation& on, BlockPattern pattern, const std::vector<PointMass>& masses);

  /// Pattern of the bending stiffness and of a tangent without contact.
  [[nodiscard]] const BlockMatrix& base() const { return bending_; }
  /// Whether a material damps bending.
  [[nodiscard]] bool has_damping() const { return damping_.has_value(); }
  /// y = K_b x, with the constant bending stiffness and the springs to the ground, without elimination [N/m]. Collective.
  void multiply_bending(Vec x, Vec y) const { compact_bending_.multiply(x, y); }
  /// y = C_b x, with the sum over the materials of their bending damping times their bending stiffness, without
  /// elimination [N s/m]. Collective.
  void multiply_damping(Vec x, Vec y) const { compact_damping_.multiply(x, y); }
  /// K_b.
  [[nodiscard]] const CompactMatrix& bending() const { return compact_bending_; }
  /// Adds C_b times a factor to the open values of a matrix with the pattern of base() or an extended one.
  void add_damping(const BlockMatrix& to, const BlockMatrix::Values& values, double factor) const {
    compact_damping_.add_to(to, values, factor);
  }
  /// Lumped mass per unknown: areal density (1 kg/m^2 where the material has none) times a third of the triangles. [kg]
  [[nodiscard]] Vec mass() const { return mass_; }
  /// That of the vertices of rigid bodies and their reference points. mass() has only its size at the carriers.
  [[nodiscard]] const std::vector<BodyMass>& body_mass() const { return body_mass_; }
  /// Consistent mass of linear triangles, m/12 (1 + delta_ij) per pair of corners, with the density that each material
  /// has and zero rows and columns where the displacement is fixed. The pattern is the tangent's. Collective. [kg]
  [[nodiscard]] BlockMatrix consistent_mass() const;

  // For the model, which fills them and then has them made compact
  [[nodiscard]] BlockMatrix& bending_blocks() { return bending_; }
  [[nodiscard]] std::optional<BlockMatrix>& damping_blocks() { return damping_; }
  /// Reads the values of both. Without `keep` those of whole blocks are given back and cannot be written any more. Collective.
  void make_compact(bool keep);

 private:
  void take_body_mass(Index v, double m, std::vector<BodyMass>& of) const;
  void write_body_mass(const petsc::WriteArray& mass) const;
  void add_consistent(const BlockMatrix& mass, const BlockMatrix::Values& values, const mesh::Triangle& corners,
                      double part) const;
  void lump(const std::vector<PointMass>& masses);

  const Discretisation* on_ = nullptr;
  BlockMatrix bending_;
  std::optional<BlockMatrix> damping_;
  CompactMatrix compact_bending_, compact_damping_;
  petsc::VecHandle mass_;
  std::vector<std::pair<Index, double>> masses_;       ///< of owned vertices, besides the sheet's [kg]
  std::vector<BodyMass> body_mass_, extra_body_mass_;  ///< the second: besides the sheet's
};

}  // namespace voile::system
