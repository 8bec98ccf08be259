#include "case_natural.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

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

void read_hinges(CaseReader& reader, Case& c) {
  read_all(reader, "hinge", c.hinges, [&](const SectionPlace& place, system::Hinge& hinge) {
    if (!c.panels.empty() || c.mesh.options.rest == io::RestShape::texture)
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

void check_imperfection(const SectionPlace& place, const Case& c, ImperfectionSection& s) {
  using Type = ImperfectionSection::Type;
  if (s.type == Type::expression) (void)place_function(place, "height", s.height, false);
  if (s.type != Type::modes) return;
  s.results = beside(c.file, s.results);
  for (const double mode : s.modes)
    if (!(mode >= 1.0) || mode != std::floor(mode))
      place.fail("modes", fmt::format("{:g}: whole numbers from 1 are needed", mode));
  if (s.amplitudes.size() != 1 && s.amplitudes.size() != s.modes.size())
    place.fail("amplitudes", fmt::format("{} amplitudes for {} modes; give one for each, or one for all",
                                         s.amplitudes.size(), s.modes.size()));
}

}  // namespace voile::input
