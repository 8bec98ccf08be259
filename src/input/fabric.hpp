// A fabric: the figures that textile laboratories measure, read from a TOML file of its own.
//
// Symbols   A11 A22 A66  membrane stiffness along warp and weft and in shear [N/m],  A12 = nu_A sqrt(A11 A22)
//           D11 D22 D66  bending stiffness along warp and weft and in twist [N m],   D12 = nu_D sqrt(D11 D22)
// The Poisson ratios are the geometric means of both directions; |nu| < 1 is what positive definiteness asks for.
// Without a measured twist, D66 = (1 - nu_D)/2 sqrt(D11 D22), which an isotropic sheet has.
#pragma once

#include <array>
#include <filesystem>
#include <numbers>
#include <optional>
#include <string>

#include "base/types.hpp"
#include "energy/yarn_law.hpp"

namespace voile::input {

/// Change of shear angle over which the force goes from one side of the loop to the other [rad].
inline constexpr double typical_shear_spread = 0.5 * std::numbers::pi / 180.0;

struct Fabric {
  std::string name, description;
  double areal_density = 0.0;       ///< [kg/m^2]
  std::optional<double> thickness;  ///< [m]
  double membrane_warp = 0.0, membrane_weft = 0.0, membrane_shear = 0.0;
  double membrane_poisson = 0.0;
  /// Measured curves of tension along warp and weft and of shear over the strains of the solver [N/m]; their tangents at zero are the
  /// membrane stiffness.
  std::array<std::optional<energy::YarnCurve>, 3> curves{};
  std::optional<energy::YarnCurve> rubbing_shear;  ///< beside friction, so that the curve is the middle of the loop
  std::optional<double> shear_hysteresis, shear_hysteresis_5;  ///< 2HG and 2HG5 of KES [N/m]
  double shear_hysteresis_spread = typical_shear_spread;       ///< [rad]
  double bending_warp = 0.0, bending_weft = 0.0;
  std::optional<double> bending_twist;
  double bending_poisson = 0.0;
  std::optional<double> bending_hysteresis;  ///< 2HB, width of the loop of moment per width over curvature [N]
  std::optional<double> bending_hysteresis_weft, bending_hysteresis_twist;  ///< where they differ; twist: 0
  std::optional<double> bending_hysteresis_spread;                          ///< [1/m]
};

/// Throws UserError naming file, line and key. Every figure must have its source in the table [sources].
[[nodiscard]] Fabric parse_fabric(const std::string& text, const std::filesystem::path& file);
[[nodiscard]] Fabric read_fabric(const std::filesystem::path& file);

/// A and D with the warp as axis 1 and the weft as axis 2. With `friction`, G without a curve is the slope of the loop that goes
/// out, from which that of the slider is taken off.
[[nodiscard]] Mat3 membrane_stiffness(const Fabric& fabric, bool friction = false);
/// What curves, and on request the friction of shear, add to A [N/m].
[[nodiscard]] energy::YarnLaw yarn_law(const Fabric& fabric, bool friction);
/// Keys of the curves, each with its table, as TOML.
inline constexpr std::array curve_keys{"tension_warp", "tension_weft", "shear_curve"};
[[nodiscard]] Mat3 bending_stiffness(const Fabric& fabric);
/// beta [s] that loses in a cycle, at the curvature 1/l and the circular frequency sqrt(g/l) with which the fabric
/// hangs under its own weight, what the loop of its hysteresis encloses: beta = 4 HB l^(3/2) / (pi B sqrt(g)), with the
/// bending length l = (B / (rho_s g))^(1/3) and B the geometric mean of both directions. Without a measured loop, 2HB/B
/// is typical_hysteresis.
[[nodiscard]] double bending_damping(const Fabric& fabric);
/// 2HB of warp, weft and twist [N]. Throws UserError without a place if there is none.
[[nodiscard]] Vec3 bending_loop(const Fabric& fabric);
/// Change of curvature over which loops of KES turn [1/m].
inline constexpr double typical_spread = 10.0;
inline constexpr double typical_hysteresis = 46.0;  ///< [1/m], see docs/reference/fabrics.md

}  // namespace voile::input
