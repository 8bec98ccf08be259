#include "near_list.hpp"

#include <algorithm>

namespace voile::contact {

namespace {

/// A point that goes far gets this multiple of what it needs now, up to so many times the usual room: with more of it the
/// list would be as long as that of all pairs.
constexpr double more_room = 1.5, most_room = 6.0;
/// Points that have used up this fraction of their room, or need no more than that, are renewed with others.
constexpr double used_fraction = 0.5;

}  // namespace

double NearList::room_for(double coming) const {
  return std::max(room_, more_room * coming);
}

bool NearList::goes_far(const std::vector<Index>& points, const std::vector<Vec3>& from,
                        const std::vector<Vec3>& to) const {
  return std::any_of(points.begin(), points.end(),
                     [&](Index i) { return room_for(2.0 * (to[i] - from[i]).norm()) > most_room * room_; });
}

bool NearList::find_stale(const std::vector<Index>& points, const std::vector<Vec3>& from, const std::vector<Vec3>& to,
                          const std::vector<char>* changed) {
  const bool all = !made_ || !changed;
  bool any = all;
  if (all) {
    reference_ = from;
    allowed_.assign(from.size(), room_);
  }
  stale_.assign(from.size(), 0);
  for (const Index i : points) {
    const double coming = 2.0 * (to[i] - from[i]).norm(), m = (from[i] - reference_[i]).norm() + coming;
    const bool is_changed = all || (*changed)[i];
    any = any || is_changed || m > allowed_[i];
    stale_[i] = is_changed || m > used_fraction * allowed_[i] || room_for(coming) < used_fraction * allowed_[i];
  }
  if (!any) return false;
  for (const Index i : points) {
    if (!stale_[i]) continue;
    reference_[i] = from[i];
    allowed_[i] = room_for(2.0 * (to[i] - from[i]).norm());
  }
  return true;
}

void NearList::renew(const std::vector<Pair>& pairs, const std::vector<Index>& points, const std::vector<Vec3>& from,
                     const std::vector<Vec3>& to, const std::vector<char>* changed, const Offset& offset) {
  if (goes_far(points, from, to)) {
    made_ = made_ && changed && std::none_of(points.begin(), points.end(), [&](Index i) { return (*changed)[i] != 0; });
    return;
  }
  if (!find_stale(points, from, to, changed)) return;
  if (made_ && changed)
    std::erase_if(entries_, [&](const Entry& e) { return is_stale(e.pair); });
  else
    entries_.clear();
  const auto kept = static_cast<std::ptrdiff_t>(entries_.size());
  for (const Pair& pair : pairs) {
    if (!is_stale(pair)) continue;
    std::array<Vec3, 4> p;
    for (int i = 0; i < 4; ++i) p[i] = pair.points[i] == no_index ? Vec3(Vec3::Zero()) : reference_[pair.points[i]];
    const double xi = offset(pair), reach = limit_ + of_both(pair, allowed_);
    if (axis_distance(pair.kind, p) - xi >= reach) continue;
    const double gap = distance(pair.kind, p) - xi;
    if (gap < reach) entries_.push_back({pair, gap});
  }
  std::inplace_merge(entries_.begin(), entries_.begin() + kept, entries_.end(),
                     [](const Entry& a, const Entry& b) { return a.pair < b.pair; });
  made_ = true;
}

void NearList::measure(const std::vector<Index>& points, const std::vector<Vec3>& x, Moves& moves) const {
  measure(points, x, x, moves);
}

void NearList::measure(const std::vector<Index>& points, const std::vector<Vec3>& x, const std::vector<Vec3>& to,
                       Moves& moves) const {
  moves.of_point.resize(reference_.size());
  moves.within = true;
  for (const Index i : points) {
    const double m = (x[i] - reference_[i]).norm() + 2.0 * (to[i] - x[i]).norm();
    moves.of_point[i] = m;
    moves.within = moves.within && m <= allowed_[i];
  }
}

}  // namespace voile::contact
