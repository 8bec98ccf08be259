// How far contact lets a step go, and predictors that begin where nothing is hit.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>

#include "voile/base/mpi.hpp"
#include "voile/system/contact.hpp"

namespace voile::system {

namespace {

using contact::Pair;
using contact::Plane;

/// Rounds in which colliding parts are made to move together.
constexpr int most_rounds = 30;
/// Of these, the last ones, which tell what is pinched.
constexpr int last_rounds = 4;

}  // namespace

double Contact::step_fraction(Vec a, Vec da) {
  const petsc::EventScope scope(petsc::events().contact_clear);
  locate(a, x_);
  other_ = x_;
  VOILE_PETSC(VecWAXPY(change_, 1.0, a, da));
  locate(change_, other_);
  cover(x_, other_);
  return -mpi::max(comm_, -set_->step_fraction(x_, other_));
}

Vec3 Contact::common_motion(const Pair& pair, const std::vector<Plane>& planes,
                            const std::vector<Plane>& planes_end) const {
  if (pair.points[1] == no_index) {  // of a point and a plane
    for (std::size_t k = 0; k < planes.size(); ++k)
      if (planes[k].body == pair.body_b) return (planes_end[k].level - planes[k].level) * planes[k].normal;
  }
  const contact::Surface& s = set_->surface();
  Vec3 leading = Vec3::Zero(), all = Vec3::Zero();
  int leaders = 0, points = 0;
  for (Index p : pair.points) {
    if (p == no_index) continue;
    const Vec3 move = other_[p] - x_[p];
    all += move;
    ++points;
    if (s.is_sheet(p) && !dofs_->is_held(p)) continue;
    leading += move;
    ++leaders;
  }
  return leaders > 0 ? Vec3(leading / leaders) : Vec3(all / points);
}

bool Contact::try_clear(Vec from, double t0, Vec to, double t1) {
  const petsc::EventScope scope(petsc::events().contact_clear);
  set_time(t0);
  locate(from, x_);
  other_ = x_;
  const std::vector<Plane> planes = set_->planes();
  std::vector<Plane> planes_end = planes;
  obstacles_->place(held_.value_or(t1), other_, planes_end);
  locate(to, other_);
  bool clear = false;
  std::vector<char> asked(x_.size(), 1);  // a pair found clear stays so until one of its points is moved
  for (int round = 0; round < most_rounds && !clear; ++round) {
    if (cover(x_, other_)) asked.assign(x_.size(), 1);
    set_->planes() = planes;
    // What two obstacles pinch is thrown from one to the other, round by round.
    if (round <= most_rounds - last_rounds && obstacles_->any_yields()) blocked_.assign(force_.size(), 0.0);
    const std::vector<Motion> motions = blocked_motions(planes, planes_end, asked);
    clear = obstruction_.empty();
    if (clear) break;
    move_along(motions, to);
    const std::vector<Vec3> before = other_;
    locate(to, other_);
    for (Index p : set_->candidates().seen()) asked[p] = other_[p] != before[p];
    for (const Motion& m : motions) asked[m.point] = 1;  // what was hit may not have moved
  }
  set_time(t1);
  return clear;
}

std::vector<Contact::Motion> Contact::blocked_motions(const std::vector<Plane>& planes,
                                                      const std::vector<Plane>& planes_end,
                                                      const std::vector<char>& asked) {
  std::vector<Motion> motions;
  std::string hit;
  set_->blocked(x_, other_, planes_end, asked, [&](const Pair& pair) {
    if (hit.empty()) hit = words(pair);
    note_blocked(pair);
    const Vec3 common = common_motion(pair, planes, planes_end);
    for (Index p : pair.points)
      if (p != no_index && set_->surface().is_sheet(p)) motions.push_back({p, common});
  });
  obstruction_ = lowest_rank_text(hit);
  std::stable_sort(motions.begin(), motions.end(), [](const Motion& a, const Motion& b) { return a.point < b.point; });
  return motions;
}

/// Each rank speaks for its own vertices, which move by the mean of what their pairs ask for.
void Contact::move_along(const std::vector<Motion>& motions, Vec to) const {
  const petsc::WriteArray out(to);
  for (std::size_t k = 0; k < motions.size();) {
    const Index v = motions[k].point, i = partition_->row_of[v] - first_row_;
    Vec3 sum = Vec3::Zero();
    double count = 0.0;
    for (; k < motions.size() && motions[k].point == v; ++k) {
      sum += motions[k].way;
      count += 1.0;
    }
    if (i >= 0 && i < row_count_) dofs_->place_vertex(i, x_[v] + sum / count, out);
  }
}

// ---- reports -------------------------------------------------------------------------------------------------------

std::string Contact::words(const Pair& pair) const {
  const contact::Surface& s = set_->surface();
  const std::string &a = s.bodies[pair.body_a].name, &b = s.bodies[pair.body_b].name;
  const Vec3& x = x_[pair.points[0]];
  return fmt::format("{} against {} near ({:.4g}, {:.4g}, {:.4g})", a, b, x[0], x[1], x[2]);
}

std::string Contact::lowest_rank_text(const std::string& own) const {
  const int size = mpi::size(comm_), rank = mpi::rank(comm_);
  const double lowest = -mpi::max(comm_, own.empty() ? -size : -rank);
  if (static_cast<int>(lowest) == size) return "";
  std::string text = own;
  mpi::broadcast_from(comm_, static_cast<int>(lowest), text);
  return text;
}

}  // namespace voile::system
