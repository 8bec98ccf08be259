// Hyperelastic laws in several triangles side by side; private to the element kernels. Symbols as in hyperelastic.hpp.
//
// With M = tr C/2, r = (l1^2 - l2^2)/2 and the angle of the larger stretch, w = w(M, r), and of a change of strain
//   dM = (1, 1, 0), dr = (c, -c, s), dt = (-s, s, c),   c, s cosine and sine of twice that angle:
//   N = w_M dM + w_r dr,  d2w/dE2 = w_MM dM dM + w_Mr (dM dr + dr dM) + w_rr dr dr + w_r/r dt dt
// Theory: docs/theory/membrane.md, rubber.
#pragma once

#include <limits>

#include "membrane_lanes.hpp"

namespace voile::energy::VOILE_KERNELS {

/// What the law answers at a strain, times A.
struct RubberAt {
  Real is;                                     ///< 1 where the triangle has such a law, otherwise 0
  Real energy, by_mean, by_half;               ///< w, w_M, w_r
  Real cosine, sine;                           ///< of twice the angle
  Real mean_mean, mean_half, half_half, turn;  ///< second derivatives, w_r/r
};

VOILE_INLINE Real rubber_number(const MembraneBatch& batch, int lane, int place) {
  return load(batch.rubber + place * batch_lanes + lane);
}

/// Strain from the natural state.
VOILE_INLINE void natural_strain(const MembraneBatch& batch, int lane, const Real (&strain)[3], Real (&e)[3]) {
  for (int r = 0; r < 3; ++r) {
    e[r] = rubber_number(batch, lane, 3 * r) * strain[0];
    for (int k = 1; k < 3; ++k) e[r] += rubber_number(batch, lane, 3 * r + k) * strain[k];
  }
}
/// Adds a form of natural strains to one of strains.
VOILE_INLINE void add_natural_form(const MembraneBatch& batch, int lane, const Real (&form)[3], Real (&to)[3]) {
  for (int k = 0; k < 3; ++k)
    for (int r = 0; r < 3; ++r) to[k] += rubber_number(batch, lane, 3 * r + k) * form[r];
}

/// exp(x) - 1 - x
inline double exponential_rest(double x) {
  if (std::abs(x) > 0.5) return std::expm1(x) - x;
  double sum = 0.0;
  for (int k = 16; k >= 2; --k) sum = (1.0 + sum) * x / k;
  return x * sum;
}

/// One of Ogden's terms in one lane: adds to energy, w_M, w_r, w_MM, w_Mr, w_rr, w_r/r. mean, half: M - 1, r.
inline void add_ogden(double modulus, double exponent, double mean, double half, double (&to)[7]) {
  const double p = 0.5 * exponent, m = 1.0 + mean;
  const double first = std::log1p(mean + half), second = std::log1p(mean - half);
  const double volume = first + second;
  to[0] +=
      modulus / exponent * (exponential_rest(p * first) + exponential_rest(p * second) + exponential_rest(-p * volume));
  const double shrinks = std::expm1(-(p + 1.0) * volume), inverse = 1.0 + shrinks;
  const double u = std::exp((p - 2.0) * first), v = std::exp((p - 2.0) * second), w = std::exp(-(p + 2.0) * volume);
  // g(a) - g(b) over r without a difference: 2 (a b)^(k/2) sinh(k atanh(r/M))/r of powers k.
  const double ratio = half / m, angle = std::atanh(ratio);
  const auto slope = [&](double k) {
    return 2.0 * std::exp(0.5 * k * volume) * (ratio > 1e-8 ? std::sinh(k * angle) / half : k / m);
  };
  const double factor = 0.5 * modulus;  // modulus/exponent p
  const double turn = factor * (slope(p - 1.0) + 2.0 * inverse);
  to[1] += factor * (std::expm1((p - 1.0) * first) + std::expm1((p - 1.0) * second) - 2.0 * mean - 2.0 * m * shrinks);
  to[2] += turn * half;
  const double curved = (p + 1.0) * w;
  to[3] += factor * ((p - 1.0) * (u + v) + 4.0 * m * m * curved - 2.0 * inverse);
  to[4] += factor * ((p - 1.0) * half * slope(p - 2.0) - 4.0 * m * half * curved);
  to[5] += factor * ((p - 1.0) * (u + v) + 4.0 * half * half * curved + 2.0 * inverse);
  to[6] += turn;
}

/// Ogden's terms.
VOILE_APART void add_ogden_terms(const MembraneBatch& batch, int lane, const Real& mean, RubberAt& at,
                                 const Real& half) {
  alignas(64) double means[width], halves[width], sums[7][width];
  store(means, mean);
  store(halves, half);
  for (int k = 0; k < width; ++k) {
    double to[7] = {};
    for (int t = 0; t < batch.terms; ++t) {
      const double* term = batch.rubber + (rubber_fields::terms + 2 * t) * batch_lanes + lane + k;
      if (term[0] != 0.0) add_ogden(term[0], term[batch_lanes], means[k], halves[k], to);
    }
    for (int i = 0; i < 7; ++i) sums[i][k] = to[i];
  }
  Real* const numbers[7] = {&at.energy,    &at.by_mean,   &at.by_half, &at.mean_mean,
                            &at.mean_half, &at.half_half, &at.turn};
  for (int i = 0; i < 7; ++i) *numbers[i] += load(sums[i]);
}

/// At a strain in material axes.
VOILE_APART void rubber_at(const MembraneBatch& batch, int lane, const Real (&strain)[3], RubberAt& at) {
  const Real none = all(0.0), one = all(1.0);
  at.is = rubber_number(batch, lane, rubber_fields::is);
  Real e[3];
  natural_strain(batch, lane, strain, e);
  const auto rubber = at.is > none;
  for (Real& number : e) number = select(rubber, number, none);
  const Real mean = e[0] + e[1], difference = e[0] - e[1], m = one + mean;
  const Real half = root(difference * difference + e[2] * e[2]);
  at.cosine = select(half > none, difference / select(half > none, half, one), one);
  at.sine = select(half > none, e[2] / select(half > none, half, one), none);
  // j = J - 1 and what is of second order in the strain, so that small strains keep their figures.
  const Real square = 4.0 * e[0] * e[1] - e[2] * e[2], j = 2.0 * mean + square;
  const Real nan = all(std::numeric_limits<double>::quiet_NaN());
  const Real volume = select(one + j > none, select(m > none, one + j, nan), nan), inverse = one / volume,
             inverse_square = inverse * inverse;
  const Real c10 = rubber_number(batch, lane, rubber_fields::c10), c01 = rubber_number(batch, lane, rubber_fields::c01);
  at.energy = inverse * (c10 * (2.0 * mean * j - square) + c01 * (j * j - square));
  at.by_mean = 2.0 * inverse_square *
               (c10 * (2.0 * j + j * j - mean) +
                c01 * (3.0 * (j - mean) + j * j + 2.0 * mean * j + mean * j * j - 2.0 * mean * mean));
  // d/dJ and d2/dJ2 at constant M, d2/dJ dM
  const Real by_volume = c01 - (c10 + 2.0 * m * c01) * inverse_square,
             twice = 2.0 * (c10 + 2.0 * m * c01) * inverse_square * inverse, mixed = -2.0 * c01 * inverse_square;
  at.turn = -2.0 * by_volume;
  at.by_half = at.turn * half;
  at.mean_mean = 4.0 * m * mixed + 4.0 * m * m * twice + 2.0 * by_volume;
  at.mean_half = -2.0 * half * mixed - 4.0 * m * half * twice;
  at.half_half = 4.0 * half * half * twice - 2.0 * by_volume;
  if (batch.terms > 0) add_ogden_terms(batch, lane, mean, at, half);
}

/// dM-, dr- and dt-components of a strain.
VOILE_INLINE void components_of(const RubberAt& at, const Real (&e)[3], Real (&to)[3]) {
  const Real difference = e[0] - e[1];
  to[0] = e[0] + e[1];
  to[1] = at.cosine * difference + at.sine * e[2];
  to[2] = at.cosine * e[2] - at.sine * difference;
}
/// Form of natural strains from its components.
VOILE_INLINE void form_of(const RubberAt& at, const Real& mean, const Real& half, const Real& turn, Real (&form)[3]) {
  const Real both = at.cosine * half - at.sine * turn;
  form[0] = mean + both;
  form[1] = mean - both;
  form[2] = at.sine * half + at.cosine * turn;
}

/// Takes the elastic strain off the effective one, of which the law of yarns and plates takes the stress.
VOILE_INLINE void leave_viscous(const MembraneBatch& batch, int lane, const Real (&strain)[3], Real (&effective)[3]) {
  const auto rubber = rubber_number(batch, lane, rubber_fields::is) > all(0.0);
  for (int r = 0; r < 3; ++r) effective[r] = select(rubber, effective[r] - strain[r], effective[r]);
}

/// Where a triangle is, and where its stress is wanted: by the tangent from there.
struct RubberStrains {
  const Real (&at)[3], (&wanted)[3];
};
/// Adds factor times the stress of the law.
VOILE_APART void add_rubber_stress(const MembraneBatch& batch, int lane, double factor, const RubberStrains& strains,
                                   Real (&stress)[3]) {
  RubberAt at;
  rubber_at(batch, lane, strains.at, at);
  Real change[3], e[3], k[3], form[3], own[3] = {all(0.0), all(0.0), all(0.0)};
  for (int r = 0; r < 3; ++r) change[r] = strains.wanted[r] - strains.at[r];
  natural_strain(batch, lane, change, e);
  components_of(at, e, k);
  form_of(at, at.by_mean + at.mean_mean * k[0] + at.mean_half * k[1],
          at.by_half + at.mean_half * k[0] + at.half_half * k[1], at.turn * k[2], form);
  add_natural_form(batch, lane, form, own);
  for (int r = 0; r < 3; ++r) stress[r] += select(at.is > all(0.0), factor * own[r], all(0.0));
}

/// Three forms f and signs with d2w/dE2 + viscous C = sum sign f f^T; `positive`: without what is negative. Only lanes of such triangles.
VOILE_APART void rubber_factor(const MembraneBatch& batch, int lane, const RubberAt& at, const Real& viscous,
                               bool positive, Real (&to)[9], Real (&sign)[3]) {
  const Real none = all(0.0), one = all(1.0);
  const Real held = viscous * rubber_number(batch, lane, rubber_fields::shear_modulus);
  const Real a = at.mean_mean + 3.0 * held, d = at.half_half + held, b = at.mean_half;
  const Real mean = 0.5 * (a + d), half = 0.5 * (a - d), radius = root(half * half + b * b),
             safe = select(radius > none, radius, one);
  const auto size = [](const Real& x) { return larger(x, -x); };
  const Real large = root(0.5 * (one + select(radius > none, size(half) / safe, one))),
             small = select(b < none, -one, one) * 0.5 * size(b) / (safe * large);
  const auto first = half < none;
  const Real cosine = select(first, size(small), large), sine = select(first, select(b < none, -large, large), small);
  const Real value[3] = {mean + radius, mean - radius, at.turn + held};
  const Real direction[3][3] = {{cosine, sine, none}, {-sine, cosine, none}, {none, none, one}};
  for (int v = 0; v < 3; ++v) {
    const auto negative = value[v] < none;
    const Real factor = root(select(negative, positive ? none : -value[v], value[v]));
    sign[v] = select(negative, -one, one);
    Real form[3], own[3] = {none, none, none};
    form_of(at, factor * direction[v][0], factor * direction[v][1], factor * direction[v][2], form);
    add_natural_form(batch, lane, form, own);
    for (int k = 0; k < 3; ++k) to[3 * v + k] = own[k];
  }
}

}  // namespace voile::energy::VOILE_KERNELS
