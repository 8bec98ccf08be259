// Angles at several edges side by side, with their derivatives; private to the element kernels. Symbols as in edge_angle.hpp.
#pragma once

#include "element_kernels.hpp"
#include "lanes.hpp"

namespace voile::energy::VOILE_KERNELS {

/// Angle of (x, y); 0 where both are 0. Source: Cephes' atan.c (S. Moshier), two of its three ranges.
VOILE_INLINE Real angle_of(const Real& y, const Real& x) {
  const double above[] = {-8.750608600031904122785e-1, -1.615753718733365076637e1, -7.500855792314704667340e1,
                          -1.228866684490136173410e2, -6.485021904942025371773e1};
  const double below[] = {2.485846490142306297962e1, 1.650270098316988542046e2, 4.328810604912902668951e2,
                          4.853903996359136964868e2, 1.945506571482613964425e2};
  const double quarter = 0.78539816339744830962, half = 1.57079632679489661923, pi = 3.14159265358979323846;
  const Real none = all(0.0), ax = select(x < none, -x, x), ay = select(y < none, -y, y);
  const auto steep = ax < ay;
  const Real low = select(steep, ax, ay), high = select(steep, ay, ax);
  const auto large = 0.414213562373095 * high < low;
  const Real denominator = select(large, low + high, high);
  const Real a = select(large, low - high, low) / select(denominator > none, denominator, all(1.0)), z = a * a;
  Real p = all(above[0]), q = z + below[0];
  for (int i = 1; i < 5; ++i) {
    p = p * z + above[i];
    q = q * z + below[i];
  }
  Real angle = a * (z * p / q) + a + select(large, all(quarter), none);
  angle = select(steep, half - angle, angle);
  angle = select(x < none, pi - angle, angle);
  return select(y < none, -angle, angle);
}

/// What the angle and its derivatives are made of.
struct Edge {
  Vector e, p, q, normal_p, normal_q;
  Real square, length;  ///< l^2, l
};

VOILE_INLINE void edge_of(const EdgeBatch& batch, int lane, const KernelState& state, Edge& edge) {
  Vector x[4];
  for (int k = 0; k < 4; ++k) x[k] = gather_vector(state.x, batch.points + k * batch_lanes + lane);
  edge.e = x[1] - x[0];
  edge.p = x[2] - x[0];
  edge.q = x[3] - x[0];
  edge.normal_p = cross(edge.e, edge.p);
  edge.normal_q = cross(edge.q, edge.e);
  edge.square = dot(edge.e, edge.e);
  edge.length = root(edge.square);
}

VOILE_INLINE Real angle_at(const Edge& edge) {
  return angle_of(dot(edge.e, cross(edge.normal_q, edge.normal_p)) / edge.length, dot(edge.normal_p, edge.normal_q));
}

VOILE_INLINE void slopes_at(const Edge& edge, Vector (&slope)[4]) {
  const Vector by_p = edge.length / dot(edge.normal_p, edge.normal_p) * edge.normal_p,
               by_q = edge.length / dot(edge.normal_q, edge.normal_q) * edge.normal_q;
  slope[1] = zero() - dot(edge.p, edge.e) / edge.square * by_p - dot(edge.q, edge.e) / edge.square * by_q;
  slope[2] = by_p;
  slope[3] = by_q;
  slope[0] = zero() - slope[1] - by_p - by_q;
}

VOILE_INLINE int count_lanes(const EdgeBatch& batch, int lane) {
  return batch.lanes - lane < width ? batch.lanes - lane : width;
}

inline void edge_angles(const EdgeBatch& batch, const KernelState& state) {
  for (int lane = 0; lane < batch.lanes; lane += width) {
    Edge edge;
    edge_of(batch, lane, state, edge);
    store(batch.angle + lane, angle_at(edge));
  }
}

inline void edge_slopes(const EdgeBatch& batch, const KernelState& state) {
  for (int lane = 0; lane < batch.lanes; lane += width) {
    Edge edge;
    edge_of(batch, lane, state, edge);
    store(batch.angle + lane, angle_at(edge));
    Vector slope[4];
    slopes_at(edge, slope);
    for (int k = 0; k < 4; ++k) {
      alignas(64) double numbers[3][width];
      store(numbers[0], slope[k].x);
      store(numbers[1], slope[k].y);
      store(numbers[2], slope[k].z);
      for (int l = 0; l < width; ++l) {
        double* to = batch.slopes + 16 * (lane + l) + 4 * k;
        for (int c = 0; c < 3; ++c) to[c] = numbers[c][l];
        to[3] = 0.0;
      }
    }
  }
}

inline void edge_gradient(const EdgeBatch& batch, const KernelState& state, double* force) {
  for (int lane = 0; lane < batch.lanes; lane += width) {
    Edge edge;
    edge_of(batch, lane, state, edge);
    Vector slope[4];
    slopes_at(edge, slope);
    const Real pull = load(batch.pull + lane);
    for (int k = 0; k < 4; ++k)
      scatter_vector(force, batch.scatter + k * batch_lanes + lane, pull * slope[k], count_lanes(batch, lane));
  }
}

/// to += s [v]_x
VOILE_INLINE void add_cross(Block& to, const Real& s, const Vector& v) {
  const Vector w = s * v;
  to.k[1] -= w.z;
  to.k[2] += w.y;
  to.k[3] += w.z;
  to.k[5] -= w.x;
  to.k[6] -= w.y;
  to.k[7] += w.x;
}
VOILE_INLINE Block empty_block() {
  Block block;
  for (Real& k : block.k) k = all(0.0);
  return block;
}

/// Second derivatives times the pull: by (p, b), (q, b), (p, p), (q, q), (b, b).
struct EdgeSecond {
  Block pb, qb, pp, qq, bb;
};
VOILE_INLINE EdgeSecond second_of(const Edge& edge, const Real& pull) {
  EdgeSecond s{empty_block(), empty_block(), empty_block(), empty_block(), empty_block()};
  const Real inverse = 1.0 / edge.square, of_p = 1.0 / dot(edge.normal_p, edge.normal_p),
             of_q = 1.0 / dot(edge.normal_q, edge.normal_q);
  const Real foot_p = dot(edge.p, edge.e) * inverse, foot_q = dot(edge.q, edge.e) * inverse;
  const Real pull_p = pull * edge.length * of_p, pull_q = pull * edge.length * of_q;
  const Vector by_p = pull_p * edge.normal_p, by_q = pull_q * edge.normal_q;
  const Vector along = inverse * edge.e;
  // n_p = e x P and n_q = Q x e; the slopes also grow with l.
  add_outer(s.pb, by_p, along + (2.0 * of_p) * cross(edge.normal_p, edge.p));
  add_cross(s.pb, -pull_p, edge.p);
  add_outer(s.qb, by_q, along - (2.0 * of_q) * cross(edge.normal_q, edge.q));
  add_cross(s.qb, pull_q, edge.q);
  add_outer(s.pp, by_p, (-2.0 * of_p) * cross(edge.normal_p, edge.e));
  add_cross(s.pp, pull_p, edge.e);
  add_outer(s.qq, by_q, (2.0 * of_q) * cross(edge.normal_q, edge.e));
  add_cross(s.qq, -pull_q, edge.e);
  add_outer(s.bb, zero() - by_p, inverse * (edge.p - (2.0 * foot_p) * edge.e));
  add_outer(s.bb, zero() - by_q, inverse * (edge.q - (2.0 * foot_q) * edge.e));
  for (int k = 0; k < 9; ++k) s.bb.k[k] -= foot_p * s.pb.k[k] + foot_q * s.qb.k[k];
  return s;
}

/// Blocks aa ab ap aq bb bp bq pp qq: those of a such that all rows add up to zero.
VOILE_INLINE void edge_blocks(const EdgeSecond& s, Block (&block)[9]) {
  const auto turned = [](const Block& b, int k) { return b.k[k % 3 * 3 + k / 3]; };
  for (int k = 0; k < 9; ++k) {
    const Real pb = turned(s.pb, k), qb = turned(s.qb, k);
    block[1].k[k] = -(s.bb.k[k] + s.pb.k[k] + s.qb.k[k]);
    block[2].k[k] = -(pb + s.pp.k[k]);
    block[3].k[k] = -(qb + s.qq.k[k]);
    block[4].k[k] = s.bb.k[k];
    block[5].k[k] = pb;
    block[6].k[k] = qb;
    block[7].k[k] = s.pp.k[k];
    block[8].k[k] = s.qq.k[k];
  }
  for (int k = 0; k < 9; ++k) block[0].k[k] = -(turned(block[1], k) + turned(block[2], k) + turned(block[3], k));
}

inline void edge_tangent(const EdgeBatch& batch, const KernelState& state, double* blocks) {
  const int pairs[9][3] = {{0, 0, 0}, {0, 1, 1}, {0, 2, 2}, {0, 3, 3}, {1, 1, 4},
                           {1, 2, 5}, {1, 3, 6}, {2, 2, 7}, {3, 3, 9}};
  for (int lane = 0; lane < batch.lanes; lane += width) {
    for (const auto& p : pairs) fetch_blocks(blocks, batch.slots + p[2] * batch_lanes + lane);
    Edge edge;
    edge_of(batch, lane, state, edge);
    Block block[9];
    edge_blocks(second_of(edge, load(batch.pull + lane)), block);
    Real number[4];
    for (int k = 0; k < 4; ++k) number[k] = converted(batch.scatter + k * batch_lanes + lane);
    for (int k = 0; k < 9; ++k) {
      order_block(block[k], number[pairs[k][0]], number[pairs[k][1]]);
      scatter_block(blocks, batch.slots + pairs[k][2] * batch_lanes + lane, block[k], count_lanes(batch, lane));
    }
  }
}

}  // namespace voile::energy::VOILE_KERNELS
