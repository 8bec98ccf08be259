#include "case_natural.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "base/text.hpp"
#include "case_lines.hpp"
#include "case_materials.hpp"
#include "case_sections.hpp"
#include "voile/errors.hpp"

namespace voile::input {

PlaceExpression place_function(const SectionPlace& place, const char* key, const std::string& text, bool time) {
  const auto named = [place, key](const auto& f) {
    try {
      return f();
    } catch (const UserError& e) {
      place.fail(key, e.what());
    }
  };
  PlaceExpression e = named([&] { return place_expression(text, time); });
  e.value = [named, value = e.value](const Vec3& x, double t) { return named([&] { return value(x, t); }); };
  return e;
}

void read_temperature(const SectionPlace& place, const Case& c, system::Temperature& t) {
  if (t.change.text.empty() && t.difference.text.empty())
    place.fail("change", "the key is missing, and so is difference; give at least one of them");
  for (const auto& [key, field] : {std::pair{"change", &t.change}, {"difference", &t.difference}}) {
    if (field->text.empty()) continue;
    const PlaceExpression e = place_function(place, key, field->text, true);
    field->value = e.value;
    field->in_time = e.in_time;
    if (e.in_time && t.constant)
      place.fail("constant", fmt::format("{} depends on t, so it is not constant; remove one of the two", key));
  }
  const auto expands = [](const energy::Material& m) { return m.expands; };
  if (std::none_of(c.materials.begin(), c.materials.end(), expands))
    place.fail("change",
               "no [[material]] has an expansion, so a temperature has no effect; give the material `expansion` "
               "(`expansion_1` and `expansion_2`), or remove the section");
}

void check_form(const SectionPlace& place, Case& c) {
  c.form.active = place.is_there();
  for (const system::Spring& s : c.springs)
    if (!std::isnan(s.force) && !std::isnan(s.length))
      throw UserError(fmt::format("{}: [[spring]] of group '{}': force: `length` is given too; remove one of the two",
                                  c.file.string(), s.group));
  if (!c.form.active) return;
  const auto refuse = [&](const std::string& what) {
    throw UserError(fmt::format("{}: [form]: {}", c.file.string(), what));
  };
  if (c.remesh.active) refuse("a new mesh would not carry its prestress; remove [remesh] or [form]");
  if (!c.rigids.empty()) refuse("it has no [[rigid]] groups; hold the group by a [[support]], or remove [form]");
  if (!c.panels.empty() || !c.mesh.start.empty() || c.mesh.options.rest == formats::RestShape::texture)
    refuse("the rest shape is found, so none can be given; remove [[panel]], mesh.start, mesh.rest, or [form]");
  for (const energy::Material& m : c.materials) {
    const Vec3& n = m.prestress;
    if (!(n[0] > 0.0 && n[1] > 0.0 && n[0] * n[1] > n[2] * n[2]))
      refuse(fmt::format(
          "the [[material]] of {} has the prestress [{:g}, {:g}] N/m, which does not pull in all "
          "directions; give it positive forces",
          m.groups.empty() ? std::string("all other triangles") : "'" + m.groups.front() + "'", n[0], n[1]));
    if (m.texture_direction)
      refuse("a material axis in texture coordinates is that of a flat piece; give `direction` instead");
  }
  for (const system::Spring& s : c.springs)
    if (s.kind == system::Spring::Kind::band && !std::isnan(s.length))
      refuse(fmt::format("the band along '{}' has a length, but the curve gets its own; give it `force` instead",
                         s.group));
  for (const system::Support& s : c.supports) {
    const bool turned = s.x_axis || s.cylinder_axis, all = s.components[0] && s.components[1] && s.components[2];
    if (turned && !all)
      refuse(fmt::format("the [[support]] of '{}' has axes of its own; hold global components, or all three", s.group));
    if (s.kind == system::Support::Kind::symmetry &&
        !(s.normal && s.normal->cwiseAbs().maxCoeff() > (1.0 - 1e-12) * s.normal->norm()))
      refuse(
          fmt::format("the [[support]] of '{}' is a plane of symmetry whose normal is not known to be the x, y or z "
                      "axis; give `normal`, or turn the mesh",
                      s.group));
  }
}

void read_hinges(CaseReader& reader, Case& c) {
  read_all(reader, "hinge", c.hinges, [&](const SectionPlace& place, system::Hinge& hinge) {
    if (!c.panels.empty() || c.mesh.options.rest == formats::RestShape::texture)
      place.fail("group",
                 "pieces of cloth have no hinges; remove the section, or use a mesh that is its own rest shape");
    if (hinge.angle.text.empty()) {
      if (hinge.constant) place.fail("constant", "it has no effect without angle; remove it");
      return;
    }
    const PlaceExpression e = place_function(place, "angle", hinge.angle.text, true);
    hinge.angle.value = e.value;
    hinge.angle.in_time = e.in_time;
    if (e.in_time && hinge.constant)
      place.fail("constant", "angle depends on t, so it is not constant; remove one of the two");
  });
}

void check_folds(const Case& c) {
  for (const system::Hinge& hinge : c.hinges) {
    char* end = nullptr;
    const double angle = std::strtod(hinge.angle.text.c_str(), &end);
    const bool is_number = !hinge.angle.text.empty() && end != nullptr && *end == '\0';
    const double most =
        c.analysis == Analysis::statics && !hinge.constant ? std::max(1.0, c.steps.final_load_factor) : 1.0;
    if (!is_number || std::abs(angle) * most <= 180.0 * (1.0 + 1e-9)) continue;
    throw UserError(fmt::format(
        "{}: [[hinge]] group = \"{}\": angle = {:g} degrees: a fold is counted from the mesh, and beyond 180 the "
        "sheet would pass through itself; give at most 180 the one way or the other",
        place_in_case(c.file, "hinge", "group", hinge.group), hinge.group, angle * most));
  }
}

void check_imperfection(const SectionPlace& place, const Case& c, ImperfectionSection& s) {
  using Type = ImperfectionSection::Type;
  if (s.type == Type::expression) (void)place_function(place, "height", s.height, false);
  if (s.type != Type::modes) return;
  if (s.results.empty() == s.stage.empty())
    place.fail(
        s.stage.empty() ? "results" : "stage",
        "modes come from the results of another run or from a stage of this case; give one of `results` and `stage`");
  if (!s.stage.empty() && !c.is_staged())
    place.fail(
        "stage",
        fmt::format("there is no stage '{}': the case has none; add [[stage]] tables, or give `results`", s.stage));
  if (s.stage.empty()) s.results = beside(c.file, s.results);
  for (const double mode : s.modes)
    if (!(mode >= 1.0) || mode != std::floor(mode))
      place.fail("modes", fmt::format("{:g}: whole numbers from 1 are needed", mode));
  if (s.amplitudes.size() != 1 && s.amplitudes.size() != s.modes.size())
    place.fail("amplitudes", fmt::format("{} amplitudes for {} modes; give one for each, or one for all",
                                         s.amplitudes.size(), s.modes.size()));
}

namespace {

/// Number of the stage that finds the modes of an imperfection.
std::size_t mode_stage_of(const std::vector<Case>& stages, const ImperfectionSection& s) {
  const auto fail = [&](const char* key, const std::string& what) {
    throw UserError(fmt::format("{}: [[imperfection]] {}: {}", stages.front().file.string(), key, what));
  };
  std::vector<std::string> names;
  for (const Case& one : stages) names.push_back(one.stage.name);
  const auto at = std::find(names.begin(), names.end(), s.stage);
  if (at == names.end()) fail("stage", fmt::format("there is no stage '{}':{}", s.stage, suggestion(s.stage, names)));
  const auto number = static_cast<std::size_t>(at - names.begin());
  const Case& finds = stages[number];
  if (finds.analysis != Analysis::buckling && finds.analysis != Analysis::modal)
    fail("stage", fmt::format("stage '{}' has analysis = \"{}\", which gives no modes; name one with \"buckling\" or "
                              "\"modal\"",
                              s.stage, word_of(finds.analysis)));
  if (number + 1 == names.size())
    fail("stage", fmt::format("no stage comes after '{}', whose modes would change its shape; add one, or name an "
                              "earlier stage",
                              s.stage));
  for (const double mode : s.modes)
    if (mode > finds.eigen.modes)
      fail("modes", fmt::format("mode {:g}: stage '{}' finds {} mode(s); give it more by eigen.modes", mode, s.stage,
                                finds.eigen.modes));
  return number;
}

/// Throws where a stage leaves something that a later one on another shape cannot begin without.
void require_nothing_left(const Case& stage, const std::string& next) {
  const auto fail = [&](const std::string& why) {
    throw UserError(fmt::format("{}: [[imperfection]] stage: stage '{}' begins anew on the imperfect shape, but {}",
                                stage.file.string(), next, why));
  };
  if (stage.analysis == Analysis::dynamic)
    fail(fmt::format("in stage '{}' before it time has passed; move that one behind it", stage.stage.name));
  if (stage.remesh.active)
    fail(fmt::format("stage '{}' before it may have changed the mesh; give it [stage.remesh] active = false",
                     stage.stage.name));
  if (!stage.panels.empty() || stage.mesh.options.rest == formats::RestShape::texture)
    fail("panels are flat without stress; use a mesh whose own shape is without stress");
}

}  // namespace

void assign_mode_stages(std::vector<Case>& stages) {
  std::size_t first = 0;  // that has the imperfect shape
  for (const ImperfectionSection& s : stages.front().imperfections) {
    if (s.stage.empty()) continue;
    const std::size_t number = mode_stage_of(stages, s);
    stages[number].stage.gives_modes = true;
    first = std::max(first, number + 1);
  }
  if (first == 0) return;
  for (std::size_t k = 0; k < stages.size(); ++k) {
    stages[k].stage.takes_modes = k >= first;
    stages[k].stage.begins_anew = k == first;
    if (k >= first) continue;
    require_nothing_left(stages[k], stages[first].stage.name);
    stages[k].imperfections.clear();
  }
}

}  // namespace voile::input
