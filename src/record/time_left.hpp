// How long the rest of a run takes, from its progress so far.
//
// Symbols  p progress (load factor or time), p1 its end, e elapsed wall time [s]
// Left = (p1 - p) sqrt(r r'), r = de/dp since the start, r' = de/dp over the last third of the elapsed time: of the simple
// rules that were tried on 45 recorded paths and motions it stays within a factor of two most often (two thirds of the time).
#pragma once

#include <optional>
#include <utility>
#include <vector>

namespace voile::record {

class TimeLeft {
 public:
  /// Progress and elapsed time [s] of an accepted step, or of the start.
  void add(double progress, double elapsed);
  /// Seconds until `end` is reached; nothing where progress does not tell. Not collective.
  [[nodiscard]] std::optional<double> until(double end) const;

 private:
  std::vector<std::pair<double, double>> steps_;
};

}  // namespace voile::record
