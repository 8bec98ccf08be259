#include "energy_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "validity.hpp"

namespace voile::record {

namespace {

/// Fraction of the turnover that is too much.
constexpr double much = 0.05;

}  // namespace

std::string balance_text(const system::EnergyBalance& b, double round_off) {
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
  add("friction inside the fabric", b.fabric, false);
  add("numerical", b.numerical, true);
  const double all = b.turnover(), amiss = std::abs(b.unaccounted);
  text += fmt::format("; unaccounted {:.2g}", b.unaccounted);
  if (amiss <= round_off) return text + " (round-off)";
  return text + fmt::format(" ({})", percent_text(amiss / all));
}

std::string creation_warning(const system::EnergyBalance& b, double round_off) {
  const double all = b.turnover(), gained = b.created;
  if (gained <= std::max(round_off, much * all)) return "";
  return fmt::format(
      "the time stepping has created {:.3g} J, {} of the energy that came in: speeds or stiffnesses are beyond what "
      "steps of this size resolve; use a smaller time.step (history: numerical_loss)",
      gained, percent_text(gained / all));
}

std::string balance_warning(const system::EnergyBalance& b, const solve::TimeOptions& options, double round_off) {
  const double all = b.turnover(), gained = b.created;
  if (std::max({gained, -b.damping, std::abs(b.unaccounted)}) <= round_off) return "";
  if (std::string text = creation_warning(b, round_off); !text.empty() && gained > std::abs(b.unaccounted)) return text;
  if (-b.damping > much * all)
    return fmt::format(
        "damping has given {:.3g} J instead of taking it, {} of the energy that came in: steps are long against "
        "what "
        "is damped, and what it takes is not separated from numerical loss; use a smaller time.step, above all after "
        "velocities that jump (history: damping_loss)",
        -b.damping, percent_text(-b.damping / all));
  if (!(std::abs(b.unaccounted) > much * all)) return "";
  const bool iterates = options.method == solve::TimeOptions::Method::implicit_alpha;
  std::string remedy = "a smaller time.step";
  if (iterates && options.velocity_tolerance > 0.0)
    remedy += fmt::format(", or a time.velocity_tolerance below {:.3g} m/s,", options.velocity_tolerance);
  else if (iterates)
    remedy += ", or smaller -snes_rtol and -snes_stol,";
  return fmt::format(
      "{} of the energy is not accounted for: forces that steps leave unbalanced did that work; {} is needed "
      "where energies or speeds count (history: energy_unaccounted)",
      percent_text(std::abs(b.unaccounted) / all), remedy);
}

std::string rest_text(const KineticEnergy& k) {
  if (k.largest == 0.0) return "";
  return fmt::format("{} at the end: kinetic energy {:.3g} J, {:.2g} of the largest, {:.3g} J at t = {:.6g} s",
                     k.at_rest() ? "at rest" : "in motion", k.last, k.last / k.largest, k.largest, k.time_of_largest);
}

}  // namespace voile::record
