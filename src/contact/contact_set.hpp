// Barrier contact and lagged friction of everything that can touch, as terms of the potential.
//
// Symbols   d, c_i  distance of a pair and signed weights of its closest points (distance.hpp);  g = d - offset gap [m]
//           kappa   barrier stiffness [Pa];  A area of the pair [m^2];  m mollifier (barrier.hpp)
//   E = sum over pairs  kappa A m b(g)       + sum over planes and points  kappa A_i b(n.x_i - level)
// Friction is that of the start of the step: normal force N = kappa A m |b'|, weights c_i and tangents T stay as they
// are there, and with the slip s = |T^T sum_i c_i (x_i - x_i^start)|
//   D = sum mu N f0(s),   f0 = s - e/3 for s > e, else -s^3/(3 e^2) + s^2/e: Coulomb's force, smoothed below the slip
//   e.
// The barrier of a pair begins at dh, or nearer while a start is let out (set_reaches) and between neighbours
// (neighbours.hpp). A sheet point's area enters with half its size where the other side has points of its own. Nothing
// here communicates: every rank evaluates the pairs with an own point; energies count on the owner of the lowest sheet
// point. Source: Li et al. 2020 and 2021 (barrier.hpp), with area weights. Theory: docs/theory/contact.md (2).
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "candidates.hpp"
#include "contact_options.hpp"

namespace voile::contact {

/// A half-space that only points can touch: n.x >= level + offset.
struct Plane {
  int body = 0;
  Vec3 normal = Vec3::UnitZ();
  double level = 0.0;  ///< [m]
};

struct ContactState {
  long pairs = 0;                                        ///< within the activation distance
  double gap = std::numeric_limits<double>::infinity();  ///< smallest [m]
  Pair nearest{};                                        ///< one point only: with a plane, which is body_b
};

class ContactSet {
 public:
  /// `owned`: per sheet point, whether it is this rank's.
  ContactSet(Surface surface, std::vector<Plane> planes, ContactOptions options, std::vector<char> owned);

  [[nodiscard]] const Surface& surface() const { return *surface_; }
  [[nodiscard]] const ContactOptions& options() const { return options_; }
  std::vector<Plane>& planes() { return planes_; }
  [[nodiscard]] const std::vector<Plane>& planes() const { return planes_; }
  Rule& rule(int a, int b) { return surface_->rules[a][b]; }

  /// Makes the candidates hold for all positions between `from` and `to` and some way around (candidates.hpp); true if
  /// some were found anew. With peers collective.
  bool cover(const std::vector<Vec3>& from, const std::vector<Vec3>& to, Peers* peers = nullptr) {
    return candidates_.cover(from, to, peers);
  }
  [[nodiscard]] const Candidates& candidates() const { return candidates_; }

  /// Fraction of the displacements from `from` to `to` that this rank's pairs admit, planes staying where they are.
  [[nodiscard]] double step_fraction(const std::vector<Vec3>& from, const std::vector<Vec3>& to) const;
  /// Every candidate with a point in `asked` that may not go all of it or would lose more than half of its gap
  /// within the activation distance, while planes go to `planes_to`; a plane as a pair of its point alone.
  void blocked(const std::vector<Vec3>& from, const std::vector<Vec3>& to, const std::vector<Plane>& planes_to,
               const std::vector<char>& asked, const std::function<void(const Pair&)>& found) const;

  /// Takes normal forces and directions of friction from positions x, which are covered; slips count from `start`.
  /// `slip`: e [m].
  void lag_friction(const std::vector<Vec3>& x, const std::vector<Vec3>& start, double slip);
  [[nodiscard]] bool has_friction() const;
  /// Displacement since then of an obstacle's material at a place where it was then; none: its points move one by one.
  using Carrier = std::function<std::optional<Vec3>(int body, const Vec3& place)>;
  /// Takes over how far surfaces have been carried along, e.g. by a spin that moves no point. Where points move one by one from
  /// `start` to `now` their triangles tell how the way to the sheet turns.
  void carry(const Carrier& displacement, const std::vector<Vec3>& start, const std::vector<Vec3>& now);

  /// Barriers of pairs and planes with sheet point i begin at a gap of reach[i] at most [m]; empty: at the distance.
  void set_reaches(std::vector<double> reach) { reach_ = std::move(reach); }
  [[nodiscard]] const std::vector<double>& reaches() const { return reach_; }
  /// What passes through obstacles: bit k of `points` (per sheet point; empty: nothing) says that the point does not see the bodies
  /// with bit k in `bodies` (per body).
  void set_passing(std::vector<std::uint64_t> points, std::vector<std::uint64_t> bodies) {
    passing_ = std::move(points);
    passing_bits_ = std::move(bodies);
  }
  /// The smallest gap of each sheet point over this rank's pairs, or the activation distance if that is less. [m]
  [[nodiscard]] std::vector<double> smallest_gaps(const std::vector<Vec3>& x) const;
  /// The same up to any `limit`, over pairs found anew; positions of all points. [m]
  [[nodiscard]] std::vector<double> gaps_within(const std::vector<Vec3>& x, double limit) const;

  /// The last two are the normal forces on one face of the sheet: where it is pressed from both sides, they cancel.
  enum Part { normal = 1, friction = 2, both = 3, lower_face = 4, upper_face = 8 };
  /// Sum over the pairs this rank counts; infinite if one has no gap. [J]
  [[nodiscard]] double energy(const std::vector<Vec3>& x, Part part = both) const;
  /// What friction takes, sum of force times slip over the pairs this rank counts. [J]
  [[nodiscard]] double friction_work(const std::vector<Vec3>& x) const;
  /// Where all was at the start of a step.
  struct Then {
    const std::vector<Vec3>& places;
    std::vector<Plane> planes;
    std::vector<double> reaches;  ///< as set_reaches() takes them
  };
  /// Work of what moves points of obstacles, and planes, from where they were at the start, over the pairs this rank counts, with the
  /// mean of the normal forces at `start` and x, or those at x of what was not in contact before: what is hit takes the speed of
  /// the obstacle at once. [J]
  [[nodiscard]] double obstacle_work(const std::vector<Vec3>& x, const Then& start) const;
  /// Adds the derivative of the energy to f, per sheet point; right for own points only. [N] Returns the sum of the squares of
  /// all forces on own points, which do not cancel there. [N^2]
  double add_gradient(const std::vector<Vec3>& x, std::vector<Vec3>& f, Part part = both) const;
  /// Adds the force that the sheet exerts on each body, friction included, to `on`; of this rank's share. [N]
  void add_force_on_bodies(const std::vector<Vec3>& x, std::vector<Vec3>& on) const;
  /// Whether the friction of the present is known: it has been looked at, or there is none.
  [[nodiscard]] bool knows_friction() const { return lagged_ || !has_friction(); }
  /// Takes over how much each slip has changed since the last call with other positions; before hessian(x, true, ...).
  void follow_slips(const std::vector<Vec3>& x);
  /// Calls emit(point, point, block) for sheet points; `positive` drops negative eigenvalues pair by pair and takes
  /// the secant of friction where the slip has changed much since the last tangent. [N/m]
  template <class Emit>
  void hessian(const std::vector<Vec3>& x, bool positive, Emit&& emit) const;
  /// Of this rank's pairs.
  [[nodiscard]] ContactState state(const std::vector<Vec3>& x) const;
  /// Calls near(pair) for candidates with a gap below `limit`.
  template <class F>
  void for_near(const std::vector<Vec3>& x, double limit, F&& near) const;
  /// Pairs of the sheet with itself with a gap below `limit` at x, searched anew: what candidates hold beyond the contact
  /// distance depends on where the sheet has been.
  [[nodiscard]] std::vector<Pair> sheet_pairs_within(const std::vector<Vec3>& x, double limit) const;
  /// Calls f(points) for each pair with friction.
  template <class F>
  void for_sliding(F&& f) const {
    for (const Sliding& s : sliding_) f(s.points);
  }

 private:
  /// Friction of one pair or plane.
  struct Sliding {
    std::array<Index, 4> points;
    Vec4 c;
    Eigen::Matrix<double, 3, 2> tangents;
    double force;      ///< mu N [N]
    Vec3 start;        ///< sum of c_i x_i then
    Vec3 place, axis;  ///< contact point on the sheet, and that of the obstacle's points
    int carrier;       ///< the obstacle's body, or -1
    double weight;     ///< sum of the obstacle's c_i
    Index face;        ///< a triangle of the obstacle there; no_index: it has none
    Vec3 carried = Vec3::Zero();
    Vec2 slip = Vec2::Zero();  ///< at the last tangent
    double change = 0.0;       ///< of the slip between the last two tangents [m]
  };
  /// Of a slip, as a fraction of itself or of e, up to which the true second derivative is taken.
  static constexpr double trusted_change = 0.5;
  struct Near {
    std::array<Vec3, 4> x;
    Closest closest;
    double gap;
  };

  [[nodiscard]] std::array<Vec3, 4> gather(const Pair& pair, const std::vector<Vec3>& x) const {
    std::array<Vec3, 4> p;
    for (int i = 0; i < 4; ++i) p[i] = pair.points[i] == no_index ? Vec3(Vec3::Zero()) : x[pair.points[i]];
    return p;
  }
  [[nodiscard]] double offset(const Pair& p) const { return p.fraction * surface_->offset(p.body_a, p.body_b); }
  /// Gap at which the barrier of a pair, or of a point against a plane, begins. [m]
  [[nodiscard]] double reach(const Pair& p) const { return reach(p, reach_); }
  [[nodiscard]] double reach(const Pair& p, const std::vector<double>& reaches) const {
    double gap = p.fraction * options_.distance;
    if (reaches.empty()) return gap;
    for (Index i : p.points)
      if (i != no_index && surface_->is_sheet(i)) gap = std::min(gap, reaches[i]);
    return gap;
  }
  [[nodiscard]] double reach(Index point) const { return reach_.empty() ? options_.distance : reach_[point]; }
  [[nodiscard]] double plane_gap(const Plane& p, Index point, const std::vector<Vec3>& x) const {
    return p.normal.dot(x[point]) - p.level - surface_->offset(p.body, surface_->body_of_point[point]);
  }
  [[nodiscard]] bool plane_acts(const Plane& p, Index point) const {
    return surface_->rules[p.body][surface_->body_of_point[point]].touch &&
           (passing_.empty() || !(passing_[point] & passing_bits_[p.body]));
  }
  /// False if a point of the pair passes through the obstacle.
  [[nodiscard]] bool acts(const Pair& p) const {
    if (passing_.empty()) return true;
    const std::uint64_t bits = passing_bits_[p.body_a] | passing_bits_[p.body_b];
    return bits == 0 || std::none_of(p.points.begin(), p.points.end(), [&](Index i) {
             return i != no_index && surface_->is_sheet(i) && (passing_[i] & bits);
           });
  }
  /// A point and a plane, as a pair of the point alone.
  [[nodiscard]] Pair plane_pair(const Plane& p, Index point) const {
    return {{point, no_index, no_index, no_index}, PairKind::point_edge, surface_->body_of_point[point], p.body, 0, 0};
  }
  /// Smallest gaps over pairs; `as_barrier`: neighbours only where they feel each other.
  [[nodiscard]] std::vector<double> gaps_of(const std::vector<Pair>& pairs, const std::vector<Vec3>& x, double limit,
                                            bool as_barrier) const;
  [[nodiscard]] double barrier_energy(const std::vector<Vec3>& x) const;
  /// A triangle of an obstacle's point, or no_index.
  [[nodiscard]] Index face_of(Index point);
  /// f0' over the size of a slip y [1/m].
  [[nodiscard]] double friction_rate(double y) const {
    return y >= slip_ ? 1.0 / y : 2.0 / slip_ - y / (slip_ * slip_);
  }
  [[nodiscard]] bool counted(const std::array<Index, 4>& points) const;
  /// Derivatives of kappa A m b of one pair.
  void pair_gradient(const Pair& pair, const Near& n, double reach, Vec12& g) const;
  void pair_hessian(const Pair& pair, const Near& n, bool positive, Mat12& h) const;
  [[nodiscard]] Vec3 slip_of(const Sliding& s, const std::vector<Vec3>& x) const;
  /// Derivative of the friction force by the slip r over mu N, true or its secant. [1/m]
  [[nodiscard]] Mat2 friction_stiffness(const Vec2& r, bool secant) const;
  [[nodiscard]] bool near(const Pair& pair, const std::vector<Vec3>& x, double limit, Near& n) const {
    n.x = gather(pair, x);
    if (axis_distance(pair.kind, n.x) >= limit + offset(pair)) return false;  // most candidates
    if (!acts(pair)) return false;
    n.closest = closest(pair.kind, n.x);
    n.gap = n.closest.distance - offset(pair);
    return n.gap < limit;
  }
  void add_sliding(const Pair& pair, const Vec4& c, const Vec3& n, double normal_force, const std::vector<Vec3>& x,
                   const std::vector<Vec3>& start);

  std::unique_ptr<Surface> surface_;
  std::vector<Plane> planes_;
  ContactOptions options_;
  Candidates candidates_;
  std::vector<Sliding> sliding_;
  std::vector<double> reach_;
  std::vector<std::uint64_t> passing_, passing_bits_;
  std::vector<Index> face_of_point_;  ///< filled when first asked for
  double slip_ = 1.0;
  bool slips_known_ = false, lagged_ = false;
};

template <class F>
void ContactSet::for_near(const std::vector<Vec3>& x, double limit, F&& f) const {
  Near n;
  candidates_.for_close(x, limit, [&](const Pair& pair) {
    if (near(pair, x, limit, n)) f(pair);
  });
}

template <class Emit>
void ContactSet::hessian(const std::vector<Vec3>& x, bool positive, Emit&& emit) const {
  Near n;
  Mat12 h;
  candidates_.for_close(x, options_.distance, [&](const Pair& pair) {
    if (!near(pair, x, reach(pair), n)) return;
    pair_hessian(pair, n, positive, h);
    for (int i = 0; i < 4; ++i) {
      if (pair.points[i] == no_index || !surface_->is_sheet(pair.points[i])) continue;
      for (int j = 0; j < 4; ++j)
        if (pair.points[j] != no_index && surface_->is_sheet(pair.points[j]))
          emit(pair.points[i], pair.points[j], Mat3(h.template block<3, 3>(3 * i, 3 * j)));
    }
  });
  for (const Plane& p : planes_)
    for (Index i : candidates_.own_points()) {
      if (!plane_acts(p, i)) continue;
      const double g = plane_gap(p, i, x), d = reach(i);
      if (g < d)
        emit(i, i,
             Mat3(options_.stiffness * surface_->area[i] * barrier(g, d).second * p.normal * p.normal.transpose()));
    }
  for (const Sliding& s : sliding_) {
    const Vec2 r = s.tangents.transpose() * slip_of(s, x);
    const bool secant = positive && s.change > trusted_change * std::max(slip_, r.norm());
    const Mat3 block = s.force * s.tangents * friction_stiffness(r, secant) * s.tangents.transpose();
    for (int i = 0; i < 4; ++i) {
      if (s.points[i] == no_index || !surface_->is_sheet(s.points[i])) continue;
      for (int j = 0; j < 4; ++j)
        if (s.points[j] != no_index && surface_->is_sheet(s.points[j]))
          emit(s.points[i], s.points[j], Mat3(s.c[i] * s.c[j] * block));
    }
  }
}

}  // namespace voile::contact
