// How forces and stresses change with the state, or with the loads at a state that stays.
//
// Symbols   a   a state;  u a change of its unknowns [m];  e a factor that makes u small against the cells;  s load factor
//   df = (f(a + e u) - f(a - e u)) / 2e,        of loads:  (f(a; s + 1) - f(a; s - 1)) / 2
// The second is exact for loads that are linear in s, and for natural states, whose metric is of second degree.
#pragma once

#include <functional>
#include <vector>

#include "system/model.hpp"

namespace voile::record {

/// Largest displacement of e u over the length of a cell: terms of third order are its square, and round-off of the coordinates is
/// divided by it, so about the cube root of round-off.
inline constexpr double fraction_of_cell = 1e-5;

class StateChange {
 public:
  /// By u. The model and `a` must outlive it. Collective.
  StateChange(system::Model& model, Vec a, Vec u);
  /// By one unit of the load factor.
  StateChange(system::Model& model, Vec a);

  /// Of Model::unbalanced_force. Collective.
  void force(Vec f);
  /// Of what is computed from the fields of triangles. Collective; values on rank 0.
  [[nodiscard]] std::vector<double> of_fields(
      const std::function<std::vector<double>(const system::TriangleFields&)>& f);

 private:
  template <class F>
  void at_sides(F&& f);

  system::Model& model_;
  Vec a_;
  petsc::VecHandle forward_, backward_;  ///< none: the load factor changes
  double step_ = 1.0;                    ///< e
};

}  // namespace voile::record
