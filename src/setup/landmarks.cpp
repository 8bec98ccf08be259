#include "landmarks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "base/plain_file.hpp"
#include "base/text.hpp"
#include "obstacles.hpp"
#include "voile/errors.hpp"

namespace voile::setup {

namespace {

/// Coordinate of a place that anything could have [m].
constexpr double largest = 1e6;

/// A coordinate; what follows it is empty.
bool read_number(const std::string& text, double& value) {
  try {
    std::size_t end = 0;
    value = std::stod(text, &end);
    return text.find_first_not_of(" \t\r", end) == std::string::npos && std::isfinite(value);
  } catch (const std::logic_error&) {
    return false;
  }
}

/// Lines NAME,X,Y,Z in the coordinates of the file.
std::map<std::string, Vec3> read_landmarks(const std::filesystem::path& file) {
  std::ifstream in = open_input(file);
  if (!in) throw UserError(fmt::format("{}: the file cannot be opened", file.string()));
  std::map<std::string, Vec3> named;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos || line.starts_with("#")) continue;
    const std::size_t z = line.rfind(','), y = z == 0 || z == std::string::npos ? z : line.rfind(',', z - 1);
    const std::size_t x = y == 0 || y == std::string::npos ? y : line.rfind(',', y - 1);
    Vec3 at;
    const bool whole = x != std::string::npos && x > 0 && read_number(line.substr(x + 1, y - x - 1), at[0]) &&
                       read_number(line.substr(y + 1, z - y - 1), at[1]) && read_number(line.substr(z + 1), at[2]);
    if (!whole) throw UserError(fmt::format("{}:{}: '{}': NAME,X,Y,Z is needed", file.string(), number, line));
    if (!named.emplace(line.substr(0, x), at).second)
      throw UserError(fmt::format("{}:{}: '{}' is there twice; keep one", file.string(), number, line.substr(0, x)));
  }
  return named;
}

}  // namespace

const input::ObstacleSection& Landmarks::obstacle_of(const std::string& landmark, const std::string& where) const {
  std::vector<std::string> known;
  for (const input::ObstacleSection& o : case_.obstacles) {
    if (landmark.starts_with(o.shape.name + ".")) return o;
    known.push_back(o.shape.name);
  }
  if (known.empty())
    throw UserError(
        fmt::format("{}: '{}': there is no [[obstacle]] that could have a landmark; give one, or write "
                    "three numbers [x, y, z]",
                    where, landmark));
  const std::string name = landmark.substr(0, landmark.find('.'));
  throw UserError(fmt::format("{}: '{}': a landmark is written \"OBSTACLE.NAME\", and there is no [[obstacle]] '{}':{}",
                              where, landmark, name, suggestion(name, known)));
}

const Landmarks::Named& Landmarks::of_file(const input::ObstacleSection& o) {
  const auto [at, is_new] = files_.try_emplace(o.shape.name);
  if (!is_new || o.landmarks.empty()) return at->second;
  at->second = read_landmarks(o.landmarks);
  for (auto& [name, x] : at->second) {
    std::vector<Vec3> point{x * o.scale};
    o.placement.apply(point);
    x = point.front();
    if (!(x.cwiseAbs().maxCoeff() <= largest))
      throw UserError(fmt::format("{}: '{}' lies {:g} m away; check the file and the scale of [[obstacle]] '{}'",
                                  o.landmarks.string(), name, x.cwiseAbs().maxCoeff(), o.shape.name));
  }
  return at->second;
}

const std::vector<Vec3>& Landmarks::vertices(const input::ObstacleSection& o) {
  const auto [at, is_new] = at_start_.try_emplace(o.shape.name);
  if (is_new) at->second = vertices_at_start(o);
  return at->second;
}

Vec3 Landmarks::place(const input::LandmarkSection& s, const input::ObstacleSection& o) {
  if (s.point) return *s.point;
  const std::vector<Vec3>& x = vertices(o);
  if (s.near)
    return *std::min_element(x.begin(), x.end(), [&](const Vec3& a, const Vec3& b) {
      return (a - *s.near).squaredNorm() < (b - *s.near).squaredNorm();
    });
  Vec3 mean = Vec3::Zero();
  for (const double v : s.vertices) {
    if (v > static_cast<double>(x.size()))
      throw UserError(fmt::format("{}: [[landmark]] '{}' vertices: {}: {} has {}, counted from 1", case_.file.string(),
                                  s.name, v, o.file.string(), x.size()));
    mean += x[static_cast<std::size_t>(v) - 1] / static_cast<double>(s.vertices.size());
  }
  return mean;
}

Vec3 Landmarks::place(const input::PointInput& point, const std::string& where) {
  if (point.landmark.empty()) return point.at;
  const input::ObstacleSection& o = obstacle_of(point.landmark, where);
  const std::string name = point.landmark.substr(o.shape.name.size() + 1);
  std::vector<std::string> known;
  for (const input::LandmarkSection& s : case_.landmarks) {
    if (s.obstacle != o.shape.name) continue;
    if (s.name == name) return place(s, o);
    known.push_back(s.name);
  }
  const Named& named = of_file(o);
  if (const auto at = named.find(name); at != named.end()) {
    if (!o.frames.empty() && o.frames_start < 0.0 && notes_.empty())
      notes_.push_back(
          fmt::format("[[obstacle]] '{}': the run begins within its frames (frames_start < 0), but {} has places in "
                      "the mesh as it is; name points that shall be on the body by [[landmark]] vertices",
                      o.shape.name, o.landmarks.string()));
    return at->second;
  }
  for (const auto& [other, x] : named) known.push_back(other);
  if (known.empty())
    throw UserError(
        fmt::format("{}: '{}': [[obstacle]] '{}' has no landmarks; name points of it by [[landmark]], or by "
                    "its key landmarks",
                    where, point.landmark, o.shape.name));
  throw UserError(fmt::format("{}: '{}': [[obstacle]] '{}' has no landmark '{}':{}", where, point.landmark,
                              o.shape.name, name, suggestion(name, known)));
}

}  // namespace voile::setup
