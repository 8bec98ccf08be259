// What an analysis makes of a material other than its figures say, and would not say by itself.
#include <fmt/format.h>

#include <algorithm>

#include "case_declarations.hpp"
#include "case_read.hpp"
#include "case_rubber.hpp"
#include "voile/errors.hpp"

namespace voile::input {

namespace {

bool has_curves(const energy::Material& m) {
  const auto& knots = m.yarns.knots;
  return std::any_of(knots.begin(), knots.end(), [](const auto& k) { return !k.empty(); });
}

std::string name_of(const energy::Material& m) {
  return m.groups.empty() ? "the [[material]] of all other triangles"
                          : "the [[material]] of '" + m.groups.front() + "'";
}

/// Whether a linear analysis, or one of modes, is about the shape without strain.
bool is_about_rest(const Case& c) {
  const auto constant = [](const auto& acting) { return acting.constant; };
  if (c.stage.number > 0) return false;
  if (c.analysis == Analysis::linear) return true;
  return c.finds_modes() && c.eigen.load_factor == 0.0 && std::none_of(c.loads.begin(), c.loads.end(), constant) &&
         std::none_of(c.temperatures.begin(), c.temperatures.end(), constant) &&
         std::none_of(c.hinges.begin(), c.hinges.end(), constant);
}

}  // namespace

std::vector<std::string> material_notes(const Case& c) {
  std::vector<std::string> notes;
  if (is_about_rest(c))
    for (const energy::Material& m : c.materials)
      if (has_curves(m) && m.initial_strain.isZero(0.0))
        notes.push_back(
            fmt::format("analysis = \"{}\": of the curves of {} it takes the tangent at zero strain, where a fabric is "
                        "softest; give "
                        "its `initial_strain`, or a [[stage]] with a static analysis before",
                        word_of(c.analysis), name_of(m)));
  for (const energy::Material& m : c.materials)
    if (const std::string note = m.rubber.any() ? ellipticity_note(m.rubber) : ""; !note.empty())
      notes.push_back(
          fmt::format("{}: {}; beyond it strains gather in single cells, check its moduli", name_of(m), note));
  const auto turns = [](const system::Load& l) { return l.kind == system::Load::Kind::follower_moment; };
  if (std::any_of(c.loads.begin(), c.loads.end(), turns) &&
      std::any_of(c.materials.begin(), c.materials.end(), energy::couples))
    notes.emplace_back(
        "[[load]] type 'follower_moment' on an unsymmetric laminate: in the two rows of cells at the edge forces and "
        "stresses are off by up to half of the moment's; read them further inside");
  if (c.output.stresses == OutputSection::Stresses::none) return notes;
  for (const energy::Material& m : c.materials)
    if (m.layers.empty())
      notes.push_back(fmt::format("output.stresses: 0 in {}, whose inside is not known", name_of(m)));
  return notes;
}

void read_output(const CaseReader& reader, Case& c) {
  const SectionPlace place = reader.read("output", 0, keys_of(c.output));
  if (c.time.options.method == solve::TimeOptions::Method::central_difference && !place.has("energy_balance"))
    c.output.energy_balance = false;
  const auto is_known = [](const energy::Material& m) { return !m.layers.empty(); };
  if (c.output.stresses == OutputSection::Stresses::none ||
      std::any_of(c.materials.begin(), c.materials.end(), is_known))
    return;
  place.fail(
      "stresses",
      "no [[material]] has stresses through its thickness: stretching and bending of a fabric or of matrices are "
      "given apart; remove the key, and take the fields membrane_force and bending_moment");
}

}  // namespace voile::input
