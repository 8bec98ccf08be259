#include "candidates.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace voile::contact {

namespace {

/// Room that the boxes of candidates leave around the asked path: in activation distances, and in what a cell is larger than
/// one. Where two such rooms and the activation distance are longer than a cell, rings of neighbours become candidates.
constexpr double slack = 2.0, slack_in_cell = 0.4, least_slack = 0.1;
/// Candidates are found anew only for points that left their boxes, unless these are more than this fraction, or boxes of
/// earlier, longer paths are on average longer than needed now by this fraction of the room.
constexpr double most_left = 0.3, most_excess = 0.5;
/// Gaps that the list of near pairs answers for, and how far it lets points go before it is renewed, in activation distances.
constexpr double listed = 1.0, room_in_list = 1.0;
/// Trajectories longer than so many edges on the mean are looked at in parts of one edge, of which there are at most so many.
constexpr double long_trajectory = 2.0, most_parts = 64.0;
/// Boxes that hold the faces of a rank are halved so often: a few follow a bent sheet much closer than one.
constexpr int halvings = 4;

void make_ascending(std::vector<Index>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

/// Which of the first `count` figures hold each point: those of point p are of[from[p]] to of[from[p + 1] - 1].
template <class Figure>
void list_by_point(const std::vector<Figure>& figures, Index count, Index points, std::vector<Index>& from,
                   std::vector<Index>& of) {
  from.assign(static_cast<std::size_t>(points) + 1, 0);
  for (Index f = 0; f < count; ++f)
    for (Index p : figures[f].points) ++from[p + 1];
  std::partial_sum(from.begin(), from.end(), from.begin());
  of.resize(static_cast<std::size_t>(from.back()));
  std::vector<Index> next(from.begin(), from.end() - 1);
  for (Index f = 0; f < count; ++f)
    for (Index p : figures[f].points) of[next[p]++] = f;
}

/// Halves a range of boxes along the longest side of their hull, `depth` times, and adds the hulls of the parts.
template <class Iterator>
void add_hulls(Iterator begin, Iterator end, int depth, std::vector<Box>& hulls) {
  if (begin == end) return;
  Box hull;
  std::for_each(begin, end, [&](const Box& b) { hull.include(b); });
  if (depth == 0 || end - begin == 1) {
    hulls.push_back(hull);
    return;
  }
  Eigen::Index longest = 0;
  (hull.high - hull.low).maxCoeff(&longest);
  const Iterator middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [&](const Box& a, const Box& b) {
    return a.low[longest] + a.high[longest] < b.low[longest] + b.high[longest];
  });
  add_hulls(begin, middle, depth - 1, hulls);
  add_hulls(middle, end, depth - 1, hulls);
}

}  // namespace

Candidates::Candidates(const Surface& surface, double activation_distance, std::vector<char> owned)
    : surface_(&surface),
      distance_(activation_distance),
      reach_(activation_distance),
      mean_edge_(mean_edge(surface)),
      owned_(std::move(owned)),
      list_(listed * activation_distance, room_in_list * activation_distance) {
  const Surface& s = surface;
  for (const Face& f : s.faces) reach_ = std::max(reach_, s.bodies[f.body].thickness + activation_distance);
  for (Index i = 0; i < s.sheet_points; ++i)
    if (owned_[i]) own_points_.push_back(i);
  for (Index i = s.sheet_points; i < s.points(); ++i) obstacle_points_.push_back(i);
  list_by_point(s.faces, s.sheet_faces, s.sheet_points, faces_from_, faces_of_);
  list_by_point(s.edges, s.sheet_edges, s.sheet_points, edges_from_, edges_of_);
  for (Index i : own_points_)
    for (Index k = faces_from_[i]; k < faces_from_[i + 1]; ++k) own_faces_.push_back(faces_of_[k]);
  make_ascending(own_faces_);
  is_seen_.assign(s.rest.size(), 0);
  renewed_.assign(s.rest.size(), 0);
  unchanged_.assign(s.rest.size(), 0);
  boxes_.resize(s.rest.size());
  select_sheet();
}

// ---- boxes ---------------------------------------------------------------------------------------------------------

/// What rests needs no room.
double Candidates::room(Index i, const std::vector<Vec3>& from, const std::vector<Vec3>& to) const {
  if (!surface_->is_sheet(i) && from[i] == to[i]) return 0.0;
  const double cell = std::sqrt(surface_->area[i]), wanted = slack * distance_;
  if (cell == 0.0) return wanted;
  return std::min(wanted, std::max(least_slack * cell, slack_in_cell * (cell - distance_)));
}

Departure Candidates::departure(const std::vector<Index>& points, const std::vector<Vec3>& from,
                                const std::vector<Vec3>& to) {
  Departure d;
  d.points = static_cast<double>(points.size());
  for (Index i : points) {
    const bool inside = begun_ && boxes_[i].contains(from[i]) && boxes_[i].contains(to[i]);
    renewed_[i] = !inside;
    if (!inside) d.left += 1.0;
    d.displacement += (to[i] - from[i]).norm();
    if (!begun_) continue;
    const double wanted = 6.0 * room(i, from, to);
    d.excess += (boxes_[i].high - boxes_[i].low).sum() - wanted - (to[i] - from[i]).lpNorm<1>();
    d.room += wanted;
  }
  return d;
}

void Candidates::renew_boxes(const std::vector<Index>& points, const std::vector<Vec3>& from,
                             const std::vector<Vec3>& to) {
  for (Index i : points) {
    if (!renewed_[i]) continue;
    boxes_[i] = Box{};
    boxes_[i].include(from[i]);
    boxes_[i].include(to[i]);
    boxes_[i].low.array() -= room(i, from, to);
    boxes_[i].high.array() += room(i, from, to);
  }
}

std::vector<Box> Candidates::region() const {
  std::vector<Box> faces;
  faces.reserve(own_faces_.size());
  for (Index f : own_faces_) faces.push_back(hull(surface_->faces[f].points));
  std::vector<Box> parts;
  add_hulls(faces.begin(), faces.end(), halvings, parts);
  for (Box& b : parts) {
    b.low.array() -= reach_;
    b.high.array() += reach_;
  }
  return parts;
}

std::vector<Index> Candidates::points_within(const std::vector<Box>& region) const {
  std::vector<Index> points;
  Box all;
  for (const Box& b : region) all.include(b);
  for (Index f : own_faces_) {
    const auto& corners = surface_->faces[f].points;
    const Box box = hull(corners);
    if (!box.within(all, 0.0)) continue;
    if (std::none_of(region.begin(), region.end(), [&](const Box& b) { return box.within(b, 0.0); })) continue;
    for (Index p : corners)
      if (owned_[p]) points.push_back(p);
  }
  make_ascending(points);
  return points;
}

// ---- what is seen --------------------------------------------------------------------------------------------------

void Candidates::select_obstacles() {
  const Surface& s = *surface_;
  const std::vector<Box> near = region();
  Box all;
  for (const Box& b : near) all.include(b);
  const auto is_near = [&](const Box& box) {
    return box.within(all, 0.0) &&
           std::any_of(near.begin(), near.end(), [&](const Box& b) { return box.within(b, 0.0); });
  };
  for (Index f = s.sheet_faces; f < static_cast<Index>(s.faces.size()); ++f) {
    if (!is_near(hull(s.faces[f].points))) continue;
    seen_.faces.push_back(f);
    seen_.points.insert(seen_.points.end(), s.faces[f].points.begin(), s.faces[f].points.end());
  }
  for (Index e = s.sheet_edges; e < static_cast<Index>(s.edges.size()); ++e) {
    if (!s.edges[e].bare && !is_near(hull(s.edges[e].points))) continue;
    seen_.edges.push_back(e);
    seen_.points.insert(seen_.points.end(), s.edges[e].points.begin(), s.edges[e].points.end());
  }
  seen_.points.insert(seen_.points.end(), s.bare_points.begin(), s.bare_points.end());
}

void Candidates::see(std::vector<Index> ghosts) {
  if (ghosts == ghosts_) return;
  ghosts_ = std::move(ghosts);
  select_sheet();
}

void Candidates::select_sheet() {
  const Surface& s = *surface_;
  for (Index p : sheet_.points) is_seen_[p] = 0;
  sheet_.points = own_points_;
  sheet_.points.insert(sheet_.points.end(), ghosts_.begin(), ghosts_.end());
  for (Index p : sheet_.points) is_seen_[p] = 1;
  // A figure is seen with its last point.
  const auto add = [&](const auto& figures, const std::vector<Index>& from, const std::vector<Index>& of,
                       std::vector<Index>& list) {
    list.clear();
    for (Index p : sheet_.points)
      for (Index k = from[p]; k < from[p + 1]; ++k) {
        const auto& points = figures[of[k]].points;
        if (p != *std::max_element(points.begin(), points.end())) continue;
        if (std::all_of(points.begin(), points.end(), [&](Index q) { return is_seen_[q] != 0; })) list.push_back(of[k]);
      }
    std::sort(list.begin(), list.end());
  };
  add(s.faces, faces_from_, faces_of_, sheet_.faces);
  add(s.edges, edges_from_, edges_of_, sheet_.edges);
  std::sort(sheet_.points.begin(), sheet_.points.end());
}

void Candidates::select_figures() {
  seen_ = sheet_;
  const auto sheet = static_cast<std::ptrdiff_t>(seen_.points.size());
  select_obstacles();
  std::sort(seen_.points.begin() + sheet, seen_.points.end());  // all of them follow those of the sheet
  seen_.points.erase(std::unique(seen_.points.begin() + sheet, seen_.points.end()), seen_.points.end());
}

// ---- pairs ---------------------------------------------------------------------------------------------------------

bool Candidates::cover(const std::vector<Vec3>& from, const std::vector<Vec3>& to, Peers* peers) {
  Departure sheet = departure(own_points_, from, to);
  if (peers) sheet = peers->sum(sheet);
  const Departure obstacles = departure(obstacle_points_, from, to);
  const double left = sheet.left + obstacles.left;
  if (left == 0.0) {
    renew_list(from, to, &unchanged_);
    return false;
  }
  const int parts = parts_of_trajectory(sheet, obstacles);
  const bool whole = parts > 1 || left > most_left * (sheet.points + obstacles.points) ||
                     sheet.excess + obstacles.excess > most_excess * (sheet.room + obstacles.room);
  for (const std::vector<Index>* points : {&own_points_, &obstacle_points_}) {
    if (whole)
      for (Index i : *points) renewed_[i] = 1;
    renew_boxes(*points, from, to);
  }
  if (peers) peers->exchange(*this);
  select_figures();
  if (parts > 1)
    pairs_ = pairs_on_trajectory(from, to, parts);
  else if (whole)
    pairs_ = find_pairs(*surface_, seen_, boxes_, owned_, distance_);
  else
    renew_pairs();
  begun_ = parts == 1;
  renew_list(from, to, whole ? nullptr : &renewed_);
  return true;
}

int Candidates::parts_of_trajectory(const Departure& sheet, const Departure& obstacles) const {
  const double displacement =
      std::max(sheet.displacement / sheet.points, obstacles.displacement / std::max(obstacles.points, 1.0));
  return displacement > long_trajectory * mean_edge_
             ? static_cast<int>(std::min(std::ceil(displacement / mean_edge_), most_parts))
             : 1;
}

std::vector<Pair> Candidates::pairs_on_trajectory(const std::vector<Vec3>& from, const std::vector<Vec3>& to,
                                                  int parts) const {
  std::vector<Box> boxes(from.size());
  std::vector<Pair> all;
  for (int k = 0; k < parts; ++k) {
    for (Index i : seen_.points) {
      boxes[i] = Box{};
      for (const double s : {static_cast<double>(k) / parts, (k + 1.0) / parts})
        boxes[i].include(s < 1.0 ? Vec3(from[i] + s * (to[i] - from[i])) : to[i]);
    }
    const std::vector<Pair> found = find_pairs(*surface_, seen_, boxes, owned_, distance_);
    const auto before = static_cast<std::ptrdiff_t>(all.size());
    all.insert(all.end(), found.begin(), found.end());
    std::inplace_merge(all.begin(), all.begin() + before, all.end());
    all.erase(std::unique(all.begin(), all.end(), [](const Pair& a, const Pair& b) { return !(a < b) && !(b < a); }),
              all.end());
  }
  return all;
}

void Candidates::renew_pairs() {
  std::erase_if(pairs_, [&](const Pair& pair) {
    return std::any_of(pair.points.begin(), pair.points.end(), [&](Index p) { return p != no_index && renewed_[p]; });
  });
  const auto kept = static_cast<std::ptrdiff_t>(pairs_.size());
  const std::vector<Pair> found = find_pairs(*surface_, seen_, boxes_, owned_, distance_, renewed_);
  pairs_.insert(pairs_.end(), found.begin(), found.end());
  std::inplace_merge(pairs_.begin(), pairs_.begin() + kept, pairs_.end());
}

void Candidates::renew_list(const std::vector<Vec3>& from, const std::vector<Vec3>& to,
                            const std::vector<char>* changed) {
  list_.renew(pairs_, seen_.points, from, to, changed,
              [&](const Pair& pair) { return pair.fraction * surface_->offset(pair.body_a, pair.body_b); });
}

}  // namespace voile::contact
