// Which rows of which dataset of results.vtkhdf hold what; private to src/io.
//
// A dataset such as /VTKHDF/PointData/displacement holds all steps one after the other. While a run goes on, each step
// and each epoch (a mesh) is a file of its own under steps/, and the datasets are virtual: pieces of those files. When
// it ends, the same pieces are copied. Places never change once given, so that an XDMF of some steps fits each later
// results.vtkhdf.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "hdf5_handle.hpp"
#include "results.hpp"

namespace voile::results {

enum class Number { float64, float32, int64, int32, uint8 };

[[nodiscard]] hid_t memory_type(Number n);
[[nodiscard]] std::size_t bytes_of(Number n);

/// Files relative to the folder of results.vtkhdf, and paths in it.
inline constexpr const char* results_name = "results.vtkhdf";
inline constexpr const char* obstacle_file = "steps/obstacles.h5";
inline constexpr int layout_version = 1;  ///< of what lies under /voile
[[nodiscard]] inline std::string step_file(std::size_t step) {
  return fmt::format("steps/{:06d}.h5", step);
}
[[nodiscard]] inline std::string epoch_file(std::size_t epoch) {
  return fmt::format("steps/epoch_{:06d}.h5", epoch);
}
[[nodiscard]] inline std::string epoch_path(std::size_t epoch) {
  return fmt::format("voile/epochs/{:06d}", epoch);
}
/// In ParaView the components of a symmetric tensor of the surface are called X, Y, Z: the name says what they mean.
[[nodiscard]] inline std::string shown_name(const std::string& field, Centre centre, std::size_t columns) {
  return columns == 3 && centre == Centre::triangle ? field + "_11_22_12" : field;
}

/// Rows `begin` to `begin + rows` of a dataset of results.vtkhdf: all rows of a dataset of another file.
struct Piece {
  std::string file, dataset;
  std::size_t begin, rows;
};

/// A dataset of results.vtkhdf. Rows in no piece hold no value: NaN, or 0 in integers.
struct Table {
  std::string path;
  Number number = Number::float64;
  std::size_t columns = 1, rows = 0;
  std::vector<Piece> pieces{};

  /// Adds all rows of a dataset; returns where they begin.
  std::size_t add(const std::string& file, const std::string& dataset, std::size_t count);
};

/// Values on the vertices or triangles of every step: a field, or what belongs to an epoch (a group, the partition).
struct Array {
  Table table;
  Centre centre = Centre::vertex;
  std::string name;                               ///< as given, shown in XDMF
  bool is_field = false;                          ///< else it belongs to epochs
  std::string unit{};                             ///< of a field
  std::vector<std::int64_t> begin{};              ///< first row of each step
  std::vector<std::uint8_t> present{};            ///< of a field: whether the step has it
  std::map<std::size_t, std::size_t> of_epoch{};  ///< first row of what belongs to an epoch, or of its lack of values
};

/// The mesh of some steps. Its part of the VTKHDF file (NumberOfPoints and so on) has the same number.
struct EpochPlace {
  std::size_t vertices = 0, triangles = 0;
  std::size_t point = 0, triangle = 0;  ///< first row of its rest positions in Points, of its triangles in Types
};

struct StepPlace {
  int number = 0;
  double time = 0.0, load_factor = 0.0;
  std::size_t epoch = 0, point = 0;      ///< `point`: first row of Points
  std::vector<double> path{}, bodies{};  ///< as StepFields
};

class Catalogue {
 public:
  /// Numbers of tables().
  enum { points, connectivity, offsets, types, obstacles };

  /// `length`: unit of positions.
  explicit Catalogue(std::string length) : length_(std::move(length)) {}
  [[nodiscard]] const std::string& length() const { return length_; }

  /// Adds an epoch that lies in epoch_file(): its triangles, groups and partition.
  void begin_epoch(const mesh::SurfaceMesh& mesh);
  /// Adds a step of the last epoch that lies in step_file(). `moved`: it has points of its own.
  void add_step(const StepFields& step, bool moved);
  /// Positions of obstacles in every step; before the first one.
  void let_obstacles_move(std::size_t vertices);

  [[nodiscard]] const std::vector<EpochPlace>& epochs() const { return epochs_; }
  [[nodiscard]] const std::vector<StepPlace>& steps() const { return steps_; }
  [[nodiscard]] const std::vector<Array>& arrays() const { return arrays_; }
  /// Points, Connectivity, Offsets, Types and, if they move, positions of obstacles.
  [[nodiscard]] const std::vector<Table>& tables() const { return tables_; }
  /// Every dataset of many pieces.
  [[nodiscard]] std::vector<const Table*> all_tables() const;
  [[nodiscard]] std::size_t obstacle_vertices() const { return obstacle_vertices_; }
  /// Names of groups that HDF5 paths do not allow, as "'name' is /path".
  [[nodiscard]] const std::vector<std::string>& renamed() const { return renamed_; }
  /// Name of a group in paths, the same in every epoch.
  [[nodiscard]] std::string group_name(const mesh::Group& group);

 private:
  std::string length_;
  Array& array(Centre centre, const std::string& path_name, Number number, std::size_t columns);
  void add_epoch_array(Centre centre, const std::string& path_name, const std::string& name, Number number,
                       const std::string& dataset);
  [[nodiscard]] std::size_t no_values(Array& a, std::size_t epoch) const;
  [[nodiscard]] std::size_t count(std::size_t epoch, Centre centre) const;

  std::vector<EpochPlace> epochs_;
  std::vector<StepPlace> steps_;
  std::vector<Table> tables_{{"VTKHDF/Points", Number::float32, 3, 0, {}},
                             {"VTKHDF/Connectivity", Number::int64, 1, 0, {}},
                             {"VTKHDF/Offsets", Number::int64, 1, 0, {}},
                             {"VTKHDF/Types", Number::uint8, 1, 0, {}}};
  std::vector<Array> arrays_;
  std::map<std::pair<std::string, int>, std::string> group_names_;  ///< by name and dimension
  std::vector<std::string> renamed_;
  std::size_t obstacle_vertices_ = 0;
};

}  // namespace voile::results
