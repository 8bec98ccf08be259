#include "energy_text.hpp"

#include <fmt/format.h>

#include <cmath>

namespace voile::app {

std::string balance_text(const system::EnergyBalance& b) {
  std::string text = fmt::format("energy [J]: {:.4g} at the start", b.initial);
  const auto add = [&](const char* what, double value, bool always) {
    if (always || value != 0.0) text += fmt::format(", {} {:.4g}", what, value);
  };
  add("work of loads", b.loads, true);
  add("of supports", b.supports, false);
  add("of obstacles", b.obstacles, false);
  add("remeshing", b.remeshing, false);
  text += fmt::format("; kinetic {:.4g}, stored {:.4g}", b.kinetic, b.stored);
  add("damping", b.damping, false);
  add("drag", b.drag, false);
  add("friction", b.friction, false);
  add("numerical", b.numerical, true);
  const double all = b.turnover();
  return text + fmt::format("; unaccounted {:.2g} ({:.2g} %)", b.unaccounted,
                            all > 0.0 ? 100.0 * std::abs(b.unaccounted) / all : 0.0);
}

std::string rest_text(const KineticEnergy& k) {
  if (k.largest == 0.0) return "";
  return fmt::format("{} at the end: kinetic energy {:.3g} J, {:.2g} of the largest, {:.3g} J at t = {:.6g} s",
                     k.at_rest() ? "at rest" : "in motion", k.last, k.last / k.largest, k.largest, k.time_of_largest);
}

}  // namespace voile::app
