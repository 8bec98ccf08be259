// Which operators the element uses.
#pragma once

#include <numbers>

namespace voile::energy {

enum class BendingOperator {
  edge_slope,  ///< one normal slope per edge from the patch quadratics, curvature by the divergence theorem
  edge_angle,  ///< edge_slope by the angles at the edges that it is made up of; not constant
  six_node     ///< the quadratic through the triangle and its three neighbours
};

enum class MembraneOperator {
  cst,                   ///< constant-strain triangle
  six_node,              ///< mid-side strains of the six-node patch averaged to one point
  six_node_corrected,    ///< six_node without what straight chords feign where the surface bends
  six_node_three_point,  ///< energy of the three mid-side strains averaged; stiffer on coarse meshes
  automatic  ///< six_node or six_node_corrected: to be replaced before a sheet is given terms (app/membrane_choice.hpp)
};

/// Choices of element; all are dimensionless except the angle.
struct ElementOptions {
  BendingOperator bending = BendingOperator::edge_slope;
  MembraneOperator membrane = MembraneOperator::six_node;
  /// Share of constant-strain energy mixed into `six_node` and `six_node_corrected`, 0..1: W = (1-s) W(mean E) + s W(E_cst). Without it free
  /// edges crumple at little energy; more costs accuracy on coarse meshes (docs/developers/decisions/cst-fraction.md).
  double cst_share = 0.1;
  /// A patch quadratic whose scaled 6x6 fit has a larger condition number is not used. Smaller: more edges take the
  /// dearer ring fit.
  double max_patch_condition = 30.0;
  /// Rest dihedral angle [rad] above which an edge counts as a crease: the membrane does not average across it.
  double crease_angle = 40.0 * std::numbers::pi / 180.0;
};

}  // namespace voile::energy
