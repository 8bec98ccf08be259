// Files of a drape test: the cases that are run, and what came of them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drape_test.hpp"
#include "input/fabric.hpp"

namespace voile::cli {

/// What all repeats share.
struct DrapeSetting {
  DrapeTest test;
  input::Fabric fabric;
  std::filesystem::path fabric_file;
  bool friction = false;  ///< inside the fabric
  double cell = 0.0;      ///< [m]
};

inline constexpr double drape_support_radius = 0.09;  ///< [m]

/// Writes case.toml and specimen.geo of a repeat into its folder. Throws UserError.
void write_drape_case(const DrapeSetting& s, const DrapeRepeat& r);
/// Reads what a repeat that has ended came to.
void read_drape_result(const DrapeSetting& s, DrapeRepeat& r);
/// contour_K.csv of each, circles.csv, contours.png and summary.json; `finer`: the first repeat with finer cells, if that has
/// been run. Throws UserError.
void write_drape_results(const DrapeSetting& s, const std::vector<DrapeRepeat>& repeats,
                         const std::optional<DrapeRepeat>& finer);

/// Mean and standard deviation of the coefficients [%].
struct Spread {
  double mean = 0.0, deviation = 0.0;
};
[[nodiscard]] Spread coefficient_of(const std::vector<DrapeRepeat>& repeats);

}  // namespace voile::cli
