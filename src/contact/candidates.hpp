// The pairs that can matter on one rank, kept while points move: boxes around where points can be, the pairs whose boxes
// come near each other, and of these the list of near ones.
//
// Symbols   B_i  box of point i: where it may be before candidates are asked for again
// Every rank knows the boxes of its own points and of those of other ranks (ghosts) whose triangles come near its own;
// obstacles are known to all, and looked at where they are near. Which points leave their boxes is decided from sums
// over all ranks, and each box is made by its owner, so that the pairs of all ranks together are those of one.
// Theory: docs/theory/contact.md, collision detection.
#pragma once

#include <array>
#include <vector>

#include "broad_phase.hpp"
#include "near_list.hpp"

namespace voile::contact {

/// How far points have outgrown their boxes.
struct Departure {
  double points = 0.0, left = 0.0;  ///< how many, and how many of them are outside
  double excess = 0.0;              ///< by how much boxes are larger than needed now [m]
  double room = 0.0;                ///< that they should have [m]
  double displacement = 0.0;        ///< sum of the displacements that are asked for [m]
};

class Candidates;

/// What ranks tell each other about their points.
class Peers {
 public:
  virtual ~Peers() = default;
  /// Over all ranks. Collective.
  [[nodiscard]] virtual Departure sum(const Departure& own) = 0;
  /// Has `candidates` see the ghosts that its rank needs now, with their boxes; among them are all points of triangles
  /// that hold an own point. Their positions become known. Collective.
  virtual void exchange(Candidates& candidates) = 0;
};

class Candidates {
 public:
  /// `owned`: per sheet point, whether it is this rank's. The surface must outlive it and stay as it is.
  Candidates(const Surface& surface, double activation_distance, std::vector<char> owned);

  /// Makes the candidates hold for all positions between `from` and `to` (all points; right are those of seen points and
  /// of obstacles) and some room around; true if some were found anew. Where points go far, boxes around their
  /// trajectories would all overlap: then candidates hold only as long as all go straight from `from` to `to` at the
  /// same time. `peers`: null for a rank that is alone; else collective.
  bool cover(const std::vector<Vec3>& from, const std::vector<Vec3>& to, Peers* peers);
  /// Those of the sheet that this rank sees.
  [[nodiscard]] const Figures& sheet() const { return sheet_; }
  [[nodiscard]] const std::vector<Pair>& pairs() const { return pairs_; }
  [[nodiscard]] const std::vector<char>& owned() const { return owned_; }
  [[nodiscard]] const std::vector<Index>& own_points() const { return own_points_; }
  /// Own points, ghosts and the points of obstacles that are near: all that pairs may hold, ascending.
  [[nodiscard]] const std::vector<Index>& seen() const { return seen_.points; }

  // For Peers, when boxes have been renewed
  /// Per point, right for own points, obstacles and ghosts; `renewed`: whether the box is a new one.
  std::vector<Box>& boxes() { return boxes_; }
  std::vector<char>& renewed() { return renewed_; }
  /// Boxes that together hold the own faces, enlarged by how near anything may come to them. The boxes of the own faces'
  /// points must be right.
  [[nodiscard]] std::vector<Box> region() const;
  /// Own points whose faces come into one of these boxes, ascending.
  [[nodiscard]] std::vector<Index> points_within(const std::vector<Box>& region) const;
  /// Points of the sheet that other ranks own and this one is to see from now on.
  void see(std::vector<Index> ghosts);

  /// Calls f(pair) for candidates, at least for those whose gap at x is below `limit`.
  template <class F>
  void for_close(const std::vector<Vec3>& x, double limit, F&& f) const {
    if (list_.made()) list_.measure(seen_.points, x, moves_);
    for_listed(limit, f);
  }
  /// The same for those whose gap may fall below `limit` between x and `to`.
  template <class F>
  void for_close(const std::vector<Vec3>& x, const std::vector<Vec3>& to, double limit, F&& f) const {
    if (list_.made()) list_.measure(seen_.points, x, to, moves_);
    for_listed(limit, f);
  }

 private:
  template <class F>
  void for_listed(double limit, F&& f) const {
    if (list_.holds(moves_, limit))
      list_.for_each(moves_, limit, f);
    else
      for (const Pair& pair : pairs_) f(pair);
  }
  [[nodiscard]] double room(Index i, const std::vector<Vec3>& from, const std::vector<Vec3>& to) const;
  /// Over points; those outside are noted in renewed_.
  [[nodiscard]] Departure departure(const std::vector<Index>& points, const std::vector<Vec3>& from,
                                    const std::vector<Vec3>& to);
  void renew_boxes(const std::vector<Index>& points, const std::vector<Vec3>& from, const std::vector<Vec3>& to);
  /// Of the sheet, what own points and ghosts hold.
  void select_sheet();
  void select_figures();
  void select_obstacles();
  /// In how many parts trajectories are looked at one after the other; 1: they are short.
  [[nodiscard]] int parts_of_trajectory(const Departure& sheet, const Departure& obstacles) const;
  /// The pairs that come near on straight trajectories.
  [[nodiscard]] std::vector<Pair> pairs_on_trajectory(const std::vector<Vec3>& from, const std::vector<Vec3>& to,
                                                      int parts) const;
  /// Finds the candidates anew that hold a point with a renewed box.
  void renew_pairs();
  /// Makes the list of near pairs answer again. `changed`: points whose pairs may be others; none: all.
  void renew_list(const std::vector<Vec3>& from, const std::vector<Vec3>& to, const std::vector<char>* changed);
  template <std::size_t n>
  [[nodiscard]] Box hull(const std::array<Index, n>& points) const {
    Box b;
    for (Index p : points) b.include(boxes_[p]);
    return b;
  }

  const Surface* surface_;
  double distance_, reach_;  ///< activation distance; how near figures must come to be a pair, at most [m]
  double mean_edge_;         ///< of the sheet [m]
  std::vector<char> owned_;
  std::vector<Index> own_points_, own_faces_;  ///< own faces hold an own point
  std::vector<Index> obstacle_points_;
  std::vector<Index> faces_from_, faces_of_, edges_from_, edges_of_;  ///< of each sheet point, one after another
  std::vector<Index> ghosts_;
  Figures sheet_, seen_;       ///< those of the sheet, and with obstacles
  std::vector<char> is_seen_;  ///< per point of the sheet
  std::vector<Box> boxes_;
  std::vector<char> renewed_, unchanged_;
  bool begun_ = false;  ///< boxes and pairs hold
  std::vector<Pair> pairs_;
  NearList list_;  ///< of pairs_
  mutable NearList::Moves moves_;
};

}  // namespace voile::contact
