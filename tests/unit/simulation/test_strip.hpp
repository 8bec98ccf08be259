// The strip that the tests of the library share.
#pragma once

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/mpi.hpp"
#include "voile/voile.hpp"

namespace voile::testing {

/// A cantilever strip 1 x 0.25 that bends under a load at its end.
[[nodiscard]] inline Case strip(const std::string& analysis) {
  return Case::parse(fmt::format(R"(
analysis = "{}"
mesh = {{ file = "{}/meshes/cantilever.geo", parameters = {{ nx = 8, ny = 2, length = 1, width = 0.25 }} }}
time = {{ end = 0.1, step = 0.02 }}
[[material]]
type = "isotropic"
young = 1e7
poisson = 0.0
thickness = 0.01
density = 100.0
[[support]]
type = "clamped"
group = "clamp"
[[load]]
type = "line"
group = "tip"
vector = [0, 0, 0.4]
)",
                                 analysis, VOILE_SOURCE_FOLDER));
}

/// The same above a ball that hits it from below.
[[nodiscard]] inline Case ball_below() {
  const Case c = strip("dynamic");
  return Case::parse(c.source() + R"(
[contact]
distance = 5e-3
[[obstacle]]
name = "ball"
type = "sphere"
point = [0.8, 0.125, -0.12]
radius = 0.1
)");
}

[[nodiscard]] inline bool same(const std::vector<double>& a, const std::vector<double>& b) {
  return a == b;  // bit by bit
}

[[nodiscard]] inline double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = a.size() == b.size() ? 0.0 : std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

[[nodiscard]] inline bool is_alone() {
  return mpi::size(PETSC_COMM_WORLD) == 1;
}

[[nodiscard]] inline double tip_height(const Simulation& s) {
  const std::vector<double> x = s.positions();
  return x[3 * static_cast<std::size_t>(s.group("tip").front()) + 2];
}

/// z components of forces that sum up to `total` over the vertices at the tip.
[[nodiscard]] inline std::vector<double> tip_forces(const Simulation& s, double total) {
  std::vector<double> f(3 * static_cast<std::size_t>(s.vertex_count()), 0.0);
  const std::vector<int> tip = s.group("tip");
  for (const int v : tip) f[3 * static_cast<std::size_t>(v) + 2] = total / static_cast<double>(tip.size());
  return f;
}

}  // namespace voile::testing
