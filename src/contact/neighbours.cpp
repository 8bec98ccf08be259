#include "neighbours.hpp"

#include <algorithm>
#include <vector>

#include "distance.hpp"

namespace voile::contact {

namespace {

/// Which sheet figures have each sheet point.
template <class Figure>
std::vector<std::vector<Index>> around_points(const Surface& s, const std::vector<Figure>& figures, Index count) {
  std::vector<std::vector<Index>> around(static_cast<std::size_t>(s.sheet_points));
  for (Index f = 0; f < count; ++f)
    for (Index p : figures[f].points) around[p].push_back(f);
  return around;
}

template <std::size_t n>
bool holds(const std::array<Index, n>& points, Index p) {
  return std::find(points.begin(), points.end(), p) != points.end();
}

/// Walks over figures joined by common points, from those in `queue`, as long as `admit(figure)` says so.
template <class Figure, class Admit>
void walk(const std::vector<Figure>& figures, const std::vector<std::vector<Index>>& around, std::vector<Index> queue,
          std::vector<Index>& visit, Index mark, const Admit& admit) {
  for (Index f : queue) visit[f] = mark;
  while (!queue.empty()) {
    const Index at = queue.back();
    queue.pop_back();
    for (Index p : figures[at].points)
      for (Index f : around[p]) {
        if (visit[f] == mark) continue;
        visit[f] = mark;
        if (admit(f)) queue.push_back(f);
      }
  }
}

/// How much further chains lead beside joints: two sheets at an angle of 2 asin(1 / (2 wedge)), 7 degrees, are still found.
constexpr double wedge = 8.0;

class Finder {
 public:
  Finder(const Surface& s, double distance) : s_(s), distance_(distance) {}

  Neighbours run() {
    find_wedges();
    of_points();
    of_edges();
    if (found_.of_faces.empty() && found_.of_edges.empty()) found_.concerned.clear();
    return std::move(found_);
  }

 private:
  [[nodiscard]] double needed(int a, int b) const { return s_.offset(a, b) + distance_; }
  /// Notes a pair that is nearer than it should.
  void note(std::map<std::array<Index, 4>, double>& list, const std::array<Index, 4>& points, double rest,
            double reach) {
    if (!(room_between_neighbours * rest < reach) || !(rest > 0.0)) return;
    list[points] = room_between_neighbours * rest / reach;
    for (Index p : points) found_.concerned[p] = 1;
  }
  /// Whether a chain may lead so far from what it begins at: figures beside a joint are neighbours across it, however acute it is.
  [[nodiscard]] bool leads(Index point, double rest, double reach) const {
    return room_between_neighbours * rest < (in_wedge_[point] ? wedge : 1.0) * reach;
  }
  /// Marks the points beside edges of three faces and more.
  void find_wedges() {
    in_wedge_.assign(static_cast<std::size_t>(s_.sheet_points), 0);
    std::vector<std::array<Index, 2>> sides;
    double thickest = 0.0;
    for (Index f = 0; f < s_.sheet_faces; ++f) {
      thickest = std::max(thickest, s_.bodies[s_.faces[f].body].thickness);
      for (std::size_t k = 0; k < 3; ++k) {
        const Index p = s_.faces[f].points[k], q = s_.faces[f].points[(k + 1) % 3];
        sides.push_back({std::min(p, q), std::max(p, q)});
      }
    }
    std::sort(sides.begin(), sides.end());
    std::vector<Index> joints;
    for (std::size_t i = 2; i < sides.size(); ++i)
      if (sides[i] == sides[i - 2]) joints.insert(joints.end(), sides[i].begin(), sides[i].end());
    if (joints.empty()) return;
    std::sort(joints.begin(), joints.end());
    joints.erase(std::unique(joints.begin(), joints.end()), joints.end());
    const auto around = around_points(s_, s_.faces, s_.sheet_faces);
    std::vector<Index> visit(static_cast<std::size_t>(s_.sheet_faces), no_index);
    const double far = wedge * (thickest + distance_) / room_between_neighbours;
    const auto mark = [&](const std::array<Index, 3>& corners) {
      for (const Index corner : corners) in_wedge_[corner] = 1;
    };
    for (const Index p : joints) {
      for (const Index f : around[p]) mark(s_.faces[f].points);
      walk(s_.faces, around, around[p], visit, p, [&](Index f) {
        const auto& q = s_.faces[f].points;
        mark(q);
        return point_triangle({s_.rest[p], s_.rest[q[0]], s_.rest[q[1]], s_.rest[q[2]]}).distance < far;
      });
    }
  }
  void of_points() {
    found_.concerned.assign(static_cast<std::size_t>(s_.sheet_points), 0);
    const auto around = around_points(s_, s_.faces, s_.sheet_faces);
    std::vector<Index> visit(static_cast<std::size_t>(s_.sheet_faces), no_index);
    for (Index p = 0; p < s_.sheet_points; ++p)
      walk(s_.faces, around, around[p], visit, p, [&](Index f) {
        const auto& q = s_.faces[f].points;
        const double rest = point_triangle({s_.rest[p], s_.rest[q[0]], s_.rest[q[1]], s_.rest[q[2]]}).distance;
        const double reach = needed(s_.body_of_point[p], s_.faces[f].body);
        note(found_.of_faces, {p, q[0], q[1], q[2]}, rest, reach);
        return leads(p, rest, reach);
      });
  }
  void of_edges() {
    const auto around = around_points(s_, s_.edges, s_.sheet_edges);
    std::vector<Index> visit(static_cast<std::size_t>(s_.sheet_edges), no_index);
    for (Index e = 0; e < s_.sheet_edges; ++e)
      walk(s_.edges, around, {e}, visit, e, [&](Index f) {
        const auto &p = s_.edges[e].points, &q = s_.edges[f].points;
        if (holds(q, p[0]) || holds(q, p[1])) return true;
        const double rest = edge_edge({s_.rest[p[0]], s_.rest[p[1]], s_.rest[q[0]], s_.rest[q[1]]}).distance;
        const double reach = needed(s_.edges[e].body, s_.edges[f].body);
        if (f > e) note(found_.of_edges, {p[0], p[1], q[0], q[1]}, rest, reach);  // else found from the other side
        return leads(p[0], rest, reach);
      });
  }

  const Surface& s_;
  double distance_;
  std::vector<char> in_wedge_;  ///< per sheet point
  Neighbours found_;
};

}  // namespace

Neighbours find_neighbours(const Surface& surface, double activation_distance) {
  return Finder(surface, activation_distance).run();
}

}  // namespace voile::contact
