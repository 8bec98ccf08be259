#include "key_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "formats/mesh_file.hpp"
#include "formats/point_cache.hpp"
#include "voile/errors.hpp"

namespace voile::setup {

namespace {

/// Files have single precision or six digits: what differs by less, in parts of the extent, is the same place.
constexpr double same_place = 1e-5;
/// A seam over which a vertex goes so many times further than within any other frame is a jump to the eye.
constexpr double jump = 2.0;
/// So many times further than between any other frames is a leap, where there are more than a few frames.
constexpr double leap = 5.0;
constexpr Index least_frames = 3;

struct Difference {
  double distance = 0.0;  ///< largest [m]
  std::size_t vertex = 0;
};

Difference difference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  Difference d;
  for (std::size_t v = 0; v < a.size(); ++v)
    if (const double distance = (a[v] - b[v]).norm(); distance > d.distance) d = {distance, v};
  return d;
}

double extent(const std::vector<Vec3>& points) {
  Vec3 low = points.front(), high = low;
  for (const Vec3& x : points) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  return (high - low).norm();
}

/// A point cache on the clock of the run, in metres and in place. For the rank that has the file.
class PlacedFrames {
 public:
  PlacedFrames(const input::ObstacleSection& section, std::size_t vertices)
      : cache_(section.frames, section.frames_per_second, section.second),
        placement_(section.placement),
        scale_(section.scale),
        start_(section.frames_start),
        smoothing_(section.frames_smoothing),
        loop_(section.frames_loop) {
    if (static_cast<std::size_t>(cache_.vertex_count()) != vertices)
      throw UserError(fmt::format("{}: it has {} vertices, but {} has {}; frames must be of the same mesh",
                                  section.frames.string(), cache_.vertex_count(), section.file.string(), vertices));
    const double largest = std::sqrt(3.0) * scale_ * cache_.largest_coordinate();
    formats::check_coordinates(section.frames.string(),
                               {Vec3::Zero(), Vec3::Constant(largest) + placement_.translate.cwiseAbs()});
    const double length = cache_.end() - cache_.start();
    const std::vector<Vec3> first = at(cache_.start()), last = at(cache_.end());
    seam_ = difference(first, last);
    if (seam_.distance > same_place * extent(first)) gap_ = length / std::max(cache_.frame_count() - 1, 1);
    period_ = length + gap_;
  }

  [[nodiscard]] std::vector<Vec3> positions(double time) const {
    if (smoothing_ == 0.0) return by_frames(time);
    std::vector<Vec3> mean(static_cast<std::size_t>(cache_.vertex_count()), Vec3::Zero()), before;
    const std::vector<double> times = knots(time - smoothing_, time);
    for (std::size_t k = 0; k < times.size(); ++k) {  // linear between knots
      std::vector<Vec3> now = by_frames(times[k]);
      const double half = k > 0 ? 0.5 * (times[k] - times[k - 1]) / smoothing_ : 0.0;
      for (std::size_t v = 0; k > 0 && v < mean.size(); ++v) mean[v] += half * (before[v] + now[v]);
      before = std::move(now);
    }
    return mean;
  }

  [[nodiscard]] std::vector<std::string> notes(const input::ObstacleSection& section, const std::vector<Vec3>& mesh,
                                               double run_end) const {
    std::vector<std::string> all;
    const std::string name = fmt::format("[[obstacle]] '{}': ", section.shape.name), file = section.frames.string();
    if (!cache_.remark().empty()) all.push_back(name + fmt::format("{}: {}", file, cache_.remark()));
    if (const Difference d = difference(mesh, at(cache_.start())); d.distance > same_place * extent(mesh))
      all.push_back(name + fmt::format("the first frame of {} is not {}: vertex {} (counted from 1) lies {:.4g} m away "
                                       "from there, and the body is where the frame has it; if it should not, export "
                                       "both alike",
                                       file, section.file.string(), d.vertex + 1, d.distance));
    if (cache_.start() != 0.0 && start_ == 0.0)
      all.push_back(name + fmt::format("by the clock of {} its first frame is at {:.6g} s; in the run it is at "
                                       "frames_start = 0 s",
                                       file, cache_.start()));
    const double end = start_ + cache_.end() - cache_.start();
    if (!loop_ && end < run_end * (1.0 - 1e-9))
      all.push_back(name + fmt::format("the last frame of {} is at {:.6g} s, from then to the end of the run at {:.6g} "
                                       "s the body holds still; frames_loop = true repeats the frames",
                                       file, end, run_end));
    const formats::PointCache::Step& most = cache_.largest_step();
    if (cache_.frame_count() > least_frames && most.way > leap * most.elsewhere && most.way > 0.0)
      all.push_back(name + fmt::format("from frame {} of {} to the next vertex {} (both counted from 1) goes {:.4g} m, "
                                       "between other frames no vertex goes further than {:.4g} m; if the body should "
                                       "not leap there, export it again or add frames",
                                       most.frame + 1, file, most.vertex + 1, scale_ * most.way,
                                       scale_ * most.elsewhere));
    const double step = scale_ * most.way;
    if (loop_ && gap_ > 0.0 && seam_.distance > jump * step && run_end > end)
      all.push_back(name + fmt::format("the frames of {} do not end where they begin: within {:.4g} s vertex {} "
                                       "(counted from 1) goes back {:.4g} m, within other frames no vertex goes "
                                       "further than {:.4g} m",
                                       file, gap_, seam_.vertex + 1, seam_.distance, step));
    return all;
  }

 private:
  /// At a time of the run, linear between frames.
  [[nodiscard]] std::vector<Vec3> by_frames(double time) const {
    const double first = cache_.start(), since = time - start_;
    if (!loop_ || since <= 0.0 || period_ == 0.0) return at(first + since);
    const double within = std::fmod(since, period_), after = within - (period_ - gap_);
    if (after <= 0.0) return at(first + within);
    std::vector<Vec3> x = at(cache_.end());
    const std::vector<Vec3> next = at(first);
    for (std::size_t v = 0; v < x.size(); ++v) x[v] += after / gap_ * (next[v] - x[v]);
    return x;
  }

  /// Two times of the run, and those between at which a frame is reached.
  [[nodiscard]] std::vector<double> knots(double from, double to) const {
    std::vector<double> times{from, to};
    for (Index k = 0; k < cache_.frame_count(); ++k) {
      double at = start_ + cache_.time(k) - cache_.start();
      const bool repeats = loop_ && period_ > 0.0;
      if (repeats && at < from) at += std::floor((from - at) / period_) * period_;
      for (; at < to; at += period_) {
        if (at > from) times.push_back(at);
        if (!repeats) break;
      }
    }
    std::sort(times.begin(), times.end());
    return times;
  }

  /// At a time of the file.
  [[nodiscard]] std::vector<Vec3> at(double file_time) const {
    std::vector<Vec3> x = cache_.positions(file_time);
    for (Vec3& p : x) p *= scale_;
    placement_.apply(x);
    return x;
  }

  formats::PointCache cache_;
  formats::Placement placement_;
  double scale_, start_, smoothing_;
  bool loop_;
  Difference seam_;
  double gap_ = 0.0, period_ = 0.0;  ///< d (0: none) and T [s]
};

}  // namespace

void read_frames(MPI_Comm comm, const input::ObstacleSection& section, double end, contact::Obstacle& o,
                 std::vector<std::string>& notes) {
  std::shared_ptr<PlacedFrames> frames;  // on rank 0, which reads the file
  std::vector<std::string> said;
  mpi::on_root(comm, [&] {
    frames = std::make_shared<PlacedFrames>(section, o.points.size());
    said = frames->notes(section, o.points, end);
  });
  std::vector<Index> count{static_cast<Index>(said.size())};
  mpi::broadcast(comm, count);
  said.resize(static_cast<std::size_t>(count.front()));
  for (std::string& text : said) {
    mpi::broadcast(comm, text);
    notes.push_back(text);
  }
  o.frames = [comm, frames](double time) {
    std::vector<double> values;
    mpi::on_root(comm, [&] {
      for (const Vec3& x : frames->positions(time)) values.insert(values.end(), x.begin(), x.end());
    });
    mpi::broadcast(comm, values);
    std::vector<Vec3> x;
    for (std::size_t i = 0; i + 2 < values.size(); i += 3) x.emplace_back(values[i], values[i + 1], values[i + 2]);
    return x;
  };
}

}  // namespace voile::setup
