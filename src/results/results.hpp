// Results as one HDF5 file in the VTKHDF layout with an XDMF description, both for ParaView, and a history of named
// numbers as CSV. Written by one rank from gathered arrays, step by step: every file is complete and readable after
// each step.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "mesh/surface_mesh.hpp"

namespace voile::results {

enum class Centre { vertex, triangle };

/// One field of one step; values are row-major, vertex or triangle numbers as in the mesh file's order of reading.
struct Field {
  std::string name;  ///< e.g. "displacement"
  std::string unit;  ///< e.g. "m"; stored as an attribute
  Centre centre = Centre::vertex;
  int components = 1;          ///< 1, 3 or 9; 3 is written as a vector for vertices
  std::vector<double> values;  ///< count x components
};

struct StepFields {
  int step = 0;
  double time = 0.0;         ///< shown by ParaView; never decreasing
  double load_factor = 0.0;  ///< stored as an attribute
  std::vector<Field> fields;
  std::vector<Vec3> obstacles{};  ///< where the vertices of obstacles are [m]; only if they move
  std::vector<double> path{};     ///< of a path: what its next step needs (system::path_record)
  std::vector<double> bodies{};   ///< of rigid groups: what a restart needs (system::rigid_record)
};

/// What the sheet can touch, as triangles to look at.
struct ObstacleTriangles {
  std::vector<std::string> names;         ///< of the obstacles; empty: there are none
  std::vector<Vec3> positions;            ///< at rest [m]
  std::vector<mesh::Triangle> triangles;  ///< vertices of all obstacles are numbered through
  std::vector<int> obstacle;              ///< per triangle: entry of `names`
  bool moves = false;                     ///< each step then has positions of its own
};

/// results.vtkhdf + results.xdmf in a folder, and steps/ while steps come. Not collective: root only.
///
/// Layout (see docs/reference/results.md): /VTKHDF as version 2.0 of that format has it (an UnstructuredGrid with steps), all that
/// is ours under /voile. Points of a step are positions at rest plus the field `displacement`, if there is one, in
/// single precision: they are looked at. Fields are /VTKHDF/PointData/FIELD and CellData/FIELD in double precision; one of 3
/// components on triangles is called FIELD_11_22_12, for ParaView's X, Y, Z then mean 11, 22, 12. A step without a field
/// that others have holds NaN there. In names of groups every character but letters, digits, '_', '-' and '.' is replaced by
/// '_' (attribute `name`: the original). Meshes (epochs) are stored once each, exactly, to be read back.
/// With obstacles also obstacles.xdmf, /voile/obstacles/{names,triangles,obstacle,positions} and, if they move,
/// /voile/steps/obstacle_positions. Their positions are single precision, too.
///
/// While steps come, each is a file of its own in steps/ and results.vtkhdf an index of virtual datasets over them;
/// finish() copies all into results.vtkhdf and removes steps/. A process killed at any moment, inside write() and finish()
/// too, leaves all steps readable whose write() had returned, the latest of them perhaps in steps/ only: naming each step
/// at once would cost as much as there are steps. Every file is written under another name and then renamed. Steps are not
/// forced to the disk, so a power failure can lose the latest; finish() forces its file there before steps/ goes.
class ResultsWriter {
 public:
  using Clock = std::function<std::chrono::steady_clock::time_point()>;

  /// Creates the folder, without results of an earlier run. `length`: unit of positions; `clock` tells when names are due, see
  /// write(). Throws UserError if the folder cannot be written.
  explicit ResultsWriter(const std::filesystem::path& folder, ObstacleTriangles obstacles = {},
                         std::string length = "m", Clock clock = std::chrono::steady_clock::now);
  ~ResultsWriter();
  ResultsWriter(ResultsWriter&&) noexcept;
  ResultsWriter& operator=(ResultsWriter&&) noexcept;

  /// The mesh of the steps that come, with the rank of each vertex and triangle. Throws UserError if the disk is full.
  void begin_epoch(const mesh::SurfaceMesh& mesh, const std::vector<int>& vertex_rank,
                   const std::vector<int>& triangle_rank);
  /// Groups whose names HDF5 paths do not allow, as "name -> path".
  [[nodiscard]] const std::vector<std::string>& renamed_groups() const;
  /// Adds one step on the mesh of the last epoch; all files are closed and readable when it returns. results.vtkhdf and
  /// results.xdmf name it at once unless they were renewed just before, less than twenty times ago what that took; then
  /// when a further step comes, or by flush(). Throws UserError if the disk is full; what was there stays readable.
  void write(const StepFields& step);
  /// Makes results.vtkhdf and results.xdmf name every step. Throws UserError if the disk is full.
  void flush();
  /// Puts everything into results.vtkhdf; nothing can be written after that. The destructor does so too, but tells nobody
  /// if it cannot. Throws UserError if the disk is full: all steps then stay readable as they are.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// history.csv: a header line, then one line per accepted step, flushed. Not collective: root only.
class HistoryWriter {
 public:
  HistoryWriter(const std::filesystem::path& file, const std::vector<std::string>& columns);
  ~HistoryWriter();
  HistoryWriter(HistoryWriter&&) noexcept;
  HistoryWriter& operator=(HistoryWriter&&) noexcept;
  void write(const std::vector<double>& values);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Version of the HDF5 library in use.
[[nodiscard]] std::string hdf5_version();

}  // namespace voile::results
