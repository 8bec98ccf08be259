#include "stage_obstacles.hpp"

#include <algorithm>
#include <optional>

#include "base/text.hpp"

namespace voile::simulation {

namespace {

using input::Analysis;

/// The first stage of this analysis that has the obstacle.
std::optional<std::size_t> first_of(const std::vector<input::Case>& all, Analysis analysis, int obstacle) {
  const auto at = std::find_if(all.begin(), all.end(), [&](const input::Case& c) {
    return c.analysis == analysis && contains(c.stage.obstacles, static_cast<std::size_t>(obstacle));
  });
  return at == all.end() ? std::nullopt : std::optional(static_cast<std::size_t>(at - all.begin()));
}

void stop_at(contact::Obstacle& o, double time) {
  if (o.motion) o.motion = [motion = o.motion, time](const Vec3& rest, double) { return motion(rest, time); };
  if (o.frames) o.frames = [frames = o.frames, time](double) { return frames(time); };
}

/// What the clock of the motions before a stage shows.
double time_before(const std::vector<input::Case>& all, std::size_t stage) {
  double time = 0.0;
  for (std::size_t n = 0; n < stage; ++n)
    if (all[n].analysis == Analysis::dynamic) time = all[n].time.options.end_time;
  return time;
}

}  // namespace

void lead_obstacles(const std::vector<input::Case>& all, remesh::Stage& now) {
  const std::size_t number = now.c.stage.number;
  std::vector<contact::Obstacle*> in_time;
  for (contact::Obstacle& o : now.input.contact.obstacles) {
    const std::optional<std::size_t> path = first_of(all, Analysis::statics, o.number);
    if (!o.motion || first_of(all, Analysis::dynamic, o.number)) {
      in_time.push_back(&o);
    } else if (path == number) {
      now.c.stage.moves_obstacles = true;
    } else {
      const bool moved = path && *path < number;
      stop_at(o, moved ? all[*path].steps.final_load_factor : 0.0);
      if (moved && *path + 1 == number) now.held_at = all[*path].steps.final_load_factor;
    }
  }
  if (!now.c.stage.moves_obstacles) return;
  for (contact::Obstacle* o : in_time) stop_at(*o, time_before(all, number));
}

}  // namespace voile::simulation
