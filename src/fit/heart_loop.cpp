#include "heart_loop.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "input/units.hpp"
#include "voile/errors.hpp"

namespace voile::fit {

namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index links = 100;            // of half a strip, and twice as many: h/L to 1e-6 by extrapolation
constexpr double greatest_load = 3000;  // from which on a power law holds
constexpr double growth = 1.3;          // of the loads of the ladder from 1
constexpr double end_angle = 1.5 * std::numbers::pi;
constexpr int most_iterations = 60;
constexpr double settled = 1e-9;  // [rad]

/// Half of the strip from its clamp as links with springs between them, at their angles from the vertical, and the horizontal force at
/// its lowest end, which stays below the clamp.
struct Chain {
  VectorXd angle;
  double force = 0.0;

  explicit Chain(Index count) : angle(count) {
    for (Index i = 0; i < count; ++i)
      angle[i] = end_angle * (static_cast<double>(i) + 0.5) / static_cast<double>(count);
  }
  [[nodiscard]] double link() const { return 0.5 / static_cast<double>(angle.size()); }
  [[nodiscard]] double height() const { return -link() * angle.array().cos().sum(); }
};

/// Solves a symmetric tridiagonal system with equal entries beside the diagonal for both columns.
void solve_tridiagonal(VectorXd diagonal, double beside, Eigen::MatrixX2d& columns) {
  const Index n = diagonal.size();
  for (Index i = 1; i < n; ++i) {
    const double factor = beside / diagonal[i - 1];
    diagonal[i] -= factor * beside;
    columns.row(i) -= factor * columns.row(i - 1);
  }
  columns.row(n - 1) /= diagonal[n - 1];
  for (Index i = n - 2; i >= 0; --i) columns.row(i) = (columns.row(i) - beside * columns.row(i + 1)) / diagonal[i];
}

/// Equilibrium of the chain by Newton's method: the ends are held by springs of half the length.
void settle(Chain& chain, double load) {
  const Index n = chain.angle.size();
  const double h = chain.link();
  for (int k = 0; k < most_iterations; ++k) {
    VectorXd diagonal(n), lean(n);
    Eigen::MatrixX2d columns(n, 2);
    for (Index i = 0; i < n; ++i) {
      const double c = std::cos(chain.angle[i]), s = std::sin(chain.angle[i]),
                   weight = load * h * h * (static_cast<double>(n - i) - 0.5);
      const double before = i == 0 ? 2.0 * chain.angle[i] : chain.angle[i] - chain.angle[i - 1],
                   after = i == n - 1 ? 2.0 * (end_angle - chain.angle[i]) : chain.angle[i + 1] - chain.angle[i];
      lean[i] = h * c;
      diagonal[i] = ((i == 0 ? 2.0 : 1.0) + (i == n - 1 ? 2.0 : 1.0)) / h - weight * c - chain.force * h * s;
      columns(i, 0) = (before - after) / h - weight * s + chain.force * lean[i];
    }
    columns.col(1) = lean;
    const double aside = h * chain.angle.array().sin().sum();
    solve_tridiagonal(diagonal, -1.0 / h, columns);
    const double force = (lean.dot(columns.col(0)) - aside) / lean.dot(columns.col(1));
    const VectorXd move = columns.col(0) - force * columns.col(1);
    const double most = move.cwiseAbs().maxCoeff(), part = std::min(1.0, 0.5 / std::max(most, 1e-300));
    chain.angle -= part * move;
    chain.force -= part * force;
    if (most < settled) return;
  }
  throw InternalError("the heart loop has not been found");
}

/// A loop from which heavier ones begin.
struct Rung {
  double load = 0.0;
  Chain coarse{links}, fine{2 * links};
};

Rung heavier(Rung from, double load) {
  from.load = load;
  settle(from.coarse, load);
  settle(from.fine, load);
  return from;
}

}  // namespace

double heart_height(double load) {
  if (std::isnan(load)) return load;  // a fit that is lost says so itself
  if (load > greatest_load) return 0.5 - (0.5 - heart_height(greatest_load)) * std::cbrt(greatest_load / load);
  // Found once, so that a load has one height to the last bit.
  static thread_local std::vector<Rung> ladder{heavier({}, 1.0)};
  while (growth * ladder.back().load < load) ladder.push_back(heavier(ladder.back(), growth * ladder.back().load));
  const auto above =
      std::upper_bound(ladder.begin(), ladder.end(), load, [](double x, const Rung& rung) { return x < rung.load; });
  const Rung loop = heavier(above == ladder.begin() ? ladder.front() : *(above - 1), load);
  return loop.fine.height() + (loop.fine.height() - loop.coarse.height()) / 3.0;
}

double heart_load(double height) {
  double low = 0.0, high = 1.0;
  while (high < greatest_load && heart_height(high) < height) {
    low = high;
    high = std::min(2.0 * high, 2.0 * greatest_load);
  }
  for (int k = 0; k < 50; ++k) {
    const double middle = 0.5 * (low + high);
    (heart_height(middle) < height ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double peirce_length(double height) {
  constexpr double loop = 0.1337;
  const double a = 32.85 * input::degree * (height - loop) / loop;
  return a > 0.0 && a < 0.5 * std::numbers::pi ? loop * std::cbrt(std::cos(a) / std::tan(a)) : 0.0;
}

}  // namespace voile::fit
