#include "fabric_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>

#include "base/text.hpp"
#include "input/fabric.hpp"
#include "voile/errors.hpp"

namespace voile::fit {

namespace {

using P = Parameter;

constexpr const char* typical_tension = "2 kN/m";
constexpr const char* typical_shear = "50 N/m";

struct Entry {
  std::string key, value, source;
  std::optional<std::string> instead{};  ///< of a figure that the sheet does not determine
};

std::string percent(double relative) {
  return fmt::format("{:.2g} %", 100.0 * relative);
}

/// The laboratory, or the name of the sheet.
std::string origin(const Sheet& sheet) {
  return sheet.source.empty() ? std::filesystem::path(sheet.file).filename().string() : sheet.source;
}

std::string uncertainty(const Determined& d) {
  return fmt::format(
      "standard uncertainty {}{}", percent(d.deviation),
      d.assumed ? fmt::format(", for single figures assumed to have {}", percent(assumed_deviation)) : "");
}

std::string source_of(const Sheet& sheet, const Determined& d) {
  return fmt::format("{} of {}; {}", join(d.sources, ", "), origin(sheet), uncertainty(d));
}

std::string with_unit(P p, double value) {
  return fmt::format("{:.6g} {}", value / name_of(p).si, name_of(p).unit);
}

std::string points_text(const CurveFit& curve, bool shear) {
  std::vector<std::string> rows;
  for (const RecordPoint& p : curve.points)
    rows.push_back(fmt::format("[{:.6g}, {:.6g}]", p.x / (shear ? degree : 0.01), p.force));
  return fmt::format("{{ units = [\"{}\", \"N/m\"], points = [{}] }}", shear ? "deg" : "%", join(rows, ", "));
}

/// How a curve was found.
std::string curve_source(const FittedCurve& c) {
  std::string text = fmt::format("{} points of {}", c.fit.points.size(), c.source);
  if (c.fit.deviation > 0.0)
    text += fmt::format("; its rows deviate by {} of the largest force", percent(c.fit.deviation));
  if (c.fit.uncertainty > 0.0) text += fmt::format("; standard uncertainty {}", percent(c.fit.uncertainty));
  return text;
}

/// Tension along one direction, or shear: a curve, a stiffness, both, or nothing.
std::vector<Entry> law_of(const Sheet& sheet, const Fit& fit, const char* curve, P stiffness,
                          const std::optional<std::pair<P, P>>& figures) {
  std::vector<Entry> entries;
  if (fit.curves.contains(curve)) {
    const FittedCurve& c = fit.curves.at(curve);
    entries.push_back({curve, points_text(c.fit, !figures), fmt::format("{} ({})", curve_source(c), origin(sheet))});
  } else if (figures && fit.has(figures->first)) {
    const Determined &e = fit.figures.at(figures->first), &w = fit.figures.at(figures->second);
    entries.push_back({curve,
                       fmt::format("{{ EMT = \"{}\", WT = \"{}\", load = \"{:.6g} N/m\" }}",
                                   with_unit(figures->first, e.value), with_unit(figures->second, w.value), sheet.load),
                       fmt::format("{}; WT: {}", source_of(sheet, e), uncertainty(w))});
  }
  if (fit.has(stiffness)) {
    const Determined& d = fit.figures.at(stiffness);
    entries.push_back({name_of(stiffness).key, toml_text(with_unit(stiffness, d.value)), source_of(sheet, d)});
  }
  return entries;
}

/// The law of one direction for the other, if that has one.
std::vector<Entry> copied(std::vector<Entry> entries, const char* from, const char* to) {
  for (Entry& e : entries) {
    e.key.replace(e.key.find(from), std::string(from).size(), to);
    e.instead = fmt::format("that of the {}", from);
    e.source = fmt::format("not measured; that of the {}", from);
  }
  return entries;
}

void add_tension(const Sheet& sheet, const Fit& fit, std::vector<Entry>& all) {
  std::vector<Entry> warp = law_of(sheet, fit, "tension_warp", P::membrane_warp, {{P::extension_warp, P::work_warp}}),
                     weft = law_of(sheet, fit, "tension_weft", P::membrane_weft, {{P::extension_weft, P::work_weft}}),
                     shear = law_of(sheet, fit, "shear_curve", P::membrane_shear, std::nullopt);
  const auto typical = [](const char* key, const char* value, const char* range) {
    return std::vector{Entry{key, toml_text(value),
                             fmt::format("not measured; middle of the typical range of wovens, {}", range),
                             fmt::format("{}, middle of the typical range of wovens, {}", value, range)}};
  };
  const bool none = warp.empty() && weft.empty();
  if (none) warp = typical("membrane_warp", typical_tension, "0.5 to 10 kN/m");
  if (none) weft = typical("membrane_weft", typical_tension, "0.5 to 10 kN/m");
  if (warp.empty()) warp = copied(weft, "weft", "warp");
  if (weft.empty()) weft = copied(warp, "warp", "weft");
  if (shear.empty()) shear = typical("membrane_shear", typical_shear, "20 to 100 N/m");
  for (const auto& part : {warp, weft, shear}) all.insert(all.end(), part.begin(), part.end());
}

/// A figure, or in its place that of the other direction.
void add_or_copy(const Sheet& sheet, const Fit& fit, P figure, P other, std::vector<Entry>& all) {
  if (!fit.has(figure) && !fit.has(other)) return;
  const bool own = fit.has(figure);
  const Determined& d = fit.figures.at(own ? figure : other);
  Entry e{name_of(figure).key, toml_text(with_unit(figure, d.value)), source_of(sheet, d)};
  if (!own) e.source = fmt::format("not measured; that of {}", name_of(other).key);
  if (!own) e.instead = fmt::format("{}, that of {}", with_unit(figure, d.value), name_of(other).key);
  all.push_back(std::move(e));
}

std::vector<Entry> entries_of(const Sheet& sheet, const Fit& fit) {
  std::vector<Entry> all;
  const auto add = [&](P p) {
    if (fit.has(p)) add_or_copy(sheet, fit, p, p, all);
  };
  add(P::areal_density);
  add(P::thickness);
  add_tension(sheet, fit, all);
  add(P::shear_hysteresis);
  add(P::shear_hysteresis_5);
  add(P::shear_hysteresis_spread);
  add_or_copy(sheet, fit, P::bending_warp, P::bending_weft, all);
  add_or_copy(sheet, fit, P::bending_weft, P::bending_warp, all);
  add(P::bending_twist);
  add_or_copy(sheet, fit, P::bending_hysteresis, P::bending_hysteresis_weft, all);
  add(P::bending_hysteresis_weft);
  add(P::bending_hysteresis_spread);
  return all;
}

std::string figure_line(P p, const Determined& d) {
  return fmt::format("  {:<26} {:>18} +- {:<7} {}{}", name_of(p).key, with_unit(p, d.value), percent(d.deviation),
                     join(d.sources, ", "), d.assumed ? " (assumed uncertainty)" : "");
}

}  // namespace

std::vector<Undetermined> undetermined(const Sheet& sheet, const Fit& fit) {
  std::vector<Undetermined> all;
  for (const Entry& e : entries_of(sheet, fit))
    if (e.instead) all.push_back({e.key, *e.instead});
  const auto without = [&](P p, const std::string& instead) {
    if (!fit.has(p)) all.push_back({name_of(p).key, instead});
  };
  without(P::thickness, "none; the stiffness does not depend on it");
  all.push_back({"membrane_poisson", "0"});
  all.push_back({"bending_poisson", "0"});
  without(P::bending_twist, "half of sqrt(bending_warp bending_weft), as of an isotropic sheet");
  if (!fit.has(P::bending_hysteresis) && !fit.has(P::bending_hysteresis_weft)) {
    all.push_back({"bending_hysteresis", "none: no friction in bending; damping as of 2HB/B = 46 1/m"});
  } else {
    all.push_back({"bending_hysteresis_twist", "0"});
    without(P::bending_hysteresis_spread, "10 1/m");
  }
  without(P::shear_hysteresis, "none: no friction in shear");
  if (fit.has(P::shear_hysteresis)) {
    without(P::shear_hysteresis_5, "the same width at all angles");
    without(P::shear_hysteresis_spread, "0.5 degrees");
  }
  return all;
}

std::string fabric_text(const Sheet& sheet, const Fit& fit) {
  const std::vector<Entry> entries = entries_of(sheet, fit);
  std::string text =
      fmt::format("# Made by voile fit from {}\n", printable(std::filesystem::path(sheet.file).filename().string()));
  text += fmt::format("name = {}\ndescription = {}\n\n", toml_text(sheet.name), toml_text(sheet.description));
  for (const Entry& e : entries) text += fmt::format("{} = {}\n", e.key, e.value);
  text += "\n[sources]\n";
  for (const Entry& e : entries) text += fmt::format("{} = {}\n", e.key, toml_text(e.source));
  text += "\n# Not determined by the measurements, and what holds instead:\n";
  for (const Undetermined& u : undetermined(sheet, fit)) text += fmt::format("#   {}: {}\n", u.key, u.instead);
  try {
    (void)input::parse_fabric(text, "fabric file");
  } catch (const UserError& e) {
    throw UserError(
        fmt::format("{}: these measurements make a fabric file that Voile would not read: {}", sheet.file, e.what()));
  }
  return text;
}

std::vector<std::string> report(const Sheet& sheet, const Fit& fit) {
  std::vector<std::string> lines{fmt::format("{}: {} measurements, {} figures, {} curves", sheet.name, fit.fitted,
                                             fit.figures.size(), fit.curves.size()),
                                 "determined (standard uncertainty):"};
  for (const auto& [p, d] : fit.figures) lines.push_back(figure_line(p, d));
  for (const auto& [key, curve] : fit.curves) lines.push_back(fmt::format("  {:<26} {}", key, curve_source(curve)));
  for (const FittedLoop& loop : fit.loops)
    lines.push_back(fmt::format("  {:<26} rows deviate from the law by {} of the range of the force", loop.name,
                                percent(loop.deviation)));
  lines.emplace_back("measurements:                     measured     of fabric               residual");
  for (const Comparison& c : fit.comparisons)
    lines.push_back(fmt::format("  {:<28} {:>11.5g} {:>13.5g} {:<12} {:>+8.1f} %{}", c.name, c.measured, c.found,
                                c.unit, std::round(1e3 * c.residual()) / 10.0 + 0.0,
                                c.compared ? "  (compared only)" : ""));
  lines.emplace_back("not determined, and what holds instead:");
  for (const Undetermined& u : undetermined(sheet, fit)) lines.push_back(fmt::format("  {:<26} {}", u.key, u.instead));
  if (std::any_of(sheet.measurements.begin(), sheet.measurements.end(),
                  [](const Measurement& m) { return m.name == "fast.EB5" || m.name == "fast.G"; }))
    lines.emplace_back(
        "membrane_shear is that of FAST, 123/EB5, which leaves out clamps and the stretch of the yarns: voile "
        "fabric-test "
        "shows by how much it is off");
  if (!sheet.unused.empty())
    lines.push_back(fmt::format("not used, since no key of a fabric file depends on it: {}", join(sheet.unused, ", ")));
  return lines;
}

}  // namespace voile::fit
