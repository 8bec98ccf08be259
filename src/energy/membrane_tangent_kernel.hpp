// Second derivatives of the membrane of several triangles side by side; private to the element kernels.
//
// A block is sum_v b_iv b_jv^T + d_ij I: vectors b of the strains, with the factor of their stiffness, and of the term of fourth
// order; numbers d of the stresses.
#pragma once

#include "membrane_kernel.hpp"

namespace voile::energy::VOILE_KERNELS {

/// Principal stress resultants below zero are removed.
VOILE_INLINE void keep_tensile(Real (&n)[3]) {
  const Real mean = 0.5 * (n[0] + n[1]), half = 0.5 * (n[0] - n[1]), radius = root(half * half + n[2] * n[2]);
  const Real none = all(0.0), least = mean - radius, most = mean + radius;
  // One tensile direction p: N+ = (mean + radius) p (x) p, with 2 p p^T = I + (N - mean I)/radius.
  const Real part = 0.5 * most, fraction = part / select(radius > none, radius, all(1.0));
  const Real one[3] = {part + fraction * half, part - fraction * half, fraction * n[2]};
  for (int r = 0; r < 3; ++r) n[r] = select(least >= none, n[r], select(most <= none, none, one[r]));
}

/// Takes the part of second order in the step from the previous iterate off the strains.
VOILE_INLINE void linearise(const MembraneShape& shape, const MembraneBatch& batch, int lane, const KernelState& state,
                            const Strained& s, Real (&strain)[3][3]) {
  const Fields f{batch.fields + lane};
  Vector x[six], before[six];
  gather_six(batch, lane, state.x, x);
  gather_six(batch, lane, state.previous, before);
  for (int i = 0; i < six; ++i) x[i] = x[i] - before[i];
  for (int k = shape.first_sample; k < shape.last_sample; ++k) {
    Vector a[2];
    base_of(f, k, x, a);
    add_metric(a, -shape.weight[k], strain[shape.group[k]]);
  }
  if (!shape.corrected) return;
  Vector step[bends];
  bends_of(f, batch, lane, state.x, state.previous, step);
  for (int c = 0; c < chords; ++c) {
    const Vector d = along_chord(s.forms.along[c], step);
    const Real half_square = 0.5 * dot(d, d);
    for (int r = 0; r < 3; ++r) {
      strain[0][r] -= half_square * s.forms.mean[c][r];
      if (c < own_chords) strain[1][r] -= half_square * s.forms.own[c][r];
    }
  }
}

/// The strains of another state.
VOILE_APART void strains_at(const MembraneShape& shape, const MembraneBatch& batch, int lane, const KernelState& state,
                            Real (&strain)[3][3]) {
  Strained there;
  strain_lanes(shape, batch, lane, state, there);
  for (int g = 0; g < 3; ++g)
    for (int r = 0; r < 3; ++r) strain[g][r] = there.samples.strain[g][r];
}

/// What the blocks of a group of triangles are made of.
struct TangentParts {
  static constexpr int most_vectors = 9;
  int vectors;                           ///< of each point, the last of which is taken off if `indefinite`
  bool indefinite;                       ///< with a negative part of the term of fourth order
  Vector b[most_points][most_vectors];   ///< of each point
  Real six_by_six[six * (six + 1) / 2];  ///< d of the six points, pairs i <= j row by row
  Real form[bends][bends];               ///< derivatives by K_A and K_B that are the same for x, y and z
  Real sign[7];                          ///< of the first vectors, where triangles have laws of their own
};

VOILE_INLINE constexpr int pair_place(int i, int j, int count) {
  return i * count - i * (i - 1) / 2 + j - i;
}

/// Stresses in d of the six points.
VOILE_INLINE void add_geometric(const MembraneShape& shape, const Fields& f, const Real (&stress)[3][3],
                                TangentParts& t) {
  for (Real& d : t.six_by_six) d = all(0.0);
  for (int s = shape.first_sample; s < shape.last_sample; ++s) {
    const Real(&n)[3] = stress[shape.group[s]];
    for (int k = 0; k < nodes(s); ++k) {
      const Real d0 = shape.weight[s] * f.slope(s, 0, k), d1 = shape.weight[s] * f.slope(s, 1, k);
      const Real p = n[0] * d0 + n[2] * d1, q = n[1] * d1 + n[2] * d0;
      for (int l = k; l < nodes(s); ++l)
        t.six_by_six[pair_place(node(s, k), node(s, l), six)] += p * f.slope(s, 0, l) + q * f.slope(s, 1, l);
    }
  }
}

/// Derivatives of the strains by the six points through base vectors, times L^T and the root of the factor.
template <int n>
VOILE_INLINE void vectors_at_six(const MembraneShape& shape, const Fields& f, const Samples& s, const Real (&l)[3][n],
                                 TangentParts& t) {
  for (int i = 0; i < six; ++i)
    for (int v = 0; v < 3 * shape.groups; ++v) t.b[i][v] = zero();
  for (int k = shape.first_sample; k < shape.last_sample; ++k) {
    const int v = 3 * shape.group[k];
    for (int i = 0; i < nodes(k); ++i) {
      const Real d0 = shape.weight[k] * f.slope(k, 0, i), d1 = shape.weight[k] * f.slope(k, 1, i);
      Vector* b = t.b[node(k, i)] + v;
      b[0] = b[0] + d0 * s.a[k][0];
      b[1] = b[1] + d1 * s.a[k][1];
      b[2] = b[2] + d1 * s.a[k][0] + d0 * s.a[k][1];
    }
  }
  for (int i = 0; i < six; ++i)
    for (int g = 0; g < shape.groups; ++g) {
      Vector* b = t.b[i] + 3 * g;
      times_factor(l[g], b[0], b[1], b[2]);
    }
}

/// dE_r/dK_B of one strain from its chords, times L^T.
template <int count, int n>
VOILE_INLINE void bend_slopes(const ChordForms& forms, const Real (&fraction)[count][3], const ChordBends& bent,
                              const Real (&l)[n], Vector (&slopes)[3][bends]) {
  for (int r = 0; r < 3; ++r)
    for (int b = 0; b < bends; ++b) slopes[r][b] = zero();
  for (int c = 0; c < count; ++c)
    for (int r = 0; r < 3; ++r) {
      const Vector v = fraction[c][r] * bent.chord[c];
      for (int b = 0; b < bends; ++b) slopes[r][b] = slopes[r][b] + forms.along[c][b] * v;
    }
  for (int b = 0; b < bends; ++b) times_factor(l, slopes[0][b], slopes[1][b], slopes[2][b]);
}

/// Two vectors of each K_B, f f^T - g g^T = d2W/dK_A dK_B without its diagonal part: with a, b the derivatives of both factors,
/// a b^T + b a^T = ((a + b)(a + b)^T - (a - b)(a - b)^T) / 2 of vectors that are first made equally long.
VOILE_INLINE void fourth_order(const Invariants& v, Vector (&sum)[3], Vector (&difference)[3]) {
  Real a = all(0.0), b = all(0.0);
  for (int k = 0; k < 3; ++k) {
    a += dot(v.of_bending[k], v.of_bending[k]);
    b += dot(v.of_trace[k], v.of_trace[k]);
  }
  const Real none = all(0.0), one = all(1.0), square_root_of_two = all(1.41421356237309504880);
  const Real ratio = root(root(select(a > none, b, none) / select(a > none, a, one)));
  const Real of_a = square_root_of_two * ratio,
             of_b = select(ratio > none, square_root_of_two / select(ratio > none, ratio, one), none);
  for (int k = 0; k < 3; ++k) {
    sum[k] = of_a * v.of_bending[k] + of_b * v.of_trace[k];
    difference[k] = of_a * v.of_bending[k] - of_b * v.of_trace[k];
  }
}

/// Stresses, at the chords, and the term of fourth order in `form`.
VOILE_INLINE void bend_form(const Fields& f, const Strained& s, const Real (&stress)[3][3], bool fourth, bool positive,
                            TangentParts& t) {
  const auto clipped = [&](const Real& a) { return positive ? larger(a, all(0.0)) : a; };
  for (auto& line : t.form)
    for (Real& number : line) number = all(0.0);
  for (int c = 0; c < chords; ++c) {
    Real weight = clipped(chord_pull(s.forms, c, stress[0]));
    if (c < own_chords) weight += clipped(own_chord_pull(s.forms, c, stress[1]));
    for (int a = 0; a < bends; ++a) {
      const Real part = weight * s.forms.along[c][a];
      for (int b = a; b < bends; ++b) t.form[a][b] += part * s.forms.along[c][b];
    }
  }
  if (fourth) {
    Real bending[6], trace[6];
    f.six_numbers(membrane_fields::bending, bending);
    f.six_numbers(membrane_fields::trace, trace);
    const Real of_bending = 2.0 * clipped(s.invariants.trace), of_trace = 2.0 * clipped(s.invariants.bending);
    for (int a = 0, k = 0; a < 3; ++a)
      for (int b = a; b < 3; ++b, ++k) t.form[a][b] += of_bending * bending[k] + of_trace * trace[k];
  }
  for (int a = 0; a < bends; ++a)
    for (int b = 0; b < a; ++b) t.form[a][b] = t.form[b][a];
}

/// Adds what the vectors of all points get through K.
template <int n>
VOILE_INLINE void vectors_of_bends(const MembraneBatch& batch, int lane, const Strained& s, const Real (&l)[3][n],
                                   TangentParts& t) {
  const Fields f{batch.fields + lane};
  Vector mean[3][bends], own[3][bends];
  bend_slopes<chords>(s.forms, s.forms.mean, s.bends, l[0], mean);
  bend_slopes<own_chords>(s.forms, s.forms.own, s.bends, l[1], own);
  for (int i = 0; i < batch.points; ++i) {
    Real w[bends];
    for (int b = 0; b < bends; ++b) w[b] = f(membrane_fields::weights + bends * i + b);
    for (int r = 0; r < 3; ++r) {
      Vector at_mean = i < six ? t.b[i][r] : zero(), at_own = i < six ? t.b[i][3 + r] : zero();
      for (int b = 0; b < bends; ++b) {
        at_mean = at_mean + w[b] * mean[r][b];
        at_own = at_own + w[b] * own[r][b];
      }
      t.b[i][r] = at_mean;
      t.b[i][3 + r] = at_own;
    }
  }
}

/// Vectors of the term of fourth order.
VOILE_INLINE void vectors_of_fourth(const MembraneBatch& batch, int lane, const Strained& s, TangentParts& t) {
  const Fields f{batch.fields + lane};
  Vector sum[3], difference[3];
  fourth_order(s.invariants, sum, difference);
  for (int i = 0; i < batch.points; ++i) {
    const int at = membrane_fields::weights + bends * i;
    t.b[i][6] = f(at) * sum[0] + f(at + 1) * sum[1] + f(at + 2) * sum[2];
    t.b[i][7] = f(at) * difference[0] + f(at + 1) * difference[1] + f(at + 2) * difference[2];
  }
}

/// Emits the blocks i <= j.
template <bool corrected, bool laws>
VOILE_INLINE void emit_blocks(const MembraneBatch& batch, int lane, const TangentParts& t, double* blocks) {
  const Fields f{batch.fields + lane};
  const int active = count_lanes(batch, lane), *slot = batch.slots + lane;
  const int pairs = batch.points * (batch.points + 1) / 2;
  Real number[most_points];
  for (int i = 0; i < batch.points; ++i) number[i] = converted(batch.scatter + i * batch_lanes + lane);
  constexpr int ahead = 3;
  for (int i = 0, at = 0; i < batch.points; ++i) {
    [[maybe_unused]] Real along[bends];
    if constexpr (corrected)
      for (int a = 0; a < bends; ++a) {
        along[a] = t.form[a][0] * f(membrane_fields::weights + bends * i);
        for (int b = 1; b < bends; ++b) along[a] += t.form[a][b] * f(membrane_fields::weights + bends * i + b);
      }
    for (int j = i; j < batch.points; ++j, ++at, slot += batch_lanes) {
      if (at + ahead < pairs) fetch_blocks(blocks, slot + ahead * batch_lanes);
      Block block;
      for (Real& k : block.k) k = all(0.0);
      for (int v = 0; v < t.vectors; ++v) {
        Vector a = t.b[i][v], b = t.b[j][v];
        if constexpr (laws) b = t.sign[v] * b;
        hold(a);
        hold(b);
        add_outer(block, a, b);
      }
      if (corrected && t.indefinite) add_outer(block, all(-1.0) * t.b[i][7], t.b[j][7]);
      Real d = j < six ? t.six_by_six[pair_place(i, j, six)] : all(0.0);
      if constexpr (corrected)
        for (int b = 0; b < bends; ++b) d += along[b] * f(membrane_fields::weights + bends * j + b);
      block.k[0] += d;
      block.k[4] += d;
      block.k[8] += d;
      order_block(block, number[i], number[j]);
      scatter_block(blocks, slot, block, active);
    }
  }
}

/// What the factor of a group's stiffness is made of where triangles have laws of their own.
struct Stiffened {
  const Real (&plain)[6];
  const Real& viscous;
  const Real (&strain)[3];
  bool positive;
};
VOILE_APART void stiffen(const MembraneShape& shape, const MembraneBatch& batch, int lane, int group,
                         const Stiffened& from, Real (&to)[9], Real (&sign)[3]) {
  const Real none = all(0.0), one = all(1.0);
  Real l[6];
  for (int k = 0; k < 6; ++k) l[k] = root(from.viscous) * from.plain[k];
  if (batch.law) {
    YarnsAt y;
    yarns_of_group(shape, batch, lane, group, from.strain, y);
    yarn_factor(batch, lane, y, from.viscous, from.plain, l);
  }
  const Real rows[9] = {l[0], l[1], l[2], none, l[3], l[4], none, none, l[5]};
  for (int k = 0; k < 9; ++k) to[k] = rows[k];
  for (Real& s : sign) s = one;
  if (batch.rubber) {
    RubberAt at;
    Real own[9], signs[3];
    rubber_at(batch, lane, from.strain, at);
    rubber_factor(batch, lane, at, from.viscous - one, from.positive, own, signs);
    const auto rubber = at.is > none;
    for (int k = 0; k < 9; ++k) to[k] = select(rubber, own[k], to[k]);
    for (int k = 0; k < 3; ++k) sign[k] = select(rubber, signs[k], one);
  }
  for (Real& number : to) number *= std::sqrt(shape.factor[group]);
}

/// Factors of the stiffnesses of the groups: L^T, or full where triangles have laws of their own.
template <bool laws>
VOILE_INLINE void factors_of(const MembraneShape& shape, const MembraneBatch& batch, int lane, const Strained& s,
                             bool positive, const Real (&plain)[6], Real (&l)[3][laws ? 9 : 6], TangentParts& t) {
  const Real viscous = batch.start ? 1.0 + load(batch.viscosity + lane) : all(1.0);
  if constexpr (laws)
    for (Real& sign : t.sign) sign = all(1.0);
  for (int g = 0; g < shape.groups; ++g) {
    if constexpr (laws) {
      Real sign[3];
      stiffen(shape, batch, lane, g, {plain, viscous, s.samples.strain[g], positive}, l[g], sign);
      for (int k = 0; k < 3; ++k) t.sign[3 * g + k] = sign[k];
    } else {
      const Real factor = root(shape.factor[g] * viscous);
      for (int k = 0; k < 6; ++k) l[g][k] = factor * plain[k];
    }
  }
}

template <bool laws>
VOILE_APART void tangent_of(const MembraneShape& shape, const MembraneBatch& batch, const KernelState& state,
                            double* blocks) {
  for (int lane = batch.first; lane < batch.last; lane += width) {
    Strained s;
    strain_lanes(shape, batch, lane, state, s);
    const Fields f{batch.fields + lane};
    TangentParts t;
    t.vectors = 3 * shape.groups;
    t.indefinite = false;
    Real plain[6], l[3][laws ? 9 : 6], stress[3][3];
    f.six_numbers(membrane_fields::stiffness, plain);
    factors_of<laws>(shape, batch, lane, s, state.positive, plain, l, t);
    vectors_at_six(shape, f, s.samples, l, t);
    Samples at = s.samples;
    if (state.previous) linearise(shape, batch, lane, state, s, at.strain);
    if (state.stress_x) strains_at(shape, batch, lane, {state.stress_x, state.stress_u}, at.strain);
    stresses_of<laws>(shape, batch, lane, plain, {s.samples.strain, at.strain}, stress);
    if (shape.corrected) {
      vectors_of_bends(batch, lane, s, l, t);
      if (batch.fourth) {
        vectors_of_fourth(batch, lane, s, t);
        t.vectors = 7;
        t.indefinite = !state.positive;
      }
      bend_form(f, s, stress, batch.fourth, state.positive, t);
    }
    if (state.positive)
      for (int g = 0; g < shape.groups; ++g) keep_tensile(stress[g]);
    add_geometric(shape, f, stress, t);
    if (shape.corrected)
      emit_blocks<true, laws>(batch, lane, t, blocks);
    else
      emit_blocks<false, laws>(batch, lane, t, blocks);
  }
}

inline void membrane_tangent(const MembraneShape& shape, const MembraneBatch& batch, const KernelState& state,
                             double* blocks) {
  if (batch.law || batch.rubber)
    tangent_of<true>(shape, batch, state, blocks);
  else
    tangent_of<false>(shape, batch, state, blocks);
}

}  // namespace voile::energy::VOILE_KERNELS
