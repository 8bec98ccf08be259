#include "fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/text.hpp"
#include "drape_fit.hpp"
#include "fabric_file.hpp"
#include "heart_loop.hpp"
#include "least_squares.hpp"
#include "voile/errors.hpp"

namespace voile::fit {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Part of an unseen combination, and of the uncertainty of a figure, that counts.
constexpr double counts = 1e-3, contributes = 0.03;
/// Rounds through the virtual strip along the bias, how often it is softened in each, and what its place between a narrow one and a
/// cylinder may still change; how far apart these must be to count.
constexpr int bias_rounds = 8, most_halvings = 8;
/// Part of a change that is taken: it would swing about the place where warp and weft are very unlike.
constexpr double bias_tolerance = 1e-3, alike = 0.01, relaxed = 0.7;
/// Part of the rigidity of the yarns along the bias below which there is no twist.
constexpr double least_twist = 1e-3;
/// Distance of the rows of a loop from its law that is odd, over the range of the force.
constexpr double odd_rows = 0.03;
/// A residual that is odd: in standard deviations, and of the measurement.
constexpr double odd_deviations = 4.0, odd_residual = 0.05;
/// Relative standard uncertainty from which a figure is as good as unknown.
constexpr double open_deviation = 0.5;

/// The measurements that are fitted, and the figures that they depend on.
struct Problem {
  std::vector<Measurement> measurements;
  std::vector<Parameter> parameters;
  Values base = ordinary_values();

  [[nodiscard]] Values values(const VectorXd& x) const {
    Values v = base;
    for (std::size_t i = 0; i < parameters.size(); ++i) at(v, parameters[i]) = std::exp(x[static_cast<Index>(i)]);
    return v;
  }
  [[nodiscard]] VectorXd residuals(const VectorXd& x) const {
    const Values v = values(x);
    VectorXd r(static_cast<Index>(measurements.size()));
    for (std::size_t i = 0; i < measurements.size(); ++i) {
      const Figure& f = measurements[i].figure;
      r[static_cast<Index>(i)] = std::log(measurements[i].instrument.read(v) / f.mean) * f.mean / f.deviation;
    }
    return r;
  }
};

bool depends(const Measurement& m, const Values& base, Parameter p) {
  Values moved = base;
  at(moved, p) *= 1.1;
  return m.instrument.read(moved) != m.instrument.read(base);
}

/// Heights of heart loops hardly change far from the rigidity that they belong to.
void start_from_loops(Problem& p) {
  for (const Measurement& m : p.measurements) {
    if (m.instrument.kind != Kind::heart_loop) continue;
    const double length = m.instrument.length > 0.0 ? m.instrument.length : at(p.base, Parameter::loop_length);
    at(p.base, m.instrument.direction == Direction::warp ? Parameter::bending_warp : Parameter::bending_weft) =
        gravity * at(p.base, Parameter::areal_density) * std::pow(length, 3) / heart_load(m.figure.mean / length);
  }
}

Problem problem_of(const std::vector<Measurement>& all) {
  Problem p;
  for (const Measurement& m : all) {
    if (m.compared) continue;
    if (m.instrument.kind == Kind::figure) at(p.base, m.instrument.parameter) = m.figure.mean;
    p.measurements.push_back(m);
  }
  start_from_loops(p);
  for (std::size_t i = 0; i < parameter_count; ++i) {
    const auto parameter = static_cast<Parameter>(i);
    if (std::any_of(p.measurements.begin(), p.measurements.end(),
                    [&](const Measurement& m) { return depends(m, p.base, parameter); }))
      p.parameters.push_back(parameter);
  }
  return p;
}

/// Figures that the data see only together, and the measurements that do.
void require_rank(const Sheet& sheet, const Problem& p, const LeastSquares& found) {
  if (found.null.cols() == 0) return;
  std::vector<std::string> figures, measurements;
  int line = 0;
  std::vector<bool> unseen(p.parameters.size());
  for (std::size_t i = 0; i < p.parameters.size(); ++i) {
    unseen[i] = found.null.row(static_cast<Index>(i)).norm() > counts;
    if (unseen[i]) figures.emplace_back(name_of(p.parameters[i]).key);
  }
  for (const Measurement& m : p.measurements)
    for (std::size_t i = 0; i < unseen.size(); ++i)
      if (unseen[i] && depends(m, p.base, p.parameters[i]) && !contains(measurements, m.name)) {
        measurements.push_back(m.name);
        line = line == 0 ? m.line : std::min(line, m.line);
      }
  sheet.fail(
      line, join(measurements, ", "),
      fmt::format("{} cannot be separated: {} unknowns, of which the measurements see {} (rank of the Jacobian). "
                  "Measure {} of them otherwise, or leave out what depends on them",
                  join(figures, ", "), p.parameters.size(),
                  p.parameters.size() - static_cast<std::size_t>(found.null.cols()), found.null.cols()));
}

/// A strip along the bias that is softer than its yarns alone leaves no twist, or a negative one.
struct TooSoft {
  const Measurement* strip = nullptr;
  double yarns = 0.0;  ///< [N m]
};

TooSoft too_soft(const std::vector<Measurement>& all, const Problem& p, const LeastSquares& found) {
  if (!found.unknowns.allFinite()) return {};
  const Values v = p.values(found.unknowns);
  const double yarns = 0.25 * (at(v, Parameter::bending_warp) + at(v, Parameter::bending_weft));
  if (at(v, Parameter::bending_twist) > least_twist * yarns) return {};
  for (const Measurement& m : all)
    if (!m.compared && m.instrument.direction == Direction::bias && depends(m, p.base, Parameter::bending_twist))
      return {&m, yarns};
  return {};
}

[[noreturn]] void fail(const Sheet& sheet, const TooSoft& soft) {
  sheet.fail(soft.strip->line, soft.strip->name,
             fmt::format("the strip along the bias is softer than (bending_warp + bending_weft)/4 = {:.4g} uN.m, "
                         "which the yarns have without any twist: the twist would be negative. Check it and those "
                         "of warp and weft for unit and direction, take a wider strip, which twists less, or leave "
                         "it out",
                         1e6 * soft.yarns));
}

void take_figures(Fit& fit, const Problem& p, const LeastSquares& found) {
  const MatrixXd covariance = found.covariance();
  const VectorXd contradiction = found.contradictions();
  for (std::size_t i = 0; i < p.parameters.size(); ++i) {
    if (!is_of_fabric(p.parameters[i])) continue;
    const auto row = static_cast<Index>(i);
    Determined d;
    d.value = std::exp(found.unknowns[row]);
    // Where data contradict each other by more than their uncertainties, these are too small.
    d.deviation = std::sqrt(std::max(1.0, contradiction[row]) * covariance(row, row));
    const double most = found.gain.row(row).cwiseAbs().maxCoeff();
    for (std::size_t j = 0; j < p.measurements.size(); ++j)
      if (std::abs(found.gain(row, static_cast<Index>(j))) > contributes * most) {
        d.sources.push_back(p.measurements[j].name +
                            (p.measurements[j].shared ? " (one figure for both directions)" : ""));
        d.assumed = d.assumed || p.measurements[j].figure.assumed;
      }
    fit.figures[p.parameters[i]] = d;
  }
}

/// A loop of shear that narrows gets one width, as without 2HG5.
void drop_narrowing_loop(Fit& fit, Values& values) {
  const double near = at(values, Parameter::shear_hysteresis), far = at(values, Parameter::shear_hysteresis_5);
  if (!fit.has(Parameter::shear_hysteresis) || !fit.has(Parameter::shear_hysteresis_5) || far > near) return;
  fit.warnings.push_back(
      fmt::format("2HG5 = {:.4g} N/m is not larger than 2HG = {:.4g} N/m: the loop of shear gets the "
                  "width 2HG at all angles",
                  far, near));
  fit.figures.erase(Parameter::shear_hysteresis_5);
  at(values, Parameter::shear_hysteresis_5) = near;
}

/// Figures that no cloth has point to a unit. Ranges: from a tenth to three times those of docs/reference/fabrics.md (typical ranges),
/// in tension from the knits there; of thickness and extensions from a voile to a blanket, from a yarn to an elastic knit.
void warn_of_units(Fit& fit) {
  struct Range {
    Parameter parameter;
    double least, most;
  };
  constexpr std::array ranges{
      Range{Parameter::areal_density, 3e-3, 1.47},  Range{Parameter::thickness, 2e-5, 1e-2},
      Range{Parameter::bending_warp, 1e-7, 3.3e-4}, Range{Parameter::bending_weft, 1e-7, 3.3e-4},
      Range{Parameter::membrane_warp, 3.0, 3e4},    Range{Parameter::membrane_weft, 3.0, 3e4},
      Range{Parameter::membrane_shear, 2.0, 300.0}, Range{Parameter::extension_warp, 2e-3, 2.0},
      Range{Parameter::extension_weft, 2e-3, 2.0}};
  for (const Range& r : ranges) {
    const auto at = fit.figures.find(r.parameter);
    if (at == fit.figures.end() || (at->second.value >= r.least && at->second.value <= r.most)) continue;
    const ParameterName& n = name_of(r.parameter);
    fit.warnings.push_back(fmt::format("{} = {:.3g} {}: cloth has {:.3g} to {:.3g}; check the unit of the measurement",
                                       n.key, at->second.value / n.si, n.unit, r.least / n.si, r.most / n.si));
  }
}

/// Measurements that say or agree so little leave a figure open.
void warn_of_open_figures(Fit& fit) {
  for (const auto& [parameter, figure] : fit.figures)
    if (figure.deviation > open_deviation)
      fit.warnings.push_back(fmt::format(
          "{} is known to +-{:.2g} % only: its measurements say too little, or differ; correct a wrong one, or measure "
          "more",
          name_of(parameter).key, 100.0 * figure.deviation));
}

void compare(Fit& fit, const std::vector<Measurement>& all, const Values& values) {
  for (const Measurement& m : all) {
    Comparison c;
    c.name = m.name;
    c.unit = m.unit;
    c.measured = m.figure.mean / m.si;
    c.deviation = m.figure.deviation / m.si;
    c.found = m.instrument.read(values) / m.si;
    c.count = m.figure.count;
    c.assumed = m.figure.assumed;
    c.compared = m.compared;
    if (std::abs(c.found - c.measured) > odd_deviations * c.deviation && std::abs(c.residual()) > odd_residual)
      fit.warnings.push_back(
          fmt::format("{} is {:.4g} {}, and the fabric has {:.4g}: the other measurements contradict "
                      "it; check its unit and direction",
                      m.name, c.measured, m.unit, c.found));
    fit.comparisons.push_back(c);
  }
}

void take_curves(const Sheet& sheet, Fit& fit) {
  for (const Record& r : sheet.records) {
    const bool weft = r.direction == Direction::weft;
    if (r.kind != Record::Kind::tension_curve && r.kind != Record::Kind::shear_curve) continue;
    const std::string key = r.kind == Record::Kind::shear_curve ? "shear_curve"
                            : weft                              ? "tension_weft"
                                                                : "tension_warp";
    if (fit.curves.contains(key))
      sheet.fail(r.line, r.name,
                 fmt::format("{} is there already, by {}; leave one of them out", key, fit.curves[key].source));
    fit.curves[key] = {curve_of(sheet, r), r.name};
    fit.curves[key].fit.uncertainty = r.deviation;
  }
}

/// A curve replaces a stiffness, and two curves contradict each other.
void require_one_law(const Sheet& sheet, const Fit& fit) {
  using P = Parameter;
  const std::array<std::pair<const char*, std::vector<P>>, 3> laws{
      {{"tension_warp", {P::membrane_warp, P::extension_warp}},
       {"tension_weft", {P::membrane_weft, P::extension_weft}},
       {"shear_curve", {P::membrane_shear}}}};
  for (const auto& [key, parameters] : laws)
    for (const P p : parameters)
      if (fit.curves.contains(key) && fit.has(p))
        sheet.fail(0, key,
                   fmt::format("{} and {} both give it; leave one of them out", fit.curves.at(key).source,
                               join(fit.figures.at(p).sources, ", ")));
  if (fit.has(P::shear_hysteresis_5) && !fit.has(P::shear_hysteresis))
    sheet.fail(0, "kes.2HG5", "2HG, the loop at 0.5 degrees that it belongs to, is missing; add it");
  if (!fit.has(P::areal_density))
    sheet.fail(0, "areal_density",
               "it is missing, and nothing else gives it; weigh the fabric, and add it with its unit");
  if (!fit.has(P::bending_warp) && !fit.has(P::bending_weft) && !sheet.drape)
    sheet.fail(0, "bending_length",
               "nothing here determines the bending stiffness; add bending_length, overhang, heart_loop, "
               "bending_rigidity, kes.B, "
               "fast.C-1 and C-2, bending_loop or drape");
}

/// Figures of loops, and how far their rows are from the law of a spring and a slider.
void take_loops(const Sheet& sheet, std::vector<FittedLoop>& loops, std::vector<Measurement>& all) {
  for (const Record& r : sheet.records) {
    if (r.kind != Record::Kind::bending_loop && r.kind != Record::Kind::shear_loop) continue;
    loops.push_back({r.name, 0.0});
    for (const Measurement& m : measurements_of(sheet, r)) {
      loops.back().deviation = std::max(loops.back().deviation, m.rows);
      all.push_back(m);
    }
  }
}

void warn_of_loops(Fit& fit, std::vector<FittedLoop> loops) {
  for (const FittedLoop& l : loops)
    if (l.deviation > odd_rows)
      fit.warnings.push_back(
          fmt::format("{}: its rows deviate from the loop of a fabric file by {:.1f} % of the range of the force, root "
                      "mean square: straight branches do not describe it, or it is noisy; compare both before you use "
                      "its figures",
                      l.name, 100.0 * l.deviation));
  fit.loops = std::move(loops);
}

/// `soft`: becomes the strip that leaves no twist; the fit is then without figures.
Fit fit_figures(const Sheet& sheet, const std::vector<Measurement>& all, TooSoft& soft) {
  Fit fit;
  const Problem p = problem_of(all);
  VectorXd start(static_cast<Index>(p.parameters.size()));
  for (std::size_t i = 0; i < p.parameters.size(); ++i)
    start[static_cast<Index>(i)] = std::log(at(p.base, p.parameters[i]));
  const LeastSquares found = least_squares([&](const VectorXd& x) { return p.residuals(x); }, start);
  soft = too_soft(all, p, found);
  if (soft.strip) return fit;
  require_rank(sheet, p, found);
  take_figures(fit, p, found);
  fit.fitted = p.measurements.size();
  Values values = p.values(found.unknowns);
  drop_narrowing_loop(fit, values);
  warn_of_units(fit);
  warn_of_open_figures(fit);
  compare(fit, all, values);
  take_curves(sheet, fit);
  require_one_law(sheet, fit);
  return fit;
}

bool is_bias_cantilever(const Instrument& i) {
  return i.direction == Direction::bias && (i.kind == Kind::bending_length || i.kind == Kind::overhang);
}

/// Where the virtual instrument sees strips along the bias between narrow ones and cylinders; false: nothing has changed.
bool correct_bias(const Sheet& sheet, const Fit& fit, const BiasInstrument& bias, std::vector<Measurement>& all) {
  using P = Parameter;
  if (!fit.has(P::bending_warp) || !fit.has(P::bending_weft) || !fit.has(P::bending_twist)) return false;
  const BiasLimits limits = bias_limits(fit.figures.at(P::bending_warp).value, fit.figures.at(P::bending_weft).value,
                                        fit.figures.at(P::bending_twist).value);
  if (limits.narrow > (1.0 - alike) * limits.cylinder) return false;
  std::map<double, double> seen;
  bool changed = false;
  for (Measurement& m : all) {
    Instrument& i = m.instrument;
    if (!is_bias_cantilever(i)) continue;
    if (!seen.contains(i.width))
      seen[i.width] = std::clamp((bias(fabric_text(sheet, fit), i.width) * limits.cylinder - limits.narrow) /
                                     (limits.cylinder - limits.narrow),
                                 0.0, 1.0);
    changed = changed || std::abs(seen[i.width] - i.strip) > bias_tolerance;
    i.strip += relaxed * (seen[i.width] - i.strip);
  }
  return changed;
}

/// Fits; where strips along the bias leave no twist, with ones that have gone part of the way back to `before`, or to narrow ones.
/// Throws UserError if that does not help.
Fit fit_softened(const Sheet& sheet, std::vector<Measurement>& all, const std::vector<Measurement>& before,
                 TooSoft& first) {
  Fit fit = fit_figures(sheet, all, first);
  TooSoft soft = first;
  for (int k = 0; soft.strip && k < most_halvings; ++k) {
    for (std::size_t m = 0; m < all.size(); ++m)
      if (is_bias_cantilever(all[m].instrument))
        all[m].instrument.strip = 0.5 * (all[m].instrument.strip + (before.empty() ? 0.0 : before[m].instrument.strip));
    fit = fit_figures(sheet, all, soft);
  }
  if (soft.strip) fail(sheet, soft);
  return fit;
}

/// Fits with strips along the bias as the virtual instrument sees them, if there is one.
Fit fit_bias(const Sheet& sheet, const BiasInstrument& bias, std::vector<Measurement>& all) {
  TooSoft soft;
  Fit fit = bias ? fit_softened(sheet, all, {}, soft) : fit_figures(sheet, all, soft);
  for (int round = 0; bias && round < bias_rounds; ++round) {
    const std::vector<Measurement> before = all;
    if (!correct_bias(sheet, fit, bias, all)) break;
    fit = fit_softened(sheet, all, before, soft);
  }
  if (soft.strip) fail(sheet, soft);
  return fit;
}

}  // namespace

Fit fit_sheet(const Sheet& sheet, const DrapeInstrument& drape, const BiasInstrument& bias) {
  std::vector<Measurement> all = sheet.measurements;
  std::vector<FittedLoop> loops;
  take_loops(sheet, loops, all);
  Fit fit = fit_bias(sheet, bias, all);
  warn_of_loops(fit, std::move(loops));
  if (sheet.drape) fit_drape(sheet, fit, drape);
  return fit;
}

}  // namespace voile::fit
