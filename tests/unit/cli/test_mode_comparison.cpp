// Modes of two runs: the same ones, pairs that are turned in their plane, other meshes, other shapes.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "cli/mode_comparison.hpp"
#include "mesh/surface_mesh.hpp"
#include "test_problems.hpp"
#include "test_relative.hpp"
#include "voile/errors.hpp"

namespace test_mode_comparison {

using namespace voile;

namespace {

/// Waves of a square plate: (1, 1), the pair (1, 2) and (2, 1), (2, 2).
cli::ModeSet square(Index n) {
  cli::ModeSet set{"square", testing::grid(n, n, true, 0.0), "m", "frequency_hz", {2.0, 5.0, 5.0, 8.0}, {}, {}};
  set.shapes = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(set.mesh.positions.size()), 4);
  constexpr double pi = std::numbers::pi;
  for (std::size_t v = 0; v < set.mesh.positions.size(); ++v) {
    const Vec3& x = set.mesh.positions[v];
    const auto row = 3 * static_cast<Eigen::Index>(v) + 2;
    set.shapes(row, 0) = std::sin(pi * x[0]) * std::sin(pi * x[1]);
    set.shapes(row, 1) = std::sin(pi * x[0]) * std::sin(2.0 * pi * x[1]);
    set.shapes(row, 2) = std::sin(2.0 * pi * x[0]) * std::sin(pi * x[1]);
    set.shapes(row, 3) = std::sin(2.0 * pi * x[0]) * std::sin(2.0 * pi * x[1]);
  }
  return set;
}

/// The pair of another run: another basis of its plane.
cli::ModeSet turned(cli::ModeSet set, double angle) {
  const Eigen::VectorXd one = set.shapes.col(1), two = set.shapes.col(2);
  set.shapes.col(1) = -3.0 * (std::cos(angle) * one + std::sin(angle) * two);
  set.shapes.col(2) = 0.5 * (std::cos(angle) * two - std::sin(angle) * one);
  set.values[2] *= 1.001;
  return set;
}

}  // namespace

TEST_CASE("modes are those of their own run, weighted by any mass or none") {
  cli::ModeSet set = square(8);
  for (const bool by_mass : {false, true}) {
    if (by_mass) {
      Eigen::VectorXd mass(set.shapes.rows());
      for (Eigen::Index i = 0; i < mass.size(); ++i) mass[i] = 1.0 + std::abs(std::sin(static_cast<double>(i)));
      set.mass_shapes = mass.asDiagonal() * set.shapes;
    }
    const cli::ModeComparison c = cli::compare(set, set, 0.01);
    CHECK(c.by_mass == by_mass);
    for (Eigen::Index i = 0; i < 4; ++i) {
      CHECK(std::abs(c.mac(i, i) - 1.0) < 1e-12);
      CHECK(c.partners[static_cast<std::size_t>(i)].best == static_cast<std::size_t>(i));
      CHECK(std::abs(c.partners[static_cast<std::size_t>(i)].span - 1.0) < 1e-12);
    }
    CHECK((c.mac(0, 3) < 1e-25) == !by_mass);
  }
}

TEST_CASE("a pair that is turned in its plane is found as a span") {
  const double angle = 0.7;
  const cli::ModeSet set = square(8);
  const cli::ModeComparison c = cli::compare(set, turned(set, angle), 0.01);
  CHECK(c.mac(1, 1) == relative(std::pow(std::cos(angle), 2)).epsilon(1e-12));
  CHECK(c.mac(1, 2) == relative(std::pow(std::sin(angle), 2)).epsilon(1e-12));
  for (const std::size_t i : {1U, 2U}) {
    CHECK(c.partners[i].around == std::vector<std::size_t>{1, 2});
    CHECK(std::abs(c.partners[i].span - 1.0) < 1e-12);
  }
  const cli::ModeComparison apart = cli::compare(set, turned(set, angle), 1e-4);
  CHECK(apart.partners[1].around.size() == 1);
  CHECK(apart.partners[1].span ==
        relative(apart.mac(1, static_cast<Eigen::Index>(apart.partners[1].best))).epsilon(1e-12));
}

TEST_CASE("meshes may differ, whichever is the finer one, but not their shapes") {
  const cli::ModeSet coarse = square(8), fine = turned(square(20), 0.3);
  for (const bool forward : {true, false}) {
    const cli::ModeComparison c = forward ? cli::compare(coarse, fine, 0.01) : cli::compare(fine, coarse, 0.01);
    CHECK(!c.same_mesh);
    CHECK(c.mac(0, 0) == relative(1.0).epsilon(1e-3));
    for (const cli::Partner& p : c.partners) CHECK(p.span == relative(1.0).epsilon(1e-2));
  }
  cli::ModeSet other = square(20);
  for (Vec3& x : other.mesh.positions) x[2] += 0.2 * x[0] * x[0];
  CHECK_THROWS_WITH_AS((void)cli::compare(coarse, other, 0.01), doctest::Contains("the two shapes differ"), UserError);
}

}  // namespace test_mode_comparison
