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
  fill_positions(a, x_);
  other_ = x_;
  fill_positions(da, other_);
  for (Index v = 0; v < mesh_->vertex_count(); ++v) other_[v] += x_[v] - mesh_->positions()[v];
  cover(x_, other_);
  return -mpi::max(comm_, -set_->step_fraction(x_, other_));
}

Vec3 Contact::common_motion(const Pair& pair, const std::vector<Vec3>& start, const std::vector<Vec3>& end,
                            const std::vector<Plane>& planes, const std::vector<Plane>& planes_end) const {
  if (pair.points[1] == no_index) {  // of a point and a plane
    for (std::size_t k = 0; k < planes.size(); ++k)
      if (planes[k].body == pair.body_b) return (planes_end[k].level - planes[k].level) * planes[k].normal;
  }
  const contact::Surface& s = set_->surface();
  Vec3 leading = Vec3::Zero(), all = Vec3::Zero();
  int leaders = 0, points = 0;
  for (Index p : pair.points) {
    if (p == no_index) continue;
    const Vec3 move = end[p] - start[p];
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
  fill_positions(from, x_);
  const std::vector<Vec3> start = x_;
  std::vector<Vec3> end = x_;
  const std::vector<Plane> planes = set_->planes();
  std::vector<Plane> planes_end = planes;
  obstacles_->place(held_.value_or(t1), end, planes_end);
  fill_positions(to, end);
  const contact::Surface& s = set_->surface();
  bool clear = false;
  std::vector<char> asked(end.size(), 1);  // a pair found clear stays so until one of its points is moved
  for (int round = 0; round < most_rounds && !clear; ++round) {
    cover(start, end);
    std::vector<Vec3> sum(force_.size(), Vec3::Zero());
    std::vector<double> count(force_.size(), 0.0);
    std::string hit;
    set_->planes() = planes;
    // What two obstacles pinch is thrown from one to the other, round by round.
    if (round <= most_rounds - last_rounds) blocked_.assign(force_.size(), 0.0);
    set_->blocked(start, end, planes_end, asked, [&](const Pair& pair) {
      if (hit.empty()) hit = words(pair);
      note_blocked(pair);
      const Vec3 common = common_motion(pair, start, end, planes, planes_end);
      for (Index p : pair.points)
        if (p != no_index && s.is_sheet(p)) {
          sum[p] += common;
          count[p] += 1.0;
        }
    });
    obstruction_ = lowest_rank_text(hit);
    clear = obstruction_.empty();
    if (clear) break;
    // Each rank speaks for its own vertices.
    {
      const petsc::WriteArray out(to);
      for (Index i = 0; i < row_count_; ++i) {
        const Index v = partition_->vertex_of[first_row_ + i];
        if (count[v] > 0.0) dofs_->place_vertex(i, start[v] + sum[v] / count[v], out);
      }
    }
    const std::vector<Vec3> before = end;
    fill_positions(to, end);
    for (std::size_t p = 0; p < end.size(); ++p)
      asked[p] = end[p] != before[p] || (p < count.size() && count[p] > 0.0);  // what was hit may not have moved
  }
  set_time(t1);
  return clear;
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
