// Obstacles that give way to cloth which they pinch.
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "voile/base/mpi.hpp"
#include "voile/system/contact.hpp"

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
  const contact::Surface& s = contact.set().surface();
  const std::size_t sheets = s.bodies.size() - contact.input().obstacles.size(), of = static_cast<std::size_t>(body);
  const std::vector<double>& yielding = contact.memory().yielding;
  if (yielding.empty() || of < sheets) return false;
  const std::uint64_t own = bits(bit(of - sheets));
  return std::any_of(triangle.begin(), triangle.end(),
                     [&](Index v) { return s.is_sheet(v) && (bits(yielding[v]) & own); });
}

void Contact::tell_yielding() {
  std::vector<std::uint64_t> points(memory_.yielding.size()), bodies(set_->surface().bodies.size(), 0);
  std::transform(memory_.yielding.begin(), memory_.yielding.end(), points.begin(), bits);
  for (std::size_t k = 0; k < obstacles_->size(); ++k)
    if ((*obstacles_)[k].yields) bodies[obstacles_->body(k)] = bits(bit(k));
  set_->set_yielding(std::move(points), std::move(bodies));
}

void Contact::note_blocked(const contact::Pair& pair) {
  for (std::size_t k = 0; k < obstacles_->size(); ++k) {
    const int b = obstacles_->body(k);
    if (!(*obstacles_)[k].yields || (pair.body_a != b && pair.body_b != b)) continue;
    for (Index p : pair.points)
      if (p != no_index && set_->surface().is_sheet(p))
        blocked_[p] = static_cast<double>(bits(blocked_[p]) | bits(bit(k)));
  }
}

/// One obstacle at a time: what two of them pinch still lies on the other, and is not left behind when they part.
bool Contact::yield_to_blocked() {
  bool more = false;
  std::vector<double> all = memory_.yielding;
  all.resize(static_cast<std::size_t>(mesh_->vertex_count()), 0.0);
  for (std::size_t k = 0; k < obstacles_->size() && !more; ++k) {
    if (!(*obstacles_)[k].yields) continue;
    std::vector<double> hit(static_cast<std::size_t>(mesh_->vertex_count()));  // -1: on some rank
    for (std::size_t v = 0; v < hit.size(); ++v) hit[v] = bits(blocked_[v]) & bits(bit(k)) ? -1.0 : 0.0;
    mpi::min(comm_, hit);
    for (std::size_t v = 0; v < hit.size(); ++v) {
      if (hit[v] == 0.0 || (bits(all[v]) & bits(bit(k)))) continue;
      all[v] += bit(k);
      more = true;
    }
  }
  if (!more) return false;
  memory_.yielding = std::move(all);
  tell_yielding();
  return true;
}

/// What was pinched is pressed hard against what does not give way, which would throw it through what does.
void Contact::let_out_yielding(Vec a, double time, const std::vector<double>& before) {
  set_time(time);
  take_positions(a);
  std::vector<double> gaps = set_->smallest_gaps(x_);
  mpi::min(comm_, gaps);
  for (std::size_t v = 0; v < gaps.size(); ++v) {
    const bool is_new = memory_.yielding[v] != (before.empty() ? 0.0 : before[v]);
    if (!is_new) gaps[v] = set_->reaches().empty() ? input_.options.distance : set_->reaches()[v];
  }
  memory_.gaps = std::move(gaps);
  memory_.start = time;
}

bool Contact::clear_predictor(Vec from, double t0, Vec to, double t1, bool may_yield) {
  if (!may_yield || !obstacles_->any_yields()) return try_clear(from, t0, to, t1);
  petsc::VecHandle guess;
  VOILE_PETSC(VecDuplicate(to, guess.out()));
  VOILE_PETSC(VecCopy(to, guess));
  std::string pinched;
  const std::vector<double> before = memory_.yielding;
  for (int attempt = 0; attempt < most_attempts; ++attempt) {
    if (try_clear(from, t0, to, t1)) {
      if (attempt > 0) let_out_yielding(from, t0, before);
      set_time(t1);
      obstruction_ = pinched;
      return true;
    }
    pinched = obstruction_;
    if (!yield_to_blocked()) return false;
    VOILE_PETSC(VecCopy(guess, to));
  }
  return false;
}

bool Contact::is_free(const mesh::Triangle& t, std::size_t k) const {
  const contact::Surface& s = set_->surface();
  const double apart = s.offset(obstacles_->body(k), s.body_of_point[t[0]]) + input_.options.distance;
  return obstacles_->is_free(k, {x_[t[0]], x_[t[1]], x_[t[2]]}, x_, set_->planes(), apart);
}

void Contact::end_yielding() {
  if (memory_.yielding.empty()) return;
  const std::vector<double> before = memory_.yielding;
  for (const Index v : set_->candidates().own_points())
    for (std::size_t k = 0; before[v] != 0.0 && k < obstacles_->size(); ++k) {
      if (!(bits(before[v]) & bits(bit(k)))) continue;
      const std::vector<Index> around = mesh_->triangles_of_vertex(v);
      if (std::all_of(around.begin(), around.end(), [&](Index t) { return is_free(mesh_->triangles()[t], k); }))
        memory_.yielding[v] -= bit(k);
    }
  mpi::min(comm_, memory_.yielding);  // what other ranks have freed
  if (yielding_count(memory_) == 0) memory_.yielding.clear();
  if (memory_.yielding != before) tell_yielding();
}

}  // namespace voile::system
