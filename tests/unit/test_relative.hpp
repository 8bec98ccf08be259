// Comparison of numbers relative to their own size.
#pragma once

#include <doctest/doctest.h>

namespace voile {

/// doctest's Approx adds 1 to the size that its epsilon refers to, so that small numbers always agree; this does not.
/// Where 0 is expected, give .scale(size of what would be wrong).
inline doctest::Approx relative(double value) {
  return doctest::Approx(value).scale(0.0);
}

}  // namespace voile
