// A run's results as a list of steps, to look at them or to hand them on. The run may be finished, going on or killed.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/child_process.hpp"
#include "mesh/surface_mesh.hpp"
#include "results.hpp"

namespace voile::results {

/// Leaves HDF5 as it is when the program ends, for programs that only read: after a damaged file it cannot close itself and fills
/// the terminal with its inner tables. Before anything is read.
void leave_hdf5_at_exit();

struct StoredStepInfo {
  int number = 0;     ///< as the run printed it
  double time = 0.0;  ///< [s]; of a load path its load factor
  double load_factor = 0.0;
  std::size_t epoch = 0;                 ///< number of the mesh
  std::vector<double> path{}, bodies{};  ///< as StepFields; empty: none
};

struct FieldInfo {
  std::string name, unit;
  Centre centre = Centre::vertex;
  int components = 1;
};

/// A mesh as it was written: positions at the start, triangles, groups, texture.
struct StoredMesh {
  mesh::MeshData data;
  std::vector<int> triangle_rank;  ///< of each triangle in the run
  std::string unit = "m";          ///< of positions
};

/// Not collective. A run may go on writing: only what is finished is kept open. Everything is read in a process of its own,
/// since HDF5 can crash on a damaged file: fields in one that stays. All throw UserError with the file and what is the matter with it.
class StoredRun {
 public:
  /// `place`: a results.vtkhdf or the folder it is in.
  explicit StoredRun(const std::filesystem::path& place);

  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  [[nodiscard]] bool complete() const { return complete_; }  ///< the run had ended when this was made
  [[nodiscard]] const std::vector<StoredStepInfo>& steps() const { return steps_; }
  [[nodiscard]] StoredMesh mesh(std::size_t epoch) const;
  /// `step`: place in steps().
  [[nodiscard]] std::vector<FieldInfo> fields(std::size_t step) const;
  /// Throws UserError with the nearest name if the step has no such field. `rows`: vertices or triangles of its mesh.
  [[nodiscard]] Field field(std::size_t step, const std::string& name, const mesh::MeshData& mesh) const;
  [[nodiscard]] bool has_field(std::size_t step, const std::string& name) const;
  /// Obstacles where they rest; no names if there are none.
  [[nodiscard]] const ObstacleTriangles& obstacles() const { return obstacles_; }
  /// Where their vertices are at a step [m].
  [[nodiscard]] std::vector<Vec3> obstacle_positions(std::size_t step) const;

 private:
  std::filesystem::path file_;
  bool complete_ = false;
  std::vector<StoredStepInfo> steps_;
  ObstacleTriangles obstacles_;
  std::shared_ptr<LastingChild> reader_;
};

}  // namespace voile::results
