#include "stages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/mpi.hpp"
#include "base/text.hpp"
#include "input/case_keys.hpp"
#include "record/summary.hpp"
#include "setup/model_input.hpp"
#include "solve/load_path.hpp"
#include "stage_check.hpp"
#include "stage_obstacles.hpp"
#include "stage_options.hpp"
#include "stage_periodic.hpp"
#include "stage_rigid.hpp"
#include "voile/errors.hpp"

namespace voile::simulation {

namespace {

using system::Field;
using system::Load;
using system::Support;

/// Modes of earlier stages are where these have written them, also in the run that a restart continues.
void name_modes(const record::RunOptions& options, input::Case& c) {
  std::error_code ignored;
  const std::filesystem::path before = options.restart.parent_path().parent_path();
  for (input::ImperfectionSection& s : c.imperfections) {
    if (s.stage.empty()) continue;
    const bool restarts = !options.restart.empty() && std::filesystem::exists(before / s.stage / "modes", ignored);
    const std::filesystem::path& folder = restarts ? before : options.output;
    if (folder.empty() && !restarts) continue;  // they are kept in memory
    s.results = std::filesystem::absolute(folder / s.stage);
    s.stage.clear();
  }
}

/// The time continues from stage to stage.
void check_times(const std::vector<input::Case>& stages) {
  double time = 0.0;
  for (const input::Case& c : stages) {
    if (c.analysis != input::Analysis::dynamic) continue;
    const double end = c.time.options.end_time;
    if (end <= time)
      throw UserError(
          fmt::format("{}: stage '{}': [time] end = {:g} s, but the stage before has ended at {:g} s; the time runs "
                      "through all stages, so give a later end",
                      c.file.string(), c.stage.name, end, time));
    time = end;
  }
}

/// Place of the item `number` of the file among those of a stage, or npos.
constexpr std::size_t npos = static_cast<std::size_t>(-1);
std::size_t place_of(std::size_t number, const std::vector<std::size_t>& numbers) {
  const auto at = std::find(numbers.begin(), numbers.end(), number);
  return at == numbers.end() ? npos : static_cast<std::size_t>(at - numbers.begin());
}

/// Something of this stage is what the end of that path has made of it.
void hold_at_end(const input::Case& before, Stage& now) {
  if (before.analysis == input::Analysis::statics) now.held_at = before.steps.final_load_factor;
}

/// A support that has moved in time before goes on so. What its `value` comes to under a history counts from there, as its motion does.
void go_on(const input::Case& c, Support& s) {
  const Vec3 value = std::exchange(s.value, Vec3::Zero());
  if (!c.dynamics.load_history || value.isZero(0.0) || s.x_axis || s.y_axis || s.cylinder_axis) return;
  s.motion_text.clear();
  s.motion = [motion = s.motion, value, history = c.dynamics.load_history](const Vec3& rest, double time) -> Vec3 {
    return history(time) * value + (motion ? motion(rest, time) : Vec3(Vec3::Zero()));
  };
}

/// A support that has held in the stage before.
void hold_over(const input::Case& before, const Support& was, Support& now) {
  now.value = Vec3::Zero();
  now.motion = was.motion;
  now.motion_text = was.motion_text;
  now.rotation = was.rotation;
  if (before.analysis != input::Analysis::statics) return;
  // It has moved with the load factor, and stays where that has brought it.
  now.motion = nullptr;
  if (was.rotation) now.rotation = [turned = was.rotation(before.steps.final_load_factor)](double) { return turned; };
}

/// Whether a support of the stage before holds the slopes that another one of this stage shall hold: they are those at rest.
bool holds_slopes(const input::Case& before, const Support& s) {
  return std::any_of(before.supports.begin(), before.supports.end(), [&](const Support& was) {
    return was.kind == s.kind && was.group == s.group && !was.rotation && !s.rotation && was.normal == s.normal;
  });
}

/// What a user should know of something whose expression of t has come to its end with a load path.
std::string stays_put(const char* section, const std::string& group, const Stage& before, const Stage& now) {
  return fmt::format(
      "[[{0}]] {1} stays in stage '{2}' where the load factor of stage '{3}' has brought it; to change it in time "
      "give a {0} of its own from that stage on",
      section, group.empty() ? "of the whole sheet" : "group '" + group + "'", now.c.stage.name, before.c.stage.name);
}

/// What a stage has scaled its loads by at its end.
double factor_at_end(const input::Case& c) {
  if (c.analysis == input::Analysis::dynamic && c.dynamics.load_history)
    return c.dynamics.load_history(c.time.options.end_time);
  return c.analysis == input::Analysis::dynamic || c.analysis == input::Analysis::drape ? 1.0
                                                                                        : c.steps.final_load_factor;
}

/// Whether a stage leaves what it names where it is.
bool moves_nothing(const input::Case& c) {
  return c.finds_modes() && factor_at_end(c) == 0.0;
}

/// Returns what a user should know of supports that stay.
std::vector<std::string> hold_over_supports(const Stage& before, Stage& now) {
  std::vector<std::string> notes;
  const std::vector<std::size_t>& numbers = now.c.stage.supports;
  now.frozen.assign(numbers.size(), 0);
  now.in_time.assign(numbers.size(), now.c.analysis == input::Analysis::dynamic ? 1 : 0);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    Support& s = now.c.supports[i];
    const std::size_t was = place_of(numbers[i], before.c.stage.supports);
    if (was != npos && before.unmoved[was]) continue;
    now.unmoved[i] = now.unmoved[i] && was == npos ? 1 : 0;
    if (was != npos) {
      const bool moved = before.in_time[was] != 0;
      now.in_time[i] =
          moved || (now.c.analysis == input::Analysis::dynamic && before.c.analysis != input::Analysis::statics) ? 1
                                                                                                                 : 0;
      const bool driven = s.motion || s.rotation;
      if (moved && now.c.analysis == input::Analysis::dynamic)
        go_on(now.c, s);
      else
        hold_over(before.c, before.c.supports[was], s);
      if (driven && !moved && now.c.analysis == input::Analysis::dynamic &&
          before.c.analysis == input::Analysis::statics)
        notes.push_back(stays_put("support", s.group, before, now));
      if (before.c.supports[was].rotation) hold_at_end(before.c, now);
      now.frozen[i] = now.c.analysis == input::Analysis::statics ? 1 : 0;
    } else if ((s.kind == Support::Kind::clamped || s.kind == Support::Kind::sliding ||
                s.kind == Support::Kind::symmetry) &&
               !holds_slopes(before.c, s)) {
      throw UserError(fmt::format(
          "{}: [[support]] group '{}': a slope is held from the first stage on, and this one begins in stage '{}'; let "
          "it hold in all stages before, or, if neither turns, another one of its group, or use type = \"hinged\"",
          now.c.file.string(), s.group, now.c.stage.name));
    }
  }
  return notes;
}

/// A motion or a drape takes its loads in full: after a path that ends elsewhere that is a sudden load. Empty if there is none.
std::string sudden_loads(const input::Case& before, const input::Case& now) {
  const double factor = before.steps.final_load_factor;
  const bool moves = now.analysis == input::Analysis::dynamic || now.analysis == input::Analysis::drape;
  if (!moves || before.analysis != input::Analysis::statics || factor == 1.0) return {};
  for (std::size_t i = 0; i < now.stage.loads.size(); ++i) {
    const std::size_t was = place_of(now.stage.loads[i], before.stage.loads);
    if (was == npos || before.loads[was].constant || now.loads[i].history) continue;
    return fmt::format(
        "stage '{}': loads act in full from its start, but stage '{}' ends at final_load_factor = {:g}; for a smooth "
        "start scale the loads and end that stage at 1",
        now.stage.name, before.stage.name, factor);
  }
  return {};
}

/// Loads stay at what the stage before has brought them to, unless they have a history.
void hold_over_loads(const Stage& before, Stage& now) {
  if (now.c.analysis != input::Analysis::statics && !now.c.finds_modes()) return;
  for (std::size_t i = 0; i < now.c.stage.loads.size(); ++i) {
    const std::size_t was = place_of(now.c.stage.loads[i], before.c.stage.loads);
    Load& load = now.c.loads[i];
    if (was == npos || load.history) continue;
    const Load& old = before.c.loads[was];
    const double factor = old.constant ? 1.0 : factor_at_end(before.c);
    if (factor == 0.0) continue;  // it begins to grow here
    if (!old.constant) hold_at_end(before.c, now);
    load.vector = factor * old.vector;
    load.magnitude = factor * old.magnitude;
    load.constant = true;
  }
}

/// Holds what grew in the stage before, with what it had been held at before that. Returns whether this leaves an expression of t
/// out of a motion.
bool hold(const Stage& before, const Field& old, bool was_constant, Stage& now, Field& f, bool& constant) {
  const bool was_in_time = old.resumes || (old.in_time && before.c.analysis == input::Analysis::dynamic);
  if (!f.value || (was_in_time && now.c.analysis == input::Analysis::dynamic)) return false;
  f.resumes = was_in_time;
  const bool stands_still = f.in_time && now.c.analysis == input::Analysis::dynamic;
  const bool grows = now.c.analysis == input::Analysis::statics || now.c.finds_modes();
  if (old.in_time) {
    const double end = before.c.analysis == input::Analysis::dynamic ? before.c.time.options.end_time
                                                                     : before.c.steps.final_load_factor;
    f.value = [value = old.value, end](const Vec3& x, double) { return value(x, end); };
    hold_at_end(before.c, now);
  } else if (grows || f.in_time) {
    const double factor = was_constant ? 1.0 : factor_at_end(before.c);
    if (factor == 0.0 && grows) return false;
    if (!was_constant) hold_at_end(before.c, now);
    f.value = [value = old.value, factor](const Vec3& x, double t) { return factor * value(x, t); };
  }
  constant = constant || grows || f.in_time;
  f.in_time = false;
  return stands_still;
}

/// A temperature that the stage before has had stays, as loads do, unless both follow the same time.
void hold_over_temperatures(const Stage& before, Stage& now, std::vector<std::string>& notes) {
  for (std::size_t i = 0; i < now.c.stage.temperatures.size(); ++i) {
    const std::size_t was = place_of(now.c.stage.temperatures[i], before.c.stage.temperatures);
    if (was == npos) continue;
    const system::Temperature& old = before.c.temperatures[was];
    system::Temperature& t = now.c.temperatures[i];
    bool stays = false;
    for (auto part : {&system::Temperature::change, &system::Temperature::difference})
      stays = hold(before, old.*part, old.constant, now, t.*part, t.constant) || stays;
    if (stays) notes.push_back(stays_put("temperature", t.group, before, now));
  }
}

/// A hinge that the stage before has folded stays so, likewise.
void hold_over_hinges(const Stage& before, Stage& now, std::vector<std::string>& notes) {
  for (std::size_t i = 0; i < now.c.hinges.size(); ++i) {
    const system::Hinge& old = before.c.hinges[i];
    system::Hinge& hinge = now.c.hinges[i];
    if (hold(before, old.angle, old.constant, now, hinge.angle, hinge.constant))
      notes.push_back(stays_put("hinge", hinge.group, before, now));
  }
}

/// Time in which bands get shorter that first act after sewing, unless the case says [s].
constexpr double usual_rise = 0.1;

/// Bands get shorter from the start of the first stage that has them, if that is one in time. `before`: null for the first.
void rise_bands(const Stage* before, Stage& now) {
  for (std::size_t i = 0; i < now.input.springs.size(); ++i) {
    system::Spring& band = now.input.springs[i];
    const auto& numbers = now.c.stage.springs;
    const std::size_t was = before && !numbers.empty() ? place_of(numbers[i], before->c.stage.springs) : npos;
    if (was != npos) {
      band.start = before->input.springs[was].start;
      band.rise = before->input.springs[was].rise;
    } else if (now.c.analysis == input::Analysis::dynamic) {
      band.start = before ? now.input.sewing.start : 0.0;
      if (std::isnan(band.rise)) band.rise = now.sewn_before.empty() ? 0.0 : usual_rise;
    }
  }
}

/// Throws unless a stage in a folder of results has come to its end. Collective.
void require_end_of(const std::string& stage, const record::RunOptions& options) {
  const std::filesystem::path& folder = options.output;
  const std::string& from = options.from;
  mpi::on_root(options.comm, [&] {
    if (record::has_converged(folder / stage)) return;
    throw UserError(
        fmt::format("--from {}: stage '{}' before it has not come to its end in {}; begin with that one, or "
                    "name a state to begin from with --restart",
                    from, stage, folder.string()));
  });
}

}  // namespace

std::vector<Stage> stages_of(const input::Case& c, const record::RunOptions& options) {
  std::vector<Stage> stages;
  setup::KnownObstacles known;
  const auto add = [&](const input::Case& one, const std::filesystem::path& folder) {
    Stage s{one, options, {}, std::vector<char>(one.supports.size(), 0)};
    s.options.output = folder;
    s.in_time.assign(one.supports.size(), one.analysis == input::Analysis::dynamic ? 1 : 0);
    s.unmoved.assign(one.supports.size(), 0);
    s.unmoved_pairs.assign(one.periodics.size(), 0);
    name_modes(options, s.c);
    take_options(options.comm, s.c);
    for (std::vector<char>* all : {&s.unmoved, &s.unmoved_pairs})
      std::fill(all->begin(), all->end(), moves_nothing(s.c));
    if (one.stage.continues()) {
      std::vector<std::string> notes = hold_over_supports(stages.back(), s);
      if (const std::string text = sudden_loads(stages.back().c, s.c); !text.empty()) notes.push_back(text);
      hold_over_loads(stages.back(), s);
      hold_over_temperatures(stages.back(), s, notes);
      hold_over_hinges(stages.back(), s, notes);
      for (std::string& text : counted_from_welds(stages.back(), s)) notes.push_back(std::move(text));
      for (std::string& text : hold_over_rigids(&stages.back(), factor_at_end(stages.back().c), s))
        notes.push_back(std::move(text));
      hold_over_periodics(&stages.back(), factor_at_end(stages.back().c), s);
      if (stages.back().c.contact.input.active && one.finds_modes())
        notes.push_back(fmt::format(
            "stage '{}' knows no contact: its modes, and what comes after, are about the equilibrium without obstacles",
            one.stage.name));
      // A run prints the notes of its first stage, which is this one if it begins here.
      for (const std::string& text : notes)
        for (input::Case* of : {&stages.front().c, &s.c}) of->notes.push_back(text);
    }
    if (!one.stage.continues()) {
      (void)hold_over_rigids(nullptr, 1.0, s);
      hold_over_periodics(nullptr, 1.0, s);
    }
    if (!one.stage.attachments.empty() && one.attachments.empty()) {
      const std::string text =
          fmt::format("stage '{}': [[attachment]] holds nothing where there is no contact, with analysis = \"{}\"",
                      one.stage.name, input::word_of(one.analysis));
      s.c.notes.push_back(text);
      if (!stages.empty()) stages.front().c.notes.push_back(text);
    }
    s.input = setup::model_input(options.comm, s.c, known);
    if (one.is_staged()) lead_obstacles(c.stages, s);
    if (one.stage.continues()) {
      const Stage& before = stages.back();
      s.sewn_before = before.sewn_before;
      s.sewn_before.insert(s.sewn_before.end(), before.c.stage.sew.begin(), before.c.stage.sew.end());
      s.input.sewing.start =
          before.c.analysis == input::Analysis::dynamic ? before.c.time.options.end_time : before.input.sewing.start;
    }
    rise_bands(one.stage.continues() ? &stages.back() : nullptr, s);
    stages.push_back(std::move(s));
  };
  check_times(c.stages);
  if (c.stages.empty()) add(c, options.output);
  for (const input::Case& one : c.stages)
    add(one, options.output.empty() ? options.output : options.output / one.stage.name);
  return stages;
}

Origin begin_from(const input::Case& c, record::RunOptions& options, std::vector<Stage>& stages) {
  const bool restarts = !options.restart.empty();
  std::vector<std::string> names;
  for (const input::Case& one : c.stages) names.push_back(one.stage.name);
  if (options.from.empty()) {
    if (restarts && !names.empty())
      throw UserError(fmt::format("--restart: {} has stages; name the one that continues from there, with --from: {}",
                                  c.file.string(), join(names, ", ")));
    return restarts ? Origin::restart : Origin::nothing;
  }
  if (names.empty()) throw UserError(fmt::format("--from {}: {} has no stages", options.from, c.file.string()));
  const auto at = std::find(names.begin(), names.end(), options.from);
  if (at == names.end())
    throw UserError(fmt::format("--from: there is no stage '{}':{}", options.from, suggestion(options.from, names)));
  if (!restarts && at != names.begin()) {
    require_end_of(*(at - 1), options);
    options.restart = options.output / *(at - 1) / "checkpoint.h5";
  }
  // A checkpoint of the stage before is where this one begins, with its clock; any other state is one of this stage.
  const bool is_before = restarts && at != names.begin() && options.restart.filename() == "checkpoint.h5" &&
                         options.restart.parent_path().filename() == *(at - 1);
  stages.erase(stages.begin(), stages.begin() + (at - names.begin()));
  if (restarts && !(is_before && stages.front().c.stage.continues())) return Origin::restart;
  if (stages.front().c.stage.continues()) return Origin::stage;
  options.restart.clear();
  return Origin::nothing;
}

void require_factor(const Stage& stage, double reached) {
  if (!stage.held_at || std::abs(reached - *stage.held_at) <= 1e-9 * std::max(1.0, std::abs(*stage.held_at))) return;
  throw UserError(fmt::format(
      "{}: stage '{}': what acts since the stage before stays at that one's final_load_factor = {:g}, but its path has "
      "ended at {:.10g}; give it final_load_factor = {:.10g}, or continue in a case of its own with --restart",
      stage.c.file.string(), stage.c.stage.name, *stage.held_at, reached, reached));
}

}  // namespace voile::simulation
