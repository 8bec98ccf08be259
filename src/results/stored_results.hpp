// Looking into a results.vtkhdf, whatever state its run is in; private to src/io.
//
// A finished run has everything in the one file. Of one that goes on or was killed it is an index, and meshes and fields are
// read from steps/ beside it, where there may be steps that the index does not name yet.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/child_process.hpp"
#include "hdf5_read.hpp"
#include "results_catalogue.hpp"
#include "stored_run.hpp"

namespace voile::results {

/// The open file; throws UserError if something that is asked for is not there or damaged.
class StoredResults {
 public:
  explicit StoredResults(const std::filesystem::path& path);

  [[nodiscard]] bool complete() const { return complete_; }
  [[nodiscard]] const std::vector<StoredStepInfo>& steps() const { return steps_; }
  /// The last step of that number; negative: the last step.
  [[nodiscard]] std::size_t find(int number) const;
  /// Fields of a step, by name.
  [[nodiscard]] std::vector<FieldInfo> fields(std::size_t step) const;
  /// Values of a field that the step has, `count` rows.
  [[nodiscard]] std::vector<double> values(std::size_t step, const FieldInfo& field, std::size_t count) const;
  /// A vector field on vertices; nothing if the step does not have it.
  [[nodiscard]] std::optional<std::vector<double>> vectors(std::size_t step, const std::string& name,
                                                           std::size_t vertices) const;
  void check_mesh(std::size_t step, const mesh::SurfaceMesh& mesh) const;
  [[nodiscard]] StoredMesh mesh(std::size_t epoch) const;
  /// No names if the run has no obstacles.
  [[nodiscard]] ObstacleTriangles obstacles() const;
  /// Where vertices of obstacles are; empty if none moves.
  [[nodiscard]] std::vector<Vec3> obstacle_positions(std::size_t step, std::size_t count) const;

 private:
  template <class Work>
  void with_epoch(std::size_t epoch, const Work& work) const;
  void read_named();
  void find_unnamed();
  [[nodiscard]] ObstacleTriangles obstacles_in(hid_t file, const std::string& at,
                                               const std::filesystem::path& place) const;
  [[nodiscard]] std::pair<Hdf5Handle, std::filesystem::path> open_step(std::size_t step) const;
  /// Fields that any step may have.
  [[nodiscard]] const std::vector<FieldInfo>& known_fields() const;
  [[nodiscard]] bool has_field(const std::string& name, std::size_t step) const;
  [[nodiscard]] std::int64_t read_entry(const std::string& list, std::size_t step) const;
  [[noreturn]] void fail_missing(const std::string& file) const;

  std::filesystem::path path_;
  Hdf5Handle file_;
  bool complete_ = false;
  std::vector<StoredStepInfo> steps_;
  // Of a finished run, once read
  mutable std::map<std::string, std::vector<std::int64_t>> entries_;
  mutable std::vector<FieldInfo> known_;
};

/// Whether its run has ended, so that steps/ is not needed.
[[nodiscard]] bool holds_everything(const std::filesystem::path& path);

/// Calls work(results); once more if the run ended meanwhile and took steps/ away.
template <class Work>
auto with_results(const std::filesystem::path& path, const Work& work) {
  const Silence silence;
  const bool complete = holds_everything(path);
  try {
    return work(StoredResults(path));
  } catch (const UserError&) {
    if (complete || !holds_everything(path)) throw;
    return work(StoredResults(path));
  }
}

/// Does it in a process of its own first: HDF5 can crash on a damaged file.
template <class Work>
auto guarded(const std::filesystem::path& path, const Work& work) {
  try_in_child(path.string(), [&] { (void)with_results(path, work); });
  return with_results(path, work);
}

}  // namespace voile::results
