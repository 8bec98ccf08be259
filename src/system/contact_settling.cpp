// Starts that lie inside the contact distance.
#include <algorithm>

#include "voile/base/mpi.hpp"
#include "voile/system/contact.hpp"

namespace voile::system {

namespace {

/// Share of its contact force that may be left over at a point which counts as at rest.
constexpr double most_unbalanced = 0.5;

}  // namespace

bool Contact::note_unbalanced(Vec a, Vec others, std::vector<double>& balanced) {
  const petsc::VecHandle push = dofs_->create_vector();
  add_gradient(a, push, contact::ContactSet::normal);
  std::vector<double> now = balanced;
  {
    const petsc::ReadArray g(push), r(others);
    for (Index i = 0; i < row_count_; ++i) {
      const Eigen::Map<const Vec3> own(g.data() + 3 * i), rest(r.data() + 3 * i);
      if (own.dot(own + rest) > most_unbalanced * own.squaredNorm()) now[partition_->vertex_of[first_row_ + i]] = 0.0;
    }
  }
  mpi::min(comm_, now);
  const bool more = now != balanced;
  balanced = std::move(now);
  return more;
}

void Contact::begin_settling(Vec a, Vec residual, double time) {
  const double distance = input_.options.distance;
  set_time(time);
  memory_.gaps.clear();
  settle();
  if (input_.options.settle_time <= 0.0) return;
  take_positions(a);
  std::vector<double> gaps = set_->smallest_gaps(x_);
  mpi::min(comm_, gaps);
  const petsc::VecHandle others = dofs_->create_vector();
  add_gradient(a, others, contact::ContactSet::normal);
  VOILE_PETSC(VecAYPX(others, -1.0, residual));
  // Where one layer is let out, the next has lost what balanced it.
  std::vector<double> balanced(gaps.size(), 1.0);
  while (note_unbalanced(a, others, balanced)) {
    memory_.gaps = gaps;
    for (std::size_t v = 0; v < gaps.size(); ++v)
      if (balanced[v] == 1.0) memory_.gaps[v] = distance;
    memory_.start = time;
    settle();
  }
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
