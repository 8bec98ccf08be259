#include "record_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "energy/yarn_law.hpp"
#include "input/case_fabric_curves.hpp"
#include "input/fabric.hpp"
#include "input/units.hpp"
#include "least_squares.hpp"
#include "record_file.hpp"
#include "voile/errors.hpp"

namespace voile::fit {

namespace {

using Eigen::Index;
using Eigen::VectorXd;
using P = Parameter;

constexpr double most_correlation = 0.98;           // of neighbouring rows
constexpr std::size_t most_points = 12, knots = 8;  // of a fabric file, of a long record
/// A first bend begins within this fraction of the width; a spread is known to this relative deviation.
constexpr double first_bend = 0.25, unknown_spread = 0.5;

/// Strains and forces of the solver.
std::vector<energy::YarnPoint> solver_points(Record::Kind kind, const std::vector<RecordPoint>& points) {
  std::vector<energy::YarnPoint> all;
  for (const RecordPoint& p : points)
    all.push_back(kind == Record::Kind::bending_loop
                      ? energy::YarnPoint{p.x, p.force}
                      : input::solver_point(kind != Record::Kind::tension_curve, p.x, p.force));
  return all;
}

/// What a loop was fitted by.
struct LoopFit {
  std::vector<double> figures, deviations;  ///< B or G, widths, spread if it is known; relative deviations
  double rows = 0.0;     ///< root mean square of their distance from the law, over the range of the force
  bool bounded = false;  ///< the spread is less than the distance of the rows, which is given
};

struct LoopCourse {
  bool shear = false, turned = false;
  std::vector<double> strain, force;
  double width = 0.0;

  /// Median distance of neighbouring rows, below which a spread does not show.
  [[nodiscard]] double distance() const {
    std::vector<double> steps;
    for (std::size_t i = 1; i < strain.size(); ++i) steps.push_back(std::abs(strain[i] - strain[i - 1]));
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    return *middle;
  }
  [[nodiscard]] double range(const std::vector<double>& x) const {
    return *std::max_element(x.begin(), x.end()) - *std::min_element(x.begin(), x.end());
  }
  /// Figures as logarithms, then the zero of the force.
  [[nodiscard]] VectorXd residuals(const VectorXd& x, double spread) const {
    const double of_spread = spread > 0.0 ? spread : std::exp(x[x.size() - 2]);
    const Loop loop = shear ? shear_loop(std::exp(x[0]), std::exp(x[1]), std::exp(x[2]), of_spread)
                            : bending_loop(std::exp(x[0]), std::exp(x[1]), of_spread);
    const std::vector<double> found = loop.forces(strain, turned);
    const double scale = range(force);
    VectorXd r(static_cast<Index>(strain.size()));
    for (std::size_t i = 0; i < strain.size(); ++i)
      r[static_cast<Index>(i)] = (found[i] - force[i]) / scale + x[x.size() - 1];
    return r;
  }
};

/// Without what lies before the first turn, unless the specimen was never strained before.
LoopCourse course_of(const Record& record, std::size_t specimen) {
  LoopCourse c;
  c.shear = record.kind == Record::Kind::shear_loop;
  const std::vector<RecordPoint>& rows = record.points[specimen];
  c.width = require_loop(rows, record.files.empty() ? record.name : record.files[specimen]);
  for (const energy::YarnPoint& p : solver_points(record.kind, rows)) {
    c.strain.push_back(p.strain);
    c.force.push_back(p.force);
  }
  const bool first =
      std::abs(c.force.front()) < first_bend * c.width && std::abs(c.strain.front()) < 0.02 * c.range(c.strain);
  if (first) return c;
  const auto [least, most] = std::minmax_element(c.strain.begin(), c.strain.end());
  const auto turn = std::min(least - c.strain.begin(), most - c.strain.begin());
  c.strain.erase(c.strain.begin(), c.strain.begin() + turn);
  c.force.erase(c.force.begin(), c.force.begin() + turn);
  c.turned = true;
  return c;
}

/// Rows that say the same: neighbours beside a law that does not hold deviate alike. Of a first-order autoregression.
double repetition(const VectorXd& residuals) {
  const Index n = residuals.size() - 1;
  const double square = residuals.squaredNorm();
  if (n < 1 || !(square > 0.0)) return 1.0;
  const double correlation = std::clamp(residuals.head(n).dot(residuals.tail(n)) / square, 0.0, most_correlation);
  return (1.0 + correlation) / (1.0 - correlation);
}

LoopFit fit_loop(const LoopCourse& c, const std::string& file) {
  const double range = c.range(c.strain), slope = c.range(c.force) / range,
               typical = c.shear ? input::typical_shear_spread : input::typical_spread;
  std::vector<double> start{std::log(std::max(slope - c.width / range, 0.2 * slope)), std::log(c.width)};
  if (c.shear) start.push_back(std::log(1.5 * c.width));
  const auto solve = [&](double spread) {
    std::vector<double> x = start;
    if (spread == 0.0) x.push_back(std::log(typical));
    x.push_back(0.0);
    return least_squares([&](const VectorXd& v) { return c.residuals(v, spread); },
                         Eigen::Map<VectorXd>(x.data(), static_cast<Index>(x.size())));
  };
  LeastSquares found = solve(0.0);
  const auto deviation = [&](Index i) {
    return std::sqrt(repetition(found.residuals) * found.misfit() * found.covariance()(i, i));
  };
  const auto spread_at = static_cast<Index>(start.size());
  const bool hidden = std::exp(found.unknowns[spread_at]) < c.distance(),
             known = !hidden && found.null.cols() == 0 && deviation(spread_at) < unknown_spread;
  const double least = std::min(typical, c.distance());
  if (!known) found = solve(hidden ? least : typical);
  // Where the loop is widest it turns over several times the spread: one that rows hide may be anything below their distance.
  for (double part = 0.85; hidden && part > 0.05; part *= 0.85)
    if (LeastSquares sharper = solve(part * least); sharper.misfit() < found.misfit()) found = std::move(sharper);
  if (found.null.cols() > 0 || !found.unknowns.allFinite())
    throw UserError(fmt::format("{}: the rows do not determine the loop; give more of them on both branches", file));
  LoopFit fit;
  for (Index i = 0; i < found.unknowns.size() - 1; ++i) {
    fit.figures.push_back(std::exp(found.unknowns[i]));
    fit.deviations.push_back(std::max(deviation(i), least_deviation));
  }
  fit.rows = std::sqrt(found.residuals.squaredNorm() / static_cast<double>(found.residuals.size()));
  fit.bounded = hidden && least < typical;
  if (fit.bounded) {
    fit.figures.push_back(least);
    fit.deviations.push_back(unknown_spread);
  }
  return fit;
}

/// Strains of the points of a long record: equal parts of its strain and force together.
std::vector<double> knot_strains(std::vector<energy::YarnPoint> rows) {
  std::sort(rows.begin(), rows.end(), [](auto& a, auto& b) { return a.strain < b.strain; });
  const double end = rows.back().strain;
  double force = 0.0;
  for (const energy::YarnPoint& p : rows) force = std::max(force, p.force);
  std::vector<double> strains;
  double most = 0.0;
  for (const energy::YarnPoint& p : rows) {
    most = std::max(most, p.strain / end + p.force / force);
    if (most >= 2.0 * static_cast<double>(strains.size() + 1) / static_cast<double>(knots) &&
        (strains.empty() ? p.strain > 0.0 : p.strain > strains.back() + 0.01 * end) && strains.size() + 1 < knots)
      strains.push_back(p.strain);
  }
  if (strains.empty() || end > strains.back()) strains.push_back(end);
  return strains;
}

/// Points whose forces rise by the exponentials of the unknowns.
std::vector<energy::YarnPoint> rising(const std::vector<double>& strains, const VectorXd& unknowns) {
  std::vector<energy::YarnPoint> points;
  double force = 0.0;
  for (std::size_t j = 0; j < strains.size(); ++j)
    points.push_back({strains[j], force += std::exp(unknowns[static_cast<Index>(j)])});
  return points;
}

bool rises(const std::vector<energy::YarnPoint>& points) {
  energy::YarnPoint before{0.0, 0.0};
  for (const energy::YarnPoint& p : points) {
    if (!(p.strain > before.strain && p.force > before.force)) return false;
    before = p;
  }
  return true;
}

RecordPoint laboratory_point(bool shear, const energy::YarnPoint& p) {
  if (shear) return {std::asin(p.strain), p.force * std::sqrt(1.0 - p.strain * p.strain)};
  const double stretch = std::sqrt(1.0 + 2.0 * p.strain);
  return {stretch - 1.0, p.force * stretch};
}

}  // namespace

std::vector<Measurement> measurements_of(const Sheet& sheet, const Record& record) {
  const bool shear = record.kind == Record::Kind::shear_loop, weft = record.direction == Direction::weft;
  const std::vector<P> parameters =
      shear ? std::vector{P::membrane_shear, P::shear_hysteresis, P::shear_hysteresis_5, P::shear_hysteresis_spread}
            : std::vector{weft ? P::bending_weft : P::bending_warp,
                          weft ? P::bending_hysteresis_weft : P::bending_hysteresis, P::bending_hysteresis_spread};
  const std::vector<std::string> names =
      shear ? std::vector<std::string>{"G", "2HG", "2HG5", "spread"} : std::vector<std::string>{"B", "2HB", "spread"};
  std::vector<LoopFit> fits;
  for (std::size_t i = 0; i < record.points.size(); ++i)
    fits.push_back(fit_loop(course_of(record, i), record.files.empty() ? sheet.file : record.files[i]));
  std::vector<Measurement> all;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    std::vector<double> values;
    bool bounded = false;
    Measurement m;
    for (const LoopFit& f : fits)
      if (k < f.figures.size()) {
        values.push_back(f.figures[k]);
        bounded = bounded || (f.bounded && k + 1 == parameters.size());
        m.figure.deviation = f.deviations[k] * f.figures[k];
        m.rows = std::max(m.rows, f.rows);
      }
    if (values.empty()) continue;
    m.name = fmt::format("{}: {}{}", record.name, names[k], bounded ? " at most, by its rows" : "");
    m.line = record.line;
    m.instrument.parameter = parameters[k];
    m.unit = name_of(parameters[k]).unit;
    m.si = name_of(parameters[k]).si;
    m.figure.count = static_cast<int>(values.size());
    m.figure.mean = std::accumulate(values.begin(), values.end(), 0.0) / m.figure.count;
    double squares = 0.0;
    for (const double v : values) squares += std::pow(v - m.figure.mean, 2);
    if (values.size() > 1) m.figure.deviation = std::sqrt(squares / (m.figure.count - 1.0) / m.figure.count);
    m.figure.deviation = std::max(m.figure.deviation, least_deviation * m.figure.mean);
    all.push_back(m);
  }
  return all;
}

CurveFit curve_of(const Sheet& sheet, const Record& record) {
  const bool shear = record.kind == Record::Kind::shear_curve;
  std::vector<energy::YarnPoint> rows;
  for (const std::vector<RecordPoint>& points : record.points)
    for (const energy::YarnPoint& p : solver_points(record.kind, points)) rows.push_back(p);
  std::erase_if(rows, [](const energy::YarnPoint& p) { return p.strain == 0.0 && p.force == 0.0; });
  CurveFit fit;
  if (rows.size() <= most_points && record.points.size() == 1) {
    if (rows.size() < 2 || !rises(rows))
      sheet.fail(
          record.line, record.name,
          "2 to 12 rows have to rise from one to the next in extension and force; correct them, or give more rows, "
          "through which a curve is fitted");
    for (const energy::YarnPoint& p : rows) fit.points.push_back(laboratory_point(shear, p));
    return fit;
  }
  const std::vector<double> strains = knot_strains(rows);
  double most = 0.0;
  for (const energy::YarnPoint& p : rows) most = std::max(most, p.force);
  const VectorXd start =
      VectorXd::Constant(static_cast<Index>(strains.size()), std::log(most / static_cast<double>(strains.size())));
  const LeastSquares found = least_squares(
      [&](const VectorXd& x) {
        const energy::YarnCurve curve = energy::yarn_curve(rising(strains, x));
        VectorXd r(static_cast<Index>(rows.size()));
        for (std::size_t i = 0; i < rows.size(); ++i)
          r[static_cast<Index>(i)] = (energy::force_of(curve, std::max(rows[i].strain, 0.0)) - rows[i].force) / most;
        return r;
      },
      start);
  if (!found.unknowns.allFinite() || found.null.cols() > 0)
    sheet.fail(record.line, record.name,
               "the rows do not determine a curve that rises; give rows along the whole of it");
  for (const energy::YarnPoint& p : rising(strains, found.unknowns)) fit.points.push_back(laboratory_point(shear, p));
  fit.deviation = std::sqrt(found.residuals.squaredNorm() / static_cast<double>(rows.size()));
  return fit;
}

}  // namespace voile::fit
