// Results as HDF5 with an XDMF description that ParaView opens, and a history of named numbers as CSV.
// Written by one rank from gathered arrays, step by step: every file is complete and readable after each step.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "voile/mesh/surface_mesh.hpp"

namespace voile::io {

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
};

/// What the sheet can touch, as triangles to look at.
struct ObstacleTriangles {
  std::vector<std::string> names;         ///< of the obstacles; empty: there are none
  std::vector<Vec3> positions;            ///< at rest [m]
  std::vector<mesh::Triangle> triangles;  ///< vertices of all obstacles are numbered through
  std::vector<int> obstacle;              ///< per triangle: entry of `names`
  bool moves = false;                     ///< each step then has positions of its own
};

/// results.h5 + results.xdmf + steps/NNNNNN.h5 in a folder. Not collective: root only.
/// Layout of results.h5: /mesh/{positions,triangles}, /mesh/groups/NAME (0/1 masks),
/// /mesh/partition/{vertices,triangles}, /steps/NNNNNN/FIELD. Each step is a link to a file of its own, which HDF5
/// follows by itself. In group names every character but letters, digits, '_', '-' and '.' is replaced by '_'
/// (attribute `name`: the original). In the XDMF a field of 3 components on triangles appears as FIELD_11_22_12:
/// ParaView's X, Y, Z then mean 11, 22, 12.
/// With obstacles also obstacles.xdmf, /obstacles/{names,triangles,obstacle,positions} in results.h5 and, if they move,
/// /steps/NNNNNN/obstacle_positions. Their positions are single precision: they are looked at, not computed with.
///
/// A process killed at any moment, inside write() too, leaves all steps readable whose write() had returned, the latest
/// of them perhaps in steps/ only: naming each step at once would cost as much as there are steps. Every file
/// is written under another name and then renamed. (One growing HDF5 file would not do: a kill while HDF5 updates its
/// index makes the whole file unreadable, about once in a hundred kills during a write.) Nothing is forced to the disk,
/// so a power failure can lose the latest steps.
class ResultsWriter {
 public:
  /// Creates the files (replacing old ones). Throws UserError if the folder cannot be written.
  ResultsWriter(const std::filesystem::path& folder, const mesh::SurfaceMesh& mesh, const std::vector<int>& vertex_rank,
                const std::vector<int>& triangle_rank, const ObstacleTriangles& obstacles = {});
  ~ResultsWriter();
  ResultsWriter(ResultsWriter&&) noexcept;
  ResultsWriter& operator=(ResultsWriter&&) noexcept;

  /// Groups whose names HDF5 paths do not allow, as "name -> path".
  [[nodiscard]] std::vector<std::string> renamed_groups() const;
  /// Adds one step; all files are closed and readable when it returns. Beyond 64 steps results.h5 and
  /// results.xdmf name it after two seconds at the latest, once further steps come, or by finish(). Throws UserError if
  /// the disk is full.
  void write(const StepFields& step);
  /// Makes results.h5 and results.xdmf name every step. The destructor does so too, but tells nobody if it cannot.
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

}  // namespace voile::io
