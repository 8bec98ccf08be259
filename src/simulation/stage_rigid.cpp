#include "stage_rigid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "voile/errors.hpp"

namespace voile::simulation {

namespace {

using input::Analysis;
using input::RigidSection;
using remesh::Stage;
using system::RigidGroup;

[[noreturn]] void fail(const Stage& stage, const RigidSection& s, const std::string& why) {
  throw UserError(fmt::format("{}: stage '{}': [[rigid]] group '{}' {}", stage.c.file.string(), stage.c.stage.name,
                              s.group.group, why));
}

bool are_one_body(const RigidGroup& a, const RigidGroup& b) {
  return a.point == b.point && a.slope == b.slope && a.mass == b.mass;
}

void sort_as_before(const Stage& before, Stage& now) {
  std::vector<RigidSection>& all = now.c.rigids;
  for (std::size_t i = 0; i < before.c.rigids.size(); ++i) {
    const RigidSection& was = before.c.rigids[i];
    const auto at = std::find_if(all.begin() + static_cast<std::ptrdiff_t>(i), all.end(),
                                 [&](const RigidSection& s) { return s.group.group == was.group.group; });
    if (at == all.end())
      fail(now, was,
           fmt::format("has moved as a body in stage '{}', and does so to the end; let a [[rigid]] of it hold in every "
                       "stage, one with all motions free where nothing shall hold it",
                       before.c.stage.name));
    const auto found = static_cast<std::size_t>(at - all.begin());
    std::swap(all[i], all[found]);
    std::swap(now.c.stage.rigids[i], now.c.stage.rigids[found]);
    if (!are_one_body(all[i].group, was.group))
      fail(now, was, "needs the point, slope and mass that it has had in the stage before");
  }
  if (all.size() > before.c.rigids.size())
    fail(now, all[before.c.rigids.size()],
         "has not been rigid in the stage before; let a [[rigid]] of it hold in every stage");
}

/// Throws unless something may move in this stage.
void require_motion(const Stage& stage, const RigidSection& s) {
  if (!s.group.motion && !s.group.angle) return;
  if (stage.c.analysis == Analysis::dynamic) return;
  if (stage.c.analysis != Analysis::statics)
    fail(stage, s,
         fmt::format("has a motion, and nothing is moved with analysis = \"{}\"; hold it there",
                     input::word_of(stage.c.analysis)));
  if (stage.c.steps.control != solve::StaticOptions::Control::load)
    fail(stage, s, "moves with the load factor, for which steps.control must be \"load\"");
}

void stay(RigidGroup& g) {
  if (g.angle) g.turn = RigidGroup::Turn::held;
  g.motion = nullptr;
  g.angle = nullptr;
}

/// A force that has grown stays, where the load factor counts.
void hold_forces(const Stage& before, const RigidGroup& was, double factor, Stage& now, RigidGroup& g) {
  if (now.c.analysis != Analysis::statics && !now.c.finds_modes()) return;
  if (was.constant) factor = 1.0;
  if (factor == 0.0 || (was.force.isZero(0.0) && was.moment.isZero(0.0))) return;
  if (!was.constant && before.c.analysis == Analysis::statics) now.held_at = before.c.steps.final_load_factor;
  g.force = factor * was.force;
  g.moment = factor * was.moment;
  g.constant = true;
}

}  // namespace

std::vector<std::string> hold_over_rigids(const Stage* before, double factor, Stage& now) {
  std::vector<std::string> notes;
  const bool moves = now.c.analysis == Analysis::dynamic;
  now.rigid_in_time.assign(now.c.rigids.size(), moves ? 1 : 0);
  if (before) sort_as_before(*before, now);
  for (std::size_t i = 0; i < now.c.rigids.size(); ++i) {
    RigidSection& s = now.c.rigids[i];
    if (!before || now.c.stage.rigids[i] != before->c.stage.rigids[i]) {
      require_motion(now, s);
      continue;
    }
    const RigidGroup& was = before->c.rigids[i].group;
    const bool in_time = before->rigid_in_time[i] != 0, after_path = before->c.analysis == Analysis::statics;
    now.rigid_in_time[i] = in_time || (moves && !after_path) ? 1 : 0;
    const bool driven = s.group.motion || s.group.angle;
    if (!(moves && in_time)) {
      s.group.motion = was.motion;
      s.group.angle = was.angle;
      s.group.turn = was.turn;
      if (!moves || after_path) stay(s.group);
    }
    if (driven && !in_time && moves && after_path)
      notes.push_back(fmt::format(
          "[[rigid]] group '{}' stays in stage '{}' where the load factor of stage '{}' has brought it; to move it in "
          "time give a [[rigid]] of its own from that stage on",
          s.group.group, now.c.stage.name, before->c.stage.name));
    hold_forces(*before, was, factor, now, s.group);
  }
  return notes;
}

}  // namespace voile::simulation
