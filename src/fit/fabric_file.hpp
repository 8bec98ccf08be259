// The result of a fit: a fabric file, what was not determined and stands in its place, and residuals.
#pragma once

#include <string>
#include <vector>

#include "fit.hpp"

namespace voile::fit {

/// A figure that nothing on the sheet determines, and what holds in its place.
struct Undetermined {
  std::string key, instead;
};
[[nodiscard]] std::vector<Undetermined> undetermined(const Sheet& sheet, const Fit& fit);

/// A fabric file whose sources name measurements and uncertainties. Throws UserError if the program would not read it.
[[nodiscard]] std::string fabric_text(const Sheet& sheet, const Fit& fit);

/// Figures, residuals, what was not determined and not used, as lines for a terminal.
[[nodiscard]] std::vector<std::string> report(const Sheet& sheet, const Fit& fit);

}  // namespace voile::fit
