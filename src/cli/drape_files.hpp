// Files of a drape test: the cases that are run, and what came of them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drape_equilibria.hpp"
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
/// Shape and edge of the last step of a results.vtkhdf.
void read_drape_shape(const DrapeSetting& s, const std::filesystem::path& file, DrapeRepeat& r);
/// Sections that all cases of a specimen share; its specimen.geo goes into the folder of the repeat. Throws UserError.
[[nodiscard]] std::string specimen_text(const DrapeSetting& s, const DrapeRepeat& r, bool friction);
/// Writes a file. Throws UserError.
void write_drape_file(const std::filesystem::path& file, const std::string& text);
/// contour_K.csv of each, circles.csv, contours.png, equilibria.csv and summary.json; `finer`: the first repeat with finer cells, if
/// that has been run. Throws UserError.
void write_drape_results(const DrapeSetting& s, const std::vector<DrapeRepeat>& repeats,
                         const std::optional<DrapeRepeat>& finer, const std::vector<DrapeEquilibrium>& equilibria);

/// Mean and standard deviation of the coefficients [%].
struct Spread {
  double mean = 0.0, deviation = 0.0;
};
[[nodiscard]] Spread coefficient_of(const std::vector<DrapeRepeat>& repeats);

}  // namespace voile::cli
