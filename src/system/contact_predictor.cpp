// Predictors that begin where nothing is hit.
#include <algorithm>

#include "base/mpi.hpp"
#include "contact_parts.hpp"

namespace voile::system {

namespace {

using contact::Pair;
using contact::Plane;

/// Rounds in which colliding parts are made to move together.
constexpr int most_rounds = 30;
/// Of these, the last ones, which tell what is pinched.
constexpr int last_rounds = 4;

}  // namespace

PredictorTrajectory::PredictorTrajectory(ContactScene& scene, ContactMemory& memory, Vec from, double t0, Vec to,
                                         double t1)
    : scene_(scene), memory_(memory), from_(from), to_(to), t0_(t0), t1_(t1) {}

Vec3 PredictorTrajectory::common_motion(const Pair& pair) const {
  if (pair.points[1] == no_index) {  // of a point and a plane
    for (std::size_t k = 0; k < planes_.size(); ++k)
      if (planes_[k].body == pair.body_b) return (planes_end_[k].level - planes_[k].level) * planes_[k].normal;
  }
  const ContactScene::Points& points = scene_.points();
  Vec3 leading = Vec3::Zero(), all = Vec3::Zero();
  int leaders = 0, count = 0;
  for (Index p : pair.points) {
    if (p == no_index) continue;
    const Vec3 move = points.end[p] - points.now[p];
    all += move;
    ++count;
    if (scene_.set().surface().is_sheet(p) && !scene_.dofs().is_held(p)) continue;
    leading += move;
    ++leaders;
  }
  return leaders > 0 ? Vec3(leading / leaders) : Vec3(all / count);
}

bool PredictorTrajectory::clear() {
  const petsc::EventScope scope(petsc::events().contact_clear);
  std::vector<Vec3>&x = scene_.points().now, &end = scene_.points().end;
  set_time(scene_, memory_, t0_);
  scene_.locate(from_, x);
  end = x;
  planes_ = planes_end_ = scene_.set().planes();
  scene_.place_obstacles(t1_, end, planes_end_);
  scene_.locate(to_, end);
  bool clear = false;
  std::vector<char> asked(x.size(), 1);  // a pair found clear stays so until one of its points is moved
  for (int round = 0; round < most_rounds && !clear; ++round) {
    if (scene_.cover(x, end)) asked.assign(x.size(), 1);
    scene_.set().planes() = planes_;
    // What two obstacles pinch is thrown from one to the other, round by round.
    if (round <= most_rounds - last_rounds && scene_.obstacles().any_yields())
      blocked_.assign(static_cast<std::size_t>(scene_.dofs().mesh().vertex_count()), 0.0);
    const std::vector<Motion> motions = blocked_motions(asked);
    clear = obstruction_.empty();
    if (clear) break;
    move_along(motions);
    const std::vector<Vec3> before = end;
    scene_.locate(to_, end);
    for (Index p : scene_.set().candidates().seen()) asked[p] = end[p] != before[p];
    for (const Motion& m : motions) asked[m.point] = 1;  // what was hit may not have moved
  }
  set_time(scene_, memory_, t1_);
  return clear;
}

std::vector<PredictorTrajectory::Motion> PredictorTrajectory::blocked_motions(const std::vector<char>& asked) {
  std::vector<Motion> motions;
  std::string hit;
  const ContactScene::Points& points = scene_.points();
  scene_.set().blocked(points.now, points.end, planes_end_, asked, [&](const Pair& pair) {
    if (hit.empty()) hit = words(scene_, pair);
    note_blocked(pair);
    const Vec3 common = common_motion(pair);
    for (Index p : pair.points)
      if (p != no_index && scene_.set().surface().is_sheet(p)) motions.push_back({p, common});
  });
  obstruction_ = mpi::first_text(scene_.dofs().comm(), hit);
  std::stable_sort(motions.begin(), motions.end(), [](const Motion& a, const Motion& b) { return a.point < b.point; });
  return motions;
}

/// Each rank speaks for its own vertices, which move by the mean of what their pairs ask for.
void PredictorTrajectory::move_along(const std::vector<Motion>& motions) const {
  const Dofs& dofs = scene_.dofs();
  const petsc::WriteArray out(to_);
  for (std::size_t k = 0; k < motions.size();) {
    const Index v = motions[k].point, i = dofs.local().local_of[v];
    Vec3 sum = Vec3::Zero();
    double count = 0.0;
    for (; k < motions.size() && motions[k].point == v; ++k) {
      sum += motions[k].displacement;
      count += 1.0;
    }
    if (i != no_index && i < dofs.local().owned) dofs.place_vertex(i, scene_.points().now[v] + sum / count, out);
  }
}

}  // namespace voile::system
