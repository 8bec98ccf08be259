// What is said about the energy of a motion at its end.
#include <doctest/doctest.h>

#include "record/energy_text.hpp"

namespace test_energy_text {

using voile::record::KineticEnergy;
using voile::record::rest_text;

TEST_CASE("a motion is at rest below a millionth of its largest kinetic energy") {
  KineticEnergy k;
  CHECK(rest_text(k).empty());
  k.add(0.0, 0.0);
  CHECK_FALSE(k.at_rest());  // before anything moves
  k.add(0.1, 3.0);
  k.add(0.2, 4.0);
  k.add(0.3, 6e-6);
  CHECK_FALSE(k.at_rest());
  CHECK(rest_text(k) == "in motion at the end: kinetic energy 6e-06 J, 1.5e-06 of the largest, 4 J at t = 0.2 s");
  k.add(0.4, 3e-6);
  CHECK(k.at_rest());
  CHECK(rest_text(k) == "at rest at the end: kinetic energy 3e-06 J, 7.5e-07 of the largest, 4 J at t = 0.2 s");
}

TEST_CASE("energy that is not accounted for is warned of from a twentieth on, with what mends it") {
  using voile::record::balance_warning;
  voile::solve::TimeOptions loose, tight, explicit_steps;
  loose.velocity_tolerance = 3e-3;
  explicit_steps.method = voile::solve::TimeOptions::Method::central_difference;
  voile::system::EnergyBalance b;
  b.initial = 1.0;
  b.loads = -2.0;
  b.obstacles = 1.0;
  b.inflow = 3.0;
  b.unaccounted = -0.19;
  CHECK(balance_warning(b, loose).empty());
  b.unaccounted = -0.21;
  CHECK(balance_warning(b, loose).find("5.2 % of the energy") == 0);
  const auto names = [&](const voile::solve::TimeOptions& options, const char* text) {
    return balance_warning(b, options).find(text) != std::string::npos;
  };
  CHECK(names(loose, "time.velocity_tolerance below 0.003 m/s"));
  CHECK(names(tight, "-snes_rtol"));
  CHECK(names(explicit_steps, "time.step is needed"));
  CHECK(balance_warning({}, loose).empty());
  b.unaccounted = 0.0;
  b.numerical = 0.5;
  CHECK(balance_warning(b, loose).empty());  // what the scheme takes is no fault
  b.created = 0.19;
  CHECK(balance_warning(b, loose).empty());
  b.created = 0.21;  // although the scheme has taken more since
  CHECK(names(loose, "created 0.21 J, 5.2 %"));
  CHECK(balance_warning(b, loose, 0.22).empty());
  // Of stages that sew, where nothing else is looked at.
  CHECK(voile::record::creation_warning(b, 0.0).find("created 0.21 J, 5.2 %") != std::string::npos);
  CHECK(voile::record::creation_warning(b, 0.22).empty());
  b.created = 0.0;
  b.damping = 0.5;  // it takes
  CHECK(balance_warning(b, loose).empty());
  b.damping = -0.19;
  CHECK(balance_warning(b, loose).empty());
  b.damping = -0.21;
  CHECK(names(loose, "damping has given 0.21 J"));
}

}  // namespace test_energy_text
