// How what probes observe of a vibration depends on the amplitudes of a few displacements.
//
// Symbols   q   complex amplitudes of the displacements v_j;  h what is observed;  p force of unit size on what is held, and stress of
//               unit load factor
//   h = (A + i omega B - omega^2 N) q + g p,   g factor of the excitation;  B, N: of reactions only (support_forces.hpp)
#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "probes.hpp"
#include "state_change.hpp"
#include "vibration_fields.hpp"

namespace voile::record {

/// On rank 0: a row for each component of the probes, a column for each displacement.
struct ResponseRows {
  Eigen::MatrixXd stiffness, damping, inertia;  ///< A, B, N
  Eigen::VectorXd constant;                     ///< p
  /// h at a frequency [Hz].
  [[nodiscard]] std::vector<std::complex<double>> at(double frequency, const Eigen::VectorXcd& q,
                                                     std::complex<double> factor) const;
};

class ResponseObserver {
 public:
  /// `place` and `forces` must outlive it. Collective. Throws UserError.
  ResponseObserver(const input::Case& c, const VibrationPlace& place, SupportForces& forces);
  /// Collective.
  [[nodiscard]] ResponseRows rows_of(const std::vector<petsc::VecHandle>& vectors);
  [[nodiscard]] ResponseRows rows_of(Vec x, Vec y);
  [[nodiscard]] const Probes& probes() const { return probes_; }

 private:
  void add_column(Vec v, ResponseRows& rows);
  void add_constant(ResponseRows& rows);
  [[nodiscard]] std::vector<double> values(Vec displacement, Vec force, StateChange* stress);

  const VibrationPlace& place_;
  SupportForces& forces_;
  Probes probes_;
};

/// Sizes of what is observed: of a reaction or stress the largest of its components, of a displacement its own.
[[nodiscard]] Eigen::VectorXd largest_of_probes(const std::vector<Probes::Component>& components,
                                                Eigen::VectorXd sizes);
/// W of a symmetric positive matrix W W^T, square; exact to round-off in each row by itself.
[[nodiscard]] Eigen::MatrixXd root_of(const Eigen::MatrixXd& m);

}  // namespace voile::record
