// Coarse level of rigid motions of aggregates of vertices; private to src/solve. Symbols in solve/schwarz_pc.hpp.
#pragma once

#include <petscksp.h>

#include <vector>

#include "base/petsc.hpp"

namespace voile::solve {

/// Parts of about so many vertices each of a rank's own block rows of k, which share no vertex: the part of each. Not collective.
[[nodiscard]] std::vector<int> divide_own_rows(Mat k, int vertices);

class RigidAggregates {
 public:
  /// Aggregates of about so many vertices and their fractions, averaged so often, for matrices with the pattern of k. Collective.
  void read_pattern(Mat k, int vertices, int smoothing);
  /// Z and E, with the own vertices at these places, three coordinates each. Collective.
  void take(Mat k, const std::vector<double>& places);
  /// x = Q b. False if E had no factor. Collective.
  void solve(Vec b, Vec x);
  [[nodiscard]] bool factored() const;
  [[nodiscard]] int aggregates() const { return aggregates_; }

 private:
  void find_centres(const std::vector<double>& places);
  void fill(Mat k, const std::vector<double>& places);

  int aggregates_ = 0, first_ = 0, own_ = 0;  ///< in all; the rank's first one, and how many
  std::vector<int> aggregate_;                ///< of each own vertex; all ranks' numbers
  std::vector<double> centres_;               ///< of all aggregates, three each
  double size_ = 1.0;                         ///< of an aggregate: makes turns as large as translations
  petsc::MatHandle fractions_, z_;
  petsc::KspHandle coarse_;
  petsc::VecHandle y_, c_;
};

}  // namespace voile::solve
