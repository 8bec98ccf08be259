#include "harmonic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "base/frequency_unit.hpp"
#include "base/interrupt.hpp"
#include "base/mpi.hpp"
#include "base/text.hpp"
#include "excitation.hpp"
#include "modes.hpp"
#include "record/response.hpp"
#include "record/response_rows.hpp"
#include "record/vibration_fields.hpp"
#include "solve/direct_response.hpp"
#include "solve/modal_basis.hpp"
#include "voile/errors.hpp"

namespace voile::simulation {

namespace {

using Section = input::HarmonicSection;
using Complex = std::complex<double>;

/// Relative error of a probe by the modes that are left out, above which the user is warned.
constexpr double truncation_limit = 0.01;

std::vector<double> spaced(const Section& s) {
  std::vector<double> all;
  for (int i = 0; i < s.points; ++i) {
    const double part = static_cast<double>(i) / (s.points - 1);
    all.push_back(s.spacing == Section::Spacing::linear ? s.from + part * (s.to - s.from)
                                                        : s.from * std::pow(s.to / s.from, part));
  }
  all.back() = s.to;
  return all;
}

/// With the peaks of the modes, unless the user has listed the frequencies.
std::vector<double> frequencies_of(const Section& s, const solve::ReducedResponse* response) {
  if (!s.frequencies.empty()) return s.frequencies;
  std::vector<double> all = spaced(s);
  for (std::size_t i = 0; response && i < response->frequencies().size(); ++i) {
    const double peak = response->frequencies()[i], ratio = response->ratios()[i];
    if (!(ratio > 0.0)) continue;
    for (const double f : {peak * (1.0 - ratio), peak, peak * (1.0 + ratio)})
      if (f > s.from && f < s.to) all.push_back(f);
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

/// Throws unless the modes are those of a stable equilibrium and reach the highest frequency, or are all. Collective.
void check_modes(const input::Case& c, const system::Model& model, const std::vector<solve::Mode>& modes) {
  const double last = modes.back().value, highest = record::highest_frequency(c.harmonic);
  if (modes.front().value < 0.0 && rigid_modes(c, model, modes).front() == 0)
    throw UserError(fmt::format(
        "{}: analysis = \"harmonic\": the equilibrium is unstable (mode 1 at {:g} Hz), and a vibration about it grows; "
        "find the stable one first, with a stage of analysis = \"drape\"",
        c.file.string(), modes.front().value));
  const bool all = static_cast<long>(modes.size()) >= solve::free_unknowns(model);
  if (last < highest && !all)
    throw UserError(
        fmt::format("{}: eigen.modes (or -eps_nev): {} modes reach {:.4g} Hz, but the response is wanted up to {:.4g} "
                    "Hz; raise it, or remove the key",
                    c.file.string(), modes.size(), last, highest));
}

/// What the response is not sure of, on rank 0.
void warn(const std::vector<double>& resonances, double error, double at) {
  std::vector<std::string> names;
  for (const double f : resonances) names.push_back(fmt::format("{:.4g}", f));
  if (!names.empty())
    fmt::print(stderr,
               "voile: warning: nothing damps the resonance(s) at {} Hz: amplitudes near them depend on how near the "
               "frequencies come; give [damping] ratio\n",
               join(names, ", "));
  if (error > truncation_limit)
    fmt::print(stderr,
               "voile: warning: modes that are left out change a probe by about {:.2g} % at {:.4g} Hz; raise [eigen] "
               "modes, or remove the key\n",
               100.0 * error, at);
}

std::vector<double> undamped_within(const solve::ReducedResponse& response, std::size_t modes, double low,
                                    double high) {
  std::vector<double> all;
  for (std::size_t i = 0; i < modes; ++i)
    if (const double f = response.frequencies()[i]; f >= low && f <= high && !(response.ratios()[i] > 0.0))
      all.push_back(f);
  return all;
}

class Run {
 public:
  Run(const input::Case& c, const record::RunOptions& options, system::Model& model, Vec a, const VibrationModes& modes)
      : c_(c),
        model_(model),
        a_(a),
        modes_(modes),
        excitation_(excitation_of(c, model, a, modes.inertia)),
        damping_(solve::damping_matrix(model, a, c.dynamics, modes.mass)),
        units_(c.units),
        place_{model, a, options.output, units_, excitation_.base, c.harmonic.excitation == Section::Excitation::loads},
        forces_(model, a, c.dynamics, modes.mass),
        observer_(c, place_, forces_),
        fields_(place_, forces_) {
    mpi::on_root(model.dofs().comm(), [&] {
      table_.emplace(options.output, frequency_column(c.units.time), observer_.probes().vibrating(), excitation_.base,
                     is_random());
    });
  }

  void superpose();
  /// False if a signal has ended it.
  [[nodiscard]] bool solve_directly();
  [[nodiscard]] record::ResponseTable& table() { return *table_; }

 private:
  [[nodiscard]] bool is_random() const { return !c_.harmonic.psd_values.empty(); }
  [[nodiscard]] double unit() const { return excitation_.base.norm() > 0.0 ? excitation_.base.norm() : 1.0; }
  /// By which the force is ahead of the excitation's real part.
  [[nodiscard]] Complex factor(double frequency) const;
  [[nodiscard]] Eigen::VectorXcd coordinates(const solve::ReducedResponse& response, double frequency) const {
    return factor(frequency) * response.coordinates(frequency);
  }
  void tabulate(const solve::ReducedResponse& response, const record::ResponseRows& rows,
                const solve::ReducedResponse* fewer, std::size_t modes);
  void add_mean_squares(const solve::ReducedResponse& response, const record::ResponseRows& rows);
  void write_fields(const solve::ModalBasis& basis, const solve::ReducedResponse* response);
  void write_mean(const solve::ModalBasis& basis, const solve::ReducedResponse* response);
  [[nodiscard]] solve::SpectralDensity density() const { return {c_.harmonic.psd_frequencies, c_.harmonic.psd_values}; }

  const input::Case& c_;
  system::Model& model_;
  Vec a_;
  const VibrationModes& modes_;
  Excitation excitation_;
  petsc::MatHandle damping_;
  input::UnitSystem units_;
  record::VibrationPlace place_;
  record::SupportForces forces_;
  record::ResponseObserver observer_;
  record::VibrationFields fields_;
  std::optional<record::ResponseTable> table_;  ///< rank 0
};

Complex Run::factor(double frequency) const {
  if (!(excitation_.mass_damping > 0.0)) return 1.0;
  return {1.0, excitation_.shift(2.0 * std::numbers::pi * frequency)};
}

void Run::superpose() {
  const std::vector<solve::Mode>& modes = modes_.result.modes;
  check_modes(c_, model_, modes);
  solve::ModalBasis basis = solve::modal_basis(model_, a_, modes, modes_.mass, damping_, excitation_.force);
  const record::ResponseRows rows = observer_.rows_of(basis.vectors);
  std::optional<solve::ReducedResponse> response;
  mpi::on_root(model_.dofs().comm(), [&] {
    basis.system.rows = rows.stiffness;
    response.emplace(basis.system, c_.dynamics.ratios);
    std::optional<solve::ReducedResponse> fewer;
    if (basis.vectors.size() > modes.size())
      fewer.emplace(basis.system.first(static_cast<Eigen::Index>(basis.fewer)), c_.dynamics.ratios);
    tabulate(*response, rows, fewer ? &*fewer : nullptr, modes.size());
    if (is_random()) add_mean_squares(*response, rows);
  });
  write_fields(basis, response ? &*response : nullptr);
  if (is_random()) write_mean(basis, response ? &*response : nullptr);
}

/// `fewer`: without the last correction, whose effect is an estimate of what is still missing.
void Run::tabulate(const solve::ReducedResponse& response, const record::ResponseRows& rows,
                   const solve::ReducedResponse* fewer, std::size_t modes) {
  const std::vector<double> frequencies = frequencies_of(c_.harmonic, &response);
  double error = 0.0, where = 0.0;
  for (const double f : frequencies) {
    const double level = is_random() ? density().at(f) / (unit() * unit()) : 0.0;
    table_->add(f, rows.at(f, coordinates(response, f), factor(f)), level);
    if (!fewer) continue;
    const Eigen::VectorXd size = record::largest_of_probes(table_->components(), response.size_at(f)),
                          change = (response.at(f) - fewer->at(f)).cwiseAbs();
    for (Eigen::Index i = 0; i < size.size(); ++i)
      if (size[i] > 0.0 && change[i] / size[i] > error) {
        error = change[i] / size[i];
        where = f;
      }
  }
  warn(undamped_within(response, modes, frequencies.front(), frequencies.back()), error, where);
}

void Run::add_mean_squares(const solve::ReducedResponse& response, const record::ResponseRows& rows) {
  table_->take_mean_squares(solve::mean_squares(response, density(), [&](double f) {
    const Eigen::VectorXcd all = table_->random_parts(f, rows.at(f, coordinates(response, f), factor(f)));
    return Eigen::VectorXcd(all / unit());
  }));
}

/// `response`: on rank 0.
void Run::write_fields(const solve::ModalBasis& basis, const solve::ReducedResponse* response) {
  const petsc::VecHandle x = model_.dofs().create_vector(), y = model_.dofs().create_vector();
  for (const double f : c_.harmonic.field_frequencies) {
    std::vector<double> parts(2 * basis.vectors.size(), 0.0);
    if (response) {
      const Eigen::VectorXcd q = coordinates(*response, f);
      for (std::size_t j = 0; j < basis.vectors.size(); ++j) {
        parts[2 * j] = q[static_cast<Eigen::Index>(j)].real();
        parts[2 * j + 1] = q[static_cast<Eigen::Index>(j)].imag();
      }
    }
    mpi::broadcast(model_.dofs().comm(), parts);
    VOILE_PETSC(VecZeroEntries(x));
    VOILE_PETSC(VecZeroEntries(y));
    for (std::size_t j = 0; j < basis.vectors.size(); ++j) {
      VOILE_PETSC(VecAXPY(x, parts[2 * j], basis.vectors[j]));
      VOILE_PETSC(VecAXPY(y, parts[2 * j + 1], basis.vectors[j]));
    }
    fields_.write(f, x, y, factor(f));
  }
  fields_.finish();
}

/// `response`: on rank 0.
void Run::write_mean(const solve::ModalBasis& basis, const solve::ReducedResponse* response) {
  const auto n = static_cast<Eigen::Index>(basis.vectors.size());
  Eigen::MatrixXd displacements = Eigen::MatrixXd::Zero(n + 1, n + 1), accelerations = displacements;
  const auto roots = [&](bool twice) {
    return record::root_of(solve::covariance(*response, density(), [&](double f) {
      const double omega = 2.0 * std::numbers::pi * f;
      Eigen::VectorXcd all(n + 1);
      all << coordinates(*response, f) * (twice ? -omega * omega : 1.0), Complex(1.0);
      return Eigen::VectorXcd(all / unit());
    }));
  };
  if (response) {
    displacements = roots(false);
    accelerations = roots(true);
  }
  for (Eigen::MatrixXd* m : {&displacements, &accelerations}) {
    std::vector<double> numbers(m->data(), m->data() + m->size());
    mpi::broadcast(model_.dofs().comm(), numbers);
    *m = Eigen::Map<const Eigen::MatrixXd>(numbers.data(), n + 1, n + 1);
  }
  fields_.write_mean(basis.vectors, displacements, accelerations);
}

bool Run::solve_directly() {
  const solve::DirectResponse direct(model_, a_, modes_.mass, damping_);
  const petsc::VecHandle x = model_.dofs().create_vector(), y = model_.dofs().create_vector();
  const auto solve_at = [&](double f) {
    const double omega = 2.0 * std::numbers::pi * f;
    direct.solve(omega, excitation_.force, excitation_.mass_damping > 0.0 ? excitation_.shift(omega) : 0.0, x, y);
  };
  for (const double f : frequencies_of(c_.harmonic, nullptr)) {
    if (SignalScope::stop_asked(model_.dofs().comm())) return false;
    solve_at(f);
    const record::ResponseRows rows = observer_.rows_of(x, y);
    const Eigen::VectorXcd both = (Eigen::VectorXcd(2) << Complex(1.0), Complex(0.0, 1.0)).finished();
    mpi::on_root(model_.dofs().comm(), [&] { table_->add(f, rows.at(f, both, factor(f)), 0.0); });
  }
  for (const double f : c_.harmonic.field_frequencies) {
    if (SignalScope::stop_asked(model_.dofs().comm())) return false;
    solve_at(f);
    fields_.write(f, x, y, factor(f));
  }
  fields_.finish();
  return true;
}

}  // namespace

void run_harmonic(const input::Case& c, const record::RunOptions& options, system::Model& model, Vec a,
                  const VibrationModes& modes, record::Summary& summary) {
  Run run(c, options, model, a, modes);
  const bool direct = c.harmonic.method == Section::Method::direct;
  if (!direct) {
    run.superpose();
  } else if (!run.solve_directly()) {
    summary.converged = false;
    summary.reason = Interrupted().what();
  }
  mpi::on_root(model.dofs().comm(), [&] {
    summary.response = run.table().peaks();
    if (options.verbosity != record::Verbosity::quiet) fmt::print("{}", run.table().text());
  });
}

}  // namespace voile::simulation
