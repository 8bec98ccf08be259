// What a drape coefficient determines.
#pragma once

#include "fit.hpp"

namespace voile::fit {

/// Finds the bending length that gives the drape coefficient of the sheet to the rigidities along warp and weft that `fit` does not
/// have, or compares the coefficient where it has both. Throws UserError where no bending length has it.
void fit_drape(const Sheet& sheet, Fit& fit, const DrapeInstrument& drape);

/// Zero of a function that rises, by false position within brackets that double; the function may jump. At most `trials` calls, until
/// it is below `tolerance` or the bracket within a fiftieth of the argument.
struct Root {
  double argument = 0.0, value = 0.0;
  bool found = false;
};
[[nodiscard]] Root rising_root(const std::function<double(double)>& f, double start, double least, double most,
                               double tolerance, int trials);

}  // namespace voile::fit
