// A fabric by least squares through the instruments of a sheet.
//
// Unknowns are the logarithms of the figures that a measurement depends on, residuals those of reading over measurement in units of
// its uncertainty. A drape coefficient determines one number: the bending length of the rigidities that nothing else has measured.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "record_fit.hpp"
#include "sheet.hpp"

namespace voile::fit {

/// A figure that the sheet determines.
struct Determined {
  double value = 0.0;                ///< in SI
  double deviation = 0.0;            ///< relative standard uncertainty
  bool assumed = false;              ///< from single figures, whose uncertainty nobody has measured
  std::vector<std::string> sources;  ///< names of measurements
};

/// A measurement beside what the fabric that was found reads.
struct Comparison {
  std::string name, unit;
  double measured = 0.0, found = 0.0;  ///< in that unit
  double deviation = 0.0;              ///< of the mean, likewise
  int count = 0;
  bool assumed = false, compared = false;
  [[nodiscard]] double residual() const { return found / measured - 1.0; }
};

struct FittedCurve {
  CurveFit fit;
  std::string source;
};

struct FittedLoop {
  std::string name;
  double deviation = 0.0;  ///< of its rows, root mean square over the range of the force
};

struct DrapeTrial {
  double coefficient = 0.0, deviation = 0.0, folds = 0.0;
};
/// The virtual drape test of a fabric file with this text. Throws if it does not come to rest.
using DrapeInstrument = std::function<DrapeTrial(const std::string& fabric_text)>;

/// A virtual strip of this width along the bias of a fabric file with this text: its rigidity, as a cantilever reads it, over that of
/// one that bends to a cylinder. Throws if it fails.
using BiasInstrument = std::function<double(const std::string& fabric_text, double width)>;

struct Fit {
  std::map<Parameter, Determined> figures;
  std::map<std::string, FittedCurve> curves;  ///< by key: tension_warp, tension_weft, shear_curve
  std::vector<FittedLoop> loops;
  std::vector<Comparison> comparisons;
  std::vector<std::string> warnings;
  std::size_t fitted = 0;  ///< measurements that were fitted

  [[nodiscard]] bool has(Parameter p) const { return figures.contains(p); }
};

/// Throws UserError naming file, line and remedy where the data do not determine what they speak of.
/// Without a `bias` strips along it bend to cylinders.
[[nodiscard]] Fit fit_sheet(const Sheet& sheet, const DrapeInstrument& drape, const BiasInstrument& bias = {});

}  // namespace voile::fit
