// Friction of bent yarns in several triangles side by side; private to the element kernels. Symbols as in yarn_friction.hpp.
// Theory: docs/theory/yarn-friction.md.
#pragma once

#include "curved_kernel.hpp"

namespace voile::energy::VOILE_KERNELS {

VOILE_INLINE Real yarn_number(const YarnBatch& batch, int lane, int place) {
  return load(batch.fields + place * batch_lanes + lane);
}
VOILE_INLINE Real yarn_weight(const YarnBatch& batch, int lane, int point, int direction) {
  return yarn_number(batch, lane, yarn_fields::weights + 3 * point + direction);
}
VOILE_INLINE int count_lanes(const YarnBatch& batch, int lane) {
  return batch.last - lane < width ? batch.last - lane : width;
}

/// Curvatures of yarns, what sliders answer, and the geometry that they depend on.
struct Yarns {
  Vector arm[3], unit;      ///< as in Curved
  Real length;              ///< |m|
  Vector bend[3];           ///< k_r
  Real kappa[3];            ///< n.k_r - kappa0_r
  Real moment[3], hold[3];  ///< A m_r and its derivative
  Real energy;
};

VOILE_INLINE void yarns_of(const YarnBatch& batch, int lane, const KernelState& state, Yarns& y) {
  Vector x[3];
  for (int k = 0; k < 3; ++k) x[k] = gather_vector(state.x, batch.gather + k * batch_lanes + lane);
  const Vector a = x[1] - x[0], b = x[2] - x[0], m = cross(a, b);
  y.arm[0] = b - a;
  y.arm[1] = zero() - b;
  y.arm[2] = a;
  y.length = root(dot(m, m));
  y.unit = 1.0 / y.length * m;
  for (int r = 0; r < 3; ++r) {
    const int at = yarn_fields::start + 3 * r;
    y.bend[r] = {yarn_number(batch, lane, at), yarn_number(batch, lane, at + 1), yarn_number(batch, lane, at + 2)};
  }
  // Relative to the first point: the weights add up to zero.
  const Vector first = gather_vector(state.u, batch.gather + lane);
  for (int i = 1; i < batch.points; ++i) {
    const Vector u = gather_vector(state.u, batch.gather + i * batch_lanes + lane) - first;
    for (int r = 0; r < 3; ++r) y.bend[r] = y.bend[r] + yarn_weight(batch, lane, i, r) * u;
  }
  for (int r = 0; r < 3; ++r) y.kappa[r] = dot(y.unit, y.bend[r]) - yarn_number(batch, lane, yarn_fields::rest + r);
}

/// Huber's function of the change of curvature, summed over the sliders.
VOILE_INLINE void slide(const YarnBatch& batch, int lane, Yarns& y) {
  y.energy = all(0.0);
  for (int r = 0; r < 3; ++r) y.moment[r] = y.hold[r] = all(0.0);
  const double* at = batch.sliders + lane;
  for (int k = 0; k < batch.slider_count; ++k)
    for (int r = 0; r < 3; ++r, at += yarn_fields::per_slider * batch_lanes) {
      const Real slip = load(at), stiffness = load(at + batch_lanes), limit = load(at + 2 * batch_lanes),
                 compliance = load(at + 3 * batch_lanes);
      const Real stretch = y.kappa[r] - slip, trial = stiffness * stretch;
      const Real size = larger(trial, -trial);
      const auto sticks = size <= (1.0 + yarn_fields::round_off) * limit;
      y.hold[r] += select(sticks, stiffness, all(0.0));
      y.moment[r] += select(sticks, trial, select(trial > 0.0 * trial, limit, -limit));
      y.energy += select(sticks, 0.5 * trial * stretch, limit * (size - 0.5 * limit) * compliance);
    }
}

/// P v / |m|, P the projection across the normal.
VOILE_INLINE Vector turned(const Yarns& y, const Vector& v) {
  return 1.0 / y.length * (v - dot(y.unit, v) * y.unit);
}

inline void yarn_gradient(const YarnBatch& batch, const KernelState& state, double* force, double* energy) {
  for (int lane = batch.first; lane < batch.last; lane += width) {
    Yarns y;
    yarns_of(batch, lane, state, y);
    slide(batch, lane, y);
    store(energy + lane, y.energy);
    const Vector q = turned(y, y.moment[0] * y.bend[0] + y.moment[1] * y.bend[1] + y.moment[2] * y.bend[2]);
    for (int i = 0; i < batch.points; ++i) {
      Real w = all(0.0);
      for (int r = 0; r < 3; ++r) w += y.moment[r] * yarn_weight(batch, lane, i, r);
      Vector g = w * y.unit;
      if (i < 3) g = g - cross(y.arm[i], q);
      scatter_vector(force, batch.scatter + i * batch_lanes + lane, g, count_lanes(batch, lane));
    }
  }
}

/// The second derivative of n.v with v = sum_r A m_r k_r, for corners with all points: that of the normal-dependent part of
/// curved bending with the opposite sign.
struct YarnTurn {
  Curved curved;
  CurvedParts parts;
  Real coupling[3];
};
VOILE_INLINE void turn_of(const YarnBatch& batch, int lane, const Yarns& y, YarnTurn& t) {
  for (int k = 0; k < 3; ++k) t.curved.arm[k] = y.arm[k];
  t.curved.unit = t.curved.start_normal = y.unit;
  t.curved.length = y.length;
  t.curved.rest_energy = all(0.0);
  t.curved.change = zero() - (y.moment[0] * y.bend[0] + y.moment[1] * y.bend[1] + y.moment[2] * y.bend[2]);
  parts_of(t.curved, t.parts);
  for (int i = 0; i < 3; ++i) {
    t.coupling[i] = all(0.0);
    for (int r = 0; r < 3; ++r) t.coupling[i] = t.coupling[i] - y.moment[r] * yarn_weight(batch, lane, i, r);
  }
}

inline void yarn_tangent(const YarnBatch& batch, const KernelState& state, double* blocks) {
  for (int lane = batch.first; lane < batch.last; lane += width) {
    Yarns y;
    yarns_of(batch, lane, state, y);
    slide(batch, lane, y);
    YarnTurn turn;
    if (!state.positive) turn_of(batch, lane, y, turn);
    Vector slope[3][3];  // of kappa_r by corner i, without what the weights give
    for (int r = 0; r < 3; ++r) {
      const Vector q = turned(y, y.bend[r]);
      for (int i = 0; i < 3; ++i) slope[r][i] = zero() - cross(y.arm[i], q);
    }
    Block normal = empty_block();
    add_outer(normal, y.unit, y.unit);
    const int* slot = batch.slots + lane;
    for (int i = 0; i < batch.points; ++i) {
      Real held[3];
      Vector left[3];
      for (int r = 0; r < 3; ++r) {
        held[r] = y.hold[r] * yarn_weight(batch, lane, i, r);
        left[r] = held[r] * y.unit;
        if (i < 3) left[r] = left[r] + y.hold[r] * slope[r][i];
      }
      for (int j = i; j < batch.points; ++j, slot += batch_lanes) {
        Real weight[3];
        for (int r = 0; r < 3; ++r) weight[r] = yarn_weight(batch, lane, j, r);
        Block block = empty_block();
        if (i >= 3) {
          const Real both = held[0] * weight[0] + held[1] * weight[1] + held[2] * weight[2];
          for (int k = 0; k < 9; ++k) block.k[k] = both * normal.k[k];
          scatter_block(blocks, slot, block, count_lanes(batch, lane));  // symmetric
          continue;
        }
        add_outer(block, weight[0] * left[0] + weight[1] * left[1] + weight[2] * left[2], y.unit);
        if (j < 3)
          for (int r = 0; r < 3; ++r) add_outer(block, left[r], slope[r][j]);
        if (!state.positive) {
          Real of_j = all(0.0);
          for (int r = 0; r < 3; ++r) of_j = of_j - y.moment[r] * weight[r];
          if (j < 3)
            corner_block(turn.curved, turn.parts, i, j, turn.coupling[i], of_j, block);
          else
            for (int k = 0; k < 9; ++k) block.k[k] += of_j * turn.parts.mixed[i].k[k];
        }
        order_block(block, converted(batch.scatter + i * batch_lanes + lane),
                    converted(batch.scatter + j * batch_lanes + lane));
        scatter_block(blocks, slot, block, count_lanes(batch, lane));
      }
    }
  }
}

}  // namespace voile::energy::VOILE_KERNELS
