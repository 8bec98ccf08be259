// Vibration of probes over the frequency: response.csv, and the largest amplitudes.
#pragma once

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
/// Whether a mode of this value (frequency [Hz], load factor) counts for the result, not only for what completes it.
[[nodiscard]] bool counts(const input::Case& c, double value);

/// On one rank.
class ResponseTable {
 public:
  /// `base`: acceleration of the base, to which displacements are relative [m/s^2]. `folder` may be empty. With `random`
  /// there is a power spectral density of the acceleration of each component. Throws UserError.
  ResponseTable(const std::filesystem::path& folder, std::vector<Probes::Component> components, Vec3 base, bool random);

  /// Displacements u and accelerations -omega^2 u + base, as amplitudes at this frequency [Hz]. `density`: of the
  /// excitation, relative to that of unit size.
  void add(double frequency, const std::vector<std::complex<double>>& displacement, double density);
  [[nodiscard]] std::complex<double> acceleration(std::size_t component, double frequency,
                                                  std::complex<double> displacement) const;
  [[nodiscard]] std::vector<ResponsePeak>& peaks() { return peaks_; }
  /// One line for each component.
  [[nodiscard]] std::string text() const;

 private:
  std::vector<Probes::Component> components_;
  Vec3 base_;
  bool random_;
  std::vector<ResponsePeak> peaks_;
  std::optional<results::HistoryWriter> table_;
};

}  // namespace voile::record
