#include "voile/contact/neighbours.hpp"

#include <algorithm>
#include <vector>

#include "voile/contact/distance.hpp"

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

class Finder {
 public:
  Finder(const Surface& s, double distance) : s_(s), distance_(distance) {}

  Neighbours run() {
    of_points();
    of_edges();
    if (found_.of_faces.empty() && found_.of_edges.empty()) found_.concerned.clear();
    return std::move(found_);
  }

 private:
  [[nodiscard]] double needed(int a, int b) const { return s_.offset(a, b) + distance_; }
  /// Notes a pair that is nearer than it should; true if so.
  bool note(std::map<std::array<Index, 4>, double>& list, const std::array<Index, 4>& points, double rest,
            double reach) {
    if (!(room_between_neighbours * rest < reach)) return false;
    if (rest > 0.0) {
      list[points] = room_between_neighbours * rest / reach;
      for (Index p : points) found_.concerned[p] = 1;
    }
    return true;
  }
  void of_points() {
    found_.concerned.assign(static_cast<std::size_t>(s_.sheet_points), 0);
    const auto around = around_points(s_, s_.faces, s_.sheet_faces);
    std::vector<Index> visit(static_cast<std::size_t>(s_.sheet_faces), no_index);
    for (Index p = 0; p < s_.sheet_points; ++p)
      walk(s_.faces, around, around[p], visit, p, [&](Index f) {
        const auto& q = s_.faces[f].points;
        const double rest = point_triangle({s_.rest[p], s_.rest[q[0]], s_.rest[q[1]], s_.rest[q[2]]}).distance;
        return note(found_.of_faces, {p, q[0], q[1], q[2]}, rest, needed(s_.body_of_point[p], s_.faces[f].body));
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
        if (f < e) return room_between_neighbours * rest < reach;  // found from the other side
        return note(found_.of_edges, {p[0], p[1], q[0], q[1]}, rest, reach);
      });
  }

  const Surface& s_;
  double distance_;
  Neighbours found_;
};

}  // namespace

Neighbours find_neighbours(const Surface& surface, double contact_distance) {
  return Finder(surface, contact_distance).run();
}

}  // namespace voile::contact
