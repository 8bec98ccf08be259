// Records accepted states: results.h5/.xdmf, history.csv and the progress lines; private to src/app.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "obstacles.hpp"
#include "validity.hpp"
#include "voile/app/run.hpp"
#include "voile/io/results.hpp"
#include "voile/solve/static_path.hpp"
#include "voile/solve/time_integration.hpp"
#include "voile/system/model.hpp"

namespace voile::app {

class Recorder {
 public:
  using Control = solve::StaticOptions::Control;
  /// Creates the files on rank 0. Collective.
  Recorder(const input::Case& c, const RunOptions& options, system::Model& model, const solve::StaticOptions& steps);
  /// Collective.
  void record(const solve::StepReport& report, Vec a);
  /// A step of a motion in time. Collective.
  void record(const solve::TimeReport& report, system::Dynamics& dynamics);
  /// Writes the fields of the last recorded state if `every` has left them out, and closes the results. Collective; the
  /// model must be that of the last record.
  void finish();
  /// The model of later records, of the same mesh.
  void use(system::Model& model) { model_ = &model; }
  /// A remark of the path follower; printed unless quiet.
  void remark(const std::string& text) const;
  /// The displacement probe with one component as a linear function of the unknowns. Collective.
  [[nodiscard]] petsc::VecHandle functional(const std::string& probe) const;
  [[nodiscard]] double wall_seconds() const;

 private:
  struct ProbeVertices {
    std::vector<Index> vertices;
    std::vector<int> components;
  };
  void resolve_probes();
  [[nodiscard]] std::vector<std::string> columns() const;
  /// What probes and fields are taken from, gathered.
  struct Snapshot {
    std::vector<double> displacement, reaction;
    system::Energies energies;
    system::ContactReport contact;
    long intersections = 0;
    Validity validity;  ///< rank 0
  };
  /// A recorded state whose fields are not written.
  struct Pending {
    io::StepFields step;
    petsc::VecHandle position, velocity;
  };
  /// How contact hindered the iterations of a step.
  struct ContactEffort {
    int cut_short = 0;
    double shortest = 1.0;
  };
  [[nodiscard]] Snapshot snapshot(Vec a);
  void write_fields(io::StepFields step, Vec a, const Snapshot& s);
  void write_or_keep(bool write, io::StepFields step, Vec position, Vec velocity, const Snapshot& s);
  void warn_of_range(const Validity& v);
  void write_history(std::vector<double> values, const ContactEffort& effort, const Snapshot& s);
  void print(const solve::TimeReport& report, double kinetic, const Snapshot& s) const;
  void print(const solve::StepReport& report, const Snapshot& s) const;
  [[nodiscard]] std::string contact_note(const Snapshot& s, const ContactEffort& effort) const;
  void add_contact_fields(io::StepFields& step, Vec a) const;
  [[nodiscard]] long count_intersections(Vec a) const;
  [[nodiscard]] bool wants(const std::string& field) const;

  const input::Case& case_;
  const RunOptions& options_;
  system::Model* model_;
  solve::StaticOptions steps_;
  bool root_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::vector<ProbeVertices> probes_;
  std::optional<ObstaclePicture> obstacles_;  ///< rank 0, with contact
  std::optional<io::ResultsWriter> results_;
  std::optional<io::HistoryWriter> history_;
  std::optional<Pending> pending_;
  bool warned_of_strain_ = false, warned_of_turn_ = false;
};

}  // namespace voile::app
