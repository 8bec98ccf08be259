// Points of bodies by name, where the bodies are at the start of the run.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "input/case.hpp"

namespace voile::setup {

/// Landmarks of a case: its [[landmark]] sections and the files of its obstacles. Nothing is read before it is asked for.
/// Not collective; for the rank that reads the files.
class Landmarks {
 public:
  /// The case must outlive it.
  explicit Landmarks(const input::Case& c) : case_(c) {}

  /// The point in the scene [m]. `where` names section and key for messages.
  /// Throws UserError for unknown names and files that cannot be read.
  [[nodiscard]] Vec3 place(const input::PointInput& point, const std::string& where);

  /// What a user should know of the landmarks that were asked for.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

 private:
  using Named = std::map<std::string, Vec3>;
  [[nodiscard]] const input::ObstacleSection& obstacle_of(const std::string& landmark, const std::string& where) const;
  [[nodiscard]] const Named& of_file(const input::ObstacleSection& o);
  [[nodiscard]] const std::vector<Vec3>& vertices(const input::ObstacleSection& o);
  [[nodiscard]] Vec3 place(const input::LandmarkSection& s, const input::ObstacleSection& o);

  const input::Case& case_;
  std::map<std::string, Named> files_;                   ///< of obstacles by name
  std::map<std::string, std::vector<Vec3>> at_start_{};  ///< likewise
  std::vector<std::string> notes_;
};

}  // namespace voile::setup
