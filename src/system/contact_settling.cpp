// Starts that lie inside the contact distance.
#include <algorithm>

#include "voile/base/mpi.hpp"
#include "voile/system/contact.hpp"

namespace voile::system {

void Contact::begin_settling(Vec a, double time) {
  const double distance = input_.options.distance;
  set_time(time);
  fill_positions(a, x_);
  cover(x_, x_);
  std::vector<double> gaps = set_->smallest_gaps(x_);
  mpi::min(comm_, gaps);
  memory_.gaps.clear();
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
