// Where the energy of a motion comes from and goes to.
//
// Symbols   K, U, E   kinetic energy, energy stored in the sheet (membrane, bending, springs), energy of barriers     [J]
//           u_0, u_1  start and end of a step, du = u_1 - u_0;  F(s) a force at the stage of the step (alpha_ts.hpp)
//   K + U + E - initial = loads + supports + obstacles - damping - drag - friction - fabric - numerical + remeshing + unaccounted
// Sums over the accepted steps, each of them a force at the stage times du. With y what is prescribed for obstacles,
//   numerical  = -(dK - du.M a(s)) - (dU - du.F_int(s) - dU|y) - (dE - du.F_c(s) - dy.dE/dy(s))
// With z(t) the places and lengths that are driven (attachments, bands, seams, clamps that turn), z_0 and z_1 at the start and end:
//   supports += 1/2 [U(u_0, z_1) - U(u_0, z_0) + U(u_1, z_1) - U(u_1, z_0)]
// which for a linear spring is its force in the middle of the step times the way of z: with either state alone, a sheet that
// goes along with z would be charged k/2 |dz|^2. The numerical part
// is what the scheme takes by evaluating inertia and stored energies at one place for a whole step. What is then left is
// the residual of the steps times du: what Newton's method leaves open, or a force that somebody forgot.
#pragma once

#include <vector>

namespace voile::system {

/// Sums since a motion began; none before. Alike on all ranks. [J]
struct EnergyBalance {
  bool kept = false;
  double initial = 0.0;                ///< K + U + E at the start
  double kinetic = 0.0, stored = 0.0;  ///< K and U + E in the last state
  double loads = 0.0;                  ///< work of loads
  double supports = 0.0;               ///< of what moves supports, clamps, attachments and seams
  double obstacles = 0.0;              ///< of what moves obstacles
  double damping = 0.0;                ///< taken by damping with mass and bending, and by viscosity
  double drag = 0.0, friction = 0.0;   ///< taken by the air (in wind it may give), and by friction
  double numerical = 0.0;              ///< taken by the scheme
  double remeshing = 0.0;              ///< given at once by new meshes and by supports that release
  double unaccounted = 0.0;
  double fabric = 0.0;      ///< taken by friction inside the fabric
  double inflow = 0.0;      ///< sum of what loads, supports, obstacles and wind gave in the steps in which they gave
  double most_taken = 0.0;  ///< largest `numerical` so far
  double created = 0.0;     ///< by which `numerical` fell below that at most: later losses do not undo it
  double internal = 0.0, barriers = 0.0;  ///< U and E in the last state, to the bit

  /// What fractions are taken of: all that was there or came in.
  [[nodiscard]] double turnover() const;
};

/// For files and other ranks; and back (none if there are none; older files have fewer).
[[nodiscard]] std::vector<double> numbers_of(const EnergyBalance& balance);
[[nodiscard]] EnergyBalance balance_of(const std::vector<double>& numbers);
/// How many numbers these are.
inline constexpr std::size_t balance_numbers = 18, fewest_balance_numbers = 13;

}  // namespace voile::system
