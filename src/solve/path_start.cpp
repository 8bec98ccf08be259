// Path following: the start of a path, at its beginning or where another run has ended.
#include <fmt/format.h>

#include "path_following_impl.hpp"
#include "voile/errors.hpp"

namespace voile::solve {

/// Without the tangent.
void PathFollower::Impl::start_from(const system::State& state) {
  VOILE_PETSC(VecCopy(state.u, accepted));
  factor = state.load_factor;
  steps = state.step;
  if (state.previous) VOILE_PETSC(VecWAXPY(previous, -1.0, state.previous, state.u));
  model.conditions().set_load_factor(factor);
  model.residual(state.u, residual);
  force = model.force_scale();
}

void PathFollower::Impl::begin(const system::State& state, StepResult& r) {
  start_from(state);
  tangent = tangent_at(state.u);
  if (!tangent.good) {
    double size = 0.0;
    model.load_direction(state.u, load_solution);
    VOILE_PETSC(VecNorm(load_solution, NORM_INFINITY, &size));
    if (size == 0.0 && model.potential().natural_growth() == 0.0)
      throw UserError(
          "[steps] control: no load and no temperature grows with the load factor at the start of the path; leave out "
          "`constant`, give a [[load]], or choose \"load\"");
    throw UserError(
        "the tangent at the start of the path is singular, the linear solver does not solve it, or the load does "
        "nothing; check supports, loads and options -ksp_ and -pc_, or run `voile check`");
  }
  VOILE_PETSC(VecCopy(load_solution, tangent_solution));
  constexpr double noise = 1e-10;  // of the largest displacement
  double largest = 0.0;
  VOILE_PETSC(VecNorm(tangent_solution, NORM_INFINITY, &largest));
  if (options.control == Control::displacement && !(std::abs(probed(tangent_solution)) > noise * largest))
    throw UserError(
        "[steps] control_probe: loads and temperatures do not move it at the start of the path; name a probe that "
        "moves, add an [[imperfection]], or use control = \"arc_length\"");
  require_motion(largest);
  const system::PathMemory& memory = state.path;
  unit = std::abs(options.final_displacement);
  if (options.control == Control::arc_length) unit = memory.unit > 0.0 ? memory.unit : tangent.speed;
  length = (state.next_step > 0.0 ? std::min(state.next_step, options.max_step) : options.initial_step) * unit;
  doubted = memory.doubted;
  may_branch = options.at_critical_point == AtCriticalPoint::switch_branch && !memory.has_branched;
  if (remark && may_branch && tangent.negative_pivots > 0)
    remark(
        "the start is beyond a critical point, so that the path does not leave its branch there: begin at an earlier "
        "step");
  if (remark && !state.previous && options.final_displacement != 0.0 &&
      (options.final_displacement - probed(accepted)) * probed(load_solution) < 0.0)
    remark(options.control == Control::arc_length
               ? "at first the loads move control_probe away from final_displacement; if the path does not turn, "
                 "reverse the loads"
               : "the loads move control_probe away from final_displacement: load factors decrease at the start of the "
                 "path");
  if (memory.rate == 0.0 || !state.previous) return;
  // Another mesh may have its critical point on the other side of the state.
  rate = std::copysign(1.0 / tangent.speed, dot(previous, load_solution));
  const auto kind = kind_between(memory.rate, memory.negative_pivots, rate, tangent.negative_pivots);
  if (!kind) return;
  r.critical = {*kind, steps, factor};
  if (remark) remark(fmt::format("{} at about load factor {:.6g}, between two meshes", name(*kind), factor));
}

/// Arcs of round-off lead anywhere.
void PathFollower::Impl::require_motion(double speed) const {
  constexpr double moved = 1e-11;  // of the extent, at the end of the path
  if (options.control == Control::arc_length && options.final_displacement == 0.0 &&
      speed * std::abs(options.final_load_factor) < moved * model.dofs().mesh().extent())
    throw UserError(
        "[steps] control = \"arc_length\": loads and temperatures do not move the sheet at the start of the path, "
        "which has no "
        "length until it buckles; add an [[imperfection]], find where by analysis = \"buckling\", or use control = "
        "\"load\"");
}

}  // namespace voile::solve
