// How much of a gas is left that leaks through an orifice.
//
// Symbols   m    fraction of the gas that is left;  V, V_0  volume now and at the start                              [m^3]
//           p_0  absolute pressure of all the gas in V_0, n exponent:  p = p_0 (m V_0/V)^n;  p_a ambient pressure      [Pa]
//           r    density of the gas at p_a, r_0 = r p_0/p_a that of all of it in V_0                              [kg/m^3]
//           A    area of the orifice times its discharge coefficient                                                 [m^2]
//   out    r_0 V_0 m' = -A sqrt(2 (r_0 m V_0/V) (p - p_a)),     in  (p < p_a)  r_0 V_0 m' = A sqrt(2 r (p_a - p))
// Bernoulli's flow without change of density: for excess pressures that are small against the ambient one. With z = sqrt|p - p_a| and V
// held,  z' = -(n p / 2m) A sqrt(2 (density upstream)) / (r_0 V_0)  is smooth, and z ends at 0 in a finite time.
//   W = integral from V to V_* of (p - p_a) dV,  p(V_*) = p_a:   what the gas could still do.  At constant V a leak takes -dW.
// Source: D.S. Miller, Internal Flow Systems, 2nd ed. (1990), 14.
#pragma once

namespace voile::system {

struct LeakyGas {
  double ambient = 0.0, reference = 0.0;  ///< p_a, p_0
  double exponent = 1.0, start = 0.0;     ///< n, V_0
  double area = 0.0, density = 0.0;       ///< A, r
};

/// m after a time at constant volume.
[[nodiscard]] double content_after(const LeakyGas& gas, double content, double volume, double seconds);
/// W [J].
[[nodiscard]] double available_work(const LeakyGas& gas, double content, double volume);

}  // namespace voile::system
