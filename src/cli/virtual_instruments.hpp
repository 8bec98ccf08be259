// Cases of the instruments of `voile fabric-test`, and what they read.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "input/fabric.hpp"
#include "voile/errors.hpp"

namespace voile::cli {

inline constexpr double fast_width = 0.05;  ///< of the strip of FAST-2 [m]

/// A fabric on the instruments.
struct TestedFabric {
  input::Fabric fabric;
  std::filesystem::path file, folder;  ///< of the fabric, and of the results
};

/// Bending rigidity along the warp (0), the bias (45) or the weft (90), and what a cantilever reads of its overhang [m]. [N m]
[[nodiscard]] double rigidity_along(const input::Fabric& f, int angle);
[[nodiscard]] double rigidity_read(const input::Fabric& f, double overhang);
/// The run of an instrument that has not reached its end.
class InstrumentFailed : public UserError {
 public:
  using UserError::UserError;
};

/// Length of a strip that falls by 41.5 degrees, along the warp (0), the bias (45) or the weft (90) [m]. Throws InstrumentFailed if the run fails.
[[nodiscard]] double overhang(const TestedFabric& t, int angle, double width = fast_width);
/// A heart loop: length of its strip, and its height [m].
struct HeartLoop {
  double length = 0.0, height = 0.0;
};
/// Length of the strips of both heart loops, for the mean of warp and weft [m].
[[nodiscard]] double heart_loop_length(const TestedFabric& t);
/// Of a narrow strip along the warp (0) or the weft (90), of one length for both. Throws InstrumentFailed if the run fails.
[[nodiscard]] HeartLoop heart_loop(const TestedFabric& t, int angle);
/// Bending rigidity by the elastica [N m].
[[nodiscard]] double rigidity_read(const input::Fabric& f, const HeartLoop& loop);
/// Extension at 5 gf/cm of a strip along the bias, 100 mm between clamps and 50 mm wide (EB5 of FAST-3). Its ends cannot shear.
[[nodiscard]] double bias_extension(const TestedFabric& t);
/// Curvature [1/m] and moment per width [N] of a strip that is bent to 2.5 /cm, back, and again; the row of zeros first.
[[nodiscard]] std::vector<std::pair<double, double>> bending_record(const TestedFabric& t, int angle);
/// Angle [degree] and force per width [N/m] of a square in a picture frame, to 8 degrees, back, and again.
[[nodiscard]] std::vector<std::pair<double, double>> shear_record(const TestedFabric& t);

}  // namespace voile::cli
