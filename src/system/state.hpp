// The state of a sheet between two steps: all that a step advances.
//
// Symbols   u, v, a   displacement [m], velocity [m/s] and acceleration [m/s^2], unknowns of the model it belongs to
//                     (dofs.hpp)
//           t, lambda time [s] and load factor
// Only a stepper (solve/stepper.hpp), or what opens a new epoch, writes it. A checkpoint is a state with its mesh
// (results/checkpoint.hpp).
// Theory: docs/theory/time-integration.md.
#pragma once

#include <cmath>
#include <vector>

#include "attachments.hpp"
#include "base/petsc.hpp"
#include "contact_memory.hpp"
#include "dofs.hpp"
#include "energy_balance.hpp"

namespace voile::system {

/// Meshes that a run has had besides the first.
struct Remeshings {
  int count = 0;
  double too_long = 0.0,
         too_short = 0.0;       ///< fractions of vertices that the last one could not put right (adapt/sizing.hpp)
  int wait = 0, next_step = 0;  ///< after a refusal: looks to let pass, and the step from which it is tried again
};

/// What the solution of linear systems goes by from step to step.
struct SolverMemory {
  int positive_tangents = 0;  ///< to come before the exact one is tried again
  int factors_left = 0;       ///< tangents to be factored before iterations are tried again
  int wait = 0;               ///< how many they were at first; 0: iterations have not failed since they last worked
};

/// What central differences go by: the largest circular frequency when it was last looked for, steps to the next look and
/// between two, the limit last printed.
struct StabilityMemory {
  double frequency = 0.0;  ///< [1/s]; 0: not known
  int left = 1, wait = 1;
  double said = 0.0;  ///< [s]
};
constexpr std::size_t stability_numbers = 4;
/// Nothing where there is nothing to remember.
[[nodiscard]] inline std::vector<double> numbers_of(const StabilityMemory& m) {
  if (!(m.frequency > 0.0 && std::isfinite(m.frequency))) return {};
  return {m.frequency, static_cast<double>(m.left), static_cast<double>(m.wait), m.said};
}
/// Nothing is remembered if there are no numbers.
[[nodiscard]] inline StabilityMemory stability_of(const std::vector<double>& n) {
  if (n.size() != stability_numbers) return {};
  return {n[0], static_cast<int>(n[1]), static_cast<int>(n[2]), n[3]};
}

/// What a path goes by besides its last two states (solve/path_following.hpp); all of it outlives a mesh.
struct PathMemory {
  int steps = 0;  ///< accepted since the path began or was gone on with
  double unit =
      0.0;  ///< arc length of the step whose size is 1; under load control -1 times the last step; 0: none yet
  double rate = 0.0;          ///< dlambda/ds, whose sign changes at limit points; 0: not known
  long negative_pivots = -1;  ///< of the tangent at the state; -1: not known
  bool has_branched = false;
  double doubted = 0.0;  ///< length of a step that has led off the path where this one may turn back; 0: none
};
constexpr std::size_t path_numbers = 6;
/// Nothing where there is nothing to remember.
[[nodiscard]] inline std::vector<double> numbers_of(const PathMemory& p) {
  if (p.steps == 0 && p.unit == 0.0) return {};
  return {static_cast<double>(p.steps), p.unit,   p.rate, static_cast<double>(p.negative_pivots),
          p.has_branched ? 1.0 : 0.0,   p.doubted};
}
/// Nothing is remembered if there are no numbers.
[[nodiscard]] inline PathMemory path_of(const std::vector<double>& n) {
  if (n.size() != path_numbers) return {};
  return {static_cast<int>(n[0]), n[1], n[2], static_cast<long>(n[3]), n[4] > 0.0, n[5]};
}

/// The size of the step to come and, where a path has them, the numbers of its memory, else zeros.
constexpr std::size_t path_record_numbers = 1 + path_numbers;
[[nodiscard]] inline std::vector<double> path_record(double next_step, const PathMemory& p) {
  std::vector<double> record = numbers_of(p);
  record.resize(path_numbers, 0.0);
  record.insert(record.begin(), next_step);
  return record;
}

/// Where the last step of a motion began: damping and drag, and so reactions, depend on it.
struct StepStart {
  petsc::VecHandle u, v;  ///< none: not known
  double time = 0.0;      ///< [s]
  double size = 0.0;      ///< that rates of that step are of [s]
};

struct State {
  int step = 0;  ///< accepted steps so far
  double time = 0.0, load_factor = 0.0;
  double next_step = 0.0;  ///< size of the step to come: of time [s], of a path; 0: as the options say
  petsc::VecHandle u;
  petsc::VecHandle v, a;      ///< none: at rest; to be found from the equations
  petsc::VecHandle previous;  ///< u one step before, which gives a path its direction; none: it begins here
  StepStart last = {};
  bool in_equilibrium = true;  ///< false: after motion, or in a shape that was given
  ContactMemory contact = {};
  Remeshings remeshings = {};
  SolverMemory solver = {};
  PathMemory path = {};
  StabilityMemory stability = {};
  petsc::VecHandle stiffest;         ///< mode of stability.frequency; none: not known
  EnergyBalance balance = {};        ///< of a motion, where it is kept
  std::vector<Anchor> anchors = {};  ///< alike on all ranks
};

/// The unloaded state of a model at rest. Collective.
[[nodiscard]] inline State state_at_rest(const Dofs& dofs) {
  State s;
  s.u = dofs.create_vector();
  return s;
}

}  // namespace voile::system
