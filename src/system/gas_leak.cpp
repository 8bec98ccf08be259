#include "gas_leak.hpp"

#include <algorithm>
#include <cmath>

namespace voile::system {

namespace {

/// Of Runge and Kutta's method in one step of the motion: z is nearly linear.
constexpr int parts = 4;

double pressure(const LeakyGas& gas, double content, double volume) {
  return gas.reference * std::pow(content * gas.start / volume, gas.exponent);
}

double content_at(const LeakyGas& gas, double pressure, double volume) {
  return volume / gas.start * std::pow(pressure / gas.reference, 1.0 / gas.exponent);
}

}  // namespace

double content_after(const LeakyGas& gas, double content, double volume, double seconds) {
  const double excess = pressure(gas, content, volume) - gas.ambient, sign = excess < 0.0 ? -1.0 : 1.0;
  const double whole = gas.density * gas.reference / gas.ambient;  // r_0
  if (!(seconds > 0.0) || excess == 0.0 || !std::isfinite(excess)) return content;
  const auto rate = [&](double z) {
    const double p = gas.ambient + sign * z * z, m = content_at(gas, p, volume);
    const double upstream = sign > 0.0 ? whole * m * gas.start / volume : gas.density;
    return -gas.exponent * p / (2.0 * m) * gas.area * std::sqrt(2.0 * upstream) / (whole * gas.start);
  };
  double z = std::sqrt(std::abs(excess));
  const double h = seconds / parts;
  for (int i = 0; i < parts && z > 0.0; ++i) {
    const auto at = [&](double k, double part) { return rate(std::max(0.0, z + part * h * k)); };
    const double k1 = rate(z), k2 = at(k1, 0.5), k3 = at(k2, 0.5), k4 = at(k3, 1.0);
    z = std::max(0.0, z + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4));
  }
  return content_at(gas, gas.ambient + sign * z * z, volume);
}

double available_work(const LeakyGas& gas, double content, double volume) {
  const double p = pressure(gas, content, volume), log = std::log(p / gas.ambient) / gas.exponent;  // of V_*/V
  const double n = gas.exponent - 1.0;
  const double done = n == 0.0 ? log : -std::expm1(-n * log) / n;  // integral of p dV over p V
  return volume * (p * done - gas.ambient * std::expm1(log));
}

}  // namespace voile::system
