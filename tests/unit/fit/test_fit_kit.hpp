// What tests of sheets share.
#pragma once

#include <cstdio>
#include <fstream>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "../test_case_kit.hpp"
#include "../test_relative.hpp"
#include "base/mpi.hpp"
#include "fit/fit.hpp"

namespace voile::testing::sheets {

using fit::Parameter;
constexpr double degree = std::numbers::pi / 180.0;

/// For what is initialised before main(), when `head` may not be.
constexpr const char* head_text = "name = \"Test\"\ndescription = \"made up\"\n";
inline const std::string head = head_text;

inline fit::DrapeTrial no_drape(const std::string&) {
  throw InternalError("no drape test is needed");
}

inline fit::Fit fitted(const std::string& text) {
  return fit::fit_sheet(fit::parse_sheet(text, "sheet.toml"), no_drape);
}

inline std::string fit_error(const std::string& text) {
  return error_of([&] { (void)fitted(text); });
}

inline double value(const fit::Fit& f, Parameter p) {
  return f.figures.at(p).value;
}

/// Rows of a record as a file that is removed.
struct Rows {
  std::string file;
  explicit Rows(const std::vector<std::pair<double, double>>& rows)
      : file("fit_rows_" + std::to_string(mpi::rank(MPI_COMM_WORLD)) + ".csv") {
    std::ofstream out(file);
    out << "x,force\n";
    out.precision(12);
    for (const auto& [x, force] : rows) out << x << ',' << force << '\n';
  }
  ~Rows() { (void)std::remove(file.c_str()); }
  Rows(const Rows&) = delete;
  Rows& operator=(const Rows&) = delete;
};

/// From zero to most, to least, and back to zero.
inline std::vector<double> course(double most, double step) {
  std::vector<double> all;
  const auto count = static_cast<int>(most / step);
  for (int i = 0; i <= count; ++i) all.push_back(step * i);
  for (int i = count - 1; i >= -count; --i) all.push_back(step * i);
  for (int i = -count + 1; i <= 0; ++i) all.push_back(step * i);
  return all;
}

}  // namespace voile::testing::sheets
