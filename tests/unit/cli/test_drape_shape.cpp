// Shadow and folds of specimens whose shape is known.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "cli/drape_shape.hpp"
#include "test_relative.hpp"

namespace test_drape_shape {

using namespace voile;

namespace {

struct Ring {
  std::vector<mesh::Triangle> triangles;
  std::vector<Vec3> flat, places;
};

/// A ring from 90 to 150 mm whose outer edge is drawn in to rim(angle).
template <class Rim>
Ring ring(int around, const Rim& rim) {
  Ring r;
  const int rows = 6;
  for (int i = 0; i <= rows; ++i)
    for (int k = 0; k < around; ++k) {
      const double a = 2.0 * std::numbers::pi * k / around, s = static_cast<double>(i) / rows;
      const double at = 0.09 + 0.06 * s, now = 0.09 + (rim(a) - 0.09) * s;
      r.flat.emplace_back(at * std::cos(a), at * std::sin(a), 0.0);
      r.places.emplace_back(now * std::cos(a), now * std::sin(a), -0.03 * s);
    }
  for (int i = 0; i < rows; ++i)
    for (int k = 0; k < around; ++k) {
      const int next = (k + 1) % around, a = i * around + k, b = i * around + next, c = a + around, d = b + around;
      r.triangles.push_back({a, c, b});
      r.triangles.push_back({b, c, d});
    }
  return r;
}

}  // namespace

TEST_CASE("a specimen without folds has the coefficient of its circle") {
  const Ring r = ring(360, [](double) { return 0.12; });
  const cli::DrapeShape s = cli::drape_shape(r.triangles, r.flat, r.places, 0.09);
  CHECK(s.coefficient == relative((0.12 * 0.12 - 0.0081) / (0.0225 - 0.0081)).epsilon(1e-3));
  CHECK(s.folds.empty());
  const Ring flat = ring(360, [](double) { return 0.15; });
  CHECK(cli::drape_shape(flat.triangles, flat.flat, flat.places, 0.09).coefficient == relative(1.0).epsilon(1e-12));
}

TEST_CASE("folds are counted with their angles, amplitudes and wavelengths") {
  for (const int n : {2, 5, 9})
    for (const double turn : {0.0, 0.3, 3.0}) {
      const Ring r = ring(720, [&](double a) { return 0.12 + 0.01 * std::cos(n * (a - turn)); });
      const cli::DrapeShape s = cli::drape_shape(r.triangles, r.flat, r.places, 0.09);
      REQUIRE(s.folds.size() == static_cast<std::size_t>(n));
      for (const cli::DrapeFold& f : s.folds) {
        CHECK(std::abs(std::remainder(n * (f.angle - turn), 2.0 * std::numbers::pi)) < 0.02 * n);
        CHECK(f.amplitude == relative(0.02).epsilon(1e-3));
        CHECK(f.wavelength == relative(2.0 * std::numbers::pi / n).epsilon(0.02));
      }
      CHECK(s.amplitude_variation < 1e-3);
      CHECK(s.wavelength_variation < 0.02);
      // 1/2 int r^2: half the square of the amplitude on top.
      CHECK(s.coefficient == relative((0.0144 + 0.5e-4 - 0.0081) / (0.0225 - 0.0081)).epsilon(1e-3));
    }
}

TEST_CASE("ripples are no folds, and uneven folds are told as such") {
  const Ring ripples = ring(720, [](double a) { return 0.12 + 0.01 * std::cos(4 * a) + 3e-4 * std::cos(40 * a); });
  CHECK(cli::drape_shape(ripples.triangles, ripples.flat, ripples.places, 0.09).folds.size() == 4);
  const Ring flat = ring(720, [](double a) { return 0.149 + 1e-4 * std::cos(6 * a); });
  CHECK(cli::drape_shape(flat.triangles, flat.flat, flat.places, 0.09).folds.empty());
  const Ring uneven = ring(720, [](double a) { return 0.12 + 0.01 * std::cos(4 * a) + 0.004 * std::cos(2 * a); });
  const cli::DrapeShape s = cli::drape_shape(uneven.triangles, uneven.flat, uneven.places, 0.09);
  REQUIRE(s.folds.size() == 4);
  CHECK(s.amplitude_variation > 0.19);
}

TEST_CASE("a rim that is tucked under casts the shadow of what is above it") {
  Ring r = ring(360, [](double) { return 0.12; });
  // The last row is drawn back under the one before.
  for (std::size_t v = r.places.size() - 360; v < r.places.size(); ++v)
    r.places[v] = Vec3(0.8 * r.places[v][0], 0.8 * r.places[v][1], -0.05);
  const double rim = 0.09 + 0.03 * 5 / 6;
  CHECK(cli::drape_shape(r.triangles, r.flat, r.places, 0.09).coefficient ==
        relative((rim * rim - 0.0081) / (0.0225 - 0.0081)).epsilon(2e-3));
}

}  // namespace test_drape_shape
