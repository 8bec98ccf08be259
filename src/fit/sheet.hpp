// A laboratory's sheet: what was measured of one fabric, as a TOML file.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "instruments.hpp"

namespace voile::fit {

/// Mean of the specimens of one figure, in SI.
struct Figure {
  double mean = 0.0;
  double deviation = 0.0;  ///< standard uncertainty of the mean
  int count = 0;           ///< specimens
  bool assumed = false;    ///< one specimen without its uncertainty
};

/// Relative standard deviation that a single figure is taken to have, and the least of any.
inline constexpr double assumed_deviation = 0.03, least_deviation = 1e-3;

struct Measurement {
  std::string name;  ///< as in "kes.B.warp"
  int line = 0;
  Instrument instrument;
  std::string unit;  ///< of the sheet
  double si = 1.0;   ///< of that unit
  Figure figure;
  bool compared = false;  ///< only: the sheet has what it was computed from
  double rows =
      0.0;  ///< of a loop: root mean square of the distance of its rows from the law, over the range of the force
  bool shared = false;  ///< the sheet has one figure for warp and weft
};

/// A point of a record: extension, angle [rad] or curvature [1/m]; force per width [N/m] or moment per width [N].
struct RecordPoint {
  double x = 0.0, force = 0.0;
};

/// Points of a test.
struct Record {
  enum class Kind { bending_loop, shear_loop, tension_curve, shear_curve };
  Kind kind = Kind::bending_loop;
  Direction direction = Direction::none;
  std::string name;
  int line = 0;
  std::vector<std::string> files;  ///< a specimen each; empty: the figures of the sheet are the points
  std::vector<std::vector<RecordPoint>> points;
  double deviation = 0.0;  ///< relative standard uncertainty of figures of the sheet
};

struct DrapeFigure {
  Figure coefficient;
  std::optional<double> folds;
  int specimen = 300;  ///< diameter [mm]
  int line = 0;
};

struct Sheet {
  std::string file, name, description, source;
  std::vector<Measurement> measurements;
  std::vector<Record> records;
  std::optional<DrapeFigure> drape;
  std::vector<std::string> unused;  ///< figures that no key of a fabric file depends on
  double load = 0.0;                ///< of EMT [N/m]

  /// Throws UserError "file:line: key: message".
  [[noreturn]] void fail(int line, const std::string& key, const std::string& message) const;
};

/// Throws UserError naming file, line, key and remedy.
[[nodiscard]] Sheet read_sheet(const std::filesystem::path& file);
/// `text` as the file `file`, beside which records lie.
[[nodiscard]] Sheet parse_sheet(const std::string& text, const std::filesystem::path& file);

}  // namespace voile::fit
