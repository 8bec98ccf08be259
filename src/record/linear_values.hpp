// What a linear analysis tells of its solution: of first order in the displacements, whatever their size. The element's own forces, strains and energies are those of large displacements.
//
// Symbols   u   displacements [m];  e   a factor that makes them small against the cells
//   f(0) + (f(e u) - f(-e u)) / 2e                                             forces, strains, resultants
//   E(0) + (E(e u) - E(-e u)) / 2e + (E(e u) + E(-e u) - 2 E(0)) / 2e^2        energies, of second order; that of dead
//   loads of first, that of bending from all together: W(0) + u.(f(0) + R)/2 + u.p, R the reactions, p follower loads at rest
#pragma once

#include "system/model.hpp"

namespace voile::record {

/// The model must outlive them; its load factor is that of the solution.
class LinearValues {
 public:
  /// `about`: the state that u is added to; null: rest. Collective.
  LinearValues(system::Model& model, Vec u, Vec about = nullptr);
  /// As Model::unbalanced_force. Collective.
  void unbalanced_force(Vec f);
  /// As energies(). Collective.
  [[nodiscard]] system::Energies energies();
  /// As Potential::triangle_fields. Collective; values on rank 0.
  [[nodiscard]] system::TriangleFields triangle_fields();
  /// The same without those of the state itself. Collective; values on rank 0.
  [[nodiscard]] system::TriangleFields triangle_changes();
  /// u.(f(e u) - f(-e u)) / 2e, twice the energy of u with that of the stresses in the state [J]. Collective.
  [[nodiscard]] double stiffness();

 private:
  /// u.(f(0) + R) / 2 [J].
  [[nodiscard]] double work();
  /// Of follower loads, which no energy counts [J].
  [[nodiscard]] double follower_work();

  system::Model& model_;
  double small_ = 1.0;  ///< e
  Vec u_;
  petsc::VecHandle rest_, forward_, backward_;
};

}  // namespace voile::record
