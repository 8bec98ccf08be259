#include "marks.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "names.hpp"
#include "outline.hpp"
#include "voile/errors.hpp"

namespace voile::pattern {

namespace {

/// In sizes of cells: nearer to an edge, or to another mark, triangles would be slivers.
constexpr double least_distance = 0.2;

double distance_to(const std::vector<Vec2>& polygon, const Vec2& x) {
  double least = (x - polygon.front()).norm();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 &a = polygon[i], side = polygon[(i + 1) % polygon.size()] - a;
    const double s = side.squaredNorm() > 0.0 ? std::clamp((x - a).dot(side) / side.squaredNorm(), 0.0, 1.0) : 0.0;
    least = std::min(least, (x - a - s * side).norm());
  }
  return least;
}

[[noreturn]] void fail(const MarkRequest& r, const std::string& what) {
  throw UserError(fmt::format("{}: at = [{:g}, {:g}]: {}", r.where, r.at[0], r.at[1], what));
}

void check_inside(const MarkRequest& r, const Panel& panel) {
  const std::vector<Piece::Loop> loops = panel.piece.loops();
  double nearest = least_distance * panel.size;
  for (std::size_t k = 0; k < loops.size(); ++k) {
    std::vector<Curve> curves;
    for (std::size_t e = loops[k].begin; e < loops[k].end; ++e) curves.push_back(panel.piece.edges[e].curve);
    const std::vector<Vec2> polygon = polygon_of(curves);
    const bool is_outline = k == panel.piece.outline();
    if (is_inside(polygon, r.at) != is_outline) {
      const Extent e = extent_of(panel.piece);
      fail(r,
           fmt::format("it is {} '{}', which reaches from [{:.4g}, {:.4g}] to [{:.4g}, {:.4g}] m; give it in metres, "
                       "x to the right and y up, from the origin of the file",
                       is_outline ? "outside of piece" : "in a hole of piece", panel.piece.name, e.low[0], e.low[1],
                       e.high[0], e.high[1]));
    }
    nearest = std::min(nearest, distance_to(polygon, r.at));
  }
  if (nearest < least_distance * panel.size)
    fail(r, fmt::format("it is {:.2g} m from an edge of piece '{}', too near for cells of {:g} m; move it, make them "
                        "smaller, or name a point of the outline",
                        nearest, panel.piece.name, panel.size));
}

}  // namespace

std::vector<Mark> resolve_marks(const std::vector<Panel>& panels, const std::vector<MarkRequest>& requests) {
  std::vector<Mark> marks;
  for (const MarkRequest& r : requests) {
    Mark mark{r.name, 0, {}, r.at};
    if (r.point.empty()) {
      mark.panel = find_panel(panels, r.panel, r.where, r.panel);
      check_inside(r, panels[mark.panel]);
    } else {
      const auto [panel, point] = find_point(panels, r.where, r.point);
      mark.panel = panel;
      mark.point = point;
    }
    for (const Mark& other : marks) {
      if (other.name == mark.name) throw UserError(fmt::format("{}: another mark has this name", r.where));
      const double away = (other.at - mark.at).norm(), size = panels[mark.panel].size;
      if (!mark.point && !other.point && other.panel == mark.panel && away < least_distance * size)
        fail(r, fmt::format("it is {:.2g} m from mark '{}', too near for cells of {:g} m; move one of them", away,
                            other.name, size));
    }
    marks.push_back(std::move(mark));
  }
  return marks;
}

}  // namespace voile::pattern
