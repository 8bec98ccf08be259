// Linear elastic sheet: membrane and bending stiffness per unit width in a material frame.
//
// Symbols   A   membrane stiffness, N = A E, Voigt order (11, 22, 12), E with engineering shear   3x3 [N/m]
//           D   bending stiffness, M = D kappa, kappa = (k11, k22, 2 k12)                          3x3 [N m]
//           B   coupling of both: N = A E - B kappa, M = D kappa - B E (the strain at height z is E - z kappa) 3x3 [N]
//           rho_s  mass per unit area                                                              [kg/m^2]
// Isotropic plate of thickness h:  A = E h/(1-nu^2) [1 nu 0; nu 1 0; 0 0 (1-nu)/2],  D = A h^2/12.
// Source: Jones, Mechanics of Composite Materials, 2nd ed. (1999), chapter 4.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/types.hpp"
#include "failure.hpp"
#include "hyperelastic.hpp"
#include "yarn_law.hpp"

namespace voile::energy {

/// A layer through the thickness, for stresses.
struct Layer {
  double low = 0.0, high = 0.0;   ///< distances from the middle along the normal [m]
  Mat3 stiffness = Mat3::Zero();  ///< plane stress Q in material axes [Pa]
  Vec3 expansion = Vec3::Zero();  ///< strain per kelvin in material axes [1/K]
  double angle = 0.0;             ///< from material axis 1 to the fibres [rad]
};

/// Friction of the yarns of a fabric where they bend: a spring and a slider each (yarn_friction.hpp).
struct YarnFriction {
  /// Along warp, along weft and in twist.
  struct Slider {
    Vec3 stiffness = Vec3::Zero();  ///< D_s [N m]
    Vec3 limit = Vec3::Zero();      ///< HB [N]; 0: none in that direction
  };
  double warp_angle = 0.0;      ///< from material axis 1 to the warp [rad]
  std::vector<Slider> sliders;  ///< empty: no friction
};

struct Material {
  std::vector<std::string> groups;     ///< surface groups it covers; empty: every triangle not covered by another
  Mat3 membrane = Mat3::Zero();        ///< A [N/m]
  Mat3 bending = Mat3::Zero();         ///< D [N m]
  Mat3 coupling = Mat3::Zero();        ///< B [N]
  double areal_density = 0.0;          ///< rho_s [kg/m^2]
  double bending_damping = 0.0;        ///< damping in proportion to D, besides what holds for all materials [s]
  double viscous_time = 0.0;           ///< relaxation time of the membrane, likewise [s]
  YarnFriction friction{};             ///< inside the fabric, where it bends
  YarnLaw yarns{};                     ///< what tension and shear add to A, and friction of shear
  Hyperelastic rubber{};               ///< law of large strains instead of A, which is its tangent at zero strain
  std::vector<Layer> layers{};         ///< from the lowest up; empty where the inside is not known
  std::optional<Strength> strength{};  ///< of its layers
  // The natural state (natural_state.hpp), in material axes
  bool expands = false;                     ///< an expansion is given
  Vec3 expansion = Vec3::Zero();            ///< strain per change of temperature [1/K]
  Vec3 expansion_curvature = Vec3::Zero();  ///< curvature per difference between top and bottom [1/(m K)]
  Vec3 coupled_curvature = Vec3::Zero();    ///< curvature per change, and strain per difference, where B is not 0
  Vec3 coupled_strain = Vec3::Zero();
  Vec3 initial_strain = Vec3::Zero();  ///< of the natural state from the rest shape
  Vec3 prestress = Vec3::Zero();       ///< membrane force of the rest shape [N/m]
  /// Direction of material axis 1 in the chart, i.e. in space where the positions are the rest shape, projected into each
  /// triangle. Without it the axis is arbitrary, which only
  /// an isotropic material allows.
  std::optional<Vec3> direction;
  /// The same in the texture coordinates (u, v) of the mesh, for garments cut from flat pieces; instead of `direction`.
  std::optional<Vec2> texture_direction;
};

/// A and D of an isotropic plate. E [Pa], nu, h [m].
[[nodiscard]] Mat3 isotropic_membrane(double youngs_modulus, double poisson_ratio, double thickness);
[[nodiscard]] Mat3 bending_from_membrane(const Mat3& membrane, double thickness);
/// A of an orthotropic plate in its own axes: E1, E2 [Pa], nu12, G12 [Pa], h [m].
[[nodiscard]] Mat3 orthotropic_membrane(double e1, double e2, double nu12, double g12, double thickness);
/// One ply of a laminate.
struct Ply {
  double angle = 0.0;      ///< from material axis 1 to the fibres [rad]
  double thickness = 0.0;  ///< [m]
};
/// Classical lamination theory: A = sum Q t, B = sum Q (z1^2 - z0^2)/2, D = sum Q (z1^3 - z0^3)/3 about the middle of
/// the stack, Q the ply's plane-stress stiffness turned by its angle (Jones, Mechanics of Composite Materials, 2nd ed.
/// 1999, chapters 2 and 4).
struct LaminateStiffness {
  Mat3 membrane = Mat3::Zero();  ///< A [N/m]
  Mat3 coupling = Mat3::Zero();  ///< B [N]
  Mat3 bending = Mat3::Zero();   ///< D [N m]
  double thickness = 0.0;        ///< of the stack [m]
  std::vector<Layer> layers;
};
/// `ply_stiffness` is that of the ply's material in its own axes per thickness [Pa]; plies from the lowest z up.
[[nodiscard]] LaminateStiffness laminate(const Mat3& ply_stiffness, const std::vector<Ply>& plies);
/// A layer that is fused to a sheet.
struct FusedLayer {
  Mat3 membrane, bending;      ///< A_2 [N/m], D_2 [N m], in the axes of the material
  double areal_density = 0.0;  ///< [kg/m^2]
  double distance = 0.0;       ///< of the middles of both, h [m]
  double bond = 1.0;           ///< b: 1 glued, 0 the layers slide
};
/// A = A_1 + A_2, D = D_1 + D_2 + b h^2 (A_1^-1 + A_2^-1)^-1: the bending stiffness at free stretch, whatever the sense of the
/// curvature, of a laminate whose layers are h apart (D - B A^-1 B of Jones, chapter 4). The sheet lies in the neutral
/// surface of both, so that nothing couples stretching and bending; exact where A_1 and A_2 are in proportion.
void fuse(Material& material, const FusedLayer& layer);
/// Sliders of loops of width 2HB [N] along warp, along weft and in twist, whose moments turn over a mean change of curvature `spread`
/// [1/m]: `count` of HB/count each, and the j-th over 2 j spread/(count + 1).
[[nodiscard]] std::vector<YarnFriction::Slider> sliders_of(const Vec3& loop, double spread, int count);
/// Strains or curvatures in axes of which the first lies at `angle` [rad], from those in the axes given: (11, 22, 2 12).
[[nodiscard]] Mat3 turned_strain(double angle);
/// Stiffness of a material whose axis 1 lies at `angle` [rad] to the axes wanted.
[[nodiscard]] Mat3 rotated_stiffness(const Mat3& stiffness, double angle);
/// Strain (engineering shear) and membrane force in axes to which those of the material, in which they are given, lie at
/// `angle` [rad].
[[nodiscard]] Vec3 rotated_strain(const Vec3& strain, double angle);
[[nodiscard]] Vec3 rotated_force(const Vec3& force, double angle);
/// Expansion and its curvature of a material with layers from that of each [1/K] in its own axes, at `angles` [degree] to those
/// of the material; no angles: along them. The free plate has no resultants: (e, k) is released() of sum Q a t and
/// -sum Q a (z1^2 - z0^2)/2 for a change, of sum Q a (z1^2 - z0^2)/(2 h) and -sum Q a (z1^3 - z0^3)/(3 h) for a difference.
void set_expansion(Material& material, const Vec3& expansion, const std::vector<double>& angles);
/// Strain and curvature under a membrane force N [N/m] and a moment M [N]: A e - B k = N, D k - B e = M.
struct Released {
  Vec3 strain, curvature;
};
[[nodiscard]] Released released(const Material& material, const Vec3& force, const Vec3& moment);
/// Whether stretching bends it.
[[nodiscard]] inline bool couples(const Material& material) {
  return !material.coupling.isZero(0.0);
}
/// Whether every strain and curvature costs energy: whether [A, -B; -B, D] is positive definite.
[[nodiscard]] bool is_stable(const Material& material);
/// True if the symmetric part of m has only positive eigenvalues.
[[nodiscard]] bool is_positive_definite(const Mat3& m);

}  // namespace voile::energy
