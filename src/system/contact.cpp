#include "contact.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/mpi.hpp"
#include "contact_parts.hpp"

namespace voile::system {

namespace {

using contact::ContactSet;
using contact::Pair;

/// Pairs within so many activation distances get their place in the matrix, so that it changes rarely.
constexpr double padding = 4.0;

}  // namespace

Contact::Contact(const Dofs& dofs, ContactInput input)
    : scene_(dofs, std::move(input)),
      change_(dofs.create_vector()),
      force_(static_cast<std::size_t>(dofs.mesh().vertex_count())) {}

void Contact::set_time(double time) {
  system::set_time(scene_, memory_, time);
}

void Contact::start_step(Vec a, double slip) {
  scene_.take(a);
  end_passing(scene_, memory_);
  scene_.begin_step();
  slip_ = slip;
  scene_.lag_friction(slip);
}

void Contact::lag_friction(Vec a) {
  scene_.take(a);
  scene_.lag_friction(slip_);
}

double Contact::energy(Vec a, ContactSet::Part part) {
  const petsc::EventScope scope(petsc::events().contact_term);
  scene_.take(a);
  return mpi::sum(scene_.dofs().comm(), scene_.set().energy(scene_.points().now, part));
}

double Contact::friction_work(Vec a) {
  scene_.take(a);
  return mpi::sum(scene_.dofs().comm(), scene_.set().friction_work(scene_.points().now));
}

std::vector<Vec3> Contact::forces_on_obstacles(Vec a) {
  scene_.take(a);
  std::vector<Vec3> on_bodies(scene_.set().surface().bodies.size(), Vec3::Zero());
  scene_.set().add_force_on_bodies(scene_.points().now, on_bodies);
  std::vector<Vec3> all;
  for (std::size_t k = 0; k < scene_.obstacles().size(); ++k) {
    const Vec3& own = on_bodies[static_cast<std::size_t>(scene_.obstacles().body(k))];
    Vec3 sum;
    for (int i = 0; i < 3; ++i) sum[i] = mpi::sum(scene_.dofs().comm(), own[i]);
    if (!scene_.set().knows_friction() && !sum.isZero(0.0)) sum.setConstant(std::numeric_limits<double>::quiet_NaN());
    all.push_back(sum);
  }
  return all;
}

double Contact::obstacle_work(Vec a) {
  scene_.take(a);
  const ContactScene::Points& points = scene_.points();
  const ContactSet::Then start{points.start, scene_.planes_at_start(),
                               reaches_at(scene_, memory_, scene_.start_time())};
  return mpi::sum(scene_.dofs().comm(), scene_.set().obstacle_work(points.now, start));
}

double Contact::add_gradient(Vec a, Vec f, ContactSet::Part part) {
  const petsc::EventScope scope(petsc::events().contact_term);
  scene_.take(a);
  const contact::ContactSet& set = scene_.set();
  for (Index p : set.candidates().seen()) {
    if (!set.surface().is_sheet(p)) break;  // those of obstacles follow
    force_[p].setZero();
  }
  const double squares = set.add_gradient(scene_.points().now, force_, part);
  const LocalPoints& local = scene_.dofs().local();
  const petsc::WriteArray out(f);
  for (Index i = 0; i < local.owned; ++i) {
    const Index v = local.point_of[i];
    const Vec3 own = scene_.dofs().to_own(v, force_[v]);
    for (int k = 0; k < 3; ++k) out[3 * i + k] += own[k];
  }
  return std::sqrt(mpi::sum(scene_.dofs().comm(), squares));
}

bool Contact::extend_pattern(Vec a, const BlockMatrix& matrix, const BlockPattern& base, BlockPattern& pattern) {
  scene_.take(a);
  const ContactSet& set = scene_.set();
  const contact::Surface& s = set.surface();
  const std::vector<Vec3>& x = scene_.points().now;
  const std::vector<Index>& row_of = scene_.dofs().partition().row_of;
  const Index first = scene_.dofs().first_row(), end = first + scene_.dofs().local().owned;
  const auto for_entries = [&](const Pair& pair, const auto& f) {
    for (Index p : pair.points) {
      if (p == no_index || !s.is_sheet(p) || row_of[p] < first || row_of[p] >= end) continue;
      for (Index q : pair.points)
        if (q != no_index && s.is_sheet(q)) f(row_of[p] - first, row_of[q]);
    }
  };
  bool lacking = false;
  const auto check = [&](const Pair& pair) {
    for_entries(pair, [&](Index row, Index column) { lacking = lacking || !matrix.has(row, column); });
  };
  set.for_near(x, scene_.input().options.distance, check);
  set.for_sliding([&](const std::array<Index, 4>& points) {
    Pair pair{};
    pair.points = points;
    check(pair);
  });
  if (mpi::max(scene_.dofs().comm(), lacking ? 1.0 : 0.0) == 0.0) return false;
  pattern = base;
  const auto add = [&](const Pair& pair) {
    for_entries(pair, [&](Index row, Index column) { pattern[row].push_back(column); });
  };
  set.for_near(x, scene_.input().options.distance, add);
  // The pattern is a matter of the state alone, so that a run that continues from a checkpoint has the same.
  for (const Pair& pair : set.sheet_pairs_within(x, padding * scene_.input().options.distance)) add(pair);
  set.for_sliding([&](const std::array<Index, 4>& points) {
    Pair pair{};
    pair.points = points;
    add(pair);
  });
  for (auto& row : pattern) {
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
  }
  return true;
}

void Contact::add_blocks(const BlockMatrix& matrix, const BlockMatrix::Values& values, bool positive) {
  const petsc::EventScope scope(petsc::events().contact_term);
  const Dofs& dofs = scene_.dofs();
  const std::vector<Index>& row_of = dofs.partition().row_of;
  const Index first = dofs.first_row(), count = dofs.local().owned;
  if (positive) scene_.set().follow_slips(scene_.points().now);
  scene_.set().hessian(scene_.points().now, positive, [&](Index p, Index q, const Mat3& k) {
    const Index row = row_of[p] - first;
    if (row < 0 || row >= count) return;
    const bool plain = !dofs.has_axes(p) && !dofs.has_axes(q);
    values.add(matrix.slot(row, row_of[q]), plain ? k : Mat3(dofs.axes(p).transpose() * k * dofs.axes(q)));
  });
}

double Contact::step_fraction(Vec a, Vec da) {
  const petsc::EventScope scope(petsc::events().contact_clear);
  ContactScene::Points& points = scene_.points();
  scene_.locate(a, points.now);
  points.end = points.now;
  VOILE_PETSC(VecWAXPY(change_, 1.0, a, da));
  scene_.locate(change_, points.end);
  scene_.cover(points.now, points.end);
  return -mpi::max(scene_.dofs().comm(), -scene_.set().step_fraction(points.now, points.end));
}

Contact::Clearance Contact::clear_predictor(Vec from, double t0, Vec to, double t1, bool may_pass) {
  PredictorTrajectory trajectory(scene_, memory_, from, t0, to, t1);
  const bool clear = may_pass ? trajectory.clear_passing() : trajectory.clear();
  return {clear, trajectory.obstruction()};
}

}  // namespace voile::system
