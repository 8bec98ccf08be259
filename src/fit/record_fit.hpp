// From records to figures: loops as sliders, curves as the points of a fabric file.
#pragma once

#include <vector>

#include "sheet.hpp"

namespace voile::fit {

/// B, 2HB and the spread of each bending loop, or G, 2HG, 2HG5 and the spread of a shear loop, as measurements with the mean of the
/// specimens. A spread that the rows do not show is left out. Throws UserError.
[[nodiscard]] std::vector<Measurement> measurements_of(const Sheet& sheet, const Record& loop);

/// A curve of a fabric file.
struct CurveFit {
  std::vector<RecordPoint> points;
  double uncertainty = 0.0;  ///< relative, of points that are figures of the sheet
  double deviation = 0.0;    ///< of the rows from it, root mean square over the largest force
};
/// Through all points of a short record, by least squares with `knots` points through a long one. Throws UserError.
[[nodiscard]] CurveFit curve_of(const Sheet& sheet, const Record& curve);

}  // namespace voile::fit
