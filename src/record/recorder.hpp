// Records accepted states: results.vtkhdf/.xdmf and history.csv, if there is a folder for them, and the progress lines.
#pragma once

#include <chrono>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "discretisation_error.hpp"
#include "energy_text.hpp"
#include "input/case.hpp"
#include "probes.hpp"
#include "results/results.hpp"
#include "run_options.hpp"
#include "seam_report.hpp"
#include "setup/obstacles.hpp"
#include "solve/stepper.hpp"
#include "summary.hpp"
#include "system/contact_report.hpp"
#include "system/dynamics.hpp"
#include "system/model.hpp"
#include "system/state.hpp"
#include "time_left.hpp"
#include "warnings.hpp"

namespace voile::record {

class Recorder {
 public:
  using Control = solve::StaticOptions::Control;
  /// Which fields are meant, by name.
  using Wants = std::function<bool(const std::string& name)>;
  /// Creates the files on rank 0, unless the folder of the options is empty. Collective.
  Recorder(const input::Case& c, const RunOptions& options, system::Model& model);
  /// An accepted step, or the start. `whole`: with its fields, even if `every` would leave them out. Collective.
  void record(const system::State& state, const solve::StepResult& r, bool whole);
  /// Writes the fields of the last recorded state if `every` has left them out. Collective; the model must be that of
  /// the last record.
  void write_pending();
  /// Fields of a state by name, as the results would have them; values on rank 0. Collective; the model must be that of the
  /// state.
  [[nodiscard]] std::vector<results::Field> fields(const system::State& state, const Wants& wants);
  /// Does so, closes the results, and tells if the cells do not resolve the last state. Collective.
  void finish();
  /// The model of later records, perhaps on another mesh; the dynamics of its motion, null outside one. What is pending
  /// must have been written. Collective.
  void use(system::Model& model, const system::Dynamics* dynamics);
  /// Where the field `wanted_size` of later records comes from: sizes of the state in force, right on rank 0; collective.
  /// May be empty.
  void use_sizes(std::function<std::vector<double>()> sizes) { sizes_ = std::move(sizes); }
  /// A remark of the path follower; printed unless quiet.
  void remark(const std::string& text) const;
  /// How far a search within a step has come: the line of progress of a terminal, a remark elsewhere.
  void progress(const std::string& text) const;
  /// The displacement probe with one component as a linear function of the unknowns. Collective.
  [[nodiscard]] petsc::VecHandle functional(const std::string& probe) const {
    return probes_->functional(probe, *model_);
  }
  [[nodiscard]] double wall_seconds() const;
  /// Spurious energy of chords over that stored, in the last state whose fields were written; on rank 0. Not a
  /// number if it is not estimated.
  [[nodiscard]] double membrane_error() const { return membrane_error_; }
  /// The ply that is nearest to failure in the last state whose fields were written, likewise; none without strengths.
  [[nodiscard]] const std::optional<FirstFailure>& failure() const { return failure_; }
  /// Energy by which stress resultants differ from smooth ones over that stored, likewise.
  [[nodiscard]] const DiscretisationError& recovery_error() const { return discretisation_error_; }
  /// What history.csv has or would have, on rank 0; rows only where the options keep them. Not collective.
  struct History {
    std::vector<std::string> columns;
    std::vector<std::vector<double>> rows;
  };
  [[nodiscard]] const History& history() const { return kept_; }
  /// Forgets the rows after the first `count`: the run continues from an earlier state. Not collective.
  void forget_rows(std::size_t count) {
    if (count < kept_.rows.size()) kept_.rows.resize(count);
  }
  /// Writes seams.csv, and says which seams are open widest. Collective.
  void report_seams(const system::State& state) const;
  /// Of the motion so far.
  [[nodiscard]] const KineticEnergy& kinetic() const { return kinetic_; }

 private:
  void begin_epoch();
  [[nodiscard]] std::vector<std::string> columns() const;
  /// What probes and fields are taken from, gathered.
  struct Snapshot {
    Observed state;
    system::ContactReport contact;
    long intersections = 0;
    double kinetic = 0.0;        ///< of a motion [J]
    std::vector<double> bodies;  ///< columns of rigid groups, on rank 0
    Validity validity;           ///< rank 0
  };
  /// Velocities and accelerations at a time; null where nothing moves, or where accelerations are not known yet.
  struct Motion {
    Vec v = nullptr, a = nullptr;
    double time = 0.0;
  };
  [[nodiscard]] Motion motion_of(const system::State& state) const {
    return dynamics_ ? Motion{state.v, state.a, state.time} : Motion{};
  }
  /// A recorded state whose fields are not written.
  struct Pending {
    results::StepFields step;
    petsc::VecHandle position, velocity, acceleration;
  };
  [[nodiscard]] Snapshot snapshot(Vec a, const Motion& motion);
  /// Columns of rigid groups; of a turn that the case prescribes all of it, beyond the rotation's 2 pi.
  [[nodiscard]] std::vector<double> bodies_of(Vec a, Vec force, double time) const;
  /// Only its displacements and reactions.
  [[nodiscard]] Snapshot gathered(Vec a, const Motion& motion);
  /// Whether estimates of error are made: not of modes, which have no size.
  [[nodiscard]] bool estimates() const { return !case_.finds_modes(); }
  void write_fields(results::StepFields step, Vec a, const Snapshot& s);
  /// `judged`: estimates of error are made, wanted or not, and remembered as those of this place on the path; may be null.
  [[nodiscard]] std::vector<results::Field> fields_of(Vec a, const Snapshot& s, const Wants& wants,
                                                      const std::string* judged);
  /// Strain below which a state is only round-off. Collective.
  [[nodiscard]] double round_off_strain(Vec a) const;
  [[nodiscard]] std::vector<results::Field> stresses(const system::TriangleFields& t, const Wants& wants,
                                                     bool all) const;
  void write_or_keep(bool write, results::StepFields step, Vec position, const Motion& motion, const Snapshot& s);
  void write_step(const system::State& state, const solve::StepResult& r, const Snapshot& s, bool whole);
  void write_history(const system::State& state, const solve::StepResult& r, const Snapshot& s);
  void print_motion(const system::State& state, const solve::StepResult& r, const Snapshot& s) const;
  void print_path(const system::State& state, const solve::StepResult& r, const Snapshot& s) const;
  [[nodiscard]] std::string time_left(double end) const;
  [[nodiscard]] std::string clock_text(const std::string& left) const;
  [[nodiscard]] std::string contact_note(const Snapshot& s, const solve::StepResult& r) const;
  [[nodiscard]] std::vector<double> common_values(const system::State& state, const solve::StepResult& r,
                                                  const Snapshot& s) const;
  [[nodiscard]] long count_intersections(Vec a) const;
  /// How far the first equilibrium of a case with [form] is from its prestress.
  void say_form(const system::State& state, const solve::StepResult& r);
  [[nodiscard]] bool wants(const std::string& field) const;
  [[nodiscard]] bool has_folder() const { return !options_.output.empty(); }
  [[nodiscard]] bool keeps_balance() const {
    return case_.analysis == input::Analysis::dynamic && case_.output.energy_balance;
  }

  const input::Case& case_;
  const RunOptions& options_;
  system::Model* model_;
  const mesh::SurfaceMesh* mesh_;  ///< of the results' last epoch
  const system::Dynamics* dynamics_ = nullptr;
  std::function<std::vector<double>()> sizes_;
  bool root_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::optional<Probes> probes_;
  std::optional<setup::ObstaclePicture> obstacles_;  ///< rank 0, with contact
  std::optional<results::ResultsWriter> results_;
  std::optional<results::HistoryWriter> history_;
  History kept_;
  std::optional<Pending> pending_;
  bool linear_;
  bool said_form_ = false;
  Warnings warnings_;
  double membrane_error_ = std::nan("");
  std::optional<FirstFailure> failure_;
  DiscretisationError discretisation_error_;
  KineticEnergy kinetic_;
  SeamReport seams_;
  TimeLeft time_left_;
};

}  // namespace voile::record
