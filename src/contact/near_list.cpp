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
    const double gap = distance(pair.kind, p) - xi;
    if (gap < reach) entries_.push_back({k, gap});
  }
  reference_ = x;
  reach_ = reach;
  made_ = true;
}

void NearList::measure(const std::vector<Index>& points, const std::vector<Vec3>& x, Moves& moves) const {
  measure(points, x, x, moves);
}

void NearList::measure(const std::vector<Index>& points, const std::vector<Vec3>& x, const std::vector<Vec3>& to,
                       Moves& moves) const {
  moves.of_point.resize(reference_.size());
  moves.most = 0.0;
  for (Index i : points) {
    const double m = (x[i] - reference_[i]).norm() + 2.0 * (to[i] - x[i]).norm();
    moves.of_point[i] = m;
    moves.most = std::max(moves.most, m);
  }
}

}  // namespace voile::contact
