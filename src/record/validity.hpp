// How far a state is within what the element was made for.
//
// Symbols   F in-plane deformation gradient of the triangle's three vertices, E = (F^T F - I)/2; E_1, E_2 principal
//           theta_e   angle between the normals of the two triangles of edge e, less that at rest
// The law is linear in E (St. Venant-Kirchhoff), which stands for small strains; bending acts as D sin(theta) instead
// of D theta per edge (docs/verification/limits.md).
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "energy/sheet.hpp"
#include "mesh/surface_mesh.hpp"
#include "system/model.hpp"
#include "system/recovery.hpp"

namespace voile::record {

/// Largest strain that the law is meant for, and largest turn of an edge that bending follows [rad].
inline constexpr double strain_limit = 0.1, turn_limit = 1.0471975511965976;
/// Fraction of the stored energy that the membrane may owe to its chords (energy/chord_error.hpp).
inline constexpr double error_limit = 0.05;

/// A strain, and up to which size the law of its material is known: strain_limit, or the end of a measured curve.
struct Reach {
  double strain = 0.0, limit = strain_limit;
  enum class Of { principal, warp, weft, shear } of = Of::principal;  ///< of shear the sine of its angle
  bool measured = false;                                              ///< the limit is that of a curve
  [[nodiscard]] double ratio() const { return std::abs(strain) / limit; }
};
/// The strain of the largest ratio among the principal values of `e`, or of a material with curves those along and between its yarns;
/// E11, E22, 2 E12 from the natural state, in material axes.
[[nodiscard]] Reach reach_of(const energy::Material& material, const Vec3& e);

struct Validity {
  double strain = 0.0;                             ///< largest |E_1|, |E_2|
  Reach reach;                                     ///< that of the largest ratio
  Index triangle = no_index;                       ///< where
  double turn = 0.0;                               ///< largest |theta_e| [rad]
  Index vertex_a = no_index, vertex_b = no_index;  ///< ends of that edge
};

/// Of the model's sheet at the time that it has: where it is gathered, its strain is that beyond the gathers. `displacement`: three
/// components per vertex in global axes, mesh order [m]. `linear`: strains and turns are those in proportion to it. Not collective.
[[nodiscard]] Validity assess(const system::Model& model, const std::vector<double>& displacement, bool linear);

/// A fraction in per cent, two figures where they say something; "more than 100 %" of estimates that only say so.
[[nodiscard]] std::string percent_text(double fraction);
/// The largest of several: "up to 12 %", or "more than 100 %".
[[nodiscard]] std::string up_to_text(double fraction);

/// What to tell the user of a curved shell that locks, empty if it does not. `fields` of any state, on rank 0.
[[nodiscard]] std::string locking_warning(const energy::Sheet& sheet, const system::TriangleFields& fields);

}  // namespace voile::record
