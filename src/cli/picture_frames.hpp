// Pictures of one series divided over ranks that know nothing of each other but files.
#pragma once

#include <filesystem>
#include <functional>

#include "launched_ranks.hpp"
#include "picture/image.hpp"

namespace voile::cli {

/// Frame i is drawn by rank i mod size. The first rank takes them in order, the others leave theirs in a folder beside
/// the animation, where it fetches them.
class SharedFrames {
 public:
  using Draw = std::function<picture::Image(std::size_t)>;
  using Take = std::function<void(std::size_t, const picture::Image&)>;
  /// `animation`: the file that the first rank will write. `begun`: when this program began; older frames are of a
  /// run that was killed, since names of jobs come again.
  SharedFrames(const std::filesystem::path& animation, LaunchedRank own, std::filesystem::file_time_type begun);

  /// Draws this rank's frames of so many; on the first rank `take` is given all of them. Throws UserError if the folder
  /// cannot be written.
  void run(std::size_t count, const Draw& draw, const Take& take) const;

 private:
  [[nodiscard]] std::filesystem::path file_of(std::size_t frame) const;
  [[nodiscard]] bool is_there(const std::filesystem::path& file) const;
  [[nodiscard]] picture::Image fetch(std::size_t frame, const Draw& draw) const;

  LaunchedRank own_;
  std::filesystem::path folder_;
  std::filesystem::file_time_type begun_;
};

/// Whether a rank draws this picture of a series.
[[nodiscard]] inline bool is_own(const LaunchedRank& own, std::size_t number) {
  return number % static_cast<std::size_t>(own.size) == static_cast<std::size_t>(own.rank);
}

}  // namespace voile::cli
