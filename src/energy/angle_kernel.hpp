// Triangles side by side that bend by the angles at edges; private to the element kernels. Symbols as in angle_bending.hpp, fields
// as in element_kernels.hpp: with curvatures times L^T, A D = L L^T, the energy is half their square.
// Theory: docs/theory/curvature.md, bending by angles.
#pragma once

#include "element_kernels.hpp"
#include "lanes.hpp"

namespace voile::energy::VOILE_KERNELS {

constexpr int most_angle_points = 64;

VOILE_INLINE int count_lanes(const AngleBatch& batch, int lane) {
  return batch.last - lane < width ? batch.last - lane : width;
}

VOILE_INLINE Real angle_number(const AngleBatch& batch, int lane, int place) {
  return load(batch.fields + place * batch_lanes + lane);
}

/// kappa - kappa0: sums over the hinges of each lane.
VOILE_INLINE void curvature_of(const AngleBatch& batch, int lane, const double* angles, Real (&kappa)[3]) {
  alignas(64) double sums[3][width];
  for (int l = 0; l < width; ++l) {
    Four sum{};
    for (int h = batch.first_hinge[lane + l]; h < batch.last_hinge[lane + l]; ++h)
      sum += angles[batch.hinges[h].edge] * load_four(batch.hinge_weights + 4 * static_cast<long>(h));
    for (int r = 0; r < 3; ++r) sums[r][l] = sum[r];
  }
  for (int r = 0; r < 3; ++r) kappa[r] = load(sums[r]) - angle_number(batch, lane, angle_fields::rest + r);
}

/// r + B'u, relative to the first point: the B' add up to zero.
VOILE_INLINE void bend_of(const AngleBatch& batch, int lane, const KernelState& state, Vector (&bend)[3]) {
  for (int r = 0; r < 3; ++r) {
    const int at = angle_fields::start + 3 * r;
    bend[r] = {angle_number(batch, lane, at), angle_number(batch, lane, at + 1), angle_number(batch, lane, at + 2)};
  }
  const Vector first = gather_vector(state.u, batch.gather + lane);
  for (int i = 1; i < batch.points; ++i) {
    const Vector u = gather_vector(state.u, batch.gather + i * batch_lanes + lane) - first;
    for (int r = 0; r < 3; ++r) bend[r] = bend[r] + angle_number(batch, lane, angle_fields::weights + 3 * i + r) * u;
  }
}

/// Adds the derivatives by the angles of the active lanes.
VOILE_INLINE void add_pulls(const AngleBatch& batch, int lane, const Real (&kappa)[3], double* pulls) {
  alignas(64) double moment[3][width];
  for (int r = 0; r < 3; ++r) store(moment[r], kappa[r]);
  for (int l = 0; l < count_lanes(batch, lane); ++l)
    for (int h = batch.first_hinge[lane + l]; h < batch.last_hinge[lane + l]; ++h) {
      const double* w = batch.hinge_weights + 4 * static_cast<long>(h);
      pulls[batch.hinges[h].edge] += moment[0][l] * w[0] + moment[1][l] * w[1] + moment[2][l] * w[2];
    }
}

inline void angle_gradient(const AngleBatch& batch, const KernelState& state, const double* angles, double* pulls,
                           double* force, double* energy) {
  for (int lane = batch.first; lane < batch.last; lane += width) {
    Real kappa[3];
    Vector bend[3];
    curvature_of(batch, lane, angles, kappa);
    add_pulls(batch, lane, kappa, pulls);
    bend_of(batch, lane, state, bend);
    Real sum = all(0.0);
    for (int r = 0; r < 3; ++r) sum += kappa[r] * kappa[r] - dot(bend[r], bend[r]);
    store(energy + lane, 0.5 * sum);
    for (int i = 0; i < batch.points; ++i) {
      Vector g = zero();
      for (int r = 0; r < 3; ++r) g = g - angle_number(batch, lane, angle_fields::weights + 3 * i + r) * bend[r];
      scatter_vector(force, batch.scatter + i * batch_lanes + lane, g, count_lanes(batch, lane));
    }
  }
}

/// Of each lane the derivatives of kappa by its points, three vectors each.
struct LaneSlopes {
  alignas(64) Four of[width][3 * most_angle_points];
};

VOILE_INLINE void slopes_of_lane(const AngleBatch& batch, int lane, int l, const double* slopes, LaneSlopes& s) {
  Four* to = s.of[l];
  for (int k = 0; k < 3 * batch.points; ++k) to[k] = Four{};
  for (int h = batch.first_hinge[lane + l]; h < batch.last_hinge[lane + l]; ++h) {
    const HingeAt& hinge = batch.hinges[h];
    const double *w = batch.hinge_weights + 4 * static_cast<long>(h),
                 *slope = slopes + 16 * static_cast<long>(hinge.edge);
    for (int k = 0; k < 4; ++k) {
      const Four v = load_four(slope + 4 * k);
      Four* at = to + 3 * hinge.at[k];
      for (int r = 0; r < 3; ++r) at[r] += w[r] * v;
    }
  }
}

/// Number k of all lanes side by side.
VOILE_INLINE Vector across_lanes(const LaneSlopes& s, int k) {
#if VOILE_LANES >= 4
  Four part[width / 4][4];
  for (int q = 0; q < width / 4; ++q) {
    const Four rows[4] = {s.of[4 * q][k], s.of[4 * q + 1][k], s.of[4 * q + 2][k], s.of[4 * q + 3][k]};
    transpose(rows, part[q]);
  }
#if VOILE_LANES == 8
  const auto both = [&](int c) { return __builtin_shufflevector(part[0][c], part[1][c], 0, 1, 2, 3, 4, 5, 6, 7); };
  return {both(0), both(1), both(2)};
#else
  return {part[0][0], part[0][1], part[0][2]};
#endif
#elif VOILE_LANES == 2
  return {Real{s.of[0][k][0], s.of[1][k][0]}, Real{s.of[0][k][1], s.of[1][k][1]}, Real{s.of[0][k][2], s.of[1][k][2]}};
#else
  return {s.of[0][k][0], s.of[0][k][1], s.of[0][k][2]};
#endif
}

VOILE_INLINE void angle_blocks(const AngleBatch& batch, int lane, const Vector (*slope)[3], double* blocks) {
  const int active = count_lanes(batch, lane), *slot = batch.slots + lane;
  const int pairs = batch.points * (batch.points + 1) / 2;
  Real number[most_angle_points];
  for (int i = 0; i < batch.points; ++i) number[i] = converted(batch.scatter + i * batch_lanes + lane);
  constexpr int ahead = 3;
  for (int i = 0, at = 0; i < batch.points; ++i) {
    Real w[3];
    for (int r = 0; r < 3; ++r) w[r] = angle_number(batch, lane, angle_fields::weights + 3 * i + r);
    for (int j = i; j < batch.points; ++j, ++at, slot += batch_lanes) {
      if (at + ahead < pairs) fetch_blocks(blocks, slot + ahead * batch_lanes);
      Block block;
      for (Real& k : block.k) k = all(0.0);
      Real constant = all(0.0);
      for (int r = 0; r < 3; ++r) {
        add_outer(block, slope[i][r], slope[j][r]);
        constant += w[r] * angle_number(batch, lane, angle_fields::weights + 3 * j + r);
      }
      block.k[0] -= constant;
      block.k[4] -= constant;
      block.k[8] -= constant;
      order_block(block, number[i], number[j]);
      scatter_block(blocks, slot, block, active);
    }
  }
}

inline void angle_tangent(const AngleBatch& batch, const double* angles, const double* slopes, double* pulls,
                          double* blocks) {
  for (int lane = batch.first; lane < batch.last; lane += width) {
    Real kappa[3];
    curvature_of(batch, lane, angles, kappa);
    add_pulls(batch, lane, kappa, pulls);
    LaneSlopes s;
    for (int l = 0; l < width; ++l) slopes_of_lane(batch, lane, l, slopes, s);
    Vector slope[most_angle_points][3];
    for (int i = 0; i < batch.points; ++i)
      for (int r = 0; r < 3; ++r) slope[i][r] = across_lanes(s, 3 * i + r);
    angle_blocks(batch, lane, slope, blocks);
  }
}

}  // namespace voile::energy::VOILE_KERNELS
