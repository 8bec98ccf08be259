// Energy, forces and tangents of the membrane of several triangles side by side; private to the element kernels.
#pragma once

#include "hyperelastic_kernel.hpp"
#include "membrane_lanes.hpp"
#include "yarn_law_kernel.hpp"

namespace voile::energy::VOILE_KERNELS {

/// Stencil positions of a triangle at most.
constexpr int most_points = 64;

VOILE_INLINE int count_lanes(const MembraneBatch& batch, int lane) {
  return batch.last - lane < width ? batch.last - lane : width;
}

/// What yarns add in a group.
VOILE_INLINE void yarns_of_group(const MembraneShape& shape, const MembraneBatch& batch, int lane, int group,
                                 const Real (&strain)[3], YarnsAt& y) {
  yarns_at(batch, lane, group == shape.rubbing, strain, y);
}

/// 1/2 (E.C E + c (E - E_n).C (E - E_n)) of a group and what yarns add, times A; of rubber its law instead of the first.
template <bool laws>
VOILE_INLINE Real group_energy(const MembraneShape& shape, const MembraneBatch& batch, int lane, int group,
                               const Real (&l)[6], const Real (&strain)[3]) {
  const auto half_square = [&](Real a, Real b, Real c) {
    times_factor(l, a, b, c);
    return 0.5 * (a * a + b * b + c * c);
  };
  Real elastic = half_square(strain[0], strain[1], strain[2]);
  if constexpr (laws) {
    if (batch.law) {
      YarnsAt y;
      yarns_of_group(shape, batch, lane, group, strain, y);
      elastic += y.energy;
    }
    if (batch.rubber) {
      RubberAt at;
      rubber_at(batch, lane, strain, at);
      elastic = select(at.is > all(0.0), at.energy, elastic);
    }
  }
  if (!batch.start) return elastic;
  Real d[3];
  for (int r = 0; r < 3; ++r) d[r] = strain[r] - load(batch.start + (3 * group + r) * batch_lanes + lane);
  return elastic + load(batch.viscosity + lane) * half_square(d[0], d[1], d[2]);
}

/// Energy of the triangles; `laws`: some have yarns that stiffen or rub, or are hyperelastic.
template <bool laws>
VOILE_INLINE Real energy_of(const MembraneShape& shape, const MembraneBatch& batch, int lane, const Real (&l)[6],
                            const Strained& s) {
  Real sum = shape.corrected && batch.fourth ? s.invariants.bending * s.invariants.trace : all(0.0);
  for (int g = 0; g < shape.groups; ++g)
    if (shape.factor[g] > 0.0)
      sum += shape.factor[g] * group_energy<laws>(shape, batch, lane, g, l, s.samples.strain[g]);
  return sum;
}

inline void membrane_strain(const MembraneShape& shape, const MembraneBatch& batch, const KernelState& state,
                            double* strain) {
  for (int lane = batch.first; lane < batch.last; lane += width) {
    Strained s;
    strain_lanes(shape, batch, lane, state, s);
    for (int g = 0; g < shape.groups; ++g)
      for (int r = 0; r < 3; ++r) store(strain + (3 * g + r) * batch_lanes + lane, s.samples.strain[g][r]);
  }
}

/// Pulls of the strains at the curvatures: derivative by k_c over k_c.
VOILE_INLINE Real chord_pull(const ChordForms& forms, int chord, const Real (&mean)[3]) {
  return mean[0] * forms.mean[chord][0] + mean[1] * forms.mean[chord][1] + mean[2] * forms.mean[chord][2];
}
VOILE_INLINE Real own_chord_pull(const ChordForms& forms, int chord, const Real (&own)[3]) {
  return own[0] * forms.own[chord][0] + own[1] * forms.own[chord][1] + own[2] * forms.own[chord][2];
}

/// Forces on the six points, from the stresses of the groups.
VOILE_INLINE void pull_at_six(const MembraneShape& shape, const Fields& f, const Samples& s, const Real (&stress)[3][3],
                              Vector (&force)[six]) {
  for (Vector& g : force) g = zero();
  for (int k = shape.first_sample; k < shape.last_sample; ++k) {
    const Real(&n)[3] = stress[shape.group[k]];
    const Real weight = all(shape.weight[k]);
    const Vector p = weight * (n[0] * s.a[k][0] + n[2] * s.a[k][1]), q = weight * (n[2] * s.a[k][0] + n[1] * s.a[k][1]);
    for (int i = 0; i < nodes(k); ++i) {
      Vector& g = force[node(k, i)];
      g = g + f.slope(k, 0, i) * p + f.slope(k, 1, i) * q;
    }
  }
}

/// Derivative by K, from the stresses of the mean strain and of the triangle's own.
VOILE_INLINE void pull_at_bends(const Strained& s, const Real (&stress)[3][3], bool fourth, Vector (&pull)[bends]) {
  for (Vector& p : pull) p = zero();
  for (int c = 0; c < chords; ++c) {
    Real weight = chord_pull(s.forms, c, stress[0]);
    if (c < own_chords) weight += own_chord_pull(s.forms, c, stress[1]);
    const Vector v = weight * s.bends.chord[c];
    for (int b = 0; b < bends; ++b) pull[b] = pull[b] + s.forms.along[c][b] * v;
  }
  if (!fourth) return;
  const Real by_bending = 2.0 * s.invariants.trace, by_trace = 2.0 * s.invariants.bending;
  for (int k = 0; k < 3; ++k)
    pull[k] = pull[k] + by_bending * s.invariants.of_bending[k] + by_trace * s.invariants.of_trace[k];
}

/// Strains of the groups: where the triangles are, and where stresses are wanted.
struct StressedAt {
  const Real (&strain)[3][3], (&wanted)[3][3];
};

/// Stresses of all groups.
template <bool laws>
VOILE_INLINE void stresses_of(const MembraneShape& shape, const MembraneBatch& batch, int lane, const Real (&l)[6],
                              const StressedAt& s, Real (&stress)[3][3]) {
  for (int g = 0; g < shape.groups; ++g) {
    const Real(&wanted)[3] = s.wanted[g];
    for (int r = 0; r < 3; ++r) stress[g][r] = wanted[r];
    effective(batch, lane, g, stress[g]);
    if constexpr (laws)
      if (batch.rubber) leave_viscous(batch, lane, wanted, stress[g]);
    stress_of(l, shape.factor[g], stress[g]);
    if constexpr (laws) {
      if (batch.law) {
        YarnsAt y;
        yarns_of_group(shape, batch, lane, g, wanted, y);
        add_yarn_stress(batch, lane, y, shape.factor[g], stress[g]);
      }
      if (batch.rubber) add_rubber_stress(batch, lane, shape.factor[g], {s.strain[g], wanted}, stress[g]);
    }
  }
}

template <bool laws>
VOILE_APART void gradient_of(const MembraneShape& shape, const MembraneBatch& batch, const KernelState& state,
                             double* force, double* energy) {
  for (int lane = batch.first; lane < batch.last; lane += width) {
    Strained s;
    strain_lanes(shape, batch, lane, state, s);
    const Fields f{batch.fields + lane};
    Real l[6], stress[3][3];
    f.six_numbers(membrane_fields::stiffness, l);
    store(energy + lane, energy_of<laws>(shape, batch, lane, l, s));
    stresses_of<laws>(shape, batch, lane, l, {s.samples.strain, s.samples.strain}, stress);
    Vector at_six[six], at_bends[bends]{};
    pull_at_six(shape, f, s.samples, stress, at_six);
    if (shape.corrected) pull_at_bends(s, stress, batch.fourth, at_bends);
    const int active = count_lanes(batch, lane);
    for (int i = 0; i < batch.points; ++i) {
      Vector sum = i < six ? at_six[i] : zero();
      if (shape.corrected)
        for (int b = 0; b < bends; ++b) sum = sum + f(membrane_fields::weights + bends * i + b) * at_bends[b];
      scatter_vector(force, batch.scatter + i * batch_lanes + lane, sum, active);
    }
  }
}

inline void membrane_gradient(const MembraneShape& shape, const MembraneBatch& batch, const KernelState& state,
                              double* force, double* energy) {
  if (batch.law || batch.rubber)
    gradient_of<true>(shape, batch, state, force, energy);
  else
    gradient_of<false>(shape, batch, state, force, energy);
}

}  // namespace voile::energy::VOILE_KERNELS
