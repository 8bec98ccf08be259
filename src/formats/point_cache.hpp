// Positions of a deforming mesh by key frames: .pc2, .mdd or a sequence of .obj files.
//
// Symbols   t_k   time of key frame k [s], ascending      x_v(t_k)   position of vertex v there [m]
//
//   x_v(t) = (1 - s) x_v(t_k) + s x_v(t_(k+1)),   s = (t - t_k) / (t_(k+1) - t_k),   for t_k <= t < t_(k+1)
//
// and the first or last key frame outside. The velocity of the interpolation jumps at the key frames.
//
// Formats   PC2   "POINTCACHE2\0", int32 version 1, int32 vertices, float32 first frame, float32 frames per sample,
//                 int32 samples, then float32 x y z for each vertex of each sample; little-endian.
//                 t_k = (first frame + k x frames per sample) / frames per second
//           MDD   int32 frames, int32 vertices, float32 t_k of each frame [s], then float32 x y z for each vertex of
//                 each frame; big-endian
//           OBJ   the lines 'v x y z' of each file. t_k = (number of the frame) / frames per second
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/types.hpp"

namespace voile::formats {

/// Checked completely when opened, but only the key frames in use are kept: the files must stay as they are.
/// Not collective: any rank may have its own. One object must not be used by two threads at a time.
class PointCache {
 public:
  /// `file` is a .pc2, a .mdd, or a pattern for .obj files: either "name_%04d.obj", whose number (of at least four
  /// digits; %d: any) is the number of the frame, or "name_*.obj", whose files, ascending by the number that takes the
  /// place of the '*' (or by name, unless all are numbers), are the frames 0, 1, 2, ... The file's numbers are taken as
  /// metres. `frames_per_second` applies to PC2 and OBJ; MDD has seconds, of which one is `second` in the unit of
  /// all times here.
  /// Throws UserError that names the file if it is missing, cut short, too long or of another kind, if values are not
  /// finite or times do not ascend, if files of a sequence differ in their number of vertices or
  /// in their faces, or if frames_per_second is not positive.
  explicit PointCache(const std::filesystem::path& file, double frames_per_second = 24.0, double second = 1.0);
  ~PointCache();
  PointCache(PointCache&&) noexcept;
  PointCache& operator=(PointCache&&) noexcept;

  [[nodiscard]] Index vertex_count() const;
  /// Number of key frames, at least 1.
  [[nodiscard]] Index frame_count() const;
  /// Time of a key frame [s].
  [[nodiscard]] double time(Index frame) const;
  /// Times of the first and last key frame [s].
  [[nodiscard]] double start() const;
  [[nodiscard]] double end() const;
  /// Largest size of a coordinate in all key frames [m].
  [[nodiscard]] double largest_coordinate() const;
  /// The longest way of a vertex from one key frame to the next.
  struct Step {
    Index frame = 0, vertex = 0;        ///< the frame that it begins with
    double way = 0.0, elsewhere = 0.0;  ///< and the longest between other frames [m]
  };
  [[nodiscard]] const Step& largest_step() const;
  /// What is odd about the files: numbers of which some are left out where files are counted; empty: nothing.
  [[nodiscard]] const std::string& remark() const;
  /// Positions at a time [s], in the order of the file [m]; the caller owns them.
  /// Throws UserError if the file has gone or changed its length since it was opened.
  [[nodiscard]] std::vector<Vec3> positions(double time) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace voile::formats
