// Words about how far a result is off.
#include <doctest/doctest.h>

#include "record/validity.hpp"

namespace test_validity {

TEST_CASE("fractions in per cent: two figures, none that only look exact") {
  CHECK(voile::record::percent_text(0.0) == "0 %");
  CHECK(voile::record::percent_text(1.2e-33) == "less than 0.01 %");
  CHECK(voile::record::percent_text(0.00034) == "0.034 %");
  CHECK(voile::record::percent_text(0.123) == "12 %");
  CHECK(voile::record::up_to_text(0.123) == "up to 12 %");
  CHECK(voile::record::up_to_text(1.01) == "more than 100 %");
  CHECK(voile::record::percent_text(8.24) == "more than 100 %");
}

}  // namespace test_validity
