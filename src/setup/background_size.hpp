// Sizes of a remeshing from a field of Gmsh.
#pragma once

#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "input/case.hpp"

namespace voile::setup {

/// Remembers places that it was asked for: most vertices stay from mesh to mesh, and each question starts a program.
class BackgroundSize {
 public:
  explicit BackgroundSize(const input::Case& c);

  /// Upper bounds of the edge length at places at the start [m]. Not collective: call on one rank. Throws UserError as
  /// formats::view_values() does, and for values that are no length.
  [[nodiscard]] std::vector<double> at(const std::vector<Vec3>& places);

 private:
  std::string file_;
  formats::Placement placement_;
  double scale_;
  std::map<std::tuple<double, double, double>, double> known_;
};

}  // namespace voile::setup
