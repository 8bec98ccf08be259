#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <numbers>
#include <sstream>

#include "base/plain_file.hpp"
#include "base/text.hpp"
#include "case_fabric_curves.hpp"
#include "case_read.hpp"
#include "case_toml.hpp"
#include "energy/material.hpp"
#include "fabric.hpp"
#include "units.hpp"
#include "voile/errors.hpp"

namespace voile::input {

namespace {

/// A figure of a fabric file.
struct Figure {
  std::string name;
  std::vector<Dimension> dimensions;  ///< that it may be given in, the first one named in messages; empty: a ratio
  bool required;
  std::function<void(Fabric&, double)> set;
};

/// Areal density first: bending lengths need it.
const std::vector<Figure>& figures() {
  using enum Dimension;
  const std::vector<Dimension> rigidity{bending_rigidity, fast_bending_length};
  static const std::vector<Figure> all{
      {"areal_density", {mass_per_area}, true, [](Fabric& f, double x) { f.areal_density = x; }},
      {"thickness", {length}, false, [](Fabric& f, double x) { f.thickness = x; }},
      // Tangents at zero of the curves, where there are some.
      {"membrane_warp", {force_per_length}, true, [](Fabric& f, double x) { f.membrane_warp = x; }},
      {"membrane_weft", {force_per_length}, true, [](Fabric& f, double x) { f.membrane_weft = x; }},
      {"membrane_shear", {shear_rigidity, force_per_length}, true, [](Fabric& f, double x) { f.membrane_shear = x; }},
      {"membrane_poisson", {}, false, [](Fabric& f, double x) { f.membrane_poisson = x; }},
      {"shear_hysteresis", {force_per_length}, false, [](Fabric& f, double x) { f.shear_hysteresis = x; }},
      {"shear_hysteresis_5", {force_per_length}, false, [](Fabric& f, double x) { f.shear_hysteresis_5 = x; }},
      {"shear_hysteresis_spread", {angle}, false, [](Fabric& f, double x) { f.shear_hysteresis_spread = x; }},
      {"bending_warp", rigidity, true, [](Fabric& f, double x) { f.bending_warp = x; }},
      {"bending_weft", rigidity, true, [](Fabric& f, double x) { f.bending_weft = x; }},
      {"bending_twist", {bending_rigidity}, false, [](Fabric& f, double x) { f.bending_twist = x; }},
      {"bending_poisson", {}, false, [](Fabric& f, double x) { f.bending_poisson = x; }},
      {"bending_hysteresis", {moment_per_width}, false, [](Fabric& f, double x) { f.bending_hysteresis = x; }},
      {"bending_hysteresis_weft",
       {moment_per_width},
       false,
       [](Fabric& f, double x) { f.bending_hysteresis_weft = x; }},
      {"bending_hysteresis_twist",
       {moment_per_width},
       false,
       [](Fabric& f, double x) { f.bending_hysteresis_twist = x; }},
      {"bending_hysteresis_spread", {curvature}, false, [](Fabric& f, double x) { f.bending_hysteresis_spread = x; }},
  };
  return all;
}

std::vector<std::string> figure_names() {
  std::vector<std::string> names;
  for (const Figure& figure : figures()) names.push_back(figure.name);
  names.insert(names.end(), curve_keys.begin(), curve_keys.end());
  return names;
}

std::string text_of(const SectionPlace& place, const std::string& key, const toml::node& node) {
  std::string text = node.value<std::string>().value_or("");
  if (!node.is_string() || text.find_first_not_of(' ') == std::string::npos)
    place.fail(key, "a text in quotes is needed");
  return text;
}

SectionPlace place_of(const std::string& file, const std::string& name, const toml::table& table, int line,
                      const std::vector<std::string>& valid) {
  SectionPlace place{file, name, line, {}};
  for (const auto& [key, node] : table) place.key_lines[std::string(key.str())] = line_of(key.source());
  for (const auto& [key, key_line] : place.key_lines)
    if (std::find(valid.begin(), valid.end(), key) == valid.end())
      throw UserError(fmt::format("{}:{}: {}unknown key '{}':{}", file, key_line,
                                  name.empty() ? "" : fmt::format("[{}] ", name), key, suggestion(key, valid)));
  return place;
}

double ratio(const SectionPlace& place, const Figure& figure, const toml::node& node) {
  const double x = node.is_number() ? *node.value<double>() : std::nan("");
  if (!(std::abs(x) < 1.0))
    place.fail(figure.name, "a number between -1 and 1 is needed; beyond, the stiffness is not positive definite");
  return x;
}

double quantity(const SectionPlace& place, const Figure& figure, const std::string& text, double areal_density) {
  Quantity q;
  try {
    q = parse_quantity(text);
  } catch (const UserError& e) {
    place.fail(figure.name, e.what());
  }
  if (std::find(figure.dimensions.begin(), figure.dimensions.end(), q.dimension) == figure.dimensions.end()) {
    std::vector<std::string> valid;
    for (const Dimension d : figure.dimensions)
      for (const std::string& unit : units_of(d)) valid.push_back(unit);
    place.fail(figure.name, fmt::format("'{}' is {}, {} is needed: {}", text, name_of(q.dimension),
                                        name_of(figure.dimensions.front()), join(valid, ", ")));
  }
  return q.dimension == Dimension::fast_bending_length ? bending_rigidity(areal_density, q.value) : q.value;
}

double value_of(const SectionPlace& place, const Figure& figure, const toml::node& node, double areal_density) {
  if (figure.dimensions.empty()) return ratio(place, figure, node);
  if (!node.is_number() && !node.is_string())
    place.fail(figure.name, "a number in SI units or a text with a unit is needed");
  const double x =
      node.is_number() ? *node.value<double>() : quantity(place, figure, *node.value<std::string>(), areal_density);
  if (!(x > 0.0 && std::isfinite(x))) place.fail(figure.name, "the figure must be finite and greater than zero");
  // Slips of units; the heaviest carpets weigh half of this, and are a quarter as thick.
  if (figure.name == "areal_density" && !(x >= 1e-3 && x <= 10.0))
    place.fail(figure.name,
               fmt::format("{:g} kg/m^2 is no fabric's: they weigh 0.001 to 10 kg/m^2; check the unit", x));
  if (figure.name == "thickness" && !(x >= 1e-6 && x <= 0.1))
    place.fail(figure.name, fmt::format("{:g} m is no fabric's: they are 1e-6 to 0.1 m thick; check the unit", x));
  return x;
}

/// A figure nobody can trace is worth nothing: each needs its source, and each source its figure.
void check_sources(const SectionPlace& top, const toml::table& root) {
  const toml::node* node = root.get("sources");
  if (!node || !node->is_table())
    top.fail("sources", "the table is missing; add [sources] with a text for every figure");
  const SectionPlace place = place_of(top.file, "sources", *node->as_table(), line_of(node->source()), figure_names());
  for (const auto& [key, source] : *node->as_table()) (void)text_of(place, std::string(key.str()), source);
  for (const std::string& name : figure_names()) {
    if (top.has(name) && !place.has(name))
      top.fail(name, fmt::format("the source is missing; write in [sources] where this figure comes from: {} = \"...\"",
                                 name));
    if (!top.has(name) && place.has(name)) place.fail(name, "there is no such figure in this file");
  }
}

void check_stiffness(const SectionPlace& place, const Fabric& fabric) {
  if (!energy::is_positive_definite(membrane_stiffness(fabric)))
    place.fail("membrane_poisson", "the membrane stiffness is not positive definite; check the membrane figures");
  if (!energy::is_positive_definite(bending_stiffness(fabric)))
    place.fail("bending_poisson", "the bending stiffness is not positive definite; check the bending figures");
  for (const char* key : curve_keys)
    if (place.has(key) && !energy::is_stable(membrane_stiffness(fabric), yarn_law(fabric, false)))
      place.fail(key,
                 fmt::format("with membrane_poisson = {:g} the curves lose their stability where they are flattest; "
                             "give a smaller membrane_poisson, or correct the curve",
                             fabric.membrane_poisson));
  check_shear_friction(place, fabric);
}

Mat3 orthotropic(double s11, double s22, double s66, double poisson) {
  Mat3 s = Mat3::Zero();
  s(0, 0) = s11;
  s(1, 1) = s22;
  s(2, 2) = s66;
  s(0, 1) = s(1, 0) = poisson * std::sqrt(s11 * s22);
  return s;
}

/// Curves, then what is left of the figures. Membrane stiffness is that of a curve where it begins.
void read_figures(const SectionPlace& place, const toml::table& root, Fabric& fabric) {
  const std::array membrane{&fabric.membrane_warp, &fabric.membrane_weft, &fabric.membrane_shear};
  const std::array names{"membrane_warp", "membrane_weft", "membrane_shear"};
  std::array<std::optional<CurveFigures>, 3> curves;
  for (std::size_t r = 0; r < 3; ++r)
    if (const toml::node* node = root.get(curve_keys[r])) {
      curves[r] = read_curve({place, curve_keys[r], r == 2}, *node);
      if (!curves[r]->points.empty() && place.has(names[r]))
        place.fail(names[r], fmt::format("the points of {} give this figure; leave one of them out", curve_keys[r]));
    }
  for (const Figure& figure : figures()) {
    if (const toml::node* node = root.get(figure.name)) {
      figure.set(fabric, value_of(place, figure, *node, fabric.areal_density));
    } else if (figure.required) {
      const auto r = static_cast<std::size_t>(std::find(names.begin(), names.end(), figure.name) - names.begin());
      if (r == names.size() || !curves[r])
        place.fail(figure.name, fmt::format("the key is missing; {} is needed", name_of(figure.dimensions.front())));
    }
  }
  for (std::size_t r = 0; r < 3; ++r)
    if (curves[r]) {
      fabric.curves[r] = curve_of({place, curve_keys[r], r == 2}, *curves[r], *membrane[r]);
      *membrane[r] = fabric.curves[r]->tangent;
    }
  if (curves[2] && fabric.shear_hysteresis) fabric.rubbing_shear = middle_of_loop(fabric, curves[2]->points);
}

}  // namespace

Mat3 membrane_stiffness(const Fabric& f, bool friction) {
  double shear = f.membrane_shear;
  if (friction && f.rubbing_shear) {
    shear = f.rubbing_shear->tangent;
  } else if (friction && f.shear_hysteresis) {
    const energy::YarnLaw law = yarn_law(f, true);
    shear -= law.stiffness * law.rise / (law.stiffness + law.rise);
  }
  return orthotropic(f.membrane_warp, f.membrane_weft, shear, f.membrane_poisson);
}

Mat3 bending_stiffness(const Fabric& f) {
  const double isotropic_twist = 0.5 * (1.0 - f.bending_poisson) * std::sqrt(f.bending_warp * f.bending_weft);
  return orthotropic(f.bending_warp, f.bending_weft, f.bending_twist.value_or(isotropic_twist), f.bending_poisson);
}

Vec3 bending_loop(const Fabric& f) {
  if (!f.bending_hysteresis && f.shear_hysteresis) return Vec3::Zero();
  if (!f.bending_hysteresis)
    throw UserError(
        "the file has neither bending_hysteresis nor shear_hysteresis (2HB, 2HG of KES), so that its friction is not "
        "known; add one with its source, or leave out hysteresis = \"friction\"");
  const double warp = *f.bending_hysteresis;
  return {warp, f.bending_hysteresis_weft.value_or(warp), f.bending_hysteresis_twist.value_or(0.0)};
}

double bending_damping(const Fabric& f) {
  constexpr double gravity = 9.80665;
  const double rigidity = std::sqrt(f.bending_warp * f.bending_weft);
  const double length = std::cbrt(rigidity / (f.areal_density * gravity));
  const double loop = f.bending_hysteresis ? *f.bending_hysteresis / rigidity : typical_hysteresis;
  return 2.0 * loop * length / std::numbers::pi * std::sqrt(length / gravity);
}

Fabric parse_fabric(const std::string& text, const std::filesystem::path& file) {
  toml::table root;
  try {
    root = toml::parse(text);
  } catch (const toml::parse_error& e) {
    throw UserError(
        fmt::format("{}:{}: this is not valid TOML: {}", file.string(), line_of(e.source()), e.description()));
  }
  std::vector<std::string> valid{"name", "description", "sources"};
  for (const std::string& name : figure_names()) valid.push_back(name);
  const SectionPlace place = place_of(file.string(), "", root, 0, valid);
  for (const char* key : {"name", "description"})
    if (!place.has(key)) place.fail(key, "the key is missing; describe the fabric in words");
  Fabric fabric;
  fabric.name = text_of(place, "name", *root.get("name"));
  fabric.description = text_of(place, "description", *root.get("description"));
  read_figures(place, root, fabric);
  for (const char* key : {"bending_hysteresis_weft", "bending_hysteresis_twist", "bending_hysteresis_spread"})
    if (place.has(key) && !fabric.bending_hysteresis)
      place.fail(key, "there is no bending_hysteresis, the loop along the warp, that it belongs to; add it");
  for (const char* key : {"shear_hysteresis_5", "shear_hysteresis_spread"})
    if (place.has(key) && !fabric.shear_hysteresis)
      place.fail(key, "there is no shear_hysteresis (2HG), the loop at 0.5 degrees, that it belongs to; add it");
  check_sources(place, root);
  check_stiffness(place, fabric);
  return fabric;
}

Fabric read_fabric(const std::filesystem::path& file) {
  std::error_code ignored;
  std::ifstream in = open_input(file);
  if (!in || std::filesystem::is_directory(file, ignored))
    throw UserError(fmt::format("{}: there is no such fabric file", file.string()));
  std::ostringstream buffer;
  buffer << in.rdbuf();
  return parse_fabric(buffer.str(), file);
}

}  // namespace voile::input
