// What a run, or a stage of it, came to.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/types.hpp"
#include "discretisation_error.hpp"
#include "energy_text.hpp"
#include "garment_measures.hpp"
#include "solve/stepper.hpp"
#include "system/contact_report.hpp"
#include "system/energy_balance.hpp"

namespace voile::record {

/// What all remeshings of a stage came to; on rank 0.
struct RemeshingEffort {
  int count = 0, refused = 0;  ///< meshes taken over; looks after which the run kept the mesh it had
  int attempts = 0;            ///< new meshes and models made, refused ones included: up to two per look
  double seconds = 0.0;        ///< CPU time of rank 0, looks and new models included [s]
  double fraction = 0.0;       ///< of the CPU time that rank 0 took for the stage
};

/// The ply that is nearest to failure.
struct FirstFailure {
  double index = 0.0;         ///< 1 at failure; stresses may grow by 1/index
  int ply = 0;                ///< from 1, the lowest
  bool top = false;           ///< on its upper face
  Vec3 place = Vec3::Zero();  ///< middle of the triangle [m]
};

/// Vibration of one component of a probe.
struct ResponsePeak {
  std::string column, unit;                                 ///< m, N, Pa
  double amplitude = 0.0, frequency = 0.0;                  ///< the largest, where [Hz]
  double acceleration = 0.0, acceleration_frequency = 0.0;  ///< of a displacement, likewise [m/s^2]
  std::optional<double> mean = {}, mean_acceleration = {};  ///< root mean squares of a random vibration
};

/// What summary.json says.
struct Summary {
  bool converged = false;
  std::string reason;        ///< why not
  std::string element;       ///< its type, as in the case file
  long angle_triangles = 0;  ///< that bend by angles at edges
  double load_factor = 0.0;
  int steps = 0, newton_iterations = 0, factorisations = 0;
  solve::IterativeEffort iterative;
  std::vector<solve::CriticalPoint> critical;
  std::vector<double> eigen;         ///< frequencies or critical load factors
  double time = 0.0;                 ///< reached in a motion [s]
  long negative_pivots = -1;         ///< of the last tangent: the last state is unstable if > 0; -1: not known
  std::optional<double> eigenvalue;  ///< of a drape: nearest to zero, of the tangent in the lumped mass [1/s^2]
  bool unstable = false;             ///< load control has ended in an unstable equilibrium
  bool keeps_state = false;          ///< of modes or a response, which leave the equilibrium as it is
  double residual = 0.0;             ///< relative, of the last state
  double membrane_error = 0.0;  ///< energy that should not be there over that stored, see Warnings::membrane_error()
  DiscretisationError::Fractions recovery_error;   ///< of the last state
  double largest_recovery_error = 0.0;             ///< on the way
  std::vector<double> mode_errors;                 ///< of eigen: relative, by recovery
  std::vector<std::vector<double>> mode_shapes{};  ///< vertices x 3, for later stages where no file keeps them; rank 0
  std::vector<ResponsePeak> response;              ///< of an analysis of frequencies
  long unknowns = 0;
  Index vertices = 0, triangles = 0;
  int ranks = 1;
  double cpu_seconds = 0.0, wall_seconds = 0.0;
  system::EnergyBalance balance;                 ///< of a motion
  double round_off_energy = 0.0;                 ///< that is none, see round_off_energy() [J]
  std::optional<KineticEnergy> kinetic;          ///< of a motion
  std::optional<system::ContactReport> contact;  ///< of the last state
  std::optional<FirstFailure> failure;           ///< of the last state, with strengths
  std::optional<GarmentMeasures> garment;        ///< of a case of panels
  std::optional<RemeshingEffort> remeshing;      ///< of a stage that looks whether it needs another mesh
};

/// summary.json in the folder of a run or stage. Not collective: call on one rank. Throws UserError.
void write_summary(const std::filesystem::path& folder, const Summary& s);

/// The same over stages by name, after those that an earlier run has left (`kept`); `of`: how many were to be run.
void write_stages(const std::filesystem::path& folder, const std::vector<std::string>& kept,
                  const std::vector<std::pair<std::string, Summary>>& stages, std::size_t of);

/// Whether the summary in a folder says that its run or stage has come to its end. Not collective.
[[nodiscard]] bool has_converged(const std::filesystem::path& folder);

}  // namespace voile::record
