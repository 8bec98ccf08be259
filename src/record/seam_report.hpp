// How the seams of a stage close: lengths, how hard they are pulled, the widest gap before they are welded.
//
// Symbols   L_1, L_2   rest lengths of both sides [m]      ease = 100 (L_1/L_2 - 1): by how much the first is longer [%]
//           S          force of the springs per length of the seam (system/sewing_springs.hpp) [N/m]
//   pull = the largest mean of S along the seam, and the largest S, over the accepted steps
#pragma once

#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "input/case.hpp"
#include "system/model.hpp"
#include "system/state.hpp"

namespace voile::record {

struct SeamMeasure {
  std::string name;
  std::array<double, 2> lengths{};             ///< at rest [m]
  double mean_pull = 0.0, largest_pull = 0.0;  ///< of the hardest step [N/m]
  double pulled_at = 0.0;                      ///< when the mean was largest [s]
  double pull_at_end = 0.0;                    ///< mean of S [N/m]
  double gap = 0.0;                            ///< largest at the end [m]
  std::array<std::string, 2> edges{};          ///< "PIECE/EDGE" of the two vertices there
  Vec3 place = Vec3::Zero();                   ///< [m]
  /// Without what is round-off.
  [[nodiscard]] double ease() const {
    const double percent = lengths[1] > 0.0 ? 100.0 * (lengths[0] / lengths[1] - 1.0) : 0.0;
    return std::abs(percent) > 1e-9 ? percent : 0.0;
  }
};

class SeamReport {
 public:
  /// A state that is accepted. Collective.
  void add(const input::Case& c, system::Model& model, const system::State& state);
  /// Of the seams that a stage closes, the widest first, on rank 0; empty elsewhere. Collective.
  [[nodiscard]] std::vector<SeamMeasure> measure(const input::Case& c, const system::Model& model,
                                                 const system::State& state) const;

 private:
  struct Pull {
    double mean = 0.0, largest = 0.0, time = 0.0, last = 0.0;
  };
  std::map<std::string, Pull> pulls_;  ///< the same on every rank
};

/// seams.csv in the folder of a stage. Not collective: call on one rank. Throws UserError.
void write_seams(const std::filesystem::path& folder, const std::vector<SeamMeasure>& seams);

/// The first few, a line each.
[[nodiscard]] std::vector<std::string> seam_lines(const std::vector<SeamMeasure>& seams);

}  // namespace voile::record
