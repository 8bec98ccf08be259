// Base vectors and strains of the samples of a membrane element; private to src/energy, see membrane.hpp.
#pragma once

#include "voile/energy/membrane.hpp"

namespace voile::energy {

/// Half metric (a1.a1/2, a2.a2/2, a1.a2): Green strain before the rest metric is taken off.
inline Vec3 half_metric(const Vec3& a1, const Vec3& a2) {
  return {0.5 * a1.squaredNorm(), 0.5 * a2.squaredNorm(), a1.dot(a2)};
}

/// Base vectors of one sample.
struct Base {
  Vec3 a1, a2;
};

template <class Weights>
Base side_base(const Weights& d, const Vec3* x, const Index* points, int side) {
  Base b{Vec3::Zero(), Vec3::Zero()};
  for (int k = 0; k < 3; ++k) {
    b.a1 += d[0][k] * x[points[k]];
    b.a2 += d[1][k] * x[points[k]];
  }
  b.a1 += d[0][3] * x[points[3 + side]];
  b.a2 += d[1][3] * x[points[3 + side]];
  return b;
}

template <class Weights>
Base own_base(const Weights& d, const Vec3* x, const Index* points) {
  Base b{Vec3::Zero(), Vec3::Zero()};
  for (int k = 0; k < 3; ++k) {
    b.a1 += d[0][k] * x[points[k]];
    b.a2 += d[1][k] * x[points[k]];
  }
  return b;
}

}  // namespace voile::energy
