// What is said about the energy of a motion at its end.
#include <doctest/doctest.h>

#include "../../../src/app/energy_text.hpp"

using voile::app::KineticEnergy;
using voile::app::rest_text;

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
