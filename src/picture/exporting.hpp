// What the writers of formats share; private to src/picture.
#pragma once

#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "export.hpp"
#include "image.hpp"
#include "pieces.hpp"
#include "resample.hpp"
#include "unfinished.hpp"

namespace voile::picture {

/// One thing that is exported, all moments of it in turn.
struct Body {
  std::string name;
  std::vector<Vec3f> positions;
  std::vector<mesh::Triangle> triangles;
  bool moves = true;
};

/// The sheet and the bodies of a moment.
struct Snapshot {
  State state;
  Body sheet, bodies;  ///< no triangles: there are none
  int number = 0;
  double time = 0.0;  ///< [s] since the first moment: of a motion its own, otherwise that of the frame
};

class Exporter {
 public:
  Exporter(const Recording& recording, const std::vector<Moment>& moments, const ExportOptions& options);
  [[nodiscard]] std::size_t size() const { return moments_.size(); }
  [[nodiscard]] Snapshot snapshot(std::size_t i) const;
  /// Since the first frame [s].
  [[nodiscard]] double time(std::size_t i) const { return times_[i]; }
  /// Whether a frame has the mesh of the one before.
  [[nodiscard]] bool same_mesh(std::size_t i) const;
  /// Fields of a moment that are asked for, as they are stored.
  [[nodiscard]] std::vector<results::Field> fields(std::size_t i) const;
  [[nodiscard]] const Recording& recording() const { return recording_; }
  [[nodiscard]] const ExportOptions& options() const { return options_; }
  /// The output with something after its stem.
  [[nodiscard]] std::filesystem::path file(const std::string& suffix, const std::string& ending = "") const;
  /// The output, with the frame's number if there are several frames.
  [[nodiscard]] std::filesystem::path frame_file(std::size_t i) const;
  /// What the snapshots so far came to.
  [[nodiscard]] std::vector<std::string> notes() const;

 private:
  const Recording& recording_;
  std::vector<Moment> moments_;
  std::vector<double> times_;
  const ExportOptions& options_;
  /// Puts a snapshot on the one mesh, and notes how well it lies there.
  void put_on_one_mesh(Snapshot& s) const;

  std::size_t meshes_ = 1;  ///< that follow each other in the frames
  std::unique_ptr<Resampled> one_mesh_;
  mutable double distance_ = 0.0;       ///< largest of the snapshots so far [m]
  mutable std::set<int> intersecting_;  ///< numbers of those whose sheet intersects itself or a body
};

using Files = std::vector<std::filesystem::path>;

/// A file that is written whole or reported.
class OutFile {
 public:
  explicit OutFile(const std::filesystem::path& file);
  std::ofstream& stream() { return out_; }
  template <class Value>
  void put(const Value& value) {
    out_.write(reinterpret_cast<const char*>(&value), sizeof(Value));
  }
  /// Throws UserError if anything could not be written; then adds the name. Without it the file is removed in the end.
  void finish(Files& files);

 private:
  std::filesystem::path file_;
  Unfinished unfinished_;  // goes after the stream is closed
  std::ofstream out_;
};

[[nodiscard]] Files export_obj(const Exporter& e);
[[nodiscard]] Files export_stl(const Exporter& e);
[[nodiscard]] Files export_ply(const Exporter& e);
[[nodiscard]] Files export_csv(const Exporter& e);
[[nodiscard]] Files export_pc2(const Exporter& e);
[[nodiscard]] Files export_mdd(const Exporter& e);
[[nodiscard]] Files export_glb(const Exporter& e);
[[nodiscard]] Files export_usda(const Exporter& e);
[[nodiscard]] Files export_msh(const Exporter& e);
[[nodiscard]] Files export_vtu(const Exporter& e);

void write_obj(const std::filesystem::path& file, const char* unit, const std::vector<const Body*>& bodies,
               const mesh::MeshData* texture, Files& files);

}  // namespace voile::picture
