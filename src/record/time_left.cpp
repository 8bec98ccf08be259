#include "time_left.hpp"

#include <algorithm>
#include <cmath>

namespace voile::record {

namespace {

/// Part of the elapsed time that counts as the recent one.
constexpr double recent = 0.3;

}  // namespace

void TimeLeft::add(double progress, double elapsed) {
  if (!steps_.empty() && !(progress > steps_.back().first)) steps_.clear();  // back to an earlier state
  steps_.emplace_back(progress, elapsed);
}

std::optional<double> TimeLeft::until(double end) const {
  if (steps_.size() < 2) return std::nullopt;
  const auto [first, begin] = steps_.front();
  const auto [now, elapsed] = steps_.back();
  const double from = elapsed - recent * (elapsed - begin);
  const auto later = std::upper_bound(steps_.begin() + 1, steps_.end() - 1, from,
                                      [](double t, const auto& step) { return t < step.second; });
  const auto [then, at] = *(later - 1);
  const double whole = (elapsed - begin) / (now - first), last = (elapsed - at) / (now - then);
  return std::max(0.0, end - now) * std::sqrt(whole * last);
}

}  // namespace voile::record
