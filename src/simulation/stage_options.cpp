#include "stage_options.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/petsc.hpp"
#include "solve/load_path.hpp"
#include "voile/errors.hpp"

namespace voile::simulation {

namespace {

void check_path(const input::Case& c) {
  using Control = solve::StaticOptions::Control;
  using Answer = solve::StaticOptions::AtCriticalPoint;
  const solve::StaticOptions& s = c.steps;
  if (s.control == Control::load && s.at_critical_point != Answer::pass)
    throw UserError("-path_at_critical_point: load control cannot stop or branch there; add -path_control arc_length");
  if (s.control == Control::displacement && s.at_critical_point == Answer::switch_branch)
    throw UserError("-path_at_critical_point: a branch is followed under -path_control arc_length only");
  if (s.control == Control::load) return;
  if (c.contact.input.active && c.analysis == input::Analysis::statics)
    throw UserError("-path_control: contact in a static path needs load");
  if (!s.stops.empty())
    throw UserError("-path_control: [steps] stops are load factors and belong to load; remove one of the two");
  const auto moves = [](const auto& held) { return held.motion || held.rotation; };
  if (c.analysis == input::Analysis::statics && std::any_of(c.supports.begin(), c.supports.end(), moves))
    throw UserError("-path_control: a [[support]] that moves with the load factor needs load");
}

void read_end(solve::TimeOptions& options) {
  PetscReal end = options.end_time;
  VOILE_PETSC(PetscOptionsGetReal(nullptr, nullptr, "-ts_max_time", &end, nullptr));
  if (!(end > 0.0)) throw UserError(fmt::format("-ts_max_time {}: must be > 0 s", end));
  options.end_time = end;
}

}  // namespace

void take_options(MPI_Comm comm, input::Case& c) {
  solve::read_path_options(comm, c.steps);
  check_path(c);
  if (c.finds_modes()) {
    c.steps.final_load_factor = c.eigen.load_factor;
    std::erase_if(c.steps.stops, [&](double stop) { return stop > c.eigen.load_factor; });
  }
  const double end = c.time.options.end_time;
  if (c.analysis == input::Analysis::dynamic) read_end(c.time.options);
  if (c.is_staged()) c.time.options.end_time = std::min(c.time.options.end_time, end);  // -ts_max_time is for all
}

}  // namespace voile::simulation
