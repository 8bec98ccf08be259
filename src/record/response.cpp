#include "response.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voile::record {

namespace {

using Kind = input::Probe::Kind;
using Complex = std::complex<double>;

Eigen::Vector3cd stress_of(const std::vector<Complex>& values, std::size_t last) {
  return {values[last - 2], values[last - 1], values[last]};
}

}  // namespace

double highest_frequency(const input::HarmonicSection& section) {
  const double band = section.psd_frequencies.empty() ? 0.0 : section.psd_frequencies.back();
  const double fields = section.field_frequencies.empty() ? 0.0 : section.field_frequencies.back();
  return std::max({band, fields, section.frequencies.empty() ? section.to : section.frequencies.back()});
}

bool counts(const input::Case& c, const std::vector<double>& values, std::size_t i) {
  constexpr double rigid = 1e-3;
  if (c.analysis != input::Analysis::harmonic || values[i] <= highest_frequency(c.harmonic)) return true;
  return std::all_of(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(i),
                     [&](double lower) { return lower < rigid * values[i]; });
}

Eigen::Vector3cd von_mises_parts(const Eigen::Vector3cd& s) {
  const double root = std::sqrt(3.0);
  return {0.5 * (s[0] + s[1]), 0.5 * root * (s[0] - s[1]), root * s[2]};
}

double largest_von_mises(const Eigen::Vector3cd& s) {
  const Eigen::Vector3cd parts = von_mises_parts(s);
  const Complex square = parts.transpose() * parts;
  return std::sqrt(0.5 * (parts.squaredNorm() + std::abs(square)));
}

ResponseTable::ResponseTable(const std::filesystem::path& folder, const std::string& frequency,
                             std::vector<Probes::Component> components, Vec3 base, bool random)
    : components_(std::move(components)), base_(std::move(base)), random_(random) {
  add_entries();
  std::vector<std::string> columns{frequency};
  for (const Entry& e : entries_) add_columns(e, columns);
  if (!folder.empty()) table_.emplace(folder / "response.csv", columns);
}

void ResponseTable::add_entries() {
  for (std::size_t i = 0; i < components_.size(); ++i) {
    const Probes::Component& c = components_[i];
    const std::string unit = c.kind == Kind::displacement ? "m" : c.kind == Kind::reaction ? "N" : "Pa";
    entries_.push_back({i, false});
    peaks_.push_back({.column = c.column, .unit = unit});
    if (c.kind != Kind::stress || c.axis != 2) continue;
    entries_.push_back({i, true});
    peaks_.push_back({.column = c.column.substr(0, c.column.size() - 2) + "von_mises", .unit = unit});
  }
}

void ResponseTable::add_columns(const Entry& e, std::vector<std::string>& columns) const {
  const std::string& name = peaks_[static_cast<std::size_t>(&e - entries_.data())].column;
  columns.push_back(name + "_amplitude");
  if (!e.von_mises) columns.push_back(name + "_phase");
  if (moves(e)) columns.push_back(name + "_acceleration");
  if (random_ && !e.von_mises) columns.push_back(name + (moves(e) ? "_acceleration_psd" : "_psd"));
}

Complex ResponseTable::acceleration(const Entry& e, double frequency, Complex displacement) const {
  const double omega = 2.0 * std::numbers::pi * frequency;
  return base_[components_[e.component].axis] - omega * omega * displacement;
}

void ResponseTable::add(double frequency, const std::vector<Complex>& values, double density) {
  constexpr double degree = std::numbers::pi / 180.0;
  std::vector<double> row{frequency};
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const Entry& e = entries_[i];
    ResponsePeak& peak = peaks_[i];
    const Complex value = values[e.component];
    const double amplitude = e.von_mises ? largest_von_mises(stress_of(values, e.component)) : std::abs(value);
    const double acceleration = moves(e) ? std::abs(this->acceleration(e, frequency, value)) : 0.0;
    row.push_back(amplitude);
    if (!e.von_mises) row.push_back(std::arg(value) / degree);
    if (moves(e)) row.push_back(acceleration);
    if (random_ && !e.von_mises) row.push_back(std::pow(moves(e) ? acceleration : amplitude, 2) * density);
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

Eigen::VectorXcd ResponseTable::random_parts(double frequency, const std::vector<Complex>& values) const {
  std::vector<Complex> all;
  for (const Entry& e : entries_) {
    const Complex value = values[e.component];
    if (e.von_mises) {
      const Eigen::Vector3cd parts = von_mises_parts(stress_of(values, e.component));
      all.insert(all.end(), parts.begin(), parts.end());
      continue;
    }
    all.push_back(value);
    if (moves(e)) all.push_back(acceleration(e, frequency, value));
  }
  return Eigen::Map<const Eigen::VectorXcd>(all.data(), static_cast<Eigen::Index>(all.size()));
}

void ResponseTable::take_mean_squares(const Eigen::VectorXd& squares) {
  Eigen::Index at = 0;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const Eigen::Index parts = entries_[i].von_mises ? 3 : 1;
    peaks_[i].mean = std::sqrt(squares.segment(at, parts).sum());
    at += parts;
    if (moves(entries_[i])) peaks_[i].mean_acceleration = std::sqrt(squares[at++]);
  }
}

std::string ResponseTable::text() const {
  std::string lines = fmt::format("{:>16} {:>14} {:>5} {:>10} {:>20} {:>10}", "probe", "amplitude", "", "at [Hz]",
                                  "acceleration [m/s^2]", "at [Hz]");
  lines += random_ ? fmt::format(" {:>10} {:>13}\n", "rms", "rms [m/s^2]") : "\n";
  for (std::size_t i = 0; i < peaks_.size(); ++i) {
    const ResponsePeak& p = peaks_[i];
    lines += fmt::format("{:>16} {:>14.5g} {:>5} {:>10.5g}", p.column, p.amplitude, "[" + p.unit + "]", p.frequency);
    lines += moves(entries_[i]) ? fmt::format(" {:>20.5g} {:>10.5g}", p.acceleration, p.acceleration_frequency)
                                : fmt::format(" {:>20} {:>10}", "", "");
    if (p.mean) lines += fmt::format(" {:>10.4g}", *p.mean);
    if (p.mean_acceleration) lines += fmt::format(" {:>13.4g}", *p.mean_acceleration);
    lines.erase(lines.find_last_not_of(' ') + 1);
    lines += "\n";
  }
  return lines;
}

}  // namespace voile::record
