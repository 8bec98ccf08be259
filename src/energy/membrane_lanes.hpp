// Strains of the membrane of several triangles side by side; private to the element kernels. Symbols as in membrane.hpp and
// chord_correction.hpp.
// Theory: docs/theory/membrane.md.
#pragma once

#include "element_kernels.hpp"
#include "lanes.hpp"

namespace voile::energy::VOILE_KERNELS {

constexpr int bends = 7, chords = 12, own_chords = 3, six = 6;

/// The numbers of the triangles from one lane on.
struct Fields {
  const double* first;
  VOILE_INLINE Real operator()(int place) const { return load(first + place * batch_lanes); }
  VOILE_INLINE Vector vector(int place) const { return {(*this)(place), (*this)(place + 1), (*this)(place + 2)}; }
  /// d_alpha,k of a sample.
  VOILE_INLINE Real slope(int sample, int alpha, int k) const {
    return (*this)(sample < 3 ? membrane_fields::side + 8 * sample + 4 * alpha + k
                              : membrane_fields::own + 3 * alpha + k);
  }
  VOILE_INLINE void six_numbers(int place, Real (&to)[6]) const {
    for (int i = 0; i < 6; ++i) to[i] = (*this)(place + i);
  }
};

/// Stencil position of point k of a sample, which has so many.
VOILE_INLINE constexpr int node(int sample, int k) {
  return k < 3 ? k : 3 + sample;
}
VOILE_INLINE constexpr int nodes(int sample) {
  return sample < 3 ? 4 : 3;
}

/// Base vectors of the samples, strains of the groups.
struct Samples {
  Vector a[4][2];
  Real strain[3][3];
};

VOILE_INLINE void base_of(const Fields& f, int sample, const Vector* x, Vector (&a)[2]) {
  for (int alpha = 0; alpha < 2; ++alpha) {
    a[alpha] = f.slope(sample, alpha, 0) * x[0];
    for (int k = 1; k < nodes(sample); ++k) a[alpha] = a[alpha] + f.slope(sample, alpha, k) * x[node(sample, k)];
  }
}

/// Adds a sample's part of half the metric to the strain of its group.
VOILE_INLINE void add_metric(const Vector (&a)[2], double weight, Real (&strain)[3]) {
  strain[0] += 0.5 * weight * dot(a[0], a[0]);
  strain[1] += 0.5 * weight * dot(a[1], a[1]);
  strain[2] += weight * dot(a[0], a[1]);
}

VOILE_INLINE void samples_of(const MembraneShape& shape, const Fields& f, const Vector* x, Samples& s) {
  for (int g = 0; g < shape.groups; ++g)
    for (int r = 0; r < 3; ++r) s.strain[g][r] = -f(membrane_fields::metric + 3 * g + r);
  for (int k = shape.first_sample; k < shape.last_sample; ++k) {
    base_of(f, k, x, s.a[k]);
    add_metric(s.a[k], shape.weight[k], s.strain[shape.group[k]]);
  }
}

/// Points of a patch at the ends of its chords: sides, then across each side.
constexpr int ends[chords][2] = {{0, 1}, {1, 2}, {2, 0}, {1, 3}, {2, 3}, {0, 3},
                                 {2, 4}, {0, 4}, {1, 4}, {0, 5}, {1, 5}, {2, 5}};

/// s_c and W_rc of the mean strain and of the triangle's own.
struct ChordForms {
  Real along[chords][bends], mean[chords][3], own[own_chords][3];
};

VOILE_INLINE void along_of(const Fields& f, int chord, Real (&s)[bends]) {
  const int i = membrane_fields::place + 2 * ends[chord][0], j = membrane_fields::place + 2 * ends[chord][1];
  const Real x = f(j) - f(i), y = f(j + 1) - f(i + 1), sum_x = f(j) + f(i), sum_y = f(j + 1) + f(i + 1);
  const Real xx = x * x, yy = y * y, xy = x * y;
  s[0] = xx;
  s[1] = yy;
  s[2] = xy;
  s[3] = 3.0 * xx * sum_x;
  s[4] = xx * sum_y + 2.0 * xy * sum_x;
  s[5] = yy * sum_x + 2.0 * xy * sum_y;
  s[6] = 3.0 * yy * sum_y;
}

/// Adds factor Q^r_ij of one sample, i and k its points.
VOILE_INLINE void add_fraction(const Fields& f, int sample, int i, int k, const Real& factor, Real (&fraction)[3]) {
  const Real a0 = f.slope(sample, 0, i), a1 = f.slope(sample, 1, i), b0 = f.slope(sample, 0, k),
             b1 = f.slope(sample, 1, k);
  fraction[0] += factor * (a0 * b0);
  fraction[1] += factor * (a1 * b1);
  fraction[2] += factor * (a0 * b1 + a1 * b0);
}

VOILE_INLINE void chord_forms(const Fields& f, ChordForms& c) {
  const Real factor = f(membrane_fields::chord), third = factor / 3.0;
  for (int k = 0; k < chords; ++k) {
    along_of(f, k, c.along[k]);
    for (int r = 0; r < 3; ++r) c.mean[k][r] = all(0.0);
    if (k >= own_chords) add_fraction(f, (k - own_chords) / 3, ends[k][0], 3, third, c.mean[k]);
  }
  for (int k = 0; k < own_chords; ++k) {
    for (int r = 0; r < 3; ++r) c.own[k][r] = all(0.0);
    add_fraction(f, 3, ends[k][0], ends[k][1], factor, c.own[k]);
    for (int s = 0; s < 3; ++s) add_fraction(f, s, ends[k][0], ends[k][1], third, c.mean[k]);
  }
}

/// K less that at the start, K, and k_c.
struct ChordBends {
  Vector change[bends], now[bends], chord[chords];
};

/// sum_i (a_i - b_i) B'_i; `b` may be null.
VOILE_INLINE void bends_of(const Fields& f, const MembraneBatch& batch, int lane, const double* a, const double* b,
                           Vector (&sum)[bends]) {
  for (Vector& v : sum) v = zero();
  for (int i = 0; i < batch.points; ++i) {
    const int* at = batch.gather + i * batch_lanes + lane;
    Vector v = gather_vector(a, at);
    if (b) v = v - gather_vector(b, at);
    for (int k = 0; k < bends; ++k) sum[k] = sum[k] + f(membrane_fields::weights + bends * i + k) * v;
  }
}

VOILE_INLINE Vector along_chord(const Real (&along)[bends], const Vector (&k)[bends]) {
  Vector sum = along[0] * k[0];
  for (int b = 1; b < bends; ++b) sum = sum + along[b] * k[b];
  return sum;
}

/// Adds the correction to the strains of groups 0 and 1.
VOILE_INLINE void correct(const Fields& f, const ChordForms& forms, ChordBends& b, Samples& s) {
  for (int k = 0; k < bends; ++k) b.now[k] = f.vector(membrane_fields::start + 3 * k) + b.change[k];
  for (int c = 0; c < chords; ++c) {
    b.chord[c] = along_chord(forms.along[c], b.now);
    const Vector d = along_chord(forms.along[c], b.change);
    const Real half_square = dot(d, b.chord[c] - all(0.5) * d);
    for (int r = 0; r < 3; ++r) {
      s.strain[0][r] += half_square * forms.mean[c][r];
      if (c < own_chords) s.strain[1][r] += half_square * forms.own[c][r];
    }
  }
}

/// q_D and q_S less those at rest, times A and 1, and half their derivatives by K_1..3.
struct Invariants {
  Real bending, trace;
  Vector of_bending[3], of_trace[3];
};

/// form a_A, a row of a symmetric form times vectors.
VOILE_INLINE Vector row(const Real (&form)[6], int k, const Vector* a) {
  const int at[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  return form[at[k][0]] * a[0] + form[at[k][1]] * a[1] + form[at[k][2]] * a[2];
}

VOILE_INLINE void invariants_of(const Fields& f, const ChordBends& b, Invariants& v) {
  Real bending[6], trace[6];
  f.six_numbers(membrane_fields::bending, bending);
  f.six_numbers(membrane_fields::trace, trace);
  v.bending = f(membrane_fields::start_invariants);
  v.trace = f(membrane_fields::start_invariants + 1);
  for (int k = 0; k < 3; ++k) {
    v.of_bending[k] = row(bending, k, b.now);
    v.of_trace[k] = row(trace, k, b.now);
  }
  for (int k = 0; k < 3; ++k) {  // differences of squares as change times the sum, to keep round-off small
    v.bending += dot(b.change[k], all(2.0) * v.of_bending[k] - row(bending, k, b.change));
    v.trace += dot(b.change[k], all(2.0) * v.of_trace[k] - row(trace, k, b.change));
  }
}

/// The six points and all else that strains take.
struct Strained {
  Samples samples;
  ChordForms forms;
  ChordBends bends;
  Invariants invariants;
};

VOILE_INLINE void gather_six(const MembraneBatch& batch, int lane, const double* from, Vector (&x)[six]) {
  for (int i = 0; i < six; ++i) x[i] = gather_vector(from, batch.gather + i * batch_lanes + lane);
}

VOILE_INLINE void strain_lanes(const MembraneShape& shape, const MembraneBatch& batch, int lane,
                               const KernelState& state, Strained& s) {
  const Fields f{batch.fields + lane};
  Vector x[six];
  gather_six(batch, lane, state.x, x);
  samples_of(shape, f, x, s.samples);
  if (!shape.corrected) return;
  chord_forms(f, s.forms);
  bends_of(f, batch, lane, state.u, nullptr, s.bends.change);
  correct(f, s.forms, s.bends, s.samples);
  if (batch.fourth) invariants_of(f, s.bends, s.invariants);
}

/// (1 + c) E - c E_n, the strain whose elastic stress is the whole stress.
VOILE_INLINE void effective(const MembraneBatch& batch, int lane, int group, Real (&strain)[3]) {
  if (!batch.start) return;
  const Real c = load(batch.viscosity + lane);
  for (int r = 0; r < 3; ++r)
    strain[r] = (1.0 + c) * strain[r] - c * load(batch.start + (3 * group + r) * batch_lanes + lane);
}

/// factor A C E
VOILE_INLINE void stress_of(const Real (&l)[6], double factor, Real (&strain)[3]) {
  times_factor(l, strain[0], strain[1], strain[2]);
  times_transposed(l, strain[0], strain[1], strain[2]);
  for (Real& n : strain) n *= factor;
}

}  // namespace voile::energy::VOILE_KERNELS
