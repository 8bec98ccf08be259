// Frequency response: amplitudes of probes and fields under loads or a base that vibrate.
#pragma once

#include "input/case.hpp"
#include "record/run_options.hpp"
#include "record/summary.hpp"
#include "solve/eigen.hpp"
#include "system/model.hpp"

namespace voile::simulation {

/// Modes of vibration about a state, and what they were found with.
struct VibrationModes {
  solve::MassMatrix mass;
  system::RigidInertia inertia;
  solve::EigenResult result;
};

/// How far above the highest frequency of the response modes are needed.
inline constexpr double mode_margin = 1.5;

/// response.csv and fields of the vibration about the state `a`, and its peaks in the summary. Collective. Throws UserError where the
/// response is not determined.
void run_harmonic(const input::Case& c, const record::RunOptions& options, system::Model& model, Vec a,
                  const VibrationModes& modes, record::Summary& summary);

}  // namespace voile::simulation
