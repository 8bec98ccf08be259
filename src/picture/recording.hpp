// A run as moments to look at: one folder of results or several stages in a row, steps or modes.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/length_unit.hpp"
#include "base/time_unit.hpp"
#include "flat_sheet.hpp"
#include "results/stored_run.hpp"

namespace voile::picture {

/// A step of a part of a recording; of a mode also how far it swings.
struct Moment {
  std::size_t part = 0;
  std::optional<std::size_t> step{};  ///< place in the part's steps; none: the mesh at the start
  double swing = 1.0;                 ///< factor of a mode, -1 to 1
};

/// Where everything is at a moment [m].
struct State {
  std::shared_ptr<const results::StoredMesh> mesh;
  std::vector<Vec3> positions, obstacles;
};

/// Of times in the output folder of a run or of one of its stages.
[[nodiscard]] const TimeUnit& time_unit_in(const std::filesystem::path& folder);

/// Which part of a recording is wanted.
struct Choice {
  std::string stage;  ///< empty: all stages
  int mode = 0;       ///< number of a mode; 0: steps
};

/// Not collective. All throw UserError if what is asked for is not there or damaged.
class Recording {
 public:
  /// `place`: the output folder of a run, also of one in stages, or a results.vtkhdf.
  explicit Recording(const std::filesystem::path& place, const Choice& choice = {});

  struct Part {
    std::string stage;  ///< empty without stages
    results::StoredRun run;
    bool in_time = false;  ///< a motion, else a load path or a drape
    bool modes = false;
    std::vector<double> mode_values{};  ///< frequencies [Hz] or critical load factors
    std::string frequency_unit{};       ///< empty: they are load factors
    std::vector<Vec3> about{};          ///< what modes swing about; empty: the mesh at the start
  };
  [[nodiscard]] const std::vector<Part>& parts() const { return parts_; }
  /// Against gravity, if the case has any; else z.
  [[nodiscard]] const Vec3& up() const { return up_; }
  /// Length of 1 in the results [m].
  [[nodiscard]] double metres() const { return metres_; }
  /// Its name, such as mm.
  [[nodiscard]] const char* unit() const { return name_of_metres(metres_); }
  /// Of times.
  [[nodiscard]] const TimeUnit& time_unit() const { return time_unit_; }
  /// As the case lists them.
  [[nodiscard]] const std::vector<SheetMaterial>& materials() const { return materials_; }
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

  /// "all", "last", a number, "first:last" or "first:last:stride" by the numbers that the run printed. A single number is
  /// looked for from the last part backwards. Without any steps: the mesh at the start.
  [[nodiscard]] std::vector<Moment> select(const std::string& steps) const;
  /// Positions with displacements times `scale`. Modes: `scale` is the largest displacement [m].
  [[nodiscard]] State state(const Moment& moment, double scale) const;
  [[nodiscard]] std::shared_ptr<const results::StoredMesh> mesh(const Moment& moment) const;
  /// Number of the step, or -1 at the start.
  [[nodiscard]] int number(const Moment& moment) const;
  /// E.g. "t = 0.25 s", "load factor 0.5", "mode 2: 3.1 Hz", of a vibration "3.1 Hz".
  [[nodiscard]] std::string caption(const Moment& moment) const;

 private:
  void add_part(const std::filesystem::path& folder, const std::string& stage);
  void add_modes(const std::filesystem::path& folder, const std::string& stage, const Choice& choice);
  [[nodiscard]] std::vector<Vec3> last_positions(const std::filesystem::path& folder) const;
  void read_case(const std::filesystem::path& file, std::vector<std::string>& stages);

  std::filesystem::path folder_;
  std::vector<Part> parts_;
  Vec3 up_ = Vec3::UnitZ();
  double metres_ = 1.0;
  TimeUnit time_unit_ = time_units.front();
  std::vector<SheetMaterial> materials_;
  mutable std::map<std::pair<std::size_t, std::size_t>, std::shared_ptr<const results::StoredMesh>> meshes_;
};

}  // namespace voile::picture
