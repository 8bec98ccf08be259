// Starts that lie inside the contact distance.
#include <algorithm>

#include "voile/base/mpi.hpp"
#include "voile/system/contact.hpp"

namespace voile::system {

namespace {

/// Share of its contact force that may be left over at a point which counts as at rest.
constexpr double most_unbalanced = 0.5;

}  // namespace

std::vector<double> Contact::balanced_points(Vec a, Vec residual) {
  petsc::VecHandle push;
  VOILE_PETSC(VecDuplicate(a, push.out()));
  VOILE_PETSC(VecZeroEntries(push));
  add_gradient(a, push, contact::ContactSet::normal);
  std::vector<double> balanced(static_cast<std::size_t>(mesh_->vertex_count()), 1.0);
  const petsc::ReadArray g(push), r(residual);
  for (Index i = 0; i < row_count_; ++i) {
    const Eigen::Map<const Vec3> own(g.data() + 3 * i), all(r.data() + 3 * i);
    if (own.dot(all) > most_unbalanced * own.squaredNorm()) balanced[partition_->vertex_of[first_row_ + i]] = 0.0;
  }
  mpi::min(comm_, balanced);
  return balanced;
}

void Contact::begin_settling(Vec a, Vec residual, double time) {
  const double distance = input_.options.distance;
  set_time(time);
  memory_.gaps.clear();
  settle();
  const std::vector<double> balanced = balanced_points(a, residual);
  fill_positions(a, x_);
  cover(x_, x_);
  std::vector<double> gaps = set_->smallest_gaps(x_);
  mpi::min(comm_, gaps);
  for (std::size_t v = 0; v < balanced.size(); ++v)
    if (balanced[v] == 1.0) gaps[v] = distance;
  const bool inside = std::any_of(gaps.begin(), gaps.end(), [&](double g) { return g < distance; });
  if (inside && input_.options.settle_time > 0.0) {
    memory_.gaps = std::move(gaps);
    memory_.start = time;
  }
  settle();
}

void Contact::restore(ContactMemory memory) {
  memory_ = std::move(memory);
  settle();
  tell_yielding();
}

void Contact::settle() {
  std::vector<double> reach;
  const double share = input_.options.settle_time > 0.0 ? (time_ - memory_.start) / input_.options.settle_time : 1.0;
  if (!memory_.gaps.empty() && share < 1.0) {
    reach = memory_.gaps;
    for (double& r : reach) r += std::max(share, 0.0) * (input_.options.distance - r);
  }
  set_->set_reaches(std::move(reach));
}

}  // namespace voile::system
