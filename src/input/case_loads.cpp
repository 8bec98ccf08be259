#include "case_loads.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "case_natural.hpp"
#include "expression.hpp"
#include "voile/errors.hpp"

namespace voile::input {

namespace {

bool is_number(const std::string& text) {
  char* end = nullptr;
  (void)std::strtod(text.c_str(), &end);
  return end != text.c_str() && *end == '\0';
}

void read_load_history(const SectionPlace& place, const Case& c, system::Load& load) {
  if (load.history_text.empty()) return;
  if (c.analysis != Analysis::dynamic && !c.is_staged())
    place.fail("history", "a load has a time only with analysis = \"dynamic\"");
  if (load.constant) place.fail("constant", "a load with a history of its own is not constant; remove one of the keys");
  load.history = time_function(place, "history", load.history_text);
}

void check_leak(const SectionPlace& place, const Case& c, const system::Load& load) {
  if (c.analysis != Analysis::dynamic && !c.is_staged())
    place.fail("leak_area",
               fmt::format("a gas leaks in time, and analysis = \"{}\" has none; use dynamic, or remove the "
                           "key",
                           word_of(c.analysis)));
  if (load.exponent == 0.0)
    place.fail("exponent", "at constant pressure a leak changes nothing; give 1 or more, or remove leak_area");
  if (load.ambient == 0.0) place.fail("ambient", "a leak needs the pressure outside, to which `density` belongs");
}

/// What a gas cannot be part of.
void check_gas(const SectionPlace& place, const Case& c, const system::Load& load) {
  if (load.kind != system::Load::Kind::gas) return;
  if (c.analysis == Analysis::linear || c.analysis == Analysis::buckling || c.analysis == Analysis::drape ||
      c.analysis == Analysis::harmonic)
    place.fail("type", fmt::format("analysis = \"{}\" has no gas; use static, modal or dynamic, or follower_pressure",
                                   word_of(c.analysis)));
  if (!c.panels.empty()) place.fail("type", "panels that are sewn enclose nothing at the start; use follower_pressure");
  if (load.ambient + load.magnitude <= 0.0)
    place.fail("magnitude", fmt::format("with ambient = {:g} Pa the absolute pressure would be {:g} Pa; a gas has more "
                                        "than 0",
                                        load.ambient, load.ambient + load.magnitude));
  if (place.has("density") && !(load.leak_area > 0.0))
    place.fail("density", "nothing of the gas leaks; give leak_area, or remove the key");
  if (load.leak_area > 0.0) check_leak(place, c, load);
}

}  // namespace

std::function<double(double)> time_function(const SectionPlace& place, const char* key, const std::string& text) {
  const auto named = [place, key](const auto& f) {
    try {
      return f();
    } catch (const UserError& e) {
      place.fail(key, e.what());
    }
  };
  return [named, value = named([&] { return expression(text); })](double t) { return named([&] { return value(t); }); };
}

void read_load(const SectionPlace& place, const Case& c, system::Load& load) {
  read_load_history(place, c, load);
  check_gas(place, c, load);
  if (load.distribution_text.empty()) return;
  load.distribution = [value = place_function(place, "distribution", load.distribution_text, false).value](
                          const Vec3& x) { return value(x, 0.0); };
}

void read_wind(const SectionPlace& place, const Case& c, energy::DragOptions& s) {
  if (s.wind_texts.size() != 3)
    place.fail("wind", fmt::format("{} components; three are needed, for x, y and z", s.wind_texts.size()));
  std::vector<std::function<double(double)>> w;
  for (const std::string& text : s.wind_texts) w.push_back(time_function(place, "wind", text));
  const auto at = [w](double t) { return Vec3(w[0](t), w[1](t), w[2](t)); };
  s.wind = at(0.0);
  if (!std::all_of(s.wind_texts.begin(), s.wind_texts.end(), is_number)) s.wind_in_time = at;
  if (place.has("density") && !c.is_staged() && !place.has("normal_drag") && !place.has("tangential_drag"))
    place.fail("density",
               "without a drag coefficient the air has no force on the sheet; give normal_drag or "
               "tangential_drag, or remove the section");
  if ((s.wind.norm() > 0.0 || s.wind_in_time) && !s.active())
    place.fail("wind", "the air has no force on the sheet; give normal_drag or tangential_drag");
  if ((s.wind.norm() > 0.0 || s.wind_in_time) && c.analysis != Analysis::dynamic && !c.is_staged())
    place.fail("wind", fmt::format("analysis = \"{}\" has no wind; use dynamic, or a pressure", word_of(c.analysis)));
}

bool has_gas(const Case& c) {
  return std::any_of(c.loads.begin(), c.loads.end(),
                     [](const system::Load& l) { return l.kind == system::Load::Kind::gas; });
}

}  // namespace voile::input
