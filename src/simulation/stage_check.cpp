#include "stage_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "base/text.hpp"
#include "excitation.hpp"
#include "record/probes.hpp"
#include "remesh/remesher.hpp"
#include "setup/free_motions.hpp"
#include "system/dynamics.hpp"
#include "voile/errors.hpp"

namespace voile::simulation {

namespace {

using input::Analysis;

bool follows_growth(const input::Case& c) {
  using Excitation = input::HarmonicSection::Excitation;
  if (c.analysis == Analysis::harmonic) return c.harmonic.excitation == Excitation::loads;
  return c.analysis == Analysis::buckling ||
         (c.analysis == Analysis::statics && c.steps.control != solve::StaticOptions::Control::load);
}

/// Whether the stage before has it too.
bool stays(std::size_t number, const std::vector<std::size_t>& before) {
  return contains(before, number);
}

bool counts_from_start(const system::Spring& s) {
  using Kind = system::Spring::Kind;
  return s.kind == Kind::pair ? std::isnan(s.length) : s.kind != Kind::band;
}

}  // namespace

void require_growth(const input::Case& c, system::Model& model) {
  if (!follows_growth(c) || model.potential().natural_growth() > 0.0) return;
  const petsc::VecHandle rest = model.dofs().create_vector(), growth = model.dofs().create_vector();
  if (model.conditions().has_prescribed()) model.assemble_tangent(rest, {.kind = energy::Tangent::exact});
  model.load_direction(rest, growth);
  double size = 0.0;
  VOILE_PETSC(VecNorm(growth, NORM_INFINITY, &size));
  if (size > 0.0) return;
  const std::string what = c.analysis == Analysis::statics ? std::string("[steps] control")
                                                           : fmt::format("analysis = \"{}\"", word_of(c.analysis));
  throw UserError(fmt::format(
      "{}: {} needs a load or a temperature that grows with the load factor, which constant ones and those of "
      "earlier stages do not; give it a [[load]] of its own{}{}",
      c.file.string(), what, c.is_staged() ? " with `stages`" : "",
      c.analysis == Analysis::harmonic ? ", or harmonic.excitation = \"base\"" : ""));
}

std::vector<std::string> counted_from_welds(const remesh::Stage& before, const remesh::Stage& now) {
  std::vector<std::string> counted;
  if (before.c.stage.sew.empty()) return {};
  for (std::size_t i = 0; i < now.c.springs.size(); ++i)
    if (stays(now.c.stage.springs[i], before.c.stage.springs) && counts_from_start(now.c.springs[i]))
      counted.push_back(fmt::format(
          "[[spring]] {}", now.c.springs[i].group.empty() ? "of the whole sheet" : "'" + now.c.springs[i].group + "'"));
  for (std::size_t i = 0; i < now.c.loads.size(); ++i) {
    const system::Load& load = now.c.loads[i];
    if (!stays(now.c.stage.loads[i], before.c.stage.loads)) continue;
    if (load.distribution) counted.push_back("load.distribution");
    if (load.kind == system::Load::Kind::pressure) counted.push_back("[[load]] type \"pressure\"");
  }
  if (now.c.remesh.active && before.c.remesh.active && !now.c.remesh.size.empty()) counted.push_back("remesh.size");
  if (counted.empty()) return {};
  return {fmt::format(
      "stage '{}' begins with welded seams, and what counts from the start counts from the places there: {}",
      now.c.stage.name, join(counted, ", "))};
}

void check_stage(const remesh::Stage& stage, const mesh::SurfaceMesh& mesh) try {
  system::Model model(stage.options.comm, mesh, stage.input);
  if (stage.c.vibrates() || stage.c.analysis == Analysis::dynamic) system::require_mass(model);
  (void)setup::check_free_motions(stage.c, model);
  require_excitation(stage.c, model);
  require_growth(stage.c, model);
  (void)record::Probes(stage.c, model);
  remesh::check_remesh(stage.options.comm, stage.c, mesh);
} catch (const UserError& e) {
  // The file stands before the stage, not between it and the section.
  std::string_view what = e.what();
  const std::string file = stage.c.file.string() + ": ";
  const bool named = what.starts_with(file);
  if (named) what.remove_prefix(file.size());
  throw UserError(fmt::format("{}stage '{}': {}", named ? file : "", stage.c.stage.name, what));
}

}  // namespace voile::simulation
