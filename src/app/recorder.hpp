// Records accepted states: results.h5/.xdmf, history.csv and the progress lines; private to src/app.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "voile/app/run.hpp"
#include "voile/io/results.hpp"
#include "voile/solve/static_path.hpp"
#include "voile/system/model.hpp"

namespace voile::app {

class Recorder {
 public:
  /// Creates the files on rank 0. Collective.
  Recorder(const Case& c, const RunOptions& options, system::Model& model);
  /// Collective.
  void record(const solve::StepReport& report, Vec a);
  /// A remark of the path follower; printed unless quiet.
  void remark(const std::string& text) const;
  [[nodiscard]] double wall_seconds() const;

 private:
  struct ProbeVertices {
    std::vector<Index> vertices;
    std::vector<int> components;
  };
  void resolve_probes();
  [[nodiscard]] std::vector<std::string> columns() const;
  void write_fields(const solve::StepReport& report, Vec a, std::vector<double> displacement,
                    std::vector<double> reaction);
  void write_history(const solve::StepReport& report, const std::vector<double>& displacement,
                     const std::vector<double>& reaction, const system::Energies& energies);
  void print(const solve::StepReport& report) const;
  [[nodiscard]] bool wants(const std::string& field) const;

  const Case& case_;
  const RunOptions& options_;
  system::Model& model_;
  bool root_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::vector<ProbeVertices> probes_;
  std::optional<io::ResultsWriter> results_;
  std::optional<io::HistoryWriter> history_;
};

}  // namespace voile::app
