#include "voile/contact/near_list.hpp"

#include <algorithm>

namespace voile::contact {

void NearList::make(const std::vector<Pair>& pairs, const std::vector<Vec3>& x, double reach,
                    const std::function<double(const Pair&)>& offset) {
  entries_.clear();
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const Pair& pair = pairs[k];
    std::array<Vec3, 4> p;
    for (int i = 0; i < 4; ++i) p[i] = pair.points[i] == no_index ? Vec3(Vec3::Zero()) : x[pair.points[i]];
    const double xi = offset(pair);
    if (axis_distance(pair.kind, p) - xi >= reach) continue;
    const double gap = closest(pair.kind, p).distance - xi;
    if (gap < reach) entries_.push_back({k, gap});
  }
  reference_ = x;
  reach_ = reach;
}

std::vector<double> NearList::moved(const std::vector<Vec3>& x) const {
  std::vector<double> m(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) m[i] = (x[i] - reference_[i]).norm();
  return m;
}

std::vector<double> NearList::moved(const std::vector<Vec3>& x, const std::vector<Vec3>& to) const {
  std::vector<double> m = moved(x);
  for (std::size_t i = 0; i < x.size(); ++i) m[i] += 2.0 * (to[i] - x[i]).norm();
  return m;
}

bool NearList::holds(const std::vector<double>& moved, double limit) const {
  return made() && limit + 2.0 * *std::max_element(moved.begin(), moved.end()) <= reach_;
}

}  // namespace voile::contact
