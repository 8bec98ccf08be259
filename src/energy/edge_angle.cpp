#include "edge_angle.hpp"

#include "element_kernels.hpp"

namespace voile::energy {

namespace {

/// One edge, as the scalar kernels take it.
struct Single {
  std::array<int, 4 * batch_lanes> points{};
  std::array<int, 10 * batch_lanes> slots{};
  std::array<double, batch_lanes> angle{}, pull{};
  std::array<double, 16 * batch_lanes> slopes{};
  KernelState state;

  explicit Single(const EdgePoints& x) {
    for (int k = 0; k < 4; ++k) points[static_cast<std::size_t>(k) * batch_lanes] = k;
    for (int k = 0; k < 10; ++k) slots[static_cast<std::size_t>(k) * batch_lanes] = 9 * k;
    pull[0] = 1.0;
    state.x = x[0].data();
  }
  [[nodiscard]] EdgeBatch batch() {
    return {points.data(), points.data(), slots.data(), 1, angle.data(), slopes.data(), pull.data()};
  }
};

}  // namespace

double edge_angle(const EdgePoints& x) {
  Single one(x);
  scalar_kernels().edges.angles(one.batch(), one.state);
  return one.angle[0];
}

EdgePoints edge_angle_slopes(const EdgePoints& x) {
  Single one(x);
  scalar_kernels().edges.slopes(one.batch(), one.state);
  EdgePoints slopes;
  for (std::size_t k = 0; k < 4; ++k) slopes[k] = Eigen::Map<const Vec3>(one.slopes.data() + 4 * k);
  return slopes;
}

EdgeAngleCurvature edge_angle_curvature(const EdgePoints& x) {
  Single one(x);
  std::array<double, 90> blocks{};
  scalar_kernels().edges.tangent(one.batch(), one.state, blocks.data());
  EdgeAngleCurvature c;
  const double* at = blocks.data();
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i; j < 4; ++j, at += 9) {
      c[i][j] = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(at);
      if (j != i) c[j][i] = c[i][j].transpose();
    }
  return c;
}

}  // namespace voile::energy
