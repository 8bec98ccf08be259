// A state with its mesh, to continue from on any number of ranks.
#pragma once

#include <filesystem>
#include <vector>

#include "mesh/surface_mesh.hpp"

namespace voile::results {

/// Values are vertices x 3, global axes, mesh order.
struct Checkpoint {
  int step = 0;
  double time = 0.0, next_step = 0.0;  ///< [s]
  double load_factor = 0.0;
  bool in_equilibrium = true;
  std::vector<double> displacement{};       ///< [m]; empty: none
  std::vector<double> velocity{};           ///< [m/s]; empty: at rest
  std::vector<double> acceleration{};       ///< [m/s^2]; empty: to be found from the equations
  std::vector<double> previous{};           ///< displacement one step before [m]; empty: a path begins here
  std::vector<double> previous_velocity{};  ///< of a motion [m/s]; empty: none
  /// Time and size of the last step of a motion (system::StepStart), whose start is `previous`; empty: none.
  std::vector<double> step_start{};
  /// Smallest gap of each vertex where contact is let out from, and since when; empty: nothing is let out.
  std::vector<double> contact_gaps{};  ///< [m]
  double contact_start = 0.0;          ///< [s]
  /// Normal contact force on each vertex at the end of a stage, see system::ContactMemory; empty: not kept.
  std::vector<double> contact_push{};  ///< [N]
  /// Obstacles that each vertex passes through, see system::ContactMemory; empty: none.
  std::vector<double> passing{};
  std::vector<double> anchors{};                          ///< of attachments, see system::numbers_of; empty: none
  std::vector<double> energy_balance{};                   ///< see system::numbers_of; empty: not kept
  std::vector<double> bodies{};                           ///< unknowns of rigid bodies, see remesh/carry; empty: none
  std::vector<double> places{};                           ///< where these are, see system/rigid_places; empty: none
  std::vector<double> slips{};                            ///< see system::Potential::slips; empty: none
  std::vector<double> leaks{};                            ///< see system::BoundaryConditions::leaks; empty: none
  std::vector<double> path{};                             ///< system::PathMemory; empty: none
  std::vector<double> stability{};                        ///< system::StabilityMemory; empty: none
  std::vector<double> stiffest{};                         ///< mode of its frequency; empty: none
  std::vector<double> couplings{};                        ///< see system::Model::couplings
  int remeshings = 0;                                     ///< that led to its mesh
  double too_long = 0.0, too_short = 0.0;                 ///< what the last of them left, see system::Remeshings
  int remeshing_wait = 0, remeshing_step = 0;             ///< Remeshings::wait, next_step
  int positive_tangents = 0, factors_left = 0, wait = 0;  ///< see system::SolverMemory
};

/// Forgets what belongs to another mesh or step: the memory of central differences.
inline void forget_stability(Checkpoint& c) {
  c.stability.clear();
  c.stiffest.clear();
}

/// Replaces the file in one step: a kill leaves the old or the new one. Not collective: root only. Throws UserError.
void write_checkpoint(const std::filesystem::path& file, const Checkpoint& c, const mesh::SurfaceMesh& mesh);
/// The mesh of a checkpoint if remeshing has made it, otherwise none. Not collective: root only. Throws UserError.
[[nodiscard]] mesh::MeshData read_checkpoint_mesh(const std::filesystem::path& file);
/// Not collective: root only. Throws UserError if the file cannot be read or belongs to another mesh.
[[nodiscard]] Checkpoint read_checkpoint(const std::filesystem::path& file, const mesh::SurfaceMesh& mesh);

}  // namespace voile::results
