#include "sewn_rims.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

namespace voile::pattern {

namespace {

/// What is nearer to a break than this fraction of the rim's spacing is there.
constexpr double near_break = 0.25;
/// Of the lengths of two intervals that meet: beyond it they do not belong together.
constexpr double largest_stretch = 5.0;
/// An edge whose points are nearer to its chord than this fraction of it is straight.
constexpr double straight = 1e-5;

/// s of both rims.
using Both = std::array<double, 2>;

/// Intervals that follow each other on both rims, as points that meet; s of the first rim ascends.
struct Run {
  std::array<std::size_t, 2> rims;
  std::vector<Both> points;

  [[nodiscard]] bool is_along() const { return points.back()[1] > points.front()[1]; }
  /// Where on the one side the place s of the other lies.
  [[nodiscard]] double opposite(std::size_t side, double s) const {
    std::size_t k = 1;
    const bool ascends = side == 0 || is_along();
    while (k + 1 < points.size() && (ascends ? points[k][side] < s : points[k][side] > s)) ++k;
    const Both &a = points[k - 1], &b = points[k];
    const double f = b[side] == a[side] ? 0.0 : std::clamp((s - a[side]) / (b[side] - a[side]), 0.0, 1.0);
    return a[1 - side] + f * (b[1 - side] - a[1 - side]);
  }
};

class RimJoiner {
 public:
  RimJoiner(std::vector<Rim>& rims, const std::vector<std::vector<std::vector<RimPlace>>>& meet)
      : rims_(rims), meet_(meet) {}

  std::vector<RimSeam> run() {
    for (std::size_t r = 0; r < rims_.size(); ++r)
      for (std::size_t i = 0; i < rims_[r].points.size(); ++i) add_segment(r, i);
    join();
    extend();
    for (Run& run : runs_) snap(run);
    divide();
    return seams();
  }

 private:
  /// Places that a point is sewn to; one that is sewn to nothing may be the tip of a dart.
  [[nodiscard]] std::vector<RimPlace> places(std::size_t r, std::size_t i) const {
    const std::size_t k = i % rims_[r].points.size();
    return meet_[r][k].empty() ? std::vector<RimPlace>{{r, rims_[r].s[k]}} : meet_[r][k];
  }

  /// The interval between two points, with what meets it.
  void add_segment(std::size_t r, std::size_t i) {
    const std::size_t next = (i + 1) % rims_[r].points.size();
    if (meet_[r][i].empty() && meet_[r][next].empty()) return;
    const double length = rims_[r].s[i + 1] - rims_[r].s[i];
    double least = largest_stretch * length;
    Both other{};
    std::size_t rim = rims_.size();
    for (const RimPlace& a : places(r, i))
      for (const RimPlace& b : places(r, next)) {
        if (a.rim != b.rim) continue;
        const double whole = rims_[a.rim].length();
        const double way = std::remainder(b.s - a.s, whole);
        const bool is_itself = a.rim == r && std::abs(std::remainder(a.s - rims_[r].s[i], whole)) < 1e-9 * whole &&
                               std::abs(way - length) < 1e-9 * whole;
        // Behind the tip of a dart its other side runs the other way; beside its mouth nothing meets.
        const bool is_at_tip = meet_[r][i].empty() || meet_[r][next].empty();
        if (is_itself || (is_at_tip && way > 0.0) || std::abs(way) * largest_stretch < length || std::abs(way) >= least)
          continue;
        least = std::abs(way);
        rim = a.rim;
        other = {a.s, a.s + way};
      }
    if (rim < rims_.size()) add_interval(r, rim, {rims_[r].s[i], other[0]}, {rims_[r].s[i + 1], other[1]});
  }

  /// Puts s between 0 and the length, in two parts where the interval crosses the end of the other rim.
  void add_interval(std::size_t r, std::size_t other, Both begin, Both end) {
    const double whole = rims_[other].length(), small = 1e-9 * whole;
    const double low = std::min(begin[1], end[1]), high = std::max(begin[1], end[1]);
    const double shift = low < -small && high <= small                  ? whole
                         : low >= whole - small && high > whole + small ? -whole
                                                                        : 0.0;
    begin[1] += shift;
    end[1] += shift;
    for (const double limit : {0.0, whole})
      if (low + shift < limit - small && high + shift > limit + small) {
        const double f = (limit - begin[1]) / (end[1] - begin[1]);
        const Both middle{begin[0] + f * (end[0] - begin[0]), limit};
        add_interval(r, other, begin, middle);
        add_interval(r, other, middle, end);
        return;
      }
    const double a = 0.5 * (begin[0] + end[0]), b = 0.5 * (begin[1] + end[1]);
    Run interval{{r, other}, {begin, end}};
    if (std::tie(other, b) < std::tie(r, a)) {
      interval.rims = {other, r};
      interval.points = {{begin[1], begin[0]}, {end[1], end[0]}};
      if (begin[1] > end[1]) std::swap(interval.points[0], interval.points[1]);
    }
    intervals_.push_back(std::move(interval));
  }

  void join() {
    std::stable_sort(intervals_.begin(), intervals_.end(),
                     [](const Run& a, const Run& b) { return a.points[0][0] < b.points[0][0]; });
    for (const Run& interval : intervals_)
      if (std::none_of(runs_.begin(), runs_.end(), [&](Run& run) { return goes_on(run, interval); }))
        runs_.push_back(interval);
  }

  /// Adds an interval to a run that it follows, or lies in.
  [[nodiscard]] bool goes_on(Run& run, const Run& interval) const {
    if (run.rims != interval.rims || run.is_along() != interval.is_along()) return false;
    const double near_a = 0.01 * rims_[run.rims[0]].spacing(), near_b = 0.5 * rims_[run.rims[1]].spacing();
    const Both &begin = interval.points[0], &end = interval.points[1];
    if (begin[0] > run.points.back()[0] + near_a || std::abs(run.opposite(0, begin[0]) - begin[1]) > near_b)
      return false;
    if (end[0] > run.points.back()[0] + near_a) run.points.push_back(end);
    return true;
  }

  /// Whether some run holds a place of a rim.
  [[nodiscard]] bool is_sewn(std::size_t rim, double s) const {
    return std::any_of(runs_.begin(), runs_.end(), [&](const Run& run) {
      for (std::size_t side = 0; side < 2; ++side) {
        const auto [low, high] = std::minmax(run.points.front()[side], run.points.back()[side]);
        if (run.rims[side] == rim && s > low && s < high) return true;
      }
      return false;
    });
  }

  /// A file that knows one stitch per vertex leaves a cell open where two seams meet: a run that ends less than that before a
  /// corner of both rims, or the end of another run, goes on to it.
  void extend() {
    for (Run& run : runs_)
      for (const bool at_end : {false, true}) {
        const Both last = at_end ? run.points.back() : run.points.front();
        Both corner{};
        bool has_both = true;
        for (std::size_t side = 0; side < 2 && has_both; ++side) {
          const double sense = (at_end ? 1.0 : -1.0) * (side == 0 || run.is_along() ? 1.0 : -1.0);
          corner[side] = next_end(run, side, last[side], sense);
          const double way = std::abs(corner[side] - last[side]), spacing = rims_[run.rims[side]].spacing();
          const bool is_free =
              way < near_break * spacing || !is_sewn(run.rims[side], 0.5 * (corner[side] + last[side]));
          has_both = way > 1e-9 * spacing && way < 1.5 * spacing && is_free;
        }
        if (has_both) run.points.insert(at_end ? run.points.end() : run.points.begin(), corner);
      }
  }

  /// The nearest break, or end of another run, from the end of a run on; far away if there is none.
  [[nodiscard]] double next_end(const Run& run, std::size_t side, double last, double sense) const {
    const std::size_t rim = run.rims[side];
    double best = sense * std::numeric_limits<double>::infinity();
    const auto look_at = [&](double s) {
      const double way = sense * (s - last);
      if (way > -1e-9 * rims_[rim].length() && way < sense * (best - last)) best = s;
    };
    for (const double s : rims_[rim].breaks) look_at(s);
    for (const Run& other : runs_)
      for (std::size_t k = 0; k < 2; ++k)
        if (&other != &run && other.rims[k] == rim)
          for (const Both& end : {other.points.front(), other.points.back()}) look_at(end[k]);
    return best;
  }

  void snap(Run& run) {
    for (Both* end : {&run.points.front(), &run.points.back()})
      for (std::size_t side = 0; side < 2; ++side) (*end)[side] = rims_[run.rims[side]].break_near((*end)[side]);
  }

  /// Divides runs at breaks of either rim, until none has any inside.
  void divide() {
    for (std::size_t k = 0; k < runs_.size(); ++k)
      while (divide_once(k)) {
      }
  }

  [[nodiscard]] bool divide_once(std::size_t k) {
    for (std::size_t side = 0; side < 2; ++side) {
      const auto [low, high] = std::minmax(runs_[k].points.front()[side], runs_[k].points.back()[side]);
      const std::vector<double>& breaks = rims_[runs_[k].rims[side]].breaks;
      const auto at = std::upper_bound(breaks.begin(), breaks.end(), low);
      if (at == breaks.end() || *at >= high) continue;
      Both middle{};
      middle[side] = *at;
      middle[1 - side] = rims_[runs_[k].rims[1 - side]].break_near(runs_[k].opposite(side, *at));
      Run rest = runs_[k];
      const auto is_before = [&](const Both& p) {
        return side == 0 || runs_[k].is_along() ? p[side] < middle[side] : p[side] > middle[side];
      };
      std::erase_if(rest.points, is_before);
      std::erase_if(runs_[k].points, [&](const Both& p) { return !is_before(p); });
      if (rest.points.front()[side] != middle[side]) rest.points.insert(rest.points.begin(), middle);
      rest.points.front() = middle;
      runs_[k].points.push_back(middle);
      runs_.push_back(std::move(rest));
      return true;
    }
    return false;
  }

  [[nodiscard]] std::vector<RimSeam> seams() const {
    std::vector<RimSeam> found;
    for (const Run& run : runs_) {
      RimSeam seam{run.rims, {}, run.is_along()};
      bool is_whole = true;
      for (std::size_t side = 0; side < 2; ++side) {
        const std::vector<double>& breaks = rims_[run.rims[side]].breaks;
        const auto [low, high] = std::minmax(run.points.front()[side], run.points.back()[side]);
        const auto at = std::find(breaks.begin(), breaks.end(), low);
        seam.edges[side] = static_cast<std::size_t>(at - breaks.begin());
        is_whole = is_whole && at + 1 < breaks.end() && *(at + 1) == high;
      }
      if (is_whole && (run.rims[0] != run.rims[1] || seam.edges[0] != seam.edges[1])) found.push_back(seam);
    }
    return found;
  }

  std::vector<Rim>& rims_;
  const std::vector<std::vector<std::vector<RimPlace>>>& meet_;
  std::vector<Run> intervals_, runs_;
};

}  // namespace

Vec2 Rim::at(double where) const {
  const auto next = std::clamp(std::upper_bound(s.begin(), s.end(), where), s.begin() + 1, s.end() - 1);
  const auto i = static_cast<std::size_t>(next - s.begin()) - 1;
  const Vec2 &a = points[i], &b = points[(i + 1) % points.size()];
  return a + (where - s[i]) / (s[i + 1] - s[i]) * (b - a);
}

double Rim::break_near(double where) {
  const auto at = std::lower_bound(breaks.begin(), breaks.end(), where);
  const auto nearer = [&](double a, double b) { return std::abs(a - where) < std::abs(b - where); };
  const double nearest = at == breaks.end()     ? breaks.back()
                         : at == breaks.begin() ? breaks.front()
                                                : std::min(*(at - 1), *at, nearer);
  if (std::abs(nearest - where) <= near_break * spacing()) return nearest;
  breaks.insert(at, where);
  return where;
}

Curve Rim::curve(std::size_t edge) const {
  const double low = breaks[edge], high = breaks[edge + 1], small = 1e-9 * length();
  std::vector<Vec2> way{at(low)};
  for (std::size_t i = 0; i < points.size(); ++i)
    if (s[i] > low + small && s[i] < high - small) way.push_back(points[i]);
  way.push_back(edge + 2 == breaks.size() ? points.front() : at(high));
  const Vec2 chord = way.back() - way.front(), across = Vec2(-chord[1], chord[0]).normalized();
  const auto is_on_chord = [&](const Vec2& x) {
    return std::abs(across.dot(x - way.front())) < straight * chord.norm();
  };
  if (std::all_of(way.begin(), way.end(), is_on_chord)) return Curve::bezier({way.front(), way.back()});
  std::vector<Curve> parts;
  for (std::size_t i = 1; i < way.size(); ++i) parts.push_back(Curve::bezier({way[i - 1], way[i]}));
  return Curve::chain(std::move(parts));
}

std::vector<RimSeam> find_rim_seams(std::vector<Rim>& rims,
                                    const std::vector<std::vector<std::vector<RimPlace>>>& meet) {
  return RimJoiner(rims, meet).run();
}

}  // namespace voile::pattern
