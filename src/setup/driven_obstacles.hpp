// Obstacles that are put in place from outside while a run goes on.
//
// Symbols   x_0, x_1   positions of an obstacle's points at the times t_0 and t_1                                  [m], [s]
//   x(t) = x_0 + (t - t_0)/(t_1 - t_0) (x_1 - x_0),   x_0 before t_0, x_1 after t_1
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "contact/obstacle.hpp"

namespace voile::setup {

class DrivenObstacles {
 public:
  /// Where an obstacle goes, instead of what its case says of it; no points: as the case says.
  struct Track {
    std::vector<Vec3> from, to;     ///< x_0, x_1 [m]
    double begin = 0.0, end = 0.0;  ///< t_0, t_1 [s]
    double taken = 0.0;             ///< when it was first put anywhere: what turns by its case stays as it was then [s]
    [[nodiscard]] std::vector<Vec3> at(double time) const;
  };
  using Tracks = std::map<std::string, Track>;

  /// Lets an obstacle follow its track, once it has one. Its points move as those of a mesh; what has no triangles is carried
  /// along without turning.
  void take(contact::Obstacle& obstacle);
  /// Positions of the points of an obstacle at a time [m]. Throws UserError for unknown names.
  [[nodiscard]] std::vector<Vec3> points(const std::string& name, double time) const;
  /// From now on it goes on straight lines from where it is at time `now` to `positions` at time `end`, and stays there.
  /// Throws UserError for unknown names, another number of points, a time that is not later, and for balls, capsules and
  /// half-spaces whose points do not move alike.
  void set(const std::string& name, std::vector<Vec3> positions, double now, double end);

  [[nodiscard]] Tracks tracks() const;
  void restore(const Tracks& tracks);

 private:
  struct Driven {
    contact::Obstacle as_given;
    std::shared_ptr<Track> track = std::make_shared<Track>();
  };
  [[nodiscard]] const Driven& find(const std::string& name) const;
  std::map<std::string, Driven> driven_;
};

}  // namespace voile::setup
