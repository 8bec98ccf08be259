#include "drape_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fabric_file.hpp"

namespace voile::fit {

namespace {

constexpr double first_length = 18e-3, least_length = 5e-3, most_length = 60e-3;  // bending lengths [m]
constexpr double tolerance = 0.005;                                               // of the coefficient
constexpr double of_instrument = 0.01;  ///< what the mesh changes in the coefficient
constexpr double outward = 1.5, narrow = 0.02;
constexpr double flattest = 1.0;  ///< slope of the coefficient by the bending length [1/m]
constexpr int trials = 10;

void compare_drape(const DrapeFigure& d, const DrapeTrial& trial, bool fitted, Fit& fit) {
  fit.comparisons.push_back({"drape.coefficient", "%", 100.0 * d.coefficient.mean, 100.0 * trial.coefficient,
                             100.0 * d.coefficient.deviation, d.coefficient.count, d.coefficient.assumed, !fitted});
  if (d.folds) fit.comparisons.push_back({"drape.folds", "", *d.folds, trial.folds, 0.0, 1, false, true});
}

}  // namespace

Root rising_root(const std::function<double(double)>& f, double start, double least, double most, double tolerance_of_f,
                 int count) {
  struct Point {
    double x, f;
  };
  Point low{least, -1.0}, high{most, 1.0}, best{start, f(start)};
  bool has_low = false, has_high = false;
  const auto take = [&](double x, double value) {
    (value < 0.0 ? low : high) = {x, value};
    (value < 0.0 ? has_low : has_high) = true;
    if (std::abs(value) < std::abs(best.f)) best = {x, value};
  };
  take(best.x, best.f);
  int side = 0;
  double weight_low = 1.0, weight_high = 1.0;
  for (int i = 1; i < count && std::abs(best.f) > tolerance_of_f; ++i) {
    if (has_low && has_high && high.x - low.x < narrow * best.x) break;
    if ((!has_high && low.x >= most) || (!has_low && high.x <= least)) return {best.x, best.f, false};
    double x = has_low ? std::min(most, low.x * outward) : std::max(least, high.x / outward);
    if (has_low && has_high) {
      const double a = weight_low * low.f, b = weight_high * high.f;
      x = (low.x * b - high.x * a) / (b - a);
      // A jump beside the end of the bracket: never closer than a tenth of it.
      const double margin = 0.1 * (high.x - low.x);
      x = std::clamp(x, low.x + margin, high.x - margin);
    }
    const double value = f(x);
    // Illinois: an end that stays twice counts half.
    const int now = value < 0.0 ? -1 : 1;
    weight_low = now < 0 ? 1.0 : side > 0 ? 0.5 * weight_low : 1.0;
    weight_high = now > 0 ? 1.0 : side < 0 ? 0.5 * weight_high : 1.0;
    side = now;
    take(x, value);
  }
  return {best.x, best.f, (has_low && has_high) || std::abs(best.f) <= tolerance_of_f};
}

void fit_drape(const Sheet& sheet, Fit& fit, const DrapeInstrument& drape) {
  using P = Parameter;
  const DrapeFigure& d = *sheet.drape;
  std::vector<P> unknown;
  for (const P p : {P::bending_warp, P::bending_weft})
    if (!fit.has(p)) unknown.push_back(p);
  if (unknown.empty()) return compare_drape(d, drape(fabric_text(sheet, fit)), false, fit);
  const double weight = gravity * fit.figures.at(P::areal_density).value;
  std::map<double, DrapeTrial> seen;
  const auto set_length = [&](double length) {
    for (const P p : unknown)
      fit.figures[p] = {weight * length * length * length, 0.0, d.coefficient.assumed, {"drape.coefficient"}};
  };
  const auto difference_at = [&](double length) {
    set_length(length);
    seen[length] = drape(fabric_text(sheet, fit));
    return seen[length].coefficient - d.coefficient.mean;
  };
  const Root root = rising_root(difference_at, first_length, least_length, most_length, tolerance, trials);
  if (!root.found)
    sheet.fail(
        d.line, "drape.coefficient",
        fmt::format("{:.1f} % is not reached: a bending length of {:.0f} mm has {:.1f} %; check coefficient, areal "
                    "density and specimen",
                    100.0 * d.coefficient.mean, 1e3 * root.argument, 100.0 * (d.coefficient.mean + root.value)));
  if (seen.size() < 2) (void)difference_at(outward * root.argument);
  set_length(root.argument);
  const DrapeTrial& trial = seen.at(root.argument);
  const double slope = (seen.rbegin()->second.coefficient - seen.begin()->second.coefficient) /
                       (seen.rbegin()->first - seen.begin()->first);
  const double spread = std::hypot(d.coefficient.deviation, of_instrument, trial.deviation);
  const double of_length = spread / (std::max(slope, flattest) * root.argument);
  for (const P p : unknown)
    fit.figures[p].deviation = std::hypot(3.0 * of_length, fit.figures.at(P::areal_density).deviation);
  if (std::abs(root.value) > tolerance)
    fit.warnings.push_back(
        fmt::format("the virtual drape coefficient jumps near this bending length, where the number of "
                    "folds changes: {:.1f} % is nearest to the measured {:.1f} %",
                    100.0 * (d.coefficient.mean + root.value), 100.0 * d.coefficient.mean));
  compare_drape(d, trial, true, fit);
  ++fit.fitted;
}

}  // namespace voile::fit
