// Yarns that stiffen and rub in the plane, in several triangles side by side; private to the element kernels. Symbols as in
// yarn_law.hpp.
// Theory: docs/theory/yarn-friction.md, tension and shear.
#pragma once

#include "membrane_lanes.hpp"

namespace voile::energy::VOILE_KERNELS {

/// What yarns add to the energy, the forces and the tangents in yarn axes, times A.
struct YarnsAt {
  Real energy, force[3], slope[3];
};

VOILE_INLINE Real law_number(const MembraneBatch& batch, int lane, int place) {
  return load(batch.law + place * batch_lanes + lane);
}

VOILE_INLINE void slide(const MembraneBatch& batch, int lane, const Real& shear, YarnsAt& y) {
  const Real none = all(0.0), one = all(1.0);
  const Real slip = law_number(batch, lane, yarn_law_fields::slip),
             held = law_number(batch, lane, yarn_law_fields::stiffness),
             limit = law_number(batch, lane, yarn_law_fields::limit),
             rise = law_number(batch, lane, yarn_law_fields::rise);
  const auto size = [](const Real& a) { return larger(a, -a); };
  const auto work = [&](const Real& p) { return p * (limit + 0.5 * rise * size(p)); };
  const Real trial = held * (shear - slip);
  const auto sticks = size(trial) <= (1.0 + yarn_fields::round_off) * (limit + rise * size(slip));
  const Real side = select(trial < none, -one, one), top = held * shear - side * limit,
             growth = side * select(top < none, -one, one) * rise, below = select(held > none, held + growth, one),
             to = top / below, pull = held * (shear - to);
  y.energy += select(sticks, 0.5 * trial * (shear - slip), 0.5 * pull * (shear - to) + size(work(to) - work(slip)));
  y.force[2] += select(sticks, trial, pull);
  y.slope[2] += select(sticks, held, held * growth / below);
}

/// At a strain in material axes; friction acts on one strain of each triangle.
VOILE_APART void yarns_at(const MembraneBatch& batch, int lane, bool rubs, const Real (&strain)[3], YarnsAt& y) {
  const Real none = all(0.0);
  y.energy = none;
  for (int r = 0; r < 3; ++r) {
    Real e = law_number(batch, lane, 3 * r) * strain[0];
    for (int k = 1; k < 3; ++k) e += law_number(batch, lane, 3 * r + k) * strain[k];
    const Real size = r < 2 ? e : larger(e, -e);
    Real force = none, slope = none;
    for (int j = 0; j < batch.knots; ++j) {
      const int at = yarn_law_fields::knots + 2 * (batch.knots * r + j);
      const Real over = larger(size - law_number(batch, lane, at), none), bend = law_number(batch, lane, at + 1) * over;
      slope += bend;
      force += 0.5 * bend * over;
      y.energy += bend * over * over / 6.0;
    }
    y.force[r] = r < 2 ? force : select(e < none, -force, force);
    y.slope[r] = slope;
    if (r == 2 && rubs) slide(batch, lane, e, y);
  }
}

/// Adds factor times what they add to a stress.
VOILE_APART void add_yarn_stress(const MembraneBatch& batch, int lane, const YarnsAt& y, double factor,
                                 Real (&stress)[3]) {
  for (int k = 0; k < 3; ++k)
    for (int r = 0; r < 3; ++r) stress[k] += factor * (law_number(batch, lane, 3 * r + k) * y.force[r]);
}

/// L of viscous C + T^T slope T.
VOILE_APART void yarn_factor(const MembraneBatch& batch, int lane, const YarnsAt& y, const Real& viscous,
                             const Real (&l)[6], Real (&to)[6]) {
  Real c[6] = {l[0] * l[0],
               l[0] * l[1],
               l[0] * l[2],
               l[1] * l[1] + l[3] * l[3],
               l[1] * l[2] + l[3] * l[4],
               l[2] * l[2] + l[4] * l[4] + l[5] * l[5]};
  for (Real& number : c) number *= viscous;
  for (int r = 0; r < 3; ++r)
    for (int a = 0, at = 0; a < 3; ++a)
      for (int b = a; b < 3; ++b, ++at)
        c[at] += y.slope[r] * law_number(batch, lane, 3 * r + a) * law_number(batch, lane, 3 * r + b);
  to[0] = root(c[0]);
  to[1] = c[1] / to[0];
  to[2] = c[2] / to[0];
  to[3] = root(c[3] - to[1] * to[1]);
  to[4] = (c[4] - to[1] * to[2]) / to[3];
  to[5] = root(c[5] - to[2] * to[2] - to[4] * to[4]);
}

}  // namespace voile::energy::VOILE_KERNELS
