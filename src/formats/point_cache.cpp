#include "point_cache.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <regex>
#include <sstream>
#include <string>
#include <utility>

#include "base/plain_file.hpp"
#include "voile/errors.hpp"

namespace voile::formats {

namespace {

namespace fs = std::filesystem;
using Positions = std::vector<Vec3>;

[[noreturn]] void fail(const fs::path& file, const std::string& what) {
  throw UserError(fmt::format("{}: {}", file.string(), what));
}

/// Number of a type of four bytes.
template <class Number>
Number decode(const char* bytes, std::endian order) {
  std::array<char, 4> copy{};
  std::copy_n(bytes, 4, copy.begin());
  if (order != std::endian::native) std::reverse(copy.begin(), copy.end());
  return std::bit_cast<Number>(copy);
}

/// Where the key frames are: times and a way to read one.
class Frames {
 public:
  Frames() = default;
  virtual ~Frames() = default;
  Frames(const Frames&) = delete;
  Frames& operator=(const Frames&) = delete;
  /// Throws UserError.
  [[nodiscard]] virtual Positions read(std::size_t k) const = 0;

  std::vector<double> times;  ///< [s]
  std::size_t vertex_count = 0;
  std::string remark;
};

// -------------------------------------------------------------------------------------------------------- PC2 and MDD

/// How files count time.
struct Clock {
  double frames_per_second, second;
};

/// Frames of three float32 per vertex, one after the other.
class BinaryFrames : public Frames {
 public:
  BinaryFrames(fs::path file, const Clock& clock, bool is_pc2)
      : file_(std::move(file)), order_(is_pc2 ? std::endian::little : std::endian::big) {
    std::error_code error;
    length_ = fs::file_size(file_, error);
    if (error) fail(file_, "the file cannot be read; check its permissions");
    if (length_ == 0) fail(file_, "the file is empty; export it again");
    if (is_pc2)
      read_pc2_header(clock.frames_per_second);
    else
      read_mdd_header(clock.second);
    for (std::size_t k = 0; k < times.size(); ++k) {
      if (!std::isfinite(times[k])) fail(file_, fmt::format("the time of frame {} is not finite", k));
      if (k > 0 && !(times[k] > times[k - 1]))
        fail(file_, fmt::format("the times of frames {} and {} do not ascend ({} s, {} s); export it again", k - 1, k,
                                times[k - 1], times[k]));
    }
  }

  [[nodiscard]] Positions read(std::size_t k) const override {
    const std::size_t size = 12 * vertex_count;
    const std::string bytes = read_bytes(header_ + k * size, size);
    Positions x(vertex_count);
    for (std::size_t v = 0; v < vertex_count; ++v) {
      for (std::size_t i = 0; i < 3; ++i)
        x[v][static_cast<Eigen::Index>(i)] = decode<float>(bytes.data() + 12 * v + 4 * i, order_);
      if (!x[v].allFinite())
        fail(file_, fmt::format("frame {}: the position of vertex {} (both counted from 0) is not finite; export it "
                                "again",
                                k, v));
    }
    return x;
  }

 private:
  [[nodiscard]] std::string read_bytes(std::size_t begin, std::size_t size) const {
    std::string bytes(size, '\0');
    std::ifstream in = open_input(file_);
    in.seekg(static_cast<std::streamoff>(begin));
    in.read(bytes.data(), static_cast<std::streamsize>(size));
    if (!in) fail(file_, fmt::format("{} bytes cannot be read from byte {} on; is the file complete?", size, begin));
    return bytes;
  }

  /// The counts fit the length of the file. `per_frame`: bytes for each frame besides its positions.
  void check_length(std::int32_t frames, std::int32_t vertices, std::size_t per_frame) {
    if (frames < 1 || vertices < 1)
      fail(file_,
           fmt::format("the header claims {} frames of {} vertices; is it a file of this kind?", frames, vertices));
    // the product may not fit into 64 bits
    const std::size_t frame = 12 * static_cast<std::size_t>(vertices) + per_frame, n = static_cast<std::size_t>(frames);
    const std::size_t rest = length_ - header_;
    if (rest % frame != 0 || rest / frame != n)
      fail(file_,
           fmt::format("{} frames of {} vertices need {} bytes, but the file has {}; export it again", frames, vertices,
                       static_cast<double>(header_) + static_cast<double>(n) * static_cast<double>(frame), length_));
    vertex_count = static_cast<std::size_t>(vertices);
  }

  void read_pc2_header(double frames_per_second) {
    header_ = 32;
    const std::string bytes = length_ < header_ ? std::string() : read_bytes(0, header_);
    if (bytes.compare(0, 12, std::string("POINTCACHE2\0", 12)) != 0)
      fail(file_, "this is no point cache of kind PC2 (it does not start with POINTCACHE2); export it again");
    if (const auto version = decode<std::int32_t>(bytes.data() + 12, order_); version != 1)
      fail(file_, fmt::format("version {} of PC2 is not known; export it as version 1", version));
    const auto frames = decode<std::int32_t>(bytes.data() + 28, order_);
    check_length(frames, decode<std::int32_t>(bytes.data() + 16, order_), 0);
    const double first = decode<float>(bytes.data() + 20, order_), step = decode<float>(bytes.data() + 24, order_);
    if (!(step > 0.0) && frames > 1)
      fail(file_, fmt::format("there are {} frames from one sample to the next; this must be positive", step));
    for (std::int32_t k = 0; k < frames; ++k) times.push_back((first + k * step) / frames_per_second);
  }

  void read_mdd_header(double second) {
    header_ = 8;
    if (length_ < header_) fail(file_, "the file is shorter than the header of MDD; export it again");
    const std::string counts = read_bytes(0, header_);
    const auto frames = decode<std::int32_t>(counts.data(), order_);
    check_length(frames, decode<std::int32_t>(counts.data() + 4, order_), 4);
    const std::string bytes = read_bytes(header_, 4 * static_cast<std::size_t>(frames));
    header_ += bytes.size();
    for (std::size_t k = 0; k < bytes.size(); k += 4) times.push_back(second * decode<float>(bytes.data() + k, order_));
  }

  fs::path file_;
  std::endian order_;
  std::size_t length_ = 0;
  std::size_t header_ = 0;  ///< bytes before the first frame
};

// --------------------------------------------------------------------------------------------------------------- OBJ

/// File and the number of its frame.
using Numbered = std::pair<std::int64_t, fs::path>;

class ObjFrames : public Frames {
 public:
  ObjFrames(const fs::path& pattern, double frames_per_second) {
    for (const auto& [number, file] : matching(pattern, remark)) {
      if (!files_.empty() && number == last_)
        fail(pattern, fmt::format("two files have the number {}: {} and {}; remove one", number,
                                  files_.back().filename().string(), file.filename().string()));
      last_ = number;
      files_.push_back(file);
      times.push_back(static_cast<double>(number) / frames_per_second);
    }
    Contents first = read_contents(files_.front());
    vertex_count = first.vertices.size();
    faces_ = std::move(first.faces);
  }

  [[nodiscard]] Positions read(std::size_t k) const override {
    Contents now = read_contents(files_[k]);
    if (now.vertices.size() != vertex_count)
      fail(files_[k], fmt::format("there are {} vertices, but {} in {}; all files of a sequence must have the same",
                                  now.vertices.size(), vertex_count, files_.front().filename().string()));
    // A file of vertices alone says nothing about faces.
    if (!now.faces.empty() && !faces_.empty() && now.faces != faces_) fail_at_face(files_[k], now.faces);
    return std::move(now.vertices);
  }

 private:
  /// Numbers of the vertices round it, counted from 1, the smallest first.
  using Face = std::vector<long>;
  struct Contents {
    Positions vertices;
    std::vector<Face> faces;
  };

  [[noreturn]] void fail_at_face(const fs::path& file, const std::vector<Face>& faces) const {
    const auto text = [](const std::vector<Face>& all, std::size_t f) {
      return f < all.size() ? fmt::format("{}", fmt::join(all[f], " ")) : std::string("not there");
    };
    const auto at = std::mismatch(faces.begin(), faces.end(), faces_.begin(), faces_.end()).first;
    const auto f = static_cast<std::size_t>(at - faces.begin());
    fail(file,
         fmt::format("face {} (counted from 1, {} in all) is {}, but {} in {} ({} in all): all files of a sequence "
                     "must be of one mesh; export them with the same faces",
                     f + 1, faces.size(), text(faces, f), text(faces_, f), files_.front().filename().string(),
                     faces_.size()));
  }

  /// What follows 'f': vertex, vertex/texture, vertex//normal or all three; negative numbers count back.
  static Face face_of(const std::string& line, std::size_t vertices) {
    Face face;
    std::istringstream words(line);
    std::string word;
    for (words >> word; words >> word;) {
      const long v = std::strtol(word.c_str(), nullptr, 10);
      face.push_back(v < 0 ? static_cast<long>(vertices) + 1 + v : v);
    }
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    return face;
  }

  static Contents read_contents(const fs::path& file) {
    std::ifstream in = open_input(file);
    if (!in) fail(file, "the file cannot be read; check its permissions");
    Contents contents;
    Positions& x = contents.vertices;
    std::string line, word;
    for (int number = 1; std::getline(in, line); ++number) {
      std::istringstream words(line);
      if (!(words >> word)) continue;
      if (word == "f") contents.faces.push_back(face_of(line, x.size()));
      if (word != "v") continue;
      Vec3& last = x.emplace_back(Vec3::Zero());
      if (!(words >> last[0] >> last[1] >> last[2]))
        fail(file, fmt::format("line {}: 'v' must be followed by three finite numbers", number));
    }
    if (x.empty()) fail(file, "there are no vertices (lines 'v x y z'); export it again");
    return contents;
  }

  /// The files of a pattern with the numbers of their frames, ascending. Throws if there are none.
  static std::vector<Numbered> matching(const fs::path& pattern, std::string& remark) {
    const std::string name = pattern.filename().string();
    std::smatch place;
    if (!std::regex_search(name, place, std::regex("%(0(\\d))?d|\\*")))
      fail(pattern, "a sequence of OBJ files needs a place for the number: '*' or e.g. '%04d'");
    const std::string before = place.prefix(), after = place.suffix(), mark = place.str();
    if (after.find_first_of("%*") != std::string::npos) fail(pattern, "only one '*' or '%d' is allowed in the name");
    const std::size_t digits = place[2].matched ? static_cast<std::size_t>(std::stoi(place[2])) : 1;
    const fs::path folder = pattern.has_parent_path() ? pattern.parent_path() : fs::path(".");
    std::vector<std::string> middles;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
      const std::string file = entry.path().filename().string();
      if (file.size() < before.size() + after.size() || !file.starts_with(before) || !file.ends_with(after)) continue;
      const std::string middle = file.substr(before.size(), file.size() - before.size() - after.size());
      if (mark == "*" || (is_number(middle) && middle.size() >= digits)) middles.push_back(middle);
    }
    if (error) fail(folder, "the folder cannot be read; check its name and its permissions");
    if (middles.empty()) fail(pattern, "no file fits this pattern");
    const bool all_numbers = std::all_of(middles.begin(), middles.end(), is_number);
    std::vector<Numbered> files;
    for (const std::string& middle : middles)
      files.emplace_back(all_numbers ? std::stoll(middle) : 0, folder / (before + middle + after));
    std::sort(files.begin(), files.end());
    if (mark != "*") return files;
    if (all_numbers) remark = uneven_steps(files);
    for (std::size_t k = 0; k < files.size(); ++k) files[k].first = static_cast<std::int64_t>(k);
    return files;
  }

  /// Where files are counted one that is missing shifts all that follow: says where that may be.
  static std::string uneven_steps(const std::vector<Numbered>& files) {
    std::int64_t least = std::numeric_limits<std::int64_t>::max();
    for (std::size_t k = 1; k < files.size(); ++k) least = std::min(least, files[k].first - files[k - 1].first);
    for (std::size_t k = 1; k < files.size(); ++k)
      if (const std::int64_t step = files[k].first - files[k - 1].first; step != least)
        return fmt::format(
            "'*' counts files, but after {} comes {}, {} on where others are {} apart: if a frame is "
            "missing, all later ones come too early; export it, or write %d instead of '*', so that "
            "files have the numbers of their frames",
            files[k - 1].second.filename().string(), files[k].second.filename().string(), step, least);
    return "";
  }

  static bool is_number(const std::string& text) {
    return !text.empty() && text.size() <= 15 && text.find_first_not_of("0123456789") == std::string::npos;
  }

  std::vector<fs::path> files_;
  std::vector<Face> faces_;  ///< of the first
  std::int64_t last_ = 0;
};

std::unique_ptr<Frames> open_frames(const fs::path& file, const Clock& clock) {
  if (!(clock.frames_per_second > 0.0) || !std::isfinite(clock.frames_per_second))
    fail(file, fmt::format("{} frames per second; give a positive number", clock.frames_per_second));
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  if (extension == ".obj") return std::make_unique<ObjFrames>(file, clock.frames_per_second);
  if (extension != ".pc2" && extension != ".mdd")
    fail(file, fmt::format("unknown kind of point cache '{}'; give .pc2, .mdd or a pattern for .obj", extension));
  std::error_code ignored;
  if (!fs::exists(file, ignored)) fail(file, "there is no such point cache");
  require_plain_file(file);
  if (!fs::is_regular_file(file, ignored)) fail(file, "this is not a file");
  return std::make_unique<BinaryFrames>(file, clock, extension == ".pc2");
}

}  // namespace

struct PointCache::Impl {
  std::unique_ptr<Frames> frames;
  std::array<std::pair<std::size_t, Positions>, 2> recent;  ///< key frames read last, by number
  std::size_t oldest = 0;                                   ///< which of them to replace next
  double largest = 0.0;                                     ///< coordinate of all
  Step largest_step;

  /// Stays valid until the frame after next is asked for.
  const Positions& frame(std::size_t k) {
    for (std::size_t slot = 0; slot < 2; ++slot)
      if (recent[slot].first == k && !recent[slot].second.empty()) {
        oldest = 1 - slot;
        return recent[slot].second;
      }
    Positions x = frames->read(k);
    const std::size_t slot = std::exchange(oldest, 1 - oldest);
    recent[slot] = {k, std::move(x)};
    return recent[slot].second;
  }
};

PointCache::PointCache(const fs::path& file, double frames_per_second, double second)
    : impl_(std::make_unique<Impl>()) {
  impl_->frames = open_frames(file, {frames_per_second, second});
  for (std::size_t k = 0; k < impl_->frames->times.size(); ++k) {
    const Positions &before = impl_->frame(k > 0 ? k - 1 : 0), &x = impl_->frame(k);
    Step step{static_cast<Index>(k) - 1};
    for (std::size_t v = 0; v < x.size(); ++v) {
      impl_->largest = std::max(impl_->largest, x[v].cwiseAbs().maxCoeff());
      const double way = (x[v] - before[v]).norm();
      if (way <= step.way) continue;
      step.way = way;
      step.vertex = static_cast<Index>(v);
    }
    Step& most = impl_->largest_step;
    if (step.way > most.way) std::swap(step, most);
    most.elsewhere = std::max({most.elsewhere, step.way, step.elsewhere});
  }
}
PointCache::~PointCache() = default;
PointCache::PointCache(PointCache&&) noexcept = default;
PointCache& PointCache::operator=(PointCache&&) noexcept = default;

Index PointCache::vertex_count() const {
  return static_cast<Index>(impl_->frames->vertex_count);
}

Index PointCache::frame_count() const {
  return static_cast<Index>(impl_->frames->times.size());
}

double PointCache::time(Index frame) const {
  return impl_->frames->times[static_cast<std::size_t>(frame)];
}

double PointCache::largest_coordinate() const {
  return impl_->largest;
}

const PointCache::Step& PointCache::largest_step() const {
  return impl_->largest_step;
}

const std::string& PointCache::remark() const {
  return impl_->frames->remark;
}

double PointCache::start() const {
  return impl_->frames->times.front();
}

double PointCache::end() const {
  return impl_->frames->times.back();
}

std::vector<Vec3> PointCache::positions(double time) const {
  const std::vector<double>& times = impl_->frames->times;
  if (!(time > start())) return impl_->frame(0);
  if (time >= end()) return impl_->frame(times.size() - 1);
  const auto after = static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), time) - times.begin());
  const double s = (time - times[after - 1]) / (times[after] - times[after - 1]);
  const Positions &x0 = impl_->frame(after - 1), &x1 = impl_->frame(after);
  std::vector<Vec3> x(x0.size());
  for (std::size_t v = 0; v < x.size(); ++v) x[v] = (1.0 - s) * x0[v] + s * x1[v];
  return x;
}

}  // namespace voile::formats
