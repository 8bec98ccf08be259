#include "broad_phase.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace voile::contact {

namespace {

/// Boxes that span more cells than this are not sorted in but tried against everything.
constexpr double most_cells = 512.0;

/// Decides whether two figures make a pair, and makes it. Numbers of figures are points, edges or faces.
class Maker {
 public:
  Maker(const Surface& s, const std::vector<Box>& boxes, const std::vector<char>& owned, double distance)
      : s_(s), boxes_(boxes), owned_(owned), distance_(distance) {}

  void point_face(Index p, Index f, std::vector<Pair>& to) const {
    const Face& face = s_.faces[f];
    const auto& q = face.points;
    if (s_.same(p, q[0]) || s_.same(p, q[1]) || s_.same(p, q[2])) return;
    const int body = s_.body_of_point[p];
    if (!wanted(body, face.body, mine(p) || mine(q[0]) || mine(q[1]) || mine(q[2]))) return;
    const Box face_box = hull(q);
    if (!boxes_[p].within(face_box, reach(body, face.body))) return;
    // Of the two sides of a contact each counts half; where one has no area of its own the other counts in full.
    const double area = s_.is_sheet(p)      ? 0.5 * s_.area[p]
                        : s_.area[p] == 0.0 ? s_.face_area[f]
                                            : 0.5 * std::min(s_.area[p], s_.face_area[f]);
    const std::array<Index, 4> points{p, q[0], q[1], q[2]};
    if (!may_meet(PairKind::point_triangle, points, reach(body, face.body))) return;
    to.push_back(
        {points, PairKind::point_triangle, body, face.body, area, 0.0, fraction_of(s_.neighbours.of_faces, points)});
  }
  void point_edge(Index p, Index e, std::vector<Pair>& to) const {
    const Edge& edge = s_.edges[e];
    const int body = s_.body_of_point[p];
    if (!edge.bare || !s_.is_sheet(p) || !wanted(body, edge.body, mine(p))) return;
    if (!boxes_[p].within(hull(edge.points), reach(body, edge.body))) return;
    to.push_back(
        {{p, edge.points[0], edge.points[1], no_index}, PairKind::point_edge, body, edge.body, s_.area[p], 0.0});
  }
  void edge_edge(Index e, Index f, std::vector<Pair>& to) const {
    if (e > f) std::swap(e, f);
    const Edge &a = s_.edges[e], &b = s_.edges[f];
    const auto &p = a.points, &q = b.points;
    if (s_.same(p[0], q[0]) || s_.same(p[0], q[1]) || s_.same(p[1], q[0]) || s_.same(p[1], q[1])) return;
    if (!wanted(a.body, b.body, mine(p[0]) || mine(p[1]) || mine(q[0]) || mine(q[1]))) return;
    if (!hull(p).within(hull(q), reach(a.body, b.body))) return;
    // Two equal triangulations cross about 7.6 times per product of their edge lengths; an axis has no such length.
    const double lengths = b.bare ? a.rest_length_squared : std::sqrt(a.rest_length_squared * b.rest_length_squared);
    const std::array<Index, 4> points{p[0], p[1], q[0], q[1]};
    if (!may_meet(PairKind::edge_edge, points, reach(a.body, b.body))) return;
    to.push_back({points, PairKind::edge_edge, a.body, b.body, lengths / 8.0,
                  mollifier_threshold(a.rest_length_squared, b.rest_length_squared),
                  fraction_of(s_.neighbours.of_edges, points)});
  }
  template <std::size_t n>
  [[nodiscard]] Box hull(const std::array<Index, n>& points) const {
    Box b;
    for (Index p : points) b.include(boxes_[p]);
    return b;
  }

 private:
  [[nodiscard]] bool mine(Index p) const { return s_.is_sheet(p) && owned_[p]; }
  [[nodiscard]] bool wanted(int a, int b, bool owned) const { return owned && s_.rules[a][b].touch; }
  [[nodiscard]] double reach(int a, int b) const { return s_.offset(a, b) + distance_; }
  /// Figures that lie askew have hulls that overlap. They cannot meet if they are farther apart in the middle of their
  /// points' boxes than these go from there.
  [[nodiscard]] bool may_meet(PairKind kind, const std::array<Index, 4>& points, double reach) const {
    const int first = kind == PairKind::edge_edge ? 2 : 1;
    std::array<Vec3, 4> middle;
    double far[2] = {0.0, 0.0};
    for (int i = 0; i < 4; ++i) {
      const Box& b = boxes_[points[i]];
      middle[i] = 0.5 * (b.low + b.high);
      far[i >= first] = std::max(far[i >= first], (b.high - middle[i]).squaredNorm());
    }
    return distance(kind, middle) <= reach + (1.0 + 1e-9) * (std::sqrt(far[0]) + std::sqrt(far[1]));
  }
  [[nodiscard]] double fraction_of(const std::map<std::array<Index, 4>, double>& list,
                                   const std::array<Index, 4>& points) const {
    const std::vector<char>& concerned = s_.neighbours.concerned;
    if (concerned.empty() || !s_.is_sheet(points[0]) || !concerned[points[0]]) return 1.0;
    const auto at = list.find(points);
    return at == list.end() ? 1.0 : at->second;
  }

  const Surface& s_;
  const std::vector<Box>& boxes_;
  const std::vector<char>& owned_;
  double distance_;
};

/// Boxes sorted into the cells of a grid; find() calls back each stored box that shares a cell with the asked one once
/// per pair at most.
class Grid {
 public:
  Grid(double cell, const Box& domain) : cell_(cell), domain_(domain) {}

  void add(Index item, const Box& box) {
    if (!box.within(domain_, 0.0)) return;
    const auto [low, high] = cells(box);
    const Vec3 span = (high - low).cast<double>() + Vec3::Ones();
    if (span.prod() > most_cells) {
      large_.push_back(item);
      return;
    }
    for (int i = low[0]; i <= high[0]; ++i)
      for (int j = low[1]; j <= high[1]; ++j)
        for (int k = low[2]; k <= high[2]; ++k) entries_.push_back({key(i, j, k), item, low});
  }
  void sort() {
    std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) { return a.key < b.key; });
    std::size_t size = 16;
    while (size < 2 * entries_.size()) size *= 2;
    mask_ = size - 1;
    first_.assign(size, 0);
    for (std::size_t e = entries_.size(); e-- > 0;) {
      if (e > 0 && entries_[e - 1].key == entries_[e].key) continue;
      std::size_t at = hash(entries_[e].key);
      while (first_[at] != 0) at = (at + 1) & mask_;
      first_[at] = e + 1;
    }
  }
  template <class F>
  void find(const Box& box, F&& f) const {
    for (Index item : large_) f(item);
    const auto [low, high] = cells(box);
    for (int i = low[0]; i <= high[0]; ++i)
      for (int j = low[1]; j <= high[1]; ++j)
        for (int k = low[2]; k <= high[2]; ++k) {
          const std::uint64_t wanted = key(i, j, k);
          for (std::size_t e = start(wanted); e < entries_.size() && entries_[e].key == wanted; ++e) {
            // Both cover a block of cells: the pair is met in the lowest one they share.
            const Eigen::Vector3i shared = low.cwiseMax(entries_[e].low);
            if (shared[0] == i && shared[1] == j && shared[2] == k) f(entries_[e].item);
          }
        }
  }

 private:
  struct Entry {
    std::uint64_t key;
    Index item;
    Eigen::Vector3i low;
  };
  [[nodiscard]] std::pair<Eigen::Vector3i, Eigen::Vector3i> cells(const Box& box) const {
    const Vec3 low = box.low.cwiseMax(domain_.low), high = box.high.cwiseMin(domain_.high);
    return {place(low), place(high)};
  }
  [[nodiscard]] Eigen::Vector3i place(const Vec3& x) const {
    const Vec3 scaled = (x - domain_.low) / cell_;
    return scaled.array().floor().cast<int>();
  }
  static std::uint64_t key(int i, int j, int k) {
    return (static_cast<std::uint64_t>(i) << 42) | (static_cast<std::uint64_t>(j) << 21) |
           static_cast<std::uint64_t>(k);
  }
  [[nodiscard]] std::size_t hash(std::uint64_t k) const { return (k * 0x9E3779B97F4A7C15ull >> 20) & mask_; }
  [[nodiscard]] std::size_t start(std::uint64_t k) const {
    for (std::size_t at = hash(k); first_[at] != 0; at = (at + 1) & mask_)
      if (entries_[first_[at] - 1].key == k) return first_[at] - 1;
    return entries_.size();
  }

  double cell_;
  Box domain_;
  std::vector<Entry> entries_;
  std::vector<std::size_t> first_;  ///< open addressing: entry + 1, or 0
  std::size_t mask_ = 0;
  std::vector<Index> large_;
};

/// Bare points have rules of their own; points of an obstacle's file that no triangle uses are nothing.
bool used_point(const Surface& s, Index p) {
  return s.is_sheet(p) || s.area[p] > 0.0;
}

Box padded(Box b, double by) {
  b.low.array() -= by;
  b.high.array() += by;
  return b;
}

/// Searches the pairs with a point that is `asked`: figures that have one are sorted into grids, everything is looked
/// up.
class Search {
 public:
  Search(const Surface& s, const Figures& figures, const std::vector<Box>& boxes, const std::vector<char>& owned,
         double distance, const std::vector<char>& asked)
      : s_(s), in_(figures), boxes_(boxes), asked_(asked), make_(s, boxes, owned, distance), reach_(distance) {
    Box own, wanted;
    double size = 0.0;
    Index own_faces = 0;
    face_box_.reserve(in_.faces.size());
    for (Index f : in_.faces) {
      const Face& face = s.faces[f];
      reach_ = std::max(reach_, s.bodies[face.body].thickness + distance);
      const Box& box = face_box_.emplace_back(make_.hull(face.points));
      if (any_asked(face.points)) wanted.include(box);
      const auto mine = [&](Index p) { return s.is_sheet(p) && owned[p]; };
      if (!std::any_of(face.points.begin(), face.points.end(), mine)) continue;
      own.include(box);
      size += (box.high - box.low).maxCoeff();
      ++own_faces;
    }
    edge_box_.reserve(in_.edges.size());
    for (Index e : in_.edges) edge_box_.push_back(make_.hull(s.edges[e].points));
    // A pair has a figure in each hull, and they are within reach of each other.
    domain_.low = (own.low.cwiseMax(wanted.low)).array() - reach_;
    domain_.high = (own.high.cwiseMin(wanted.high)).array() + reach_;
    empty_ = own_faces == 0 || (domain_.low.array() > domain_.high.array()).any();
    if (!empty_) cell_ = std::max(size / own_faces + reach_, (domain_.high - domain_.low).maxCoeff() / 1e6);
  }

  std::vector<Pair> run() && {
    bare_figures();
    if (!empty_) {
      points_of_asked_faces();
      faces_of_asked_points();
      edges_of_asked_edges();
    }
    std::sort(pairs_.begin(), pairs_.end());
    return std::move(pairs_);
  }

 private:
  [[nodiscard]] bool is_asked(Index p) const { return asked_.empty() || asked_[p]; }
  template <std::size_t n>
  [[nodiscard]] bool any_asked(const std::array<Index, n>& points) const {
    return std::any_of(points.begin(), points.end(), [&](Index p) { return is_asked(p); });
  }
  /// They are few and may reach far (a ball's radius): tried against everything of this rank.
  void bare_figures() {
    for (Index p : s_.bare_points)
      for (Index f : in_.faces)
        if (f < s_.sheet_faces && (is_asked(p) || any_asked(s_.faces[f].points))) make_.point_face(p, f, pairs_);
    for (Index e = s_.sheet_edges; e < static_cast<Index>(s_.edges.size()); ++e) {
      if (!s_.edges[e].bare) continue;
      const bool asked = any_asked(s_.edges[e].points);
      for (Index f : in_.edges)
        if (f < s_.sheet_edges && (asked || any_asked(s_.edges[f].points))) make_.edge_edge(f, e, pairs_);
      for (Index p : in_.points)
        if (s_.is_sheet(p) && (asked || is_asked(p))) make_.point_edge(p, e, pairs_);
    }
  }
  void points_of_asked_faces() {
    Grid faces(cell_, domain_);
    for (std::size_t k = 0; k < in_.faces.size(); ++k)
      if (any_asked(s_.faces[in_.faces[k]].points)) faces.add(in_.faces[k], face_box_[k]);
    faces.sort();
    for (Index p : in_.points) {
      if (!used_point(s_, p) || !boxes_[p].within(domain_, 0.0)) continue;
      faces.find(padded(boxes_[p], reach_), [&](Index f) { point_face(p, f); });
    }
  }
  void faces_of_asked_points() {
    if (asked_.empty()) return;  // met above
    Grid points(cell_, domain_);
    for (Index p : in_.points)
      if (is_asked(p) && used_point(s_, p)) points.add(p, boxes_[p]);
    points.sort();
    for (std::size_t k = 0; k < in_.faces.size(); ++k) {
      const Index f = in_.faces[k];
      if (any_asked(s_.faces[f].points) || !face_box_[k].within(domain_, 0.0)) continue;
      points.find(padded(face_box_[k], reach_), [&](Index p) { point_face(p, f); });
    }
  }
  void edges_of_asked_edges() {
    Grid edges(cell_, domain_);
    for (std::size_t k = 0; k < in_.edges.size(); ++k) {
      const Edge& edge = s_.edges[in_.edges[k]];
      if (!edge.bare && any_asked(edge.points)) edges.add(in_.edges[k], edge_box_[k]);
    }
    edges.sort();
    for (std::size_t k = 0; k < in_.edges.size(); ++k) {
      const Index e = in_.edges[k];
      const bool asked = any_asked(s_.edges[e].points);  // then both edges of a pair may find each other
      if (s_.edges[e].bare || (asked && e >= s_.sheet_edges) || !edge_box_[k].within(domain_, 0.0)) continue;
      edges.find(padded(edge_box_[k], reach_), [&](Index f) {
        if (asked ? f > e : e < s_.sheet_edges || f < s_.sheet_edges) make_.edge_edge(e, f, pairs_);
      });
    }
  }
  void point_face(Index p, Index f) {
    if (s_.is_sheet(p) || f < s_.sheet_faces) make_.point_face(p, f, pairs_);
  }

  const Surface& s_;
  const Figures& in_;
  const std::vector<Box>& boxes_;
  const std::vector<char>& asked_;
  Maker make_;
  double reach_, cell_ = 0.0;
  std::vector<Box> face_box_, edge_box_;  ///< of the figures
  Box domain_;
  bool empty_ = false;
  std::vector<Pair> pairs_;
};

}  // namespace

Figures all_figures(const Surface& s) {
  Figures all{std::vector<Index>(s.rest.size()), std::vector<Index>(s.edges.size()),
              std::vector<Index>(s.faces.size())};
  for (std::vector<Index>* list : {&all.points, &all.edges, &all.faces}) std::iota(list->begin(), list->end(), 0);
  return all;
}

std::vector<Pair> find_pairs(const Surface& s, const Figures& figures, const std::vector<Box>& boxes,
                             const std::vector<char>& owned, double distance, const std::vector<char>& asked) {
  return Search(s, figures, boxes, owned, distance, asked).run();
}

std::vector<Pair> find_pairs_by_force(const Surface& s, const std::vector<Box>& boxes, const std::vector<char>& owned,
                                      double distance) {
  const Maker make(s, boxes, owned, distance);
  std::vector<Pair> pairs;
  for (Index p : s.bare_points)
    for (Index f = 0; f < s.sheet_faces; ++f) make.point_face(p, f, pairs);
  for (Index p = 0; p < s.points(); ++p)
    for (Index f = 0; used_point(s, p) && f < static_cast<Index>(s.faces.size()); ++f)
      if (s.is_sheet(p) || f < s.sheet_faces) make.point_face(p, f, pairs);
  for (Index e = 0; e < s.sheet_edges; ++e)
    for (Index f = e + 1; f < static_cast<Index>(s.edges.size()); ++f) make.edge_edge(e, f, pairs);
  for (Index e = s.sheet_edges; e < static_cast<Index>(s.edges.size()); ++e)
    for (Index p = 0; p < s.sheet_points; ++p) make.point_edge(p, e, pairs);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace voile::contact
