#include "case_pattern.hpp"

#include <fmt/format.h>

#include <cmath>

#include "case_materials.hpp"
#include "case_sections.hpp"
#include "voile/errors.hpp"

namespace voile::input {

namespace {

/// Coordinate of a place that a garment could have [m]; far beyond it cells have no area in double precision.
constexpr double largest = 1e6;

void check_place(const SectionPlace& place, const PanelSection& s, const char* key, const Vec3& value) {
  if (value.cwiseAbs().maxCoeff() <= largest) return;
  const std::string panel = s.name.empty() ? s.file.filename().string() : s.name;
  place.fail(key,
             fmt::format("[{:g}, {:g}, {:g}]: panel '{}' would lie further away than {:g} m; give coordinates near "
                         "the body, in metres",
                         value[0], value[1], value[2], panel, largest));
}

/// What says where the pieces of a panel are.
void check_places(const SectionPlace& place, const PanelSection& s) {
  check_place(place, s, "translate", s.placement.translate);
  check_place(place, s, "origin", s.origin.at);
  check_place(place, s, "wrap_point", s.wrap_point.at);
  if (s.wrap_end) check_place(place, s, "wrap_end", s.wrap_end->at);
}

void check_wrap(const SectionPlace& place, const PanelSection& s) {
  if (s.wrap_axis && s.wrap_end)
    place.fail("wrap_axis", "wrap_point and wrap_end have a direction; remove one of the keys");
  const bool by_numbers = s.wrap_end && s.wrap_end->landmark.empty() && s.wrap_point.landmark.empty();
  if (by_numbers && !((s.wrap_end->at - s.wrap_point.at).norm() > 0.0))
    place.fail("wrap_end", "it is wrap_point itself; give another point on the axis");
  for (const char* key : {"wrap_point", "wrap_along", "wrap_shift", "wrap_radius", "wrap_angle", "wrap_radii"})
    if (place.has(key) && !s.wrap_axis && !s.wrap_end)
      place.fail("wrap_axis", fmt::format("the key is missing; {} is about an axis", key));
  if (s.wrap_radii.empty()) return;
  if (!s.wrap_end) place.fail("wrap_end", "the key is missing: where the second of wrap_radii is");
  if (place.has("wrap_radius") || place.has("wrap_angle"))
    place.fail("wrap_radii", "they replace wrap_radius and wrap_angle; remove those");
  if (s.wrap_radii.size() != 2 || !(s.wrap_radii[0] + s.wrap_radii[1] > 0.0))
    place.fail("wrap_radii", "two numbers are needed, at wrap_point and at wrap_end, that are not both zero");
}

}  // namespace

void read_pattern(const CaseReader& reader, Case& c) {
  read_all(reader, "panel", c.panels, [&](const SectionPlace& place, PanelSection& s) {
    s.file = beside(c.file, s.file);
    if (!s.grain.empty() && (s.grain.size() != 2 || !(std::hypot(s.grain[0], s.grain[1]) > 0.0)))
      place.fail("grain", "two numbers [x, y] are needed that are not both zero");
    check_places(place, s);
    check_wrap(place, s);
  });
  read_all(reader, "seam", c.seams, [&](const SectionPlace& place, const SeamSection& s) {
    if (!s.meet.empty() && s.meet.size() != 2)
      place.fail("meet", fmt::format("{} points; two are needed, an end of `edges` and an end of `to`", s.meet.size()));
    if (s.zip_speed > 0.0 && s.meet.empty())
      place.fail("meet", "the key is missing; zip_speed closes the seam from the two points on that come together");
    if (c.panels.empty()) place.fail("edges", "there is no [[panel]] that they could belong to");
  });
  read_all(reader, "mark", c.marks, [&](const SectionPlace& place, const MarkSection& m) {
    if (c.panels.empty()) place.fail("name", "there is no [[panel]] that it could belong to");
    if (m.point.empty() == m.panel.empty())
      place.fail("point", m.point.empty() ? "the key is missing; give it, or panel and at"
                                          : "it gives the place of the mark; remove the key panel, or this one");
    if (!m.panel.empty() && m.at.size() != 2) place.fail("at", "two numbers [x, y] are needed, in metres");
    if (m.panel.empty() && !m.at.empty()) place.fail("at", "point gives the place of the mark; remove the key");
  });
  reader.read("sewing", 0, keys_of(c.sewing));
  if (!c.stage.sew.empty() && c.panels.empty())
    throw UserError(
        fmt::format("{}: [[stage]] '{}' sew: there are no [[panel]] with seams", c.file.string(), c.stage.name));
}

/// The mesh is made from panels.
void check_panel_mesh(const SectionPlace& place, const Case& c) {
  for (const char* key : {"file", "start", "rest", "texture_unit", "scale", "size", "algorithm", "merge",
                          "merge_tolerance", "parameters", "up_axis", "rotate", "translate"})
    if (place.has(key)) place.fail(key, "the surface is cut from [[panel]]; remove the key, or the panels");
  if (c.analysis == Analysis::linear)
    throw UserError(
        fmt::format("{}: analysis = \"linear\" begins from the shape without strain, which placed panels do "
                    "not have; use analysis = \"static\"",
                    c.file.string()));
}

}  // namespace voile::input
