#include "reduced_response.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "base/decompositions.hpp"

namespace voile::solve {

namespace {

constexpr double circle = 2.0 * std::numbers::pi;

/// Gauss's rule with eight points: half of them, on (0, 1), and their weights.
constexpr std::array<double, 4> gauss_points{0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                             0.9602898564975363};
constexpr std::array<double, 4> gauss_weights{0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                              0.1012285362903763};

/// Ends of the intervals: the points of the table, and a grading in powers of two from the width of each peak on.
std::vector<double> interval_ends(const ReducedResponse& response, const SpectralDensity& density) {
  const double low = density.frequencies.front(), high = density.frequencies.back();
  std::vector<double> ends = density.frequencies;
  const auto add = [&](double f) {
    if (f > low && f < high) ends.push_back(f);
  };
  for (double f = low; f < high; f *= 2.0) add(f);
  for (std::size_t i = 0; i < response.frequencies().size(); ++i) {
    const double peak = response.frequencies()[i];
    add(peak);
    const double width = std::max(response.ratios()[i], 1e-9) * peak;
    for (double away = width; width > 0.0 && away < high; away *= 2.0) {
      add(peak - away);
      add(peak + away);
    }
  }
  std::sort(ends.begin(), ends.end());
  return ends;
}

/// Calls f with every point and its weight.
template <class F>
void integrate(const std::vector<double>& ends, F&& f) {
  for (std::size_t n = 1; n < ends.size(); ++n) {
    const double middle = 0.5 * (ends[n - 1] + ends[n]), half = 0.5 * (ends[n] - ends[n - 1]);
    if (half <= 1e-14 * middle) continue;
    for (std::size_t g = 0; g < gauss_points.size(); ++g)
      for (const double side : {-1.0, 1.0}) f(middle + side * half * gauss_points[g], half * gauss_weights[g]);
  }
}

}  // namespace

ReducedSystem ReducedSystem::first(Eigen::Index count) const {
  ReducedSystem part{stiffness.topLeftCorner(count, count), {}, force.head(count), rows.leftCols(count)};
  if (damping.size() > 0) part.damping = damping.topLeftCorner(count, count);
  return part;
}

ReducedResponse::ReducedResponse(const ReducedSystem& system, const std::vector<double>& ratios) {
  const Spectrum modes = spectrum(system.stiffness);
  lambda_ = modes.values;
  vectors_ = modes.vectors;
  rows_ = system.rows * modes.vectors;
  force_ = modes.vectors.transpose() * system.force;
  if (system.damping.size() > 0) damping_ = modes.vectors.transpose() * system.damping * modes.vectors;
  rate_.resize(lambda_.size());
  for (Eigen::Index i = 0; i < lambda_.size(); ++i) {
    const double omega = std::sqrt(std::max(0.0, lambda_[i]));
    const double ratio = ratios.empty() ? 0.0 : ratios[std::min(static_cast<std::size_t>(i), ratios.size() - 1)];
    rate_[i] = 2.0 * ratio * omega;
    const double other = damping_.size() > 0 && omega > 0.0 ? 0.5 * damping_(i, i) / omega : 0.0;
    frequencies_.push_back(omega / circle);
    all_ratios_.push_back(ratio + other);
  }
}

Eigen::VectorXcd ReducedResponse::modal_at(double omega) const {
  constexpr std::complex<double> i(0.0, 1.0);
  const Eigen::ArrayXd square = lambda_.array() - omega * omega;
  const Eigen::VectorXcd diagonal = (square.cast<std::complex<double>>() + i * omega * rate_.array()).matrix();
  if (damping_.size() == 0) return force_.cast<std::complex<double>>().cwiseQuotient(diagonal);
  Eigen::MatrixXcd system = i * omega * damping_;
  system.diagonal() += diagonal;
  return system.partialPivLu().solve(force_.cast<std::complex<double>>());
}

Eigen::VectorXcd ReducedResponse::at(double frequency) const {
  return rows_ * modal_at(circle * frequency);
}

Eigen::VectorXcd ReducedResponse::coordinates(double frequency) const {
  return vectors_ * modal_at(circle * frequency);
}

Eigen::VectorXd ReducedResponse::size_at(double frequency) const {
  return rows_.cwiseAbs() * modal_at(circle * frequency).cwiseAbs();
}

double SpectralDensity::at(double frequency) const {
  if (frequency < frequencies.front() || frequency > frequencies.back()) return 0.0;
  const auto above = std::upper_bound(frequencies.begin() + 1, frequencies.end() - 1, frequency);
  const auto n = static_cast<std::size_t>(above - frequencies.begin());
  const double part = std::log(frequency / frequencies[n - 1]) / std::log(frequencies[n] / frequencies[n - 1]);
  return values[n - 1] * std::pow(values[n] / values[n - 1], part);
}

Eigen::VectorXd mean_squares(const ReducedResponse& response, const SpectralDensity& density,
                             const std::function<Eigen::VectorXcd(double frequency)>& h) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(h(density.frequencies.front()).size());
  integrate(interval_ends(response, density),
            [&](double f, double weight) { sum += weight * density.at(f) * h(f).cwiseAbs2(); });
  return sum;
}

Eigen::MatrixXd covariance(const ReducedResponse& response, const SpectralDensity& density,
                           const std::function<Eigen::VectorXcd(double frequency)>& h) {
  const Eigen::Index n = h(density.frequencies.front()).size();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(n, n);
  integrate(interval_ends(response, density), [&](double f, double weight) {
    const Eigen::VectorXcd x = std::sqrt(weight * density.at(f)) * h(f);
    sum.selfadjointView<Eigen::Lower>().rankUpdate(Eigen::VectorXd(x.real()));
    sum.selfadjointView<Eigen::Lower>().rankUpdate(Eigen::VectorXd(x.imag()));
  });
  return sum.selfadjointView<Eigen::Lower>();
}

}  // namespace voile::solve
