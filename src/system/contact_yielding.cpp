// Obstacles that give way to cloth which they pinch.
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/mpi.hpp"
#include "contact.hpp"
#include "contact_parts.hpp"

namespace voile::system {

namespace {

/// Attempts in which more and more of the obstacles' surface gives way.
constexpr int most_attempts = 50;

/// A set of obstacles as a number, exact in a double for 53 of them.
std::uint64_t bits(double set) {
  return static_cast<std::uint64_t>(set);
}

double bit(std::size_t obstacle) {
  return std::ldexp(1.0, static_cast<int>(obstacle));
}

}  // namespace

bool has_yielding_obstacles(const ContactInput& input) {
  return std::any_of(input.obstacles.begin(), input.obstacles.end(), [](const auto& o) { return o.yields; });
}

long yielding_count(const ContactMemory& memory) {
  return std::count_if(memory.yielding.begin(), memory.yielding.end(), [](double set) { return set != 0.0; });
}

bool gives_way(const Contact& contact, const std::array<Index, 3>& triangle, int body) {
  const contact::Surface& s = contact.scene().set().surface();
  const std::size_t sheets = s.bodies.size() - contact.scene().obstacles().size(), of = static_cast<std::size_t>(body);
  const std::vector<double>& yielding = contact.memory().yielding;
  if (yielding.empty() || of < sheets) return false;
  const std::uint64_t own = bits(bit(of - sheets));
  return std::any_of(triangle.begin(), triangle.end(),
                     [&](Index v) { return s.is_sheet(v) && (bits(yielding[v]) & own); });
}

void tell_yielding(ContactScene& scene, const ContactMemory& memory) {
  const contact::Obstacles& obstacles = scene.obstacles();
  std::vector<std::uint64_t> points(memory.yielding.size()), bodies(scene.set().surface().bodies.size(), 0);
  std::transform(memory.yielding.begin(), memory.yielding.end(), points.begin(), bits);
  for (std::size_t k = 0; k < obstacles.size(); ++k)
    if (obstacles[k].yields) bodies[obstacles.body(k)] = bits(bit(k));
  scene.set().set_yielding(std::move(points), std::move(bodies));
}

void PredictorTrajectory::note_blocked(const contact::Pair& pair) {
  const contact::Obstacles& obstacles = scene_.obstacles();
  for (std::size_t k = 0; k < obstacles.size(); ++k) {
    const int b = obstacles.body(k);
    if (!obstacles[k].yields || (pair.body_a != b && pair.body_b != b)) continue;
    for (Index p : pair.points)
      if (p != no_index && scene_.set().surface().is_sheet(p))
        blocked_[p] = static_cast<double>(bits(blocked_[p]) | bits(bit(k)));
  }
}

/// One obstacle at a time: what two of them pinch still lies on the other, and is not left behind when they part.
bool PredictorTrajectory::yield_to_blocked() {
  const contact::Obstacles& obstacles = scene_.obstacles();
  bool more = false;
  std::vector<double> all = memory_.yielding;
  all.resize(blocked_.size(), 0.0);
  for (std::size_t k = 0; k < obstacles.size() && !more; ++k) {
    if (!obstacles[k].yields) continue;
    std::vector<double> hit(blocked_.size());  // -1: on some rank
    for (std::size_t v = 0; v < hit.size(); ++v) hit[v] = bits(blocked_[v]) & bits(bit(k)) ? -1.0 : 0.0;
    mpi::min(scene_.dofs().comm(), hit);
    for (std::size_t v = 0; v < hit.size(); ++v) {
      if (hit[v] == 0.0 || (bits(all[v]) & bits(bit(k)))) continue;
      all[v] += bit(k);
      more = true;
    }
  }
  if (!more) return false;
  memory_.yielding = std::move(all);
  tell_yielding(scene_, memory_);
  return true;
}

/// What was pinched is pressed hard against what does not give way, which would throw it through what does.
void PredictorTrajectory::let_out(const std::vector<double>& before) {
  set_time(scene_, memory_, t0_);
  scene_.take(from_);
  const contact::ContactSet& set = scene_.set();
  std::vector<double> gaps = set.smallest_gaps(scene_.points().now);
  mpi::min(scene_.dofs().comm(), gaps);
  for (std::size_t v = 0; v < gaps.size(); ++v) {
    const bool is_new = memory_.yielding[v] != (before.empty() ? 0.0 : before[v]);
    if (!is_new) gaps[v] = set.reaches().empty() ? scene_.input().options.distance : set.reaches()[v];
  }
  memory_.gaps = std::move(gaps);
  memory_.start = t0_;
  set_time(scene_, memory_, t1_);
}

bool PredictorTrajectory::clear_yielding() {
  if (!scene_.obstacles().any_yields()) return clear();
  petsc::VecHandle guess;
  VOILE_PETSC(VecDuplicate(to_, guess.out()));
  VOILE_PETSC(VecCopy(to_, guess));
  std::string pinched;
  const std::vector<double> before = memory_.yielding;
  for (int attempt = 0; attempt < most_attempts; ++attempt) {
    if (clear()) {
      if (attempt > 0) let_out(before);
      obstruction_ = pinched;
      return true;
    }
    pinched = obstruction_;
    if (!yield_to_blocked()) return false;
    VOILE_PETSC(VecCopy(guess, to_));
  }
  return false;
}

namespace {

/// Of a triangle that holds an own vertex.
bool is_free(const ContactScene& scene, const mesh::Triangle& t, std::size_t k) {
  const contact::ContactSet& set = scene.set();
  const contact::Surface& s = set.surface();
  const std::vector<Vec3>& x = scene.points().now;
  const double apart = s.offset(scene.obstacles().body(k), s.body_of_point[t[0]]) + scene.input().options.distance;
  return scene.obstacles().is_free(k, {x[t[0]], x[t[1]], x[t[2]]}, x, set.planes(), apart);
}

}  // namespace

void end_yielding(ContactScene& scene, ContactMemory& memory) {
  if (memory.yielding.empty()) return;
  const mesh::SurfaceMesh& mesh = scene.dofs().mesh();
  const std::vector<double> before = memory.yielding;
  for (const Index v : scene.set().candidates().own_points())
    for (std::size_t k = 0; before[v] != 0.0 && k < scene.obstacles().size(); ++k) {
      if (!(bits(before[v]) & bits(bit(k)))) continue;
      const std::vector<Index> around = mesh.triangles_of_vertex(v);
      if (std::all_of(around.begin(), around.end(), [&](Index t) { return is_free(scene, mesh.triangles()[t], k); }))
        memory.yielding[v] -= bit(k);
    }
  mpi::min(scene.dofs().comm(), memory.yielding);  // what other ranks have freed
  if (yielding_count(memory) == 0) memory.yielding.clear();
  if (memory.yielding != before) tell_yielding(scene, memory);
}

}  // namespace voile::system
