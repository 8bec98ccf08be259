#include "outlines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

#include "base/bytes.hpp"
#include "base/text.hpp"
#include "script.hpp"
#include "session.hpp"
#include "voile/errors.hpp"

namespace voile::formats {

namespace {

/// Parts of a curve that is not straight: cubic pieces with its derivatives are off by 1e-11 of a half circle's radius.
constexpr int parts = 400;

/// The first physical group of an entity; nothing if it is in none.
std::string name_of(int dimension, int tag) {
  std::vector<int> groups;
  gmsh::model::getPhysicalGroupsForEntity(dimension, tag, groups);
  return groups.empty() ? "" : group_name(dimension, groups.front());
}

/// A curve as one side of a surface runs along it.
struct Side {
  int tag = 0;
  bool reversed = false;
  int from = 0, to = 0;  ///< points
};

Side side_of(const std::string& file, int oriented) {
  gmsh::vectorpair ends;
  gmsh::model::getBoundary({{1, std::abs(oriented)}}, ends, false, false);  // the first point, then the last
  Side side{std::abs(oriented), oriented < 0};
  if (ends.size() != 2)
    throw UserError(fmt::format("{}: curve {} is closed in itself; divide it in two", file, side.tag));
  side.from = ends[0].second;
  side.to = ends[1].second;
  if (side.reversed) std::swap(side.from, side.to);
  return side;
}

/// Loops of a surface, each side beginning where the one before ends.
std::vector<std::vector<Side>> loops_of(const std::string& file, int surface) {
  gmsh::vectorpair curves;
  gmsh::model::getBoundary({{2, surface}}, curves, false, true);
  std::vector<Side> left;
  for (const auto& [dimension, tag] : curves) left.push_back(side_of(file, tag));
  std::vector<std::vector<Side>> loops;
  while (!left.empty()) {
    std::vector<Side> loop{left.front()};
    left.erase(left.begin());
    while (loop.back().to != loop.front().from) {
      const auto next = std::find_if(left.begin(), left.end(), [&](const Side& s) { return s.from == loop.back().to; });
      if (next == left.end())
        throw UserError(fmt::format("{}: the outline of surface {} is not closed at point {}; complete its curve loop",
                                    file, surface, loop.back().to));
      loop.push_back(*next);
      left.erase(next);
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

/// Derivatives by steps at points at equal steps, to the fourth order: Gmsh's own are differences over a hundredth of a curve.
std::vector<Vec3> derivatives_of(const std::vector<Vec3>& x) {
  const std::size_t n = x.size();
  if (n < 5) return std::vector<Vec3>(n, x.back() - x.front());
  std::vector<Vec3> d(n);
  for (const bool from_end : {false, true}) {
    const auto place = [&](std::size_t i) { return from_end ? n - 1 - i : i; };
    const auto p = [&](std::size_t i) -> const Vec3& { return x[place(i)]; };
    const double step = (from_end ? -1.0 : 1.0) / 12.0;
    d[place(0)] = step * (-25.0 * p(0) + 48.0 * p(1) - 36.0 * p(2) + 16.0 * p(3) - 3.0 * p(4));
    d[place(1)] = step * (-3.0 * p(0) - 10.0 * p(1) + 18.0 * p(2) - 6.0 * p(3) + p(4));
  }
  for (std::size_t k = 2; k + 2 < n; ++k) d[k] = (x[k - 2] - 8.0 * x[k - 1] + 8.0 * x[k + 1] - x[k + 2]) / 12.0;
  return d;
}

/// Points of a side in its direction, and derivatives by steps; of a straight one the two ends.
void put_side(const Side& side, ByteWriter& out) {
  std::string type;
  gmsh::model::getType(1, side.tag, type);
  std::vector<double> low, high, t, x;
  gmsh::model::getParametrizationBounds(1, side.tag, low, high);
  const int n = type == "Line" ? 1 : parts;
  for (int i = 0; i <= n; ++i) t.push_back(low[0] + (high[0] - low[0]) * (side.reversed ? n - i : i) / n);
  gmsh::model::getValue(1, side.tag, t, x);
  std::vector<Vec3> points;
  for (std::size_t k = 0; k + 2 < x.size(); k += 3) points.emplace_back(x[k], x[k + 1], x[k + 2]);
  out.put(name_of(1, side.tag));
  out.put(name_of(0, side.from));
  out.put(points);
  out.put(derivatives_of(points));
}

std::string outlines(const std::string& file) {
  gmsh::vectorpair surfaces;
  gmsh::model::getEntities(surfaces, 2);
  if (surfaces.empty())
    throw UserError(fmt::format("{}: there is no surface; draw each piece as a Plane Surface", file));
  ByteWriter out;
  out.put(surfaces.size());
  for (const auto& [dimension, surface] : surfaces) {
    const std::string name = name_of(2, surface);
    out.put(name.empty() ? fmt::format("surface-{}", surface) : name);
    const std::vector<std::vector<Side>> loops = loops_of(file, surface);
    out.put(loops.size());
    for (const std::vector<Side>& loop : loops) {
      out.put(loop.size());
      for (const Side& side : loop) put_side(side, out);
    }
  }
  return out.take();
}

}  // namespace

std::string outlines_of(const std::vector<std::string>& words) {
  const std::string& file = words.at(1);
  std::map<std::string, double> parameters;
  for (std::size_t k = 4; k + 1 < words.size(); k += 2)
    parameters[words[k]] = std::strtod(words[k + 1].c_str(), nullptr);
  try {
    const Script script(file, parameters);
    const Session session(rights_of(words.at(3)));
    script.open();
    return outlines(file);
  } catch (const std::string& message) {  // what Gmsh throws
    throw UserError(fmt::format("{}: Gmsh: {}", file, printable(message)));
  }
}

}  // namespace voile::formats
