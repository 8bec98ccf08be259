// Steady vibration of a system reduced to a few coordinates, and its mean squares under a random excitation.
//
// Symbols   k, c, f   stiffness, damping and force in coordinates q of unit mass: q'' + c q' + k q = f cos(omega t)
//           k = V diag(lambda) V^T,  zeta_i damping ratios of the coordinates V^T q, besides c
//   (diag(lambda) - omega^2 + i omega (2 diag(zeta sqrt(lambda)) + V^T c V)) V^T q = V^T f      q(t) = Re(q e^(i omega t))
//           S(f) one-sided power spectral density, log S linear in log f between the points of its table, 0 outside
//   mean square of |h|:  integral of |h(f)|^2 S(f) df, by Gauss's rule on intervals graded towards every peak
//   mean of h_i h_j:     integral of Re(h_i conj(h_j)) S(f) df, likewise
// Source: R.W. Clough & J. Penzien, Dynamics of Structures, 3rd ed. (2003), 3, 12 and 22.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace voile::solve {

/// k, c, f, and what is observed: rows R.
struct ReducedSystem {
  Eigen::MatrixXd stiffness, damping;  ///< the second may be empty
  Eigen::VectorXd force;
  Eigen::MatrixXd rows;
  /// The same in the first `count` coordinates.
  [[nodiscard]] ReducedSystem first(Eigen::Index count) const;
};

class ReducedResponse {
 public:
  /// `ratios` may be empty; the last one is for all coordinates after it.
  ReducedResponse(const ReducedSystem& system, const std::vector<double>& ratios);
  /// R q at a frequency [Hz].
  [[nodiscard]] Eigen::VectorXcd at(double frequency) const;
  /// q.
  [[nodiscard]] Eigen::VectorXcd coordinates(double frequency) const;
  /// The sum of the sizes of what each coordinate V^T q adds to R q, which may cancel there.
  [[nodiscard]] Eigen::VectorXd size_at(double frequency) const;
  /// sqrt(lambda)/2 pi, ascending [Hz], and the damping ratio that each coordinate has in all.
  [[nodiscard]] const std::vector<double>& frequencies() const { return frequencies_; }
  [[nodiscard]] const std::vector<double>& ratios() const { return all_ratios_; }

 private:
  [[nodiscard]] Eigen::VectorXcd modal_at(double omega) const;

  Eigen::VectorXd lambda_, force_, rate_;  ///< rate: 2 zeta sqrt(lambda)
  Eigen::MatrixXd rows_, damping_;         ///< R V; V^T c V, or empty
  Eigen::MatrixXd vectors_;                ///< V
  std::vector<double> frequencies_, all_ratios_;
};

/// A power spectral density by its table.
struct SpectralDensity {
  std::vector<double> frequencies, values;  ///< ascending and positive [Hz]; positive
  [[nodiscard]] double at(double frequency) const;
};

/// Integral of |h|^2 S over the frequency for each entry of h(frequency [Hz]), which peaks at the response's frequencies.
[[nodiscard]] Eigen::VectorXd mean_squares(const ReducedResponse& response, const SpectralDensity& density,
                                           const std::function<Eigen::VectorXcd(double frequency)>& h);

/// Integral of Re(h h^H) S over the frequency.
[[nodiscard]] Eigen::MatrixXd covariance(const ReducedResponse& response, const SpectralDensity& density,
                                         const std::function<Eigen::VectorXcd(double frequency)>& h);

}  // namespace voile::solve
