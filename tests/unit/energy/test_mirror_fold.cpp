// Folding over a clamped edge: derivatives, where it begins, and that it grows to the end.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "energy/mirror_fold.hpp"
#include "test_relative.hpp"

namespace test_mirror_fold {

using namespace voile;
using energy::Configuration;
using energy::MirrorFoldTerm;

namespace {

constexpr double degree = std::numbers::pi / 180.0;

/// A triangle of height 0.5 on an edge of length 2 along y; the clamp holds the x-y plane, the sheet leaves it along -x.
MirrorFoldTerm term() {
  MirrorFoldTerm t;
  t.add({{0, 1, 2}, 0.25, 0.5, 3.0, Vec3(1.0, 0.0, 0.0), 0, true});
  return t;
}

/// Turned about the edge by an angle.
std::array<Vec3, 3> turned(double angle) {
  return {Vec3(-0.5 * std::cos(angle), 0.5, 0.5 * std::sin(angle)), Vec3(0.0, 0.0, 0.0), Vec3(0.0, 2.0, 0.0)};
}

double energy_of(const MirrorFoldTerm& t, const std::array<Vec3, 3>& x) {
  return t.energy(0, {x.data(), nullptr, nullptr, energy::Tangent::exact});
}

}  // namespace

TEST_CASE("a fold over a clamp costs nothing up to 75 degrees, and with the slope more and more to 180") {
  const MirrorFoldTerm t = term();
  for (const double angle : {0.0, 45.0, 74.9, -74.9}) CHECK(energy_of(t, turned(angle * degree)) == 0.0);
  CHECK(energy_of(t, turned(76.0 * degree)) > 0.0);
  const double c = std::cos(75.0 * degree);
  CHECK(energy_of(t, turned(180.0 * degree)) == relative(3.0 * (1.0 + c) * (1.0 + c)).epsilon(1e-12));
  // K = 2 D l/h: with half of it, times sin^2, for the slope.
  double before = 0.0;
  for (double angle = 1.0; angle <= 180.0; angle += 1.0) {
    const double sine = std::sin(angle * degree), whole = 1.5 * sine * sine + energy_of(t, turned(angle * degree));
    CHECK(whole > before);
    before = whole;
  }
}

TEST_CASE("a fold over a clamp: forces and tangents are derivatives, and turn with the clamp") {
  MirrorFoldTerm t = term();
  const Mat3 turn = Eigen::AngleAxisd(0.4, Vec3(0.2, 1.0, -0.3).normalized()).toRotationMatrix();
  t.turn({turn});
  std::array<Vec3, 3> x = turned(130.0 * degree);
  const double still = energy_of(term(), x);
  for (Vec3& p : x) p = turn * p;
  CHECK(energy_of(t, x) == relative(still).epsilon(1e-12));
  for (int i = 0; i < 3; ++i) x[i] += Vec3(0.03 * i, -0.02, 0.05 * (i - 1));
  constexpr double h = 1e-5;
  std::array<Vec3, 3> force;
  t.gradient(0, {x.data(), nullptr, nullptr, energy::Tangent::exact}, [&](int a, const Vec3& f) { force[a] = f; });
  CHECK(force[0].norm() > 0.1);
  const auto moved = [&](int a, int k, double by) {
    std::array<Vec3, 3> y = x;
    y[a][k] += by;
    return y;
  };
  for (int a = 0; a < 3; ++a)
    for (int k = 0; k < 3; ++k)
      CHECK(std::abs((energy_of(t, moved(a, k, h)) - energy_of(t, moved(a, k, -h))) / (2.0 * h) - force[a][k]) < 1e-8);
  t.hessian(0, {x.data(), nullptr, nullptr, energy::Tangent::exact}, [&](int a, int b, const Mat3& block) {
    for (int k = 0; k < 3; ++k) {
      std::array<Vec3, 2> f;
      for (const int side : {0, 1}) {
        const std::array<Vec3, 3> y = moved(b, k, side == 0 ? -h : h);
        t.gradient(0, {y.data(), nullptr, nullptr, energy::Tangent::exact}, [&](int c, const Vec3& value) {
          if (c == a) f[side] = value;
        });
      }
      CHECK(((f[1] - f[0]) / (2.0 * h) - block.col(k)).norm() < 1e-7);
    }
  });
}

}  // namespace test_mirror_fold
