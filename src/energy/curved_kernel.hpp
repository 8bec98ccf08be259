// The part of bending that depends on the normals of several triangles side by side; private to the element kernels. Symbols as in
// bending.hpp.
// Theory: docs/theory/curved-rest-shapes.md.
#pragma once

#include "edge_kernel.hpp"

namespace voile::energy::VOILE_KERNELS {

VOILE_INLINE Real curved_number(const CurvedBatch& batch, int lane, int place) {
  return load(batch.fields + place * batch_lanes + lane);
}
VOILE_INLINE Vector curved_vector(const CurvedBatch& batch, int lane, int place) {
  return {curved_number(batch, lane, place), curved_number(batch, lane, place + 1),
          curved_number(batch, lane, place + 2)};
}
VOILE_INLINE int count_lanes(const CurvedBatch& batch, int lane) {
  return batch.last - lane < width ? batch.last - lane : width;
}

/// The normal and what it meets.
struct Curved {
  Vector arm[3];                      ///< of the corners: dm/dx_i = [arm_i]_x for m = (x_1 - x_0) x (x_2 - x_0)
  Vector unit, start_normal, change;  ///< n, N_s, w + sum_i c_i u_i
  Real length, rest_energy;           ///< |m|, e0
};

VOILE_INLINE void curved_of(const CurvedBatch& batch, int lane, const KernelState& state, Curved& s) {
  Vector x[3];
  for (int k = 0; k < 3; ++k) x[k] = gather_vector(state.x, batch.gather + k * batch_lanes + lane);
  const Vector a = x[1] - x[0], b = x[2] - x[0], m = cross(a, b);
  s.arm[0] = b - a;
  s.arm[1] = zero() - b;
  s.arm[2] = a;
  s.length = root(dot(m, m));
  s.unit = 1.0 / s.length * m;
  s.rest_energy = curved_number(batch, lane, curved_fields::rest_energy);
  s.start_normal = curved_vector(batch, lane, curved_fields::normal);
  s.change = curved_vector(batch, lane, curved_fields::start_coupling);
  for (int i = 0; i < batch.points; ++i)
    s.change = s.change + curved_number(batch, lane, curved_fields::coupling + i) *
                              gather_vector(state.u, batch.gather + i * batch_lanes + lane);
}

/// v = e0 N_s + w + sum_i c_i u_i without its part along n.
VOILE_INLINE Vector across_normal(const Curved& s, Real& along) {
  const Vector v = s.rest_energy * s.start_normal + s.change;
  along = dot(s.unit, v);
  return v - along * s.unit;
}

inline void curved_gradient(const CurvedBatch& batch, const KernelState& state, double* force, double* energy) {
  for (int lane = batch.first; lane < batch.last; lane += width) {
    Curved s;
    curved_of(batch, lane, state, s);
    const Vector turn = s.start_normal - s.unit;
    // 1 - n.N_s as half the square of the difference: exact where the turn is small.
    store(energy + lane, 0.5 * s.rest_energy * dot(turn, turn) + dot(turn, s.change));
    Real along;
    const Vector q = -1.0 / s.length * across_normal(s, along);
    for (int i = 0; i < batch.points; ++i) {
      Vector g = curved_number(batch, lane, curved_fields::coupling + i) * turn;
      if (i < 3) g = g - cross(s.arm[i], q);
      scatter_vector(force, batch.scatter + i * batch_lanes + lane, g, count_lanes(batch, lane));
    }
  }
}

/// What blocks of the corners are made of.
struct CurvedParts {
  Vector by_normal[3], by_across[3];  ///< arm x n, arm x P v / |m|^2
  Block mixed[3];                     ///< [arm]_x P / |m|
  Real scale;                         ///< n.v / |m|^2
  Vector bilinear;                    ///< -P v / |m|
};

VOILE_INLINE void parts_of(const Curved& s, CurvedParts& p) {
  Real along;
  const Vector across = across_normal(s, along);
  const Real inverse = 1.0 / s.length;
  p.scale = along * inverse * inverse;
  p.bilinear = (-inverse) * across;
  for (int i = 0; i < 3; ++i) {
    p.by_normal[i] = cross(s.arm[i], s.unit);
    p.by_across[i] = (inverse * inverse) * cross(s.arm[i], across);
    p.mixed[i] = empty_block();
    add_cross(p.mixed[i], inverse, s.arm[i]);
    add_outer(p.mixed[i], (-inverse) * p.by_normal[i], s.unit);
  }
}

/// Block of corners i <= j.
VOILE_INLINE void corner_block(const Curved& s, const CurvedParts& p, int i, int j, const Real& of_i, const Real& of_j,
                               Block& block) {
  add_outer(block, p.by_normal[i], p.by_across[j] - p.scale * p.by_normal[j]);
  add_outer(block, p.by_across[i], p.by_normal[j]);
  add_outer(block, (-p.scale) * s.arm[j], s.arm[i]);
  const Real d = p.scale * dot(s.arm[i], s.arm[j]);
  block.k[0] += d;
  block.k[4] += d;
  block.k[8] += d;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) block.k[3 * r + c] += of_j * p.mixed[i].k[3 * r + c] + of_i * p.mixed[j].k[3 * c + r];
  // m is bilinear: second derivative -[q]_x for the pair of its two sides.
  if (i != j) add_cross(block, all(i == 0 && j == 2 ? 1.0 : -1.0), p.bilinear);
}

inline void curved_tangent(const CurvedBatch& batch, const KernelState& state, double* blocks) {
  for (int lane = batch.first; lane < batch.last; lane += width) {
    Curved s;
    CurvedParts p;
    curved_of(batch, lane, state, s);
    parts_of(s, p);
    const int* slot = batch.slots + lane;
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < batch.points; ++j, slot += batch_lanes) {
        const Real of_j = curved_number(batch, lane, curved_fields::coupling + j);
        Block block = empty_block();
        if (j < 3)
          corner_block(s, p, i, j, curved_number(batch, lane, curved_fields::coupling + i), of_j, block);
        else
          for (int k = 0; k < 9; ++k) block.k[k] = of_j * p.mixed[i].k[k];
        order_block(block, converted(batch.scatter + i * batch_lanes + lane),
                    converted(batch.scatter + j * batch_lanes + lane));
        scatter_block(blocks, slot, block, count_lanes(batch, lane));
      }
  }
}

}  // namespace voile::energy::VOILE_KERNELS
