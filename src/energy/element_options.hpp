// Which operators the element uses.
#pragma once

#include <numbers>

namespace voile::energy {

enum class BendingOperator {
  edge_slope,  ///< one normal slope per edge from the patch quadratics, curvature by the divergence theorem; constant
  edge_angle,  ///< edge_slope by the angles at the edges that it is made up of; not constant
  six_node     ///< the quadratic through the triangle and its three neighbours; constant
};

enum class MembraneOperator {
  cst,                ///< constant-strain triangle
  six_node,           ///< mid-side strains of the six-node patch averaged to one point
  six_node_corrected  ///< six_node less the spurious strain of straight chords where the surface bends
};

/// Choices of element; all are dimensionless except the angle.
struct ElementOptions {
  BendingOperator bending = BendingOperator::edge_slope;
  MembraneOperator membrane = MembraneOperator::six_node_corrected;
  /// Fraction of constant-strain energy in `six_node` and `six_node_corrected`, 0..1: W = (1-f) W(mean E) + f W(E_cst). Without it
  /// free edges crumple at little energy; more costs accuracy on coarse meshes (docs/developers/decisions/cst-fraction.md).
  double cst_fraction = 0.1;
  /// A patch quadratic whose scaled 6x6 fit has a larger condition number is not used. Smaller: more edges take the
  /// dearer ring fit.
  double max_patch_condition = 30.0;
  /// Rest dihedral angle [rad] above which an edge counts as a crease: the membrane does not average across it.
  double crease_angle = 40.0 * std::numbers::pi / 180.0;
};

/// An element that a case can name.
struct ElementType {
  const char* name;
  BendingOperator bending;
  MembraneOperator membrane;
  double cst_fraction;  ///< default; the published elements have none
};
inline constexpr ElementType element_types[] = {
    {"corrected", BendingOperator::edge_slope, MembraneOperator::six_node_corrected, 0.1},
    {"angles", BendingOperator::edge_angle, MembraneOperator::six_node_corrected, 0.1},
    {"six_node", BendingOperator::edge_slope, MembraneOperator::six_node, 0.1},
    {"sze_zhou_2016", BendingOperator::six_node, MembraneOperator::six_node, 0.0},
    {"zhou_sze_2012", BendingOperator::six_node, MembraneOperator::cst, 0.0}};

/// Position in element_types; their number for a pair of operators that has no name.
constexpr int type_of(const ElementOptions& options) {
  int k = 0;
  for (const ElementType& type : element_types) {
    if (type.bending == options.bending && type.membrane == options.membrane) return k;
    ++k;
  }
  return k;
}

}  // namespace voile::energy
