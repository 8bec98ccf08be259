#include "stage_periodic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "voile/errors.hpp"

namespace voile::simulation {

namespace {

using input::Analysis;
using input::PeriodicSection;
using remesh::Stage;
using system::PeriodicPair;

[[noreturn]] void fail(const Stage& stage, const PeriodicSection& s, const std::string& why) {
  throw UserError(fmt::format("{}: stage '{}': [[periodic]] from '{}' to '{}' {}", stage.c.file.string(),
                              stage.c.stage.name, s.pair.from, s.pair.to, why));
}

void sort_pairs_as_before(const Stage& before, Stage& now) {
  std::vector<PeriodicSection>& all = now.c.periodics;
  for (std::size_t i = 0; i < before.c.periodics.size(); ++i) {
    const PeriodicSection& was = before.c.periodics[i];
    const auto at = std::find_if(
        all.begin() + static_cast<std::ptrdiff_t>(i), all.end(),
        [&](const PeriodicSection& s) { return s.pair.from == was.pair.from && s.pair.to == was.pair.to; });
    if (at == all.end())
      fail(now, was,
           fmt::format("is a pair in stage '{}', and stays one to the end; let a [[periodic]] of it hold in every "
                       "stage, with difference = [\"free\", \"free\", \"free\"] where nothing shall hold it",
                       before.c.stage.name));
    const auto found = static_cast<std::size_t>(at - all.begin());
    std::swap(all[i], all[found]);
    std::swap(now.c.stage.periodics[i], now.c.stage.periodics[found]);
  }
  if (all.size() > before.c.periodics.size())
    fail(now, all[before.c.periodics.size()],
         "is no pair in the stage before; let a [[periodic]] of it hold in every stage");
}

bool changes(const PeriodicPair& p) {
  return p.motion || !p.difference.isZero(0.0);
}

/// Throws unless something may move the edges apart in this stage.
void require_path(const Stage& stage, const PeriodicSection& s) {
  if (changes(s.pair) && stage.c.analysis == Analysis::dynamic)
    fail(stage, s,
         "has a difference, and edges that move apart in time are not modelled; let it grow in a static stage before");
  const bool by_load =
      stage.c.analysis == Analysis::statics && stage.c.steps.control == solve::StaticOptions::Control::load;
  if (s.pair.motion && !by_load)
    fail(stage, s,
         "has an expression as difference, which needs analysis = \"static\" with steps.control = \"load\"; give a "
         "number, which grows with the load factor");
}

/// A force that has grown stays, where the load factor counts.
void hold_force(const Stage& before, const PeriodicPair& was, double factor, Stage& now, PeriodicPair& p) {
  if (now.c.analysis != Analysis::statics && !now.c.finds_modes()) return;
  if (was.constant) factor = 1.0;
  if (factor == 0.0 || was.force.isZero(0.0)) return;
  if (!was.constant && before.c.analysis == Analysis::statics) now.held_at = before.c.steps.final_load_factor;
  p.force = factor * was.force;
  p.constant = true;
}

}  // namespace

void hold_over_periodics(const Stage* before, double factor, Stage& now) {
  if (before) sort_pairs_as_before(*before, now);
  for (std::size_t i = 0; i < now.c.periodics.size(); ++i) {
    PeriodicSection& s = now.c.periodics[i];
    const bool goes_on = before && now.c.stage.periodics[i] == before->c.stage.periodics[i];
    if (!goes_on || before->unmoved_pairs[i]) {
      require_path(now, s);
      continue;
    }
    now.unmoved_pairs[i] = 0;
    const PeriodicPair& was = before->c.periodics[i].pair;
    s.pair.motion = nullptr;
    s.pair.difference.setZero();
    hold_force(*before, was, factor, now, s.pair);
  }
}

}  // namespace voile::simulation
