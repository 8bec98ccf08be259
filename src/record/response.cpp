#include "response.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voile::record {

double highest_frequency(const input::HarmonicSection& section) {
  const double band = section.psd_frequencies.empty() ? 0.0 : section.psd_frequencies.back();
  return std::max(band, section.frequencies.empty() ? section.to : section.frequencies.back());
}

bool counts(const input::Case& c, double value) {
  return c.analysis != "harmonic" || value <= highest_frequency(c.harmonic);
}

ResponseTable::ResponseTable(const std::filesystem::path& folder, std::vector<Probes::Component> components, Vec3 base,
                             bool random)
    : components_(std::move(components)), base_(std::move(base)), random_(random) {
  std::vector<std::string> columns{"frequency_hz"};
  for (const Probes::Component& c : components_) {
    peaks_.push_back({.column = c.column, .mean_displacement = {}, .mean_acceleration = {}});
    for (const char* part : {"_amplitude", "_phase", "_acceleration"}) columns.push_back(c.column + part);
    if (random_) columns.push_back(c.column + "_acceleration_psd");
  }
  if (!folder.empty()) table_.emplace(folder / "response.csv", columns);
}

std::complex<double> ResponseTable::acceleration(std::size_t component, double frequency,
                                                 std::complex<double> displacement) const {
  const double omega = 2.0 * std::numbers::pi * frequency;
  return base_[components_[component].axis] - omega * omega * displacement;
}

void ResponseTable::add(double frequency, const std::vector<std::complex<double>>& displacement, double density) {
  constexpr double degree = std::numbers::pi / 180.0;
  std::vector<double> row{frequency};
  for (std::size_t i = 0; i < displacement.size(); ++i) {
    const double amplitude = std::abs(displacement[i]);
    const double acceleration = std::abs(this->acceleration(i, frequency, displacement[i]));
    row.insert(row.end(), {amplitude, std::arg(displacement[i]) / degree, acceleration});
    if (random_) row.push_back(acceleration * acceleration * density);
    ResponsePeak& peak = peaks_[i];
    if (amplitude > peak.amplitude) {
      peak.amplitude = amplitude;
      peak.frequency = frequency;
    }
    if (acceleration > peak.acceleration) {
      peak.acceleration = acceleration;
      peak.acceleration_frequency = frequency;
    }
  }
  if (table_) table_->write(row);
}

std::string ResponseTable::text() const {
  std::string lines = fmt::format("{:>16} {:>14} {:>10} {:>20} {:>10}", "probe", "amplitude [m]", "at [Hz]",
                                  "acceleration [m/s^2]", "at [Hz]");
  lines += random_ ? fmt::format(" {:>10} {:>13}\n", "rms [m]", "rms [m/s^2]") : "\n";
  for (const ResponsePeak& p : peaks_) {
    lines += fmt::format("{:>16} {:>14.5g} {:>10.5g} {:>20.5g} {:>10.5g}", p.column, p.amplitude, p.frequency,
                         p.acceleration, p.acceleration_frequency);
    lines += random_ ? fmt::format(" {:>10.4g} {:>13.4g}\n", p.mean_displacement.value_or(0.0),
                                   p.mean_acceleration.value_or(0.0))
                     : "\n";
  }
  return lines;
}

}  // namespace voile::record
