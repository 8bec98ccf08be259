#include "case_fabric_curves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "units.hpp"
#include "voile/errors.hpp"

namespace voile::input {

namespace {

constexpr double kes_load = 490.3325;  // 500 gf/cm [N/m]
/// Between LT as it is printed and that of WT and EMT; LT that the smooth curve can have.
constexpr double rounding = 0.02, least_linearity = 0.2, most_linearity = 0.999;
constexpr std::size_t most_points = 12;
constexpr double most_extension = 1.0, most_angle = 60.0 * degree;

std::string valid_units(Dimension dimension) {
  return join(units_of(dimension), ", ");
}

/// What to write instead of a number without its unit.
std::string with_unit(Dimension dimension) {
  if (dimension == Dimension::extension) return "write it in per cent, as \"4 %\"";
  return "write a text with one of " + valid_units(dimension);
}

/// A text with a unit of this dimension, in SI.
double quantity(const CurveKey& k, const std::string& name, const std::string& text, Dimension dimension) {
  if (text.find_first_not_of("0123456789.+-eE ") == std::string::npos)
    k.place.fail(k.key, fmt::format("{}: the unit of '{}' is missing; {}", name, text, with_unit(dimension)));
  Quantity q;
  try {
    q = parse_quantity(text);
  } catch (const UserError& e) {
    k.place.fail(k.key, fmt::format("{}: {}", name, e.what()));
  }
  if (q.dimension != dimension)
    k.place.fail(k.key, fmt::format("{}: '{}' is {}, {} is needed: {}", name, text, name_of(q.dimension),
                                    name_of(dimension), valid_units(dimension)));
  if (!(q.value > 0.0)) k.place.fail(k.key, fmt::format("{}: '{}' has to be greater than zero", name, text));
  return q.value;
}

/// The same of a table, whose figures need their units; 0: not there.
double figure(const CurveKey& k, const toml::table& table, const char* name, Dimension dimension) {
  const toml::node* node = table.get(name);
  if (!node) return 0.0;
  if (!node->is_string()) k.place.fail(k.key, fmt::format("{}: the unit is missing; {}", name, with_unit(dimension)));
  return quantity(k, name, *node->value<std::string>(), dimension);
}

CurveFigures tensile_figures(const CurveKey& k, const toml::table& table) {
  const double extension = figure(k, table, "EMT", Dimension::extension),
               given_work = figure(k, table, "WT", Dimension::energy_per_area),
               given_load = figure(k, table, "load", Dimension::force_per_length),
               load = given_load > 0.0 ? given_load : kes_load;
  double linearity = 0.0;
  if (const toml::node* node = table.get("LT")) {
    linearity = node->is_number() ? *node->value<double>() : 0.0;
    if (!(linearity > 0.0 && linearity < 2.0)) k.place.fail(k.key, "LT: a number between 0 and 2 is needed");
  }
  if (extension == 0.0 || (given_work == 0.0 && linearity == 0.0))
    k.place.fail(k.key, "EMT and one of WT and LT are needed, or units and points");
  if (extension > most_extension)
    k.place.fail(k.key, fmt::format("EMT: {:g} % is more than a fabric has; check the unit", 100.0 * extension));
  const double work = given_work > 0.0 ? given_work : 0.5 * linearity * load * extension,
               found = 2.0 * work / (load * extension);
  if (linearity > 0.0 && std::abs(found - linearity) > rounding)
    k.place.fail(k.key,
                 fmt::format("WT and EMT under {:g} N/m give LT = {:.3g}, not {:g}; correct one of the three, or "
                             "give the load",
                             load, found, linearity));
  CurveFigures c{{}, solver_point(false, extension, load), work};
  const double of_curve = 2.0 * work / (c.end.force * c.end.strain);
  if (of_curve < least_linearity || of_curve > most_linearity)
    k.place.fail(k.key,
                 fmt::format("LT = {:.3g}: a curve that stiffens smoothly needs {:g} to {:.3f}; give the curve as "
                             "units and points",
                             found, least_linearity, most_linearity * found / of_curve));
  return c;
}

/// A row of the points, in SI.
energy::YarnPoint row_of(const CurveKey& k, const toml::node& node, const energy::YarnPoint& scale, std::size_t n) {
  const toml::array* row = node.as_array();
  if (!row || row->size() != 2 || !(*row)[0].is_number() || !(*row)[1].is_number())
    k.place.fail(k.key,
                 fmt::format("points: row {} has to be two numbers, {} and force", n, k.shear ? "angle" : "extension"));
  return {scale.strain * *(*row)[0].value<double>(), scale.force * *(*row)[1].value<double>()};
}

CurveFigures measured_points(const CurveKey& k, const toml::table& table) {
  const toml::array *units = table.get_as<toml::array>("units"), *rows = table.get_as<toml::array>("points");
  const Dimension along = k.shear ? Dimension::angle : Dimension::extension;
  if (!units || units->size() != 2 || !(*units)[0].is_string() || !(*units)[1].is_string())
    k.place.fail(k.key, fmt::format("units: the units of both columns are needed, e.g. units = [\"{}\", \"gf/cm\"]",
                                    k.shear ? "deg" : "%"));
  if (!rows || rows->size() < 2 || rows->size() > most_points)
    k.place.fail(k.key, fmt::format("points: 2 to {} rows are needed, without that of zero", most_points));
  const auto unit = [&](std::size_t i, Dimension dimension) {
    return quantity(k, "units", "1 " + *(*units)[i].value<std::string>(), dimension);
  };
  const energy::YarnPoint scale{unit(0, along), unit(1, Dimension::force_per_length)};
  CurveFigures c;
  energy::YarnPoint before{0.0, 0.0}, read_before{0.0, 0.0};
  for (std::size_t i = 0; i < rows->size(); ++i) {
    const energy::YarnPoint read = row_of(k, (*rows)[i], scale, i + 1);
    const double most = k.shear ? most_angle : most_extension;
    if (!(read.strain < most))
      k.place.fail(k.key, fmt::format("points: row {}: {:g} is beyond {:g}; check the unit", i + 1,
                                      read.strain / scale.strain, most / scale.strain));
    const energy::YarnPoint point = solver_point(k.shear, read.strain, read.force);
    if (!(read.strain > read_before.strain && read.force > read_before.force && std::isfinite(point.force)))
      k.place.fail(k.key, fmt::format("points: row {}, [{:g}, {:g}], does not rise from the one before, [{:g}, {:g}]; "
                                      "a curve without loop that rises from zero is needed",
                                      i + 1, read.strain / scale.strain, read.force / scale.force,
                                      read_before.strain / scale.strain, read_before.force / scale.force));
    if (!(point.force > before.force))
      k.place.fail(k.key,
                   fmt::format("points: row {}, [{:g}, {:g}]: the force grows by less than the length, so that the "
                               "fabric would not be stable; correct the row, or end the curve before it",
                               i + 1, read.strain / scale.strain, read.force / scale.force));
    c.points.push_back(point);
    before = point;
    read_before = read;
  }
  return c;
}

}  // namespace

energy::YarnPoint solver_point(bool shear, double x, double force) {
  return shear ? energy::YarnPoint{std::sin(x), force / std::cos(x)}
               : energy::YarnPoint{x + 0.5 * x * x, force / (1.0 + x)};
}

CurveFigures read_curve(const CurveKey& k, const toml::node& node) {
  const toml::table* table = node.as_table();
  if (!table)
    k.place.fail(k.key, k.shear ? "a table is needed: { units = [\"deg\", \"gf/cm\"], points = [[0.5, 0.3], [8, 5]] }"
                                : "a table is needed, e.g. { EMT = \"5 %\", WT = \"8 gf.cm/cm^2\" }");
  std::vector<std::string> valid{"units", "points"};
  if (!k.shear) valid.insert(valid.begin(), {"EMT", "WT", "LT", "load"});
  const bool by_points = table->contains("points") || table->contains("units");
  for (const auto& [key, value] : *table) {
    const std::string name(key.str());
    if (std::find(valid.begin(), valid.end(), name) == valid.end())
      k.place.fail(k.key, fmt::format("unknown key '{}':{}", name, suggestion(name, valid)));
    if (by_points && name != "units" && name != "points")
      k.place.fail(k.key, fmt::format("{} and points are two ways to give the curve; leave one of them out", name));
  }
  return by_points || k.shear ? measured_points(k, *table) : tensile_figures(k, *table);
}

energy::YarnCurve curve_of(const CurveKey& k, const CurveFigures& c, double tangent) {
  if (!c.points.empty()) return energy::yarn_curve(c.points);
  if (tangent > 0.0) {
    const energy::Interval fits = energy::tangents_of(c.end, c.work);
    if (!(tangent > fits.least && tangent < fits.most))
      k.place.fail(k.key,
                   fmt::format("the tangent at zero, {:g} N/m, has to lie between {:.4g} and {:.4g} N/m with these "
                               "figures; correct or leave out the membrane stiffness along it",
                               tangent, fits.least, fits.most));
  }
  return energy::yarn_curve(c.end, c.work, tangent);
}

namespace {

/// Half of the width of the loop over the shear strain.
struct HalfWidth {
  double at_zero, slope;
};
HalfWidth half_width(const Fabric& f) {
  const energy::YarnPoint near = solver_point(true, 0.5 * degree, 0.5 * *f.shear_hysteresis),
                          far = solver_point(true, 5.0 * degree, 0.5 * f.shear_hysteresis_5.value_or(0.0));
  const double slope = f.shear_hysteresis_5 ? (far.force - near.force) / (far.strain - near.strain) : 0.0;
  return {near.force - slope * near.strain, slope};
}

}  // namespace

/// The branches of the loop lie at G_s (H0 + h e)/(G_s + h) above and G_s (H0 + h e)/(G_s - h) below the curve, at a strain e.
energy::YarnLaw yarn_law(const Fabric& f, bool friction) {
  energy::YarnLaw law;
  for (std::size_t r = 0; r < 3; ++r)
    if (f.curves[r]) law.knots[r] = f.curves[r]->knots;
  if (!friction || !f.shear_hysteresis) return law;
  if (f.rubbing_shear) law.knots[2] = f.rubbing_shear->knots;
  const HalfWidth half = half_width(f);
  law.stiffness = *f.shear_hysteresis / f.shear_hysteresis_spread;
  const double ratio = half.slope / law.stiffness,
               scale = 2.0 / (1.0 + std::sqrt(1.0 + 4.0 * ratio * ratio));  // 1 - (h/G_s)^2
  law.rise = scale * half.slope;
  law.limit = scale * half.at_zero;
  return law;
}

energy::YarnCurve middle_of_loop(const Fabric& f, std::vector<energy::YarnPoint> points) {
  const energy::YarnLaw law = yarn_law(f, true);
  const HalfWidth half = half_width(f);
  for (energy::YarnPoint& p : points) p.force += law.rise / law.stiffness * (half.at_zero + half.slope * p.strain);
  return energy::yarn_curve(points);
}

namespace {

constexpr int most_halvings = 8;

/// Whether the loop is open where 2HG is measured, and leaves the shear stiffness positive.
bool fits(const Fabric& f) {
  const energy::YarnLaw law = yarn_law(f, true);
  return law.limit <= law.stiffness * std::sin(0.5 * degree) && energy::is_stable(membrane_stiffness(f, true), law);
}

}  // namespace

void check_shear_friction(const SectionPlace& place, const Fabric& f) {
  if (!f.shear_hysteresis) return;
  const energy::YarnLaw law = yarn_law(f, true);
  const char* key = f.shear_hysteresis_5 ? "shear_hysteresis_5" : "shear_hysteresis";
  if (law.rise < 0.0 || law.limit <= 0.0)
    place.fail(key, fmt::format("2HG5 = {:g} N/m has to be 1 to 10 times 2HG = {:g} N/m; check the units",
                                f.shear_hysteresis_5.value_or(0.0), *f.shear_hysteresis));
  if (fits(f)) return;
  Fabric narrower = f;
  narrower.shear_hysteresis_spread = std::min(f.shear_hysteresis_spread, degree);
  for (int k = 0; k < most_halvings && !fits(narrower); ++k) narrower.shear_hysteresis_spread *= 0.5;
  if (fits(narrower))
    place.fail(
        "shear_hysteresis_spread",
        fmt::format("{:.3g} degrees: the loop of these figures has to turn over less, to be open at 0.5 degrees, where "
                    "2HG is measured, and to leave the fabric stiff; give at most {:.2g}",
                    f.shear_hysteresis_spread / degree, narrower.shear_hysteresis_spread / degree));
  place.fail(key,
             fmt::format("the loop grows so fast ({:.3g} N/m per radian) that the shear stiffness of {:.3g} N/m does "
                         "not carry it; check shear figures and units",
                         law.rise, f.membrane_shear));
}

}  // namespace voile::input
