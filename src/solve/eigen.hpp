// Modes of vibration and of linear buckling about an equilibrium, through SLEPc's EPS.
//
// Symbols     K exact tangent at the equilibrium (a, lambda);  M mass, consistent or lumped;
//             x_f = K^-1 f, f = -dr/dlambda
// Vibration   K phi = omega^2 M phi;  frequency = omega/(2 pi), from the smallest omega^2 up (negative: unstable, then
//             the frequency is given as negative: -sqrt(-omega^2)/(2 pi))
// Buckling    (K + mu K') phi = 0,  K' what the load changes of K (load_stiffness.hpp),  critical load factor lambda + mu, from
//             the smallest mu > 0 up; solved as -K' phi = (1/mu) K phi, so that only K is factored.
// Sylvester's law counts the modes before the last one found; what is missing of equal eigenvalues is looked for.
// About an unstable state the target of the spectral transformation falls until no eigenvalue is below it (Sylvester); with loads
// that follow without a potential, the modes nearest to omega^2 = 0 are found.
// Fixed components are left out: zero rows in M and K'.
// Options of SLEPc's EPS and ST work as users know them: -eps_nev, -eps_tol, -eps_target, -eps_monitor, -eps_view ...
// Theory: docs/theory/path-following.md, modes.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "newton.hpp"
#include "system/dynamics.hpp"
#include "system/rigid_inertia.hpp"

namespace voile::solve {

struct Mode {
  double eigenvalue = 0.0;  ///< omega^2 [1/s^2], or 1/mu
  double imaginary = 0.0;   ///< of it: not 0 where loads without a potential make it grow (flutter)
  double value = 0.0;       ///< frequency [Hz], or critical load factor
  double residual = 0.0;    ///< backward error: |A x - theta B x| / ((|A| + |theta| |B|) |x|)
  petsc::VecHandle shape;   ///< unknowns, the largest displacement 1
};

/// Whether its imaginary part is more than round-off.
[[nodiscard]] inline bool is_complex(const Mode& mode) {
  return std::abs(mode.imaginary) > 1e-6 * std::abs(mode.eigenvalue);
}

struct EigenResult {
  std::vector<Mode> modes;
  int asked_for = 0;          ///< options may ask for another number than the caller
  long missed = 0;            ///< modes that are there before the last, by Sylvester's law, and have not been found
  long lower = 0;             ///< modes below the first that -eps_target leaves out
  long negative = 0;          ///< modes of vibration that grow: the equilibrium is unstable
  double nonlinearity = 0.0;  ///< of the response to the load up to the first mode of buckling, by its first correction
  petsc::VecHandle response;  ///< of buckling: what a load factor of 1 adds to the unknowns, to first order; else null
};

/// M, with zero rows where the displacement is fixed. [kg]
class MassMatrix {
 public:
  /// In the state `a`. Collective. Throws UserError if a material has no mass.
  MassMatrix(system::Model& model, Vec a, system::Mass kind);
  [[nodiscard]] Mat mat() const { return consistent_ ? consistent_->mat() : static_cast<Mat>(lumped_); }
  /// The consistent one; null: it is lumped.
  [[nodiscard]] const system::BlockMatrix* blocks() const { return consistent_ ? &*consistent_ : nullptr; }

 private:
  petsc::MatHandle lumped_;
  std::optional<system::BlockMatrix> consistent_;
};

/// A shift below the lowest mode of a plate as large as the model, so that K + shift M can be factored for free bodies.
/// [1/s^2]
[[nodiscard]] double small_shift(const system::Model& model);

/// As many modes as there are. Collective.
[[nodiscard]] long free_unknowns(const system::Model& model);

/// Lowest `count` modes of vibration about `a` at the model's load factor. Collective.
/// Throws UserError if a material has no mass.
[[nodiscard]] EigenResult vibration_modes(system::Model& model, Vec a, int count, Mat mass);
[[nodiscard]] EigenResult vibration_modes(system::Model& model, Vec a, int count, system::Mass mass);
/// Lowest `count` critical load factors beyond the model's load factor. Collective.
/// Throws UserError if the equilibrium is unstable or no load grows with the load factor.
[[nodiscard]] EigenResult buckling_modes(Newton& newton, system::Model& model, Vec a, int count);

/// How much a mode takes part in the rigid motions of RigidInertia; symbols there.
struct Participation {
  double mass = 0.0;                                           ///< m, with the largest displacement of the mode 1 [kg]
  std::array<double, system::RigidInertia::motions> factor{};  ///< L_k/m
  std::array<double, system::RigidInertia::motions> effective{};  ///< L_k^2/m; not a number: not known [kg], [kg m^2]
};
/// Of each mode. Collective.
[[nodiscard]] std::vector<Participation> participation(const std::vector<Mode>& modes, Mat mass,
                                                       const system::RigidInertia& inertia);

}  // namespace voile::solve
