#include "driven_obstacles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/text.hpp"
#include "voile/errors.hpp"

namespace voile::setup {

namespace {

using contact::Obstacle;

std::vector<Vec3> points_of(const Obstacle& o, double time) {
  if (o.frames) return o.frames(time);
  std::vector<Vec3> x = o.points;
  for (Vec3& p : x)
    if (o.motion) p += o.motion(p, time);
  return x;
}

/// Relative to the largest coordinate.
constexpr double same_way = 1e-12;

void require_alike(const std::string& name, const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
  const Vec3 way = to.front() - from.front();
  for (std::size_t i = 0; i < to.size(); ++i)
    if ((to[i] - from[i] - way).norm() > same_way * (to[i].norm() + from[i].norm()))
      throw UserError(fmt::format(
          "obstacle '{}': its points must move alike, for it has no triangles; move an obstacle of type \"mesh\" or "
          "\"cylinder\" if it shall turn",
          name));
}

}  // namespace

std::vector<Vec3> DrivenObstacles::Track::at(double time) const {
  const double s = std::clamp((time - begin) / (end - begin), 0.0, 1.0);
  std::vector<Vec3> x = s < 1.0 ? from : to;
  if (s < 1.0)
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += s * (to[i] - from[i]);
  return x;
}

void DrivenObstacles::take(Obstacle& o) {
  const auto [at, is_new] = driven_.try_emplace(o.name);
  if (is_new) at->second.as_given = o;
  const Obstacle given = at->second.as_given;
  const std::shared_ptr<const Track> track = at->second.track;
  if (o.shape == Obstacle::Shape::mesh) {
    if (given.motion)  // of which friction takes how the surface turns
      o.motion = [given, track](const Vec3& rest, double time) {
        return track->to.empty() ? given.motion(rest, time) : Vec3(Vec3::Zero());
      };
    o.frames = [given, track](double time) { return track->to.empty() ? points_of(given, time) : track->at(time); };
    return;
  }
  o.motion = [given, track](const Vec3& rest, double time) {
    if (track->to.empty()) return given.motion ? given.motion(rest, time) : Vec3(Vec3::Zero());
    const Vec3 start = given.motion ? given.motion(rest, track->taken) : Vec3(Vec3::Zero());
    return Vec3(start + track->at(time).front() - points_of(given, track->taken).front());
  };
}

const DrivenObstacles::Driven& DrivenObstacles::find(const std::string& name) const {
  const auto at = driven_.find(name);
  if (at != driven_.end()) return at->second;
  std::vector<std::string> names;
  for (const auto& [known, driven] : driven_) names.push_back(known);
  throw UserError(fmt::format("there is no obstacle '{}':{}", name, suggestion(name, names)));
}

std::vector<Vec3> DrivenObstacles::points(const std::string& name, double time) const {
  const Driven& d = find(name);
  return d.track->to.empty() ? points_of(d.as_given, time) : d.track->at(time);
}

void DrivenObstacles::set(const std::string& name, std::vector<Vec3> positions, double now, double end) {
  const Driven& d = find(name);
  std::vector<Vec3> from = points(name, now);
  if (positions.size() != from.size())
    throw UserError(
        fmt::format("obstacle '{}': {} positions are given, it has {} points", name, positions.size(), from.size()));
  if (!(end > now))
    throw UserError(
        fmt::format("obstacle '{}': it shall be there at t = {:g} s, which is not later than the present t = {:g} s",
                    name, end, now));
  if (d.as_given.shape != Obstacle::Shape::mesh) require_alike(name, from, positions);
  const double taken = d.track->to.empty() ? now : d.track->taken;
  *d.track = {std::move(from), std::move(positions), now, end, taken};
}

DrivenObstacles::Tracks DrivenObstacles::tracks() const {
  Tracks all;
  for (const auto& [name, driven] : driven_) all.emplace(name, *driven.track);
  return all;
}

void DrivenObstacles::restore(const Tracks& tracks) {
  for (const auto& [name, track] : tracks) *find(name).track = track;
}

}  // namespace voile::setup
