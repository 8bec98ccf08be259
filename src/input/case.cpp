#include "case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/text.hpp"
#include "case_attachments.hpp"
#include "case_harmonic.hpp"
#include "case_loads.hpp"
#include "case_materials.hpp"
#include "case_natural.hpp"
#include "case_pattern.hpp"
#include "case_periodic.hpp"
#include "case_read.hpp"
#include "case_rigid.hpp"
#include "case_sections.hpp"
#include "case_supports.hpp"
#include "command_line.hpp"
#include "expression.hpp"
#include "petsc_allowed.hpp"
#include "voile/errors.hpp"

namespace voile::input {

namespace {

/// [time] velocity_tolerance of stages that sew [m/s].
constexpr double sewing_tolerance = 3e-3;
using Control = solve::StaticOptions::Control;

void check_steps(const SectionPlace& place, const Case& c, solve::StaticOptions& s) {
  // Load factors may be loads of real size: ten steps to the end. Beyond a bifurcation an arc may be thousands of times softer.
  const double end = c.finds_modes() ? c.eigen.load_factor : s.final_load_factor;
  const double size = s.control == Control::load ? std::max(1.0, 0.1 * end) : 1.0;
  if (!place.has("max_step")) s.max_step = s.control == Control::arc_length ? 1e9 : std::max(s.max_step, size);
  if (!place.has("initial_step")) s.initial_step = std::min(s.initial_step * size, s.max_step);
  if (!place.has("min_step")) s.min_step = std::min(s.min_step, s.initial_step);
  if (s.initial_step > s.max_step)
    place.fail("initial_step", fmt::format("{}: must not be larger than max_step = {}", s.initial_step, s.max_step));
  if (s.min_step > s.initial_step)
    place.fail("min_step", fmt::format("{}: must not be larger than initial_step = {}", s.min_step, s.initial_step));
  for (std::size_t k = 1; k < s.stops.size(); ++k)
    if (s.stops[k] <= s.stops[k - 1])
      place.fail("stops", fmt::format("{} follows {}: list the stops in ascending order, each once", s.stops[k],
                                      s.stops[k - 1]));
  if (!s.stops.empty() && s.control != Control::load)
    place.fail("stops", "stops are load factors and belong to control = \"load\"; remove them");
  if (!s.stops.empty() && s.stops.back() > s.final_load_factor)
    place.fail("stops", fmt::format("{} lies beyond final_load_factor = {}: remove it or raise the final load factor",
                                    s.stops.back(), s.final_load_factor));
}

/// Control and the probe that goes with it. A probe is named before it is read: sections may stand in any order.
void check_control(const SectionPlace& place, solve::StaticOptions& s, const std::vector<Probe>& probes) {
  if (!place.has("target_iterations") && s.control != Control::load) s.target_iterations = 5;
  if (s.control == Control::displacement && (s.control_probe.empty() || s.final_displacement == 0.0))
    place.fail(s.control_probe.empty() ? "control_probe" : "final_displacement",
               "the key is missing (or zero); displacement control needs control_probe and final_displacement");
  if (s.final_displacement != 0.0 && s.control_probe.empty())
    place.fail("control_probe", "the key is missing; final_displacement is that of a probe");
  if (s.control == Control::load && !s.control_probe.empty())
    place.fail("control_probe", "control = \"load\" has no probe; choose \"displacement\" or \"arc_length\"");
  using AtCriticalPoint = solve::StaticOptions::AtCriticalPoint;
  if (s.at_critical_point != AtCriticalPoint::pass && s.control == Control::load)
    place.fail("at_critical_point", "control = \"load\" cannot stop or branch there; choose \"arc_length\"");
  if (s.at_critical_point == AtCriticalPoint::switch_branch && s.control != Control::arc_length)
    place.fail("at_critical_point", "a branch is followed under control = \"arc_length\" only");
  if (s.branch_step == 0.0) place.fail("branch_step", "0 does not leave the path; give a positive or negative number");
  if (s.control_probe.empty()) return;
  std::vector<std::string> names;
  for (const Probe& p : probes) names.push_back(p.name);
  const auto at = std::find(names.begin(), names.end(), s.control_probe);
  if (at == names.end())
    place.fail("control_probe",
               fmt::format("there is no probe '{}':{}", s.control_probe, suggestion(s.control_probe, names)));
  const Probe& probe = probes[static_cast<std::size_t>(at - names.begin())];
  if (probe.kind != Probe::Kind::displacement || probe.components.size() != 1)
    place.fail("control_probe", fmt::format("probe '{}' must be of type displacement with one component", probe.name));
}

void check_probe(const SectionPlace& place, const Probe& probe, const Case& c) {
  require_column_name(place, probe.name);
  std::vector<std::string> known;
  for (const ObstacleSection& o : c.obstacles) known.push_back(o.shape.name);
  if (probe.kind == Probe::Kind::contact && !c.is_staged() && !contains(known, probe.obstacle))
    place.fail("obstacle",
               fmt::format("there is no [[obstacle]] '{}':{}", probe.obstacle, suggestion(probe.obstacle, known)));
  for (const Probe& other : c.probes)
    if (other.name == probe.name) place.fail("name", fmt::format("'{}': another probe has this name", probe.name));
  if (probe.kind == Probe::Kind::height && probe.components.size() > 1)
    place.fail("components", "a height is along one axis; name the one that points up");
  if (probe.kind != Probe::Kind::displacement) return;
  if (place.has("group") == place.has("point"))
    place.fail(place.has("point") ? "point" : "group", "a displacement probe needs either 'group' or 'point'");
}

void read_obstacle(const SectionPlace& place, Case& c, ObstacleSection& s) {
  using Type = ObstacleSection::Type;
  using Shape = contact::Obstacle::Shape;
  contact::Obstacle& o = s.shape;
  constexpr std::array shapes{Shape::mesh, Shape::plane, Shape::sphere, Shape::capsule, Shape::mesh};
  o.shape = shapes[static_cast<std::size_t>(s.type)];
  o.passable = s.on_pinch == ObstacleSection::OnPinch::pass;
  if (o.passable && c.analysis != Analysis::dynamic && !c.is_staged())
    place.fail("on_pinch", "vertices pass through an obstacle with analysis = \"dynamic\" only; remove the key");
  for (const ObstacleSection& other : c.obstacles)
    if (other.shape.name == o.name) place.fail("name", fmt::format("'{}': another obstacle has this name", o.name));
  if (o.shape == Shape::plane && o.normal.norm() == 0.0) place.fail("normal", "the vector is zero");
  if (o.shape == Shape::capsule && (s.end - s.point).norm() == 0.0)
    place.fail("end", "the axis has no length; a ball is type = \"sphere\"");
  if (s.type == Type::cylinder && (s.end - s.point).norm() == 0.0)
    place.fail("end", "the same as point, so that the axis has no length; move one of the two");
  o.motion =
      motion_function(place, s.motion, c.is_staged() || c.analysis == Analysis::dynamic || c.moves_obstacles_by_load(),
                      "\"dynamic\" or \"static\"");
  if (o.shape == Shape::capsule)
    o.points = {s.point, s.end};
  else if (o.shape != Shape::mesh)
    o.points = {s.point};
  if (!s.file.empty()) s.file = beside(c.file, s.file);
  if (!s.landmarks.empty()) s.landmarks = beside(c.file, s.landmarks);
  for (const auto& [key, given] : {std::pair{"frames_loop", s.frames_loop},
                                   {"frames_start", s.frames_start != 0.0},
                                   {"frames_smoothing", s.frames_smoothing != 0.0}})
    if (s.frames.empty() && given) place.fail(key, "there are no frames; give them, or remove the key");
  if (s.frames.empty()) return;
  s.frames = beside(c.file, s.frames);
  if (o.motion) place.fail("frames", "a mesh moves by frames or by motion, not by both");
  if (c.analysis != Analysis::dynamic && !c.is_staged())
    place.fail("frames", "key frames move a body with analysis = \"dynamic\" only");
}

void read_remesh(const CaseReader& reader, Case& c) {
  RemeshSection& s = c.remesh;
  const SectionPlace place = reader.read("remesh", 0, keys_of(s));
  if (place.is_there() && !place.has("active")) s.active = true;
  if (!s.active) return;
  if (c.analysis != Analysis::statics && c.analysis != Analysis::dynamic && c.analysis != Analysis::drape) {
    if (!c.is_staged())
      throw UserError(
          fmt::format("{}: [remesh]: nothing is remeshed with analysis = \"{}\"; remove the section, or "
                      "choose static, dynamic or drape",
                      c.file.string(), word_of(c.analysis)));
    s.active = false;
  }
  if (s.active && has_gas(c))
    place.fail("active", "a new mesh would change the volume of a [[load]] of type gas; remove one of the two");
  if (s.smallest > 0.0 && s.largest > 0.0 && s.smallest > s.largest)
    place.fail("smallest", "it must not be more than `largest`");
  if (s.angle > 1.0) place.fail("angle", "it must not be more than 57 degrees");
  if (!s.size.empty()) {
    try {
      (void)size_expression(s.size);
    } catch (const UserError& e) {
      place.fail("size", e.what());
    }
  }
  if (!s.background.empty() && s.background.extension() != ".pos")
    place.fail("background",
               fmt::format("{} is no .pos; in Gmsh, save the view in that format", s.background.string()));
  if (!s.background.empty()) s.background = beside(c.file, s.background);
  if (c.element.bending == energy::BendingOperator::six_node)
    place.fail("active",
               "remeshed meshes are irregular, and the published elements are wrong on those; use element.type = "
               "\"corrected\"");
}

void read_contact(const CaseReader& reader, Case& c, const StagesBefore& before) {
  const SectionPlace place = reader.read("contact", 0, keys_of(c.contact));
  read_all(reader, "obstacle", c.obstacles,
           [&](const SectionPlace& at, ObstacleSection& s) { read_obstacle(at, c, s); });
  for (ObstacleSection& s : c.obstacles) s.second = UnitSystem(c.units).own_default(1.0, "s");
  read_all(reader, "landmark", c.landmarks,
           [&](const SectionPlace& at, const LandmarkSection& s) { check_landmark(at, c, s); });
  read_all(reader, "contact_rule", c.contact_rules, [](const SectionPlace&, const auto&) {});
  read_all(reader, "attachment", c.attachments,
           [&](const SectionPlace& at, const system::Attachment& s) { check_attachment(at, c, s, before); });
  c.contact.input.active = place.is_there() || !c.obstacles.empty() || !c.contact_rules.empty();
  if (!c.contact.input.active) return;
  if (c.analysis != Analysis::statics && c.analysis != Analysis::dynamic && c.analysis != Analysis::drape)
    throw UserError(
        fmt::format("{}: [contact], [[obstacle]]: there is no contact with analysis = \"{}\"; remove the "
                    "sections, or choose static, dynamic or drape",
                    place.file, word_of(c.analysis)));
  if (c.analysis == Analysis::statics && c.steps.control != Control::load)
    throw UserError(fmt::format("{}: steps.control: contact in a static path needs \"load\"", place.file));
}

void check_time(const SectionPlace& place, Case& c) {
  solve::TimeOptions& o = c.time.options;
  // Contact makes long iterations at every step size: smaller steps would not make them shorter.
  if (c.contact.input.active && !place.has("target_iterations")) o.target_iterations = 25;
  // With more, what hits something in one step, or a seam closes, may leave it faster than it came.
  if ((c.contact.input.active || !c.stage.sew.empty()) && !place.has("spectral_radius")) o.radius = 0.0;
  // Where sides come together on the way does not matter.
  if (!c.stage.sew.empty() && !place.has("velocity_tolerance")) o.velocity_tolerance = sewing_tolerance;
  if (c.contact.input.active && o.method == solve::TimeOptions::Method::central_difference)
    place.fail("method", "there is no contact with \"central_difference\"; choose \"alpha\"");
  if (o.max_step > 0.0 && o.max_step < o.step)
    place.fail("max_step", fmt::format("{}: must not be smaller than step = {}", o.max_step, o.step));
  if (o.min_step > o.step)
    place.fail("min_step", fmt::format("{}: must not be larger than step = {}", o.min_step, o.step));
  if (o.method == solve::TimeOptions::Method::central_difference && c.dynamics.mass == system::Mass::consistent)
    place.fail("mass", "central_difference needs mass = \"lumped\"");
  const bool moves =
      std::any_of(c.motions.begin(), c.motions.end(), [](const MotionInput& m) { return m.any(); }) ||
      (!c.time.load_history.empty() && std::any_of(c.supports.begin(), c.supports.end(),
                                                   [](const system::Support& s) { return s.value.norm() > 0.0; }));
  if (c.analysis == Analysis::dynamic && c.dynamics.mass == system::Mass::consistent && moves)
    place.fail("mass", "held vertices that move need \"lumped\": their inertia would be missing beside the free ones");
  if (!c.time.load_history.empty()) c.dynamics.load_history = time_function(place, "load_history", c.time.load_history);
}

void check_petsc(const SectionPlace& place, const std::string& options) {
  std::vector<std::pair<std::string, std::string>> pairs;
  try {
    pairs = petsc_pairs(options);
  } catch (const UserError& e) {
    place.fail("options", e.what());
  }
  for (const auto& [name, value] : pairs)
    if (const std::string why = refusal_of_petsc_option(name, value); !why.empty())
      place.fail("options", why + "; give it on the command line");
}

void check_mesh(const SectionPlace& place, Case& c) {
  if (!c.panels.empty()) return check_panel_mesh(place, c);
  if (c.mesh.file.empty())
    place.fail("file",
               "the key is missing; Gmsh mesh (`.msh`) or geometry (`.geo`), or another kind of mesh file; or "
               "cut the surface from [[panel]]");
  c.mesh.file = beside(c.file, c.mesh.file);
  if (c.stage.number > 0) c.mesh.start.clear();  // it begins where the stage before has ended
  if (c.mesh.options.rest != formats::RestShape::texture &&
      c.mesh.options.texture_unit != UnitSystem(c.units).own_default(1.0, "m"))
    place.fail("texture_unit", "only rest = \"texture\" has one; give that, or remove the key");
  if (c.mesh.options.rest == formats::RestShape::texture && c.analysis == Analysis::linear)
    place.fail("rest",
               "analysis = \"linear\" begins from the shape without strain, which sewn panels do not have; use "
               "analysis = \"static\"");
  if (c.mesh.start.empty()) return;
  c.mesh.start = beside(c.file, c.mesh.start);
  if (c.analysis != Analysis::statics && c.analysis != Analysis::drape && c.analysis != Analysis::dynamic)
    place.fail("start", fmt::format("analysis = \"{}\" begins from the shape without strain; remove the key",
                                    word_of(c.analysis)));
  if (c.mesh.options.merge)
    place.fail("start",
               "vertices that `merge` joins would have two places; merge them in both files, or remove the key");
}

/// Converts what is in SI whatever the case is in.
void read_units(CaseReader& reader, Case& c) {
  const SectionPlace place = reader.read("units", 0, keys_of(c.units));
  if (!place.is_there()) return;
  try {
    reader.set_units(UnitSystem(c.units));
  } catch (const UserError& e) {
    throw UserError(fmt::format("{}:{}: units.{}", place.file, place.line, e.what()));
  }
  if (!reader.units().is_si() && reader.count("panel") > 0)
    place.fail("length",
               "patterns and their sewing are in metres; remove the section, and give other numbers with their units");
}

Case read_case(CaseReader& reader, const std::filesystem::path& file, StageSection stage, const StagesBefore& before) {
  Case c;
  c.file = file;
  c.stage = std::move(stage);
  reader.read_top(top_keys(c));
  read_units(reader, c);
  read_pattern(reader, c);
  check_mesh(reader.read("mesh", 0, keys_of(c.mesh)), c);
  reader.read("element", 0, keys_of(c.element));
  read_materials(reader, c);
  if (c.element.bending == energy::BendingOperator::edge_angle &&
      std::any_of(c.materials.begin(), c.materials.end(), energy::couples))
    throw UserError(fmt::format(
        "{}: element.type: \"angles\" has no laminates that couple stretching and bending; use \"corrected\", "
        "or a symmetric stack",
        c.file.string()));
  const auto unchecked = [](const SectionPlace&, const auto&) {};
  read_supports(reader, c);
  read_all(reader, "load", c.loads, [&](const SectionPlace& place, system::Load& load) { read_load(place, c, load); });
  read_all(reader, "temperature", c.temperatures,
           [&](const SectionPlace& place, system::Temperature& t) { read_temperature(place, c, t); });
  read_hinges(reader, c);
  read_all(reader, "imperfection", c.imperfections,
           [&](const SectionPlace& place, ImperfectionSection& s) { check_imperfection(place, c, s); });
  read_all(reader, "mass", c.masses, unchecked);
  read_all(reader, "spring", c.springs, unchecked);
  const SectionPlace steps = reader.read("steps", 0, keys_of(c.steps));
  if (c.analysis == Analysis::statics && c.steps.control != Control::load &&
      std::any_of(c.motions.begin(), c.motions.end(), [](const MotionInput& m) { return m.any(); }))
    steps.fail("control", "supports with a motion or rotation need \"load\": they move with the load factor");
  if (c.finds_modes() && c.steps.final_displacement != 0.0)
    steps.fail("final_displacement", "modes are found where the load factor is eigen.load_factor; leave the key out");
  read_all(reader, "rigid", c.rigids, [&](const SectionPlace& place, RigidSection& s) { read_rigid(place, c, s); });
  read_periodics(reader, c);
  read_harmonic(reader, c);
  check_steps(steps, c, c.steps);
  read_contact(reader, c, before);
  check_time(reader.read("time", 0, keys_of(c.time, c.dynamics.mass)), c);
  read_all(reader, "initial_velocity", c.initial_velocities, [&](const SectionPlace& place, const InitialVelocity&) {
    if (c.analysis != Analysis::dynamic)
      place.fail("velocity", "only analysis = \"dynamic\" has one; remove the section");
  });
  read_wind(reader.read("air", 0, keys_of(c.dynamics.drag)), c, c.dynamics.drag);
  reader.read("drape", 0, keys_of(c.drape));
  read_remesh(reader, c);
  check_form(reader.read("form", 0, keys_of(c.form)), c);
  read_all(reader, "probe", c.probes,
           [&](const SectionPlace& place, const Probe& probe) { check_probe(place, probe, c); });
  check_control(steps, c.steps, c.probes);
  read_output(reader, c);
  check_petsc(reader.read("petsc", 0, petsc_keys(c)), c.petsc_options);
  check_rigid(c);
  check_periodic(c);
  check_folds(c);
  check_harmonic(c);
  c.notes = idle_sections(reader, c);
  for (std::string& note : material_notes(c)) c.notes.push_back(std::move(note));
  return c;
}

/// Throws UserError for an obstacle with a motion in stages none of which moves obstacles (simulation/stage_obstacles).
void require_moving_stage(const std::vector<Case>& stages) {
  for (const Case& c : stages)
    for (std::size_t i = 0; i < c.obstacles.size(); ++i) {
      const std::size_t number = c.stage.obstacles[i];
      const auto moves_it = [&](const Case& other) {
        return (other.analysis == Analysis::dynamic || other.analysis == Analysis::statics) &&
               contains(other.stage.obstacles, number);
      };
      if (c.obstacles[i].motion.any() && std::none_of(stages.begin(), stages.end(), moves_it))
        throw UserError(
            fmt::format("{}: obstacle.motion: '{}' moves in stages with analysis = \"dynamic\" or \"static\" only, and "
                        "none of its stages is one; add one that brings it in place, or place it there",
                        c.file.string(), c.obstacles[i].shape.name));
    }
}

/// Throws UserError for a probe of an obstacle that no stage has.
void require_probed_obstacles(const std::vector<Case>& stages) {
  for (const Probe& probe : stages.front().probes) {
    const auto has_it = [&](const Case& c) {
      return std::any_of(c.obstacles.begin(), c.obstacles.end(),
                         [&](const ObstacleSection& o) { return o.shape.name == probe.obstacle; });
    };
    if (probe.kind == Probe::Kind::contact && std::none_of(stages.begin(), stages.end(), has_it))
      throw UserError(fmt::format("{}: probe.obstacle: '{}': no stage has an [[obstacle]] of this name; correct it",
                                  stages.front().file.string(), probe.obstacle));
  }
}

Case read_whole_case(CaseReader& whole, const std::string& text, const std::filesystem::path& file,
                     const std::vector<std::string>& settings, const std::vector<Key>& top) {
  if (whole.stage_count() == 0) return read_case(whole, file, {}, {});
  std::vector<Case> stages;
  StagesBefore before;
  for (std::size_t n = 0; n < whole.stage_count(); ++n) {
    CaseReader reader(text, file, top, settings);
    StageSection stage = reader.select_stage(n);
    stages.push_back(read_case(reader, file, std::move(stage), before));
    before.add(stages.back());
  }
  assign_mode_stages(stages);
  require_moving_stage(stages);
  require_probed_obstacles(stages);
  Case c = stages.front();
  c.stage = {};
  c.stages = std::move(stages);
  c.staged_text = whole.text(std::filesystem::absolute(file).parent_path());
  return c;
}

}  // namespace

Case parse_case(const std::string& text, const std::filesystem::path& file, const std::vector<std::string>& settings) {
  Case names_only;
  const std::vector<Key> top = top_keys(names_only);
  CaseReader whole(text, file, top, settings);
  try {
    return read_whole_case(whole, text, file, settings, top);
  } catch (const UserError& e) {
    throw UserError(with_other_mistakes(whole, e.what()));
  }
}

}  // namespace voile::input
