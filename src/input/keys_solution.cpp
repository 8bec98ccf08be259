// Keys of analyses, of motion in time, and of what is recorded.
#include "keys_common.hpp"

namespace voile::input {

namespace {

/// What a path is followed by, and where it ends.
std::vector<Key> end_keys(solve::StaticOptions& s) {
  return {
      {.name = "control",
       .slot = choice(s.control, {{"load", solve::StaticOptions::Control::load},
                                  {"displacement", solve::StaticOptions::Control::displacement},
                                  {"arc_length", solve::StaticOptions::Control::arc_length}}),
       .meaning = "What a step prescribes: `load` the load factor, `displacement` that of `control_probe`, "
                  "`arc_length` the distance between the states, which follows limit points and snap-back."},
      {.name = "final_load_factor",
       .slot = &s.final_load_factor,
       .meaning = "Load factor at the end of the run (with `final_displacement` that ends it instead).",
       .range = positive},
      {.name = "control_probe",
       .slot = &s.control_probe,
       .meaning = "Name of a displacement probe with one component. Needed for `displacement`; with `arc_length` it "
                  "belongs to `final_displacement`.",
       .absent = "none"},
      {.name = "final_displacement",
       .slot = &s.final_displacement,
       .meaning = "Displacement of `control_probe` at the end of the run, of either sign. 0: the run ends at "
                  "`final_load_factor`.",
       .unit = "m"},
      {.name = "initial_step",
       .slot = &s.initial_step,
       .meaning = "First increment of the load factor; a fraction of `final_displacement` under `displacement`; under "
                  "`arc_length` the length that this increment of the load factor has at the start. `min_step` and "
                  "`max_step` are in the same unit. `max_step` if that is smaller and this key is not given.",
       .range = positive}};
}

/// Steps on the way.
std::vector<Key> step_keys(solve::StaticOptions& s) {
  return {
      {.name = "max_steps",
       .slot = &s.max_steps,
       .meaning = "A path that has not ended after so many steps ends with exit code 3.",
       .range = {1}},
      {.name = "min_step",
       .slot = &s.min_step,
       .meaning = "A step that fails at this size ends the run with exit code 3.",
       .range = positive},
      {.name = "max_step",
       .slot = &s.max_step,
       .meaning = "Largest step. Not given, at least a tenth of the path; under `arc_length` 1e9, in practice none.",
       .range = positive},
      {.name = "stops",
       .slot = &s.stops,
       .meaning = "Load factors that a step ends on exactly, ascending; results are recorded there. `load` only.",
       .range = positive,
       .absent = "none"},
      {.name = "target_iterations",
       .slot = &s.target_iterations,
       .meaning = "A step that converges in fewer iterations lets the next one grow. Under `displacement` and "
                  "`arc_length`, 5 if this key is not given.",
       .range = {1}},
      {.name = "fallback",
       .slot = &s.fallback,
       .meaning = "Try pseudo-transient continuation before a step is made very small. `load` only."},
      {.name = "at_critical_point",
       .slot = choice(s.at_critical_point, {{"pass", solve::StaticOptions::AtCriticalPoint::pass},
                                            {"stop", solve::StaticOptions::AtCriticalPoint::stop},
                                            {"switch_branch", solve::StaticOptions::AtCriticalPoint::switch_branch}}),
       .meaning =
           "At a limit or bifurcation point: only report it, end the run there, or (the first bifurcation, under "
           "`arc_length`) leave along the lowest mode. `displacement` and `arc_length` only."},
      {.name = "branch_step",
       .slot = &s.branch_step,
       .meaning = "First step along the mode, in units of the step in force; its sign picks the side."}};
}

}  // namespace

std::vector<Key> keys_of(solve::StaticOptions& s) {
  return joined(end_keys(s), step_keys(s));
}

std::vector<Key> keys_of(EigenSection& s) {
  return {
      {.name = "modes",
       .slot = &s.modes,
       .meaning = "How many modes, lowest first. 0, in `harmonic` only and there if this key is not given: as many as "
                  "reach 1.5 times the highest frequency.",
       .range = {0}},
      {.name = "load_factor",
       .slot = &s.load_factor,
       .meaning = "Load factor of the equilibrium about which modes are found; the path of `steps` leads to it. 0: the "
                  "unloaded state (constant loads act), or the state that an earlier stage or a restart gives.",
       .range = not_negative},
      {.name = "mass",
       .slot = choice(s.mass, {{"consistent", system::Mass::consistent}, {"lumped", system::Mass::lumped}}),
       .meaning = "Mass matrix of `modal` and `harmonic`: consistent with linear displacements in the triangles, or "
                  "lumped at the "
                  "vertices (better for taut sheets, see docs/howto/find-modes.md)."}};
}

namespace {

/// The integrator and its steps.
std::vector<Key> integration_keys(solve::TimeOptions& o) {
  return {
      {.name = "method",
       .slot = choice(o.method, {{"alpha", solve::TimeOptions::Method::implicit_alpha},
                                 {"central_difference", solve::TimeOptions::Method::central_difference}}),
       .meaning =
           "`alpha`: implicit generalised-alpha. `central_difference`: explicit, steps below the stability limit."},
      {.name = "end", .slot = &o.end_time, .meaning = "End of the run.", .unit = "s", .range = positive},
      {.name = "step", .slot = &o.step, .meaning = "Size of the first step.", .unit = "s", .range = positive},
      {.name = "min_step",
       .slot = &o.min_step,
       .meaning = "A step that fails at this size ends the run with exit code 3. 0: a thousandth of `step`.",
       .unit = "s",
       .range = not_negative},
      {.name = "max_step",
       .slot = &o.max_step,
       .meaning = "Largest step. 0: `step`.",
       .unit = "s",
       .range = not_negative},
      {.name = "step_error",
       .slot = &o.step_error,
       .meaning = "Largest local error of any displacement in a step, which then sets the step. 0: not controlled.",
       .unit = "m",
       .range = not_negative},
      {.name = "spectral_radius",
       .slot = &o.radius,
       .meaning = "Spectral radius at infinite frequency: 1 no numerical dissipation, 0 the most. With contact, and "
                  "where a stage sews, 0 if this key is not given: what hits something in one step can leave it with 1 "
                  "+ 2 `spectral_radius` times its speed.",
       .range = {0, 1}}};
}

/// What ends a step, what moves, what is kept.
std::vector<Key> course_keys(TimeSection& s, system::Mass& mass) {
  solve::TimeOptions& o = s.options;
  return {
      {.name = "target_iterations",
       .slot = &o.target_iterations,
       .meaning =
           "A step that needs more iterations makes the next one smaller. With contact 25 if this key is not given.",
       .range = {1}},
      {.name = "velocity_tolerance",
       .slot = &o.velocity_tolerance,
       .meaning =
           "An increment of the iteration below this, as root mean square over the mass and per step, ends the step. "
           "0: `-snes_rtol` and `-snes_stol` alone decide. 3e-3 in stages that sew if this key is not given.",
       .unit = "m/s",
       .range = not_negative},
      {.name = "mass",
       .slot = choice(mass, {{"consistent", system::Mass::consistent}, {"lumped", system::Mass::lumped}}),
       .meaning = "Mass matrix: consistent with linear displacements in the triangles, or lumped at the vertices."},
      {.name = "load_history",
       .slot = &s.load_history,
       .meaning = "Load factor as an expression of the time t.",
       .absent = "1 throughout"},
      {.name = "checkpoint_steps",
       .slot = &s.checkpoint_steps,
       .meaning = "Write `checkpoint.h5` every so many steps of a motion. 0: not by steps.",
       .range = not_negative},
      {.name = "checkpoint_minutes",
       .slot = &s.checkpoint_minutes,
       .meaning = "Write `checkpoint.h5` after so many minutes. 0: not by time.",
       .unit = "min",
       .range = not_negative}};
}

}  // namespace

std::vector<Key> keys_of(TimeSection& s, system::Mass& mass) {
  return joined(integration_keys(s.options), course_keys(s, mass));
}

std::vector<Key> keys_of(InitialVelocity& s) {
  return {{.name = "group", .slot = GroupList{&s.group}, .meaning = "Any group.", .absent = "the whole surface"},
          {.name = "velocity", .slot = &s.velocity, .meaning = "Velocity of every vertex of the group.", .unit = "m/s"},
          {.name = "angular_velocity",
           .slot = &s.angular_velocity,
           .meaning = "Added turning: axis times speed, right-handed.",
           .unit = "rad/s"},
          {.name = "centre", .slot = &s.centre, .meaning = "A point on that axis.", .unit = "m"}};
}

std::vector<Key> damping_keys(system::DynamicsOptions& s) {
  return {{.name = "mass",
           .slot = &s.mass_damping,
           .meaning = "Damping in proportion to the mass, as by air at rest.",
           .unit = "1/s",
           .range = not_negative},
          {.name = "bending",
           .slot = &s.bending_damping,
           .meaning = "Damping in proportion to the constant bending stiffness.",
           .unit = "s",
           .range = not_negative},
          {.name = "membrane",
           .slot = &s.viscous_time,
           .meaning = "Relaxation time of the membrane (Kelvin-Voigt).",
           .unit = "s",
           .range = not_negative},
          {.name = "materials",
           .slot = &s.material_damping,
           .meaning = "Whether the materials' own damping (`bending_damping` and `membrane_damping` of `[[material]]`, "
                      "which a `fabric` always has) acts besides."},
          {.name = "ratio",
           .slot = &s.ratios,
           .meaning = "Damping ratio of the modes in `harmonic`: a list with one number for all, or one for each mode, "
                      "the last for all after it. 0.02 is 2 % of critical. Acts besides the keys above.",
           .range = {0, 1},
           .absent = "none"}};
}

std::vector<Key> keys_of(energy::DragOptions& s) {
  return {{.name = "density", .slot = &s.air_density, .meaning = "Of the air.", .unit = "kg/m^3", .range = positive},
          {.name = "normal_drag",
           .slot = &s.normal,
           .meaning = "Drag coefficient of the air that moves across the surface; 0: none.",
           .range = not_negative},
          {.name = "tangential_drag",
           .slot = &s.tangential,
           .meaning = "Drag coefficient of the air that moves along the surface; 0: none.",
           .range = not_negative},
          {.name = "wind",
           .slot = &s.wind_texts,
           .meaning = "Velocity of the air: three numbers, or expressions of the time t such as `\"5 + 2*sin(t)\"`.",
           .unit = "m/s"}};
}

std::vector<Key> keys_of(solve::DrapeOptions& s) {
  return {{.name = "max_iterations",
           .slot = &s.max_iterations,
           .meaning = "Iterations of one search for an equilibrium, falls included.",
           .range = {1}},
          {.name = "max_escapes",
           .slot = &s.max_escapes,
           .meaning = "How often an unstable equilibrium is left along its lowest mode.",
           .range = not_negative},
          {.name = "push",
           .slot = &s.push,
           .meaning = "Largest displacement of such an escape, in edge lengths.",
           .range = positive},
          {.name = "fall",
           .slot = &s.fall,
           .meaning = "With contact: the sheet first falls, damped, until it nearly rests, then the search begins. "
                      "`false`: the search begins at once."}};
}

std::vector<Key> keys_of(Probe& s) {
  return {
      {.name = "name", .slot = &s.name, .meaning = "Column of `history.csv`; unique.", .required = true},
      {.name = "type",
       .slot = choice(s.kind, {{"displacement", Probe::Kind::displacement},
                               {"reaction", Probe::Kind::reaction},
                               {"energy", Probe::Kind::energy},
                               {"height", Probe::Kind::height},
                               {"ease", Probe::Kind::ease},
                               {"stress", Probe::Kind::stress},
                               {"contact", Probe::Kind::contact}}),
       .meaning =
           "`displacement`: mean over the length or area of a group, or of the vertex nearest to a point. "
           "`reaction`: total over a "
           "group. `energy`: of the shell. `height`: least, mean over the length or area, and largest of a group, "
           "columns `NAME_min`, `_mean`, `_max`. `ease`: least distance to the bodies and its mean over the "
           "area, `NAME_min`, `_mean`. `stress`: of a triangle in material axes, `NAME_11`, `_22`, `_12`, "
           "`_von_mises`. `contact`: total force by which the sheet presses and rubs on an obstacle; not that of an "
           "`[[attachment]]`.",
       .unit = "m, N, J, Pa",
       .required = true},
      {.name = "group",
       .slot = GroupList{&s.group},
       .meaning = "Physical group to observe; a displacement needs this or `point`; an ease without it is that of "
                  "the whole surface.",
       .types = {"displacement", "reaction", "height", "ease"},
       .required_types = {"reaction", "height"},
       .absent = "none"},
      {.name = "point",
       .slot = &s.point,
       .meaning = "Rest position near the vertex to observe; of a stress, of the triangle.",
       .unit = "m",
       .types = {"displacement", "stress"},
       .required_types = {"stress"},
       .absent = "none"},
      {.name = "obstacle",
       .slot = &s.obstacle,
       .meaning = "Name of the obstacle whose force is observed.",
       .types = {"contact"},
       .required = true,
       .absent = "none"},
      {.name = "components",
       .slot = &s.components,
       .meaning = "Which of `\"x\"`, `\"y\"`, `\"z\"` to record; of a height the one that points up.",
       .types = {"displacement", "reaction", "height", "contact"},
       .absent = "all three; height: `\"z\"`"},
      {.name = "ground",
       .slot = &s.ground,
       .meaning = "Where heights count from, on the axis that points up.",
       .unit = "m",
       .types = {"height"}},
      {.name = "face",
       .slot = choice(s.face, {{"top", Probe::Face::top}, {"bottom", Probe::Face::bottom}}),
       .meaning = "Of the sheet: `top` is where the normal points to.",
       .types = {"stress"}}};
}

std::vector<Key> keys_of(OutputSection& s) {
  return {
      {.name = "fields",
       .slot = Words{&s.fields,
                     {"displacement", "reaction", "velocity", "membrane_force", "bending_moment", "curvature",
                      "membrane_strain", "membrane_error", "membrane_recovery_error", "bending_recovery_error",
                      "contact_force", "friction_force", "contact_pressure", "passing", "ease", "wanted_size",
                      "failure_index", "failure_ply", "principal_stretch"}},
       .meaning =
           "Fields in `results.vtkhdf`, any of `displacement`, `velocity`, `reaction`, `membrane_force`, "
           "`bending_moment`, "
           "`curvature`, `membrane_strain`, `membrane_error`, `membrane_recovery_error`, `bending_recovery_error`, "
           "`contact_force`, `friction_force`, `contact_pressure`, "
           "`passing` (1 where the vertex passes through an obstacle), `ease` (distance to the nearest body), "
           "`failure_index`, "
           "`failure_ply`, `principal_stretch` (of hyperelastic materials: two in the sheet and that of its "
           "thickness), "
           "`wanted_size` (of edges, "
           "with "
           "`[remesh]`).",
       .absent = "all of them; `ease` with `[[panel]]` only"},
      {.name = "stresses",
       .slot = choice(s.stresses, {{"none", OutputSection::Stresses::none},
                                   {"surface", OutputSection::Stresses::surface},
                                   {"plies", OutputSection::Stresses::plies}}),
       .meaning = "Stresses besides these fields: `surface`: 11, 22, 12 in material axes, principal and von Mises at "
                  "the top (where the normal points to) and the bottom; `plies`: also at both faces of every ply. For "
                  "all types but `matrices` and `fabric`; of hyperelastic ones true stresses."},
      {.name = "every",
       .slot = &s.every,
       .meaning = "Results every so many steps; stops and the last step always.",
       .range = {1}},
      {.name = "energy_balance",
       .slot = &s.energy_balance,
       .meaning =
           "Of a motion: account for its energy in `history.csv` and `summary.json`, see results.md. `false` with "
           "`central_difference` if this key is not given: there it doubles the cost of a step."}};
}

std::vector<Key> petsc_keys(Case& c) {
  return {{.name = "options",
           .slot = &c.petsc_options,
           .meaning = "Options of PETSc as on its command line, e.g. `\"-snes_rtol 1e-10 -ksp_type cg\"`, that choose "
                      "and tune solvers "
                      "or print to the screen; others belong on the command line (security.md)."}};
}

}  // namespace voile::input
