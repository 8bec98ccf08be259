#include "case_rigid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "case_loads.hpp"
#include "voile/errors.hpp"

namespace voile::input {

namespace {

using Turn = system::RigidGroup::Turn;
constexpr const char* axes[] = {"x", "y", "z"};

bool is_zero(const std::string& text) {
  return text == "0" || text == "0.0" || text == "-0";
}

/// Where something may move in this case.
void require_motion(const SectionPlace& place, const Case& c, const char* key) {
  if (c.analysis == Analysis::dynamic || c.stage.number > 0) return;  // a later stage holds it
  if (c.analysis != Analysis::statics)
    place.fail(key, fmt::format("nothing is moved with analysis = \"{}\"; choose \"static\" or \"dynamic\", or hold it",
                                word_of(c.analysis)));
  if (c.steps.control != solve::StaticOptions::Control::load)
    place.fail(key, "it moves with the load factor, for which steps.control must be \"load\"");
}

void take_translation(const SectionPlace& place, const Case& c, RigidSection& s) {
  if (s.translation.empty()) return;
  if (s.translation.size() != 3)
    place.fail("translation", fmt::format("{} entries; three are needed, for x, y and z", s.translation.size()));
  std::array<std::function<double(double)>, 3> u;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::string& text = s.translation[k];
    s.group.held[k] = text != "free";
    if (!s.group.held[k]) continue;
    if (s.group.force[static_cast<Eigen::Index>(k)] != 0.0)
      place.fail("force", fmt::format("its {} component acts where the translation is prescribed; set it to 0, or the "
                                      "translation to \"free\"",
                                      axes[k]));
    if (is_zero(text)) continue;
    u[k] = time_function(place, "translation", text);
    require_motion(place, c, "translation");
  }
  if (std::none_of(u.begin(), u.end(), [](const auto& f) { return static_cast<bool>(f); })) return;
  s.group.motion = [u](double t) {
    Vec3 d = Vec3::Zero();
    for (std::size_t k = 0; k < 3; ++k)
      if (u[k]) d[static_cast<Eigen::Index>(k)] = u[k](t);
    return d;
  };
}

void take_turn(const SectionPlace& place, const Case& c, RigidSection& s) {
  system::RigidGroup& g = s.group;
  if (g.turn == Turn::about && !g.axis) place.fail("turn_axis", "the key is missing; turn = \"about\" has an axis");
  if (g.turn != Turn::about && (g.axis || !s.angle.empty()))
    place.fail(g.axis ? "turn_axis" : "turn_angle", "only turn = \"about\" has one; give that, or remove the key");
  if (!s.angle.empty()) {
    require_motion(place, c, "turn_angle");
    g.angle = [f = time_function(place, "turn_angle", s.angle)](double t) { return f(t) * (std::numbers::pi / 180.0); };
  }
  if (g.moment.squaredNorm() == 0.0 || g.turn == Turn::free) return;
  if (g.turn == Turn::held || g.angle)
    place.fail("moment", "it acts where the turn is prescribed; remove it, or let the body turn");
  constexpr double round_off = 1e-12;
  if (g.moment.cross(*g.axis).norm() > round_off * g.moment.norm() * g.axis->norm())
    place.fail("moment", "only a moment along turn_axis turns the body; give its other components to none");
}

}  // namespace

void read_rigid(const SectionPlace& place, const Case& c, RigidSection& s) {
  if (c.analysis == Analysis::drape)
    place.fail("group", "there are no rigid groups with analysis = \"drape\"; use [[support]]");
  if (s.name.empty()) s.name = s.group.group;
  require_column_name(place, s.name);
  for (const RigidSection& other : c.rigids)
    if (other.name == s.name) place.fail("name", fmt::format("'{}': another [[rigid]] has this name", s.name));
  take_translation(place, c, s);
  take_turn(place, c, s);
}

void check_rigid(const Case& c) {
  if (c.rigids.empty()) return;
  const auto refuse = [&](const char* key, const char* why) {
    throw UserError(fmt::format("{}: [[rigid]] and {}: {}", c.file.string(), key, why));
  };
  if (c.contact.input.active) refuse("[contact]", "rigid groups have no contact; remove one of the sections");
  if (c.remesh.active) refuse("[remesh]", "the mesh of rigid groups stays as it is; remove one of the sections");
  if (!c.panels.empty()) refuse("[[panel]]", "panels have no rigid groups; use [[support]]");
  if (!c.mesh.start.empty() || c.mesh.options.rest == formats::RestShape::texture)
    refuse("mesh", "rigid groups begin in the shape without strain; remove mesh.start and mesh.rest");
  if (c.dynamics.drag.active()) refuse("[air]", "rigid groups have no drag; remove one of the sections");
  for (const RigidSection& s : c.rigids)
    for (const char* part : {"", "_turn", "_force", "_moment"})
      for (const Probe& probe : c.probes)
        if (probe.name == s.name + part)
          refuse("probe.name", ("'" + probe.name + "': both have columns of this name; rename one of them").c_str());
  const bool held = std::any_of(c.rigids.begin(), c.rigids.end(), [](const RigidSection& s) { return s.group.slope; });
  if (held && c.element.bending == energy::BendingOperator::six_node)
    refuse("element.type", "the published elements hold no slope; use \"corrected\", or slope = \"free\"");
  if (c.vibrates() && c.eigen.mass == system::Mass::lumped) refuse("eigen.mass", "rigid groups need \"consistent\"");
  if (c.analysis != Analysis::dynamic) return;
  if (c.dynamics.mass == system::Mass::consistent) refuse("time.mass", "rigid groups need \"lumped\"");
  if (c.time.options.method == solve::TimeOptions::Method::central_difference)
    refuse("time.method", "rigid groups need \"alpha\"");
  // Nothing damps what the constraints of rotations excite from step to step.
  constexpr double largest_radius = 0.9;
  if (c.time.options.radius > largest_radius)
    refuse("time.spectral_radius", "oscillations from step to step would grow; use 0.9 at most");
}

}  // namespace voile::input
