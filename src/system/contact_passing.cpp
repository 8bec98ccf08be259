// Pinched cloth that passes through obstacles.
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/mpi.hpp"
#include "contact.hpp"
#include "contact_parts.hpp"

namespace voile::system {

namespace {

/// Attempts in which more and more of the obstacles' surface is passable.
constexpr int most_attempts = 50;

/// A set of obstacles as a number, exact in a double for 53 of them.
std::uint64_t bits(double set) {
  return static_cast<std::uint64_t>(set);
}

double bit(const contact::Obstacle& obstacle) {
  return std::ldexp(1.0, obstacle.number);
}

}  // namespace

bool has_passable_obstacles(const ContactInput& input) {
  return std::any_of(input.obstacles.begin(), input.obstacles.end(), [](const auto& o) { return o.passable; });
}

long passing_count(const ContactMemory& memory) {
  return std::count_if(memory.passing.begin(), memory.passing.end(), [](double set) { return set != 0.0; });
}

bool passes(const Contact& contact, const std::array<Index, 3>& triangle, int body) {
  const contact::Surface& s = contact.scene().set().surface();
  const std::size_t sheets = s.bodies.size() - contact.scene().obstacles().size(), of = static_cast<std::size_t>(body);
  const std::vector<double>& passing = contact.memory().passing;
  if (passing.empty() || of < sheets) return false;
  const std::uint64_t own = bits(bit(contact.scene().obstacles()[of - sheets]));
  return std::any_of(triangle.begin(), triangle.end(),
                     [&](Index v) { return s.is_sheet(v) && (bits(passing[v]) & own); });
}

void forget_absent(const ContactScene& scene, ContactMemory& memory) {
  std::uint64_t present = 0;
  for (const contact::Obstacle& o : scene.input().obstacles)
    if (o.passable) present |= bits(bit(o));
  for (double& set : memory.passing) set = static_cast<double>(bits(set) & present);
}

void set_passing(ContactScene& scene, const ContactMemory& memory) {
  const contact::Obstacles& obstacles = scene.obstacles();
  std::vector<std::uint64_t> points(memory.passing.size()), bodies(scene.set().surface().bodies.size(), 0);
  std::transform(memory.passing.begin(), memory.passing.end(), points.begin(), bits);
  for (std::size_t k = 0; k < obstacles.size(); ++k)
    if (obstacles[k].passable) bodies[obstacles.body(k)] = bits(bit(obstacles[k]));
  scene.set().set_passing(std::move(points), std::move(bodies));
}

void PredictorTrajectory::note_blocked(const contact::Pair& pair) {
  const contact::Obstacles& obstacles = scene_.obstacles();
  for (std::size_t k = 0; k < obstacles.size(); ++k) {
    const int b = obstacles.body(k);
    if (!obstacles[k].passable || (pair.body_a != b && pair.body_b != b)) continue;
    for (Index p : pair.points)
      if (p != no_index && scene_.set().surface().is_sheet(p))
        blocked_[p] = static_cast<double>(bits(blocked_[p]) | bits(bit(obstacles[k])));
  }
}

/// One obstacle at a time: what two of them pinch still lies on the other, and is not left behind when they part.
bool PredictorTrajectory::pass_blocked() {
  const contact::Obstacles& obstacles = scene_.obstacles();
  bool more = false;
  std::vector<double> all = memory_.passing;
  all.resize(blocked_.size(), 0.0);
  for (std::size_t k = 0; k < obstacles.size() && !more; ++k) {
    if (!obstacles[k].passable) continue;
    std::vector<double> hit(blocked_.size());  // -1: on some rank
    for (std::size_t v = 0; v < hit.size(); ++v) hit[v] = bits(blocked_[v]) & bits(bit(obstacles[k])) ? -1.0 : 0.0;
    mpi::min(scene_.dofs().comm(), hit);
    for (std::size_t v = 0; v < hit.size(); ++v) {
      if (hit[v] == 0.0 || (bits(all[v]) & bits(bit(obstacles[k])))) continue;
      all[v] += bit(obstacles[k]);
      more = true;
    }
  }
  if (!more) return false;
  memory_.passing = std::move(all);
  set_passing(scene_, memory_);
  return true;
}

/// What was pinched is pressed hard against what is not passable, which would throw it through what is.
void PredictorTrajectory::let_out(const std::vector<double>& before) {
  set_time(scene_, memory_, t0_);
  scene_.take(from_);
  const contact::ContactSet& set = scene_.set();
  std::vector<double> gaps = set.smallest_gaps(scene_.points().now);
  mpi::min(scene_.dofs().comm(), gaps);
  for (std::size_t v = 0; v < gaps.size(); ++v) {
    const bool is_new = memory_.passing[v] != (before.empty() ? 0.0 : before[v]);
    if (!is_new) gaps[v] = set.reaches().empty() ? scene_.input().options.distance : set.reaches()[v];
  }
  memory_.gaps = std::move(gaps);
  memory_.start = t0_;
  set_time(scene_, memory_, t1_);
}

bool PredictorTrajectory::clear_passing() {
  if (!scene_.obstacles().any_passable()) return clear();
  petsc::VecHandle guess;
  VOILE_PETSC(VecDuplicate(to_, guess.out()));
  VOILE_PETSC(VecCopy(to_, guess));
  std::string pinched;
  const std::vector<double> before = memory_.passing;
  for (int attempt = 0; attempt < most_attempts; ++attempt) {
    if (clear()) {
      if (attempt > 0) let_out(before);
      obstruction_ = pinched;
      return true;
    }
    pinched = obstruction_;
    if (!pass_blocked()) return false;
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

void end_passing(ContactScene& scene, ContactMemory& memory) {
  if (memory.passing.empty()) return;
  const mesh::SurfaceMesh& mesh = scene.dofs().mesh();
  const std::vector<double> before = memory.passing;
  for (const Index v : scene.set().candidates().own_points())
    for (std::size_t k = 0; before[v] != 0.0 && k < scene.obstacles().size(); ++k) {
      if (!(bits(before[v]) & bits(bit(scene.obstacles()[k])))) continue;
      const std::vector<Index> around = mesh.triangles_of_vertex(v);
      if (std::all_of(around.begin(), around.end(), [&](Index t) { return is_free(scene, mesh.triangles()[t], k); }))
        memory.passing[v] -= bit(scene.obstacles()[k]);
    }
  mpi::min(scene.dofs().comm(), memory.passing);  // what other ranks have freed
  if (passing_count(memory) == 0) memory.passing.clear();
  if (memory.passing != before) set_passing(scene, memory);
}

}  // namespace voile::system
