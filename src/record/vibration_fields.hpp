// Fields of a vibration: amplitudes at chosen frequencies, and root mean squares of a random one.
//
// Symbols   x + i y   complex displacement;  s + i t   what depends on it linearly, of unit load factor s_0
//           V vectors of a basis, q their amplitudes;  G mean of (q, 1)(q, 1)^T = W W^T, W from its eigenvectors
//   amplitude |s + i t|,  of von Mises's stress its largest value in a cycle (response.hpp)
//   mean square of s = S (q, 1):  sum over the columns w of W of (S w)^2, which is exact without a correlation of fields
#pragma once

#include <complex>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "input/unit_system.hpp"
#include "results/results.hpp"
#include "support_forces.hpp"

namespace voile::record {

/// Where the fields of a model's vibration about a state go.
struct VibrationPlace {
  system::Model& model;
  Vec about;
  std::filesystem::path folder;  ///< empty: nowhere
  const input::UnitSystem& units;
  Vec3 base = Vec3::Zero();  ///< acceleration of the base [m/s^2]
  bool by_loads = false;     ///< of loads of unit load factor, not of a base
};

class VibrationFields {
 public:
  /// Collective; `place` and `forces` must outlive it.
  VibrationFields(const VibrationPlace& place, SupportForces& forces);

  /// Amplitudes at a frequency [Hz], ascending, in the folder `response`; `of_base`: factor of the force of the base's
  /// acceleration on what is held. Collective.
  void write(double frequency, Vec x, Vec y, std::complex<double> of_base);
  /// Root mean squares in the folder `random`: W by rows of the basis and a last one for the loads, and the same of accelerations,
  /// whose last row is that of the base. Collective; W on all ranks.
  void write_mean(const std::vector<petsc::VecHandle>& basis, const Eigen::MatrixXd& w,
                  const Eigen::MatrixXd& accelerations);
  /// Collective.
  void finish();

 private:
  /// Stresses and resultants, one after another, on rank 0.
  [[nodiscard]] std::vector<double> change(Vec u);
  [[nodiscard]] std::vector<double> combined(const std::vector<double>& real,
                                             const std::vector<double>& imaginary) const;
  void add_stresses(const std::vector<double>& square, std::vector<results::Field>& fields, const char* suffix) const;
  void add_reactions(Vec x, Vec y, double omega, std::complex<double> of_base, std::vector<results::Field>& fields);
  void open(std::optional<results::ResultsWriter>& writer, const char* name) const;
  void add(std::vector<results::Field>& fields, const std::string& name, const char* unit, results::Centre centre,
           int components, std::vector<double> values) const;

  const VibrationPlace& place_;
  SupportForces& forces_;
  bool root_, layered_;
  int steps_ = 0;
  std::vector<double> of_loads_;  ///< as change(), of unit load factor; empty: a base
  petsc::VecHandle held_;         ///< force on what is held, of unit load factor or of the base
  std::optional<results::ResultsWriter> response_;
};

}  // namespace voile::record
