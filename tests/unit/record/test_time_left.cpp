// How long a run is still to take.
#include <doctest/doctest.h>

#include <cmath>

#include "record/time_left.hpp"

namespace voile::record::test_time_left {

TEST_CASE(
    "time left: exact for a steady course, from where a restart began, and between the mean and the latest pace") {
  TimeLeft steady, slower;
  CHECK_FALSE(steady.until(1.0));
  for (int k = 0; k <= 6; ++k) steady.add(0.4 + 0.05 * k, 3.0 + 2.0 * k);
  CHECK(*steady.until(1.0) == doctest::Approx(12.0));
  CHECK(*steady.until(0.5) == 0.0);
  for (int k = 0; k <= 10; ++k) slower.add(0.05 * k, k <= 5 ? k : 5.0 + 3.0 * (k - 5));  // 5 s for a quarter, then 15 s
  CHECK(*slower.until(1.0) == doctest::Approx(0.5 * std::sqrt(40.0 * 60.0)));
}

TEST_CASE("time left: a state before the last one begins anew") {
  TimeLeft left;
  left.add(0.0, 0.0);
  left.add(0.5, 1.0);
  left.add(0.2, 2.0);
  CHECK_FALSE(left.until(1.0));
  left.add(0.4, 3.0);
  CHECK(*left.until(1.0) == doctest::Approx(3.0));
}

}  // namespace voile::record::test_time_left
