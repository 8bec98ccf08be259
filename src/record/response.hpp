// Vibration of probes over the frequency: response.csv, and the largest amplitudes.
//
// Symbols   s = (s11, s22, s12) complex amplitude of a stress, s(t) = Re(s e^(i omega t));  s_v(t)^2 = s(t).Q s(t) von Mises
//   largest s_v in a cycle:  sqrt((s^H Q s + |s^T Q s|) / 2)
//   mean of s_v^2:           mean squares of (s11 + s22)/2, sqrt(3) (s11 - s22)/2, sqrt(3) s12, added up
// Source: D.J. Segalman et al., J. Vib. Acoust. 122 (2000) 42-48.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <filesystem>
#include <optional>
#include <vector>

#include "probes.hpp"
#include "results/results.hpp"
#include "summary.hpp"

namespace voile::record {

/// The highest frequency of the response [Hz].
[[nodiscard]] double highest_frequency(const input::HarmonicSection& section);
/// Whether mode i of these values (frequencies [Hz], load factors) counts for the result, not only for what completes it. Of a response
/// below all modes that strain, the first of them does.
[[nodiscard]] bool counts(const input::Case& c, const std::vector<double>& values, std::size_t i);

/// The three parts whose squares add up to von Mises's stress squared, and its largest value in a cycle.
[[nodiscard]] Eigen::Vector3cd von_mises_parts(const Eigen::Vector3cd& stress);
[[nodiscard]] double largest_von_mises(const Eigen::Vector3cd& stress);

/// On one rank.
class ResponseTable {
 public:
  /// `frequency`: its column. `base`: acceleration of the base, to which displacements are relative [m/s^2]. `folder` may be empty. With `random`
  /// there is a power spectral density of the acceleration of each component. Throws UserError.
  ResponseTable(const std::filesystem::path& folder, const std::string& frequency,
                std::vector<Probes::Component> components, Vec3 base, bool random);

  /// Amplitudes at this frequency [Hz] of what the components observe; accelerations are -omega^2 u + base. `density`: of
  /// the excitation, relative to that of unit size.
  void add(double frequency, const std::vector<std::complex<double>>& values, double density);
  /// What mean squares are wanted of, for these amplitudes; and takes them in the same order.
  [[nodiscard]] Eigen::VectorXcd random_parts(double frequency, const std::vector<std::complex<double>>& values) const;
  void take_mean_squares(const Eigen::VectorXd& squares);
  [[nodiscard]] const std::vector<Probes::Component>& components() const { return components_; }
  [[nodiscard]] const std::vector<ResponsePeak>& peaks() const { return peaks_; }
  /// One line for each component.
  [[nodiscard]] std::string text() const;

 private:
  /// A line of the text: a component, or von Mises's stress of the three that end with it.
  struct Entry {
    std::size_t component;
    bool von_mises;
  };
  [[nodiscard]] bool moves(const Entry& e) const {
    return components_[e.component].kind == input::Probe::Kind::displacement;
  }
  [[nodiscard]] std::complex<double> acceleration(const Entry& e, double frequency,
                                                  std::complex<double> displacement) const;
  void add_entries();
  void add_columns(const Entry& e, std::vector<std::string>& columns) const;

  std::vector<Probes::Component> components_;
  std::vector<Entry> entries_;
  Vec3 base_;
  bool random_;
  std::vector<ResponsePeak> peaks_;
  std::optional<results::HistoryWriter> table_;
};

}  // namespace voile::record
