// Starts that lie inside the activation distance.
#include <algorithm>
#include <utility>

#include "base/mpi.hpp"
#include "contact.hpp"
#include "contact_parts.hpp"

namespace voile::system {

namespace {

/// Fraction of its contact force that may be left over at a point which counts as at rest.
constexpr double most_unbalanced = 0.5;

/// A contact force beside the one that a stage has ended with; where seams have been welded since, that is it nearly.
enum class Push { unknown, kept, grown };
Push compare(const std::vector<double>& before, Index v, const Vec3& now) {
  constexpr double same = 0.1;
  if (before.empty()) return Push::unknown;
  const Vec3 was = Eigen::Map<const Vec3>(&before[3 * static_cast<std::size_t>(v)]);
  if ((now - was).norm() <= same * was.norm()) return Push::kept;
  return was.squaredNorm() > 0.0 && now.dot(was) > was.squaredNorm() ? Push::grown : Push::unknown;
}

}  // namespace

std::vector<double> Contact::push(Vec a) {
  const petsc::VecHandle force = scene_.dofs().create_vector();
  scene_.take(a);
  add_gradient(a, force, contact::ContactSet::normal);
  std::vector<double> all = scene_.dofs().gather_forces(force);
  mpi::broadcast(scene_.dofs().comm(), all);
  return all;
}

bool Contact::note_unbalanced(Vec a, Vec others, const std::vector<double>& before, std::vector<double>& balanced) {
  const LocalPoints& local = scene_.dofs().local();
  const petsc::VecHandle push = scene_.dofs().create_vector();
  add_gradient(a, push, contact::ContactSet::normal);
  std::vector<double> now = balanced;
  {
    const petsc::ReadArray g(push), r(others);
    for (Index i = 0; i < local.owned; ++i) {
      const Eigen::Map<const Vec3> own(g.data() + 3 * i), rest(r.data() + 3 * i);
      const Index v = local.point_of[i];
      const Push is = compare(before, v, scene_.dofs().to_global(v, own));
      const bool unbalanced = own.dot(own + rest) > most_unbalanced * own.squaredNorm();
      if (is == Push::grown || (unbalanced && is != Push::kept)) now[v] = 0.0;
    }
  }
  mpi::min(scene_.dofs().comm(), now);
  const bool more = now != balanced;
  balanced = std::move(now);
  return more;
}

void Contact::match_push(Vec a, const std::vector<double>& before, const std::vector<double>& gaps,
                         const std::vector<double>& balanced) {
  constexpr int halvings = 12;
  std::vector<std::size_t> pressed;
  const auto of = [](const std::vector<double>& force, std::size_t v) {
    return Vec3(Eigen::Map<const Vec3>(&force[3 * v]));
  };
  for (std::size_t v = 0; v < gaps.size() && !before.empty(); ++v)
    if (balanced[v] == 0.0 && of(before, v).squaredNorm() > 0.0) pressed.push_back(v);
  if (pressed.empty()) return;
  std::vector<double> low = gaps, high(gaps.size(), scene_.input().options.distance);
  for (int k = 0; k < halvings; ++k) {
    for (const std::size_t v : pressed) memory_.gaps[v] = 0.5 * (low[v] + high[v]);
    settle(scene_, memory_);
    const std::vector<double> now = push(a);
    for (const std::size_t v : pressed) {
      const Vec3 was = of(before, v);
      (of(now, v).dot(was) < was.squaredNorm() ? low : high)[v] = memory_.gaps[v];
    }
  }
  for (const std::size_t v : pressed) memory_.gaps[v] = low[v];
  settle(scene_, memory_);
}

void Contact::begin_settling(Vec a, Vec residual, double time) {
  const contact::ContactOptions& options = scene_.input().options;
  memory_.gaps.clear();
  std::vector<double> before = std::exchange(memory_.push, {});
  if (before.size() != 3 * static_cast<std::size_t>(scene_.dofs().mesh().vertex_count())) before.clear();
  set_time(time);
  if (options.settle_time <= 0.0) return;
  scene_.take(a);
  std::vector<double> gaps = scene_.set().smallest_gaps(scene_.points().now);
  mpi::min(scene_.dofs().comm(), gaps);
  const petsc::VecHandle others = scene_.dofs().create_vector();
  add_gradient(a, others, contact::ContactSet::normal);
  VOILE_PETSC(VecAYPX(others, -1.0, residual));
  // Where one layer is let out, the next has lost what balanced it.
  std::vector<double> balanced(gaps.size(), 1.0);
  while (note_unbalanced(a, others, before, balanced)) {
    memory_.gaps = gaps;
    for (std::size_t v = 0; v < gaps.size(); ++v)
      if (balanced[v] == 1.0) memory_.gaps[v] = options.distance;
    memory_.start = time;
    settle(scene_, memory_);
  }
  match_push(a, before, gaps, balanced);
}

double Contact::grown_since(Vec a, double before) {
  if (memory_.gaps.empty() || before >= memory_.start + scene_.input().options.settle_time) return 0.0;
  const double now = energy(a, contact::ContactSet::normal);
  scene_.set().set_reaches(reaches_at(scene_, memory_, before));
  const double then = energy(a, contact::ContactSet::normal);
  settle(scene_, memory_);
  return now - then;
}

void Contact::restore(ContactMemory memory) {
  memory_ = std::move(memory);
  forget_absent(scene_, memory_);
  settle(scene_, memory_);
  set_passing(scene_, memory_);
}

void set_time(ContactScene& scene, const ContactMemory& memory, double time) {
  scene.set_time(time);
  settle(scene, memory);
}

std::vector<double> reaches_at(const ContactScene& scene, const ContactMemory& memory, double time) {
  const contact::ContactOptions& options = scene.input().options;
  std::vector<double> reach;
  const double fraction = options.settle_time > 0.0 ? (time - memory.start) / options.settle_time : 1.0;
  if (!memory.gaps.empty() && fraction < 1.0) {
    reach = memory.gaps;
    for (double& r : reach) r += std::max(fraction, 0.0) * (options.distance - r);
  }
  return reach;
}

void settle(ContactScene& scene, const ContactMemory& memory) {
  scene.set().set_reaches(reaches_at(scene, memory, scene.time()));
}

}  // namespace voile::system
