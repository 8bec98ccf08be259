#include "harmonic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>

#include "base/interrupt.hpp"
#include "base/mpi.hpp"
#include "base/text.hpp"
#include "modes.hpp"
#include "record/probes.hpp"
#include "record/response.hpp"
#include "solve/direct_response.hpp"
#include "solve/modal_basis.hpp"
#include "system/rigid_motions.hpp"
#include "voile/errors.hpp"

namespace voile::simulation {

namespace {

using Section = input::HarmonicSection;
using Complex = std::complex<double>;

/// Relative error of a probe by the modes that are left out, above which the user is warned.
constexpr double truncation_limit = 0.01;

struct Excitation {
  petsc::VecHandle force;     ///< on the free unknowns [N]
  Vec3 base = Vec3::Zero();   ///< acceleration of the base [m/s^2]
  double mass_damping = 0.0;  ///< that acts on its velocity too [1/s]
  /// The part of the force that is ahead by a quarter of the circle.
  [[nodiscard]] double shift(double omega) const { return -mass_damping / omega; }
};

/// Of a base that moves, displacements are relative to it: inertia loads them, and air at rest damps its motion too.
Excitation excitation_of(const input::Case& c, system::Model& model, Vec a, const system::RigidInertia& inertia) {
  Excitation e;
  e.force = model.dofs().create_vector();
  if (c.harmonic.excitation == Section::Excitation::base) {
    e.base = c.harmonic.acceleration * c.harmonic.direction->normalized();
    e.mass_damping = c.dynamics.mass_damping;
    for (std::size_t k = 0; k < 3; ++k)
      VOILE_PETSC(VecAXPY(e.force, -e.base[static_cast<Eigen::Index>(k)], inertia.force[k]));
    return e;
  }
  model.assemble_tangent(a, {.kind = energy::Tangent::exact});
  model.load_direction(a, e.force);
  model.dofs().clear_fixed(e.force);
  double size = 0.0;
  VOILE_PETSC(VecNorm(e.force, NORM_2, &size));
  if (size == 0.0)
    throw UserError(c.file.string() +
                    ": harmonic.excitation: no load acts on what can move (those of earlier stages are constant); give "
                    "a [[load]], or excitation = \"base\"");
  return e;
}

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

/// Throws unless the modes are those of a stable equilibrium and reach the highest frequency.
void check_modes(const input::Case& c, const system::Model& model, const std::vector<solve::Mode>& modes) {
  const double last = modes.back().value, highest = record::highest_frequency(c.harmonic);
  if (modes.front().value < 0.0 && rigid_modes(c, model, modes).front() == 0)
    throw UserError(fmt::format(
        "{}: analysis = \"harmonic\": the equilibrium is unstable (mode 1 at {:g} Hz), and a vibration about it grows; "
        "find the stable one first, with a stage of analysis = \"drape\"",
        c.file.string(), modes.front().value));
  if (last < highest)
    throw UserError(
        fmt::format("{}: eigen.modes: {} modes reach {:.4g} Hz, but the response is wanted up to {:.4g} "
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
      : c_(c), model_(model), a_(a), modes_(modes), probes_(c, model), root_(mpi::rank(model.dofs().comm()) == 0) {
    excitation_ = excitation_of(c, model, a, modes.inertia);
    damping_ = solve::damping_matrix(model, a, c.dynamics, modes.mass);
    mpi::on_root(model.dofs().comm(), [&] {
      table_.emplace(options.output, probes_.displacement_components(), excitation_.base, is_random());
    });
  }

  void superpose();
  /// False if a signal has ended it.
  [[nodiscard]] bool solve_directly();
  [[nodiscard]] record::ResponseTable& table() { return *table_; }

 private:
  [[nodiscard]] bool is_random() const { return !c_.harmonic.psd_values.empty(); }
  [[nodiscard]] std::vector<double> observe(Vec x) const {
    const std::vector<double> u = model_.dofs().gather_change(x);
    return root_ ? probes_.displacement_values(u) : std::vector<double>{};
  }
  [[nodiscard]] std::vector<Complex> at(const solve::ReducedResponse& response, double frequency) const;
  void tabulate(const solve::ReducedResponse& response, const solve::ReducedResponse* fewer, std::size_t modes);
  void add_mean_squares(const solve::ReducedResponse& response);
  /// Of the excitation, relative to that of the table; 0 without.
  [[nodiscard]] double density(double frequency) const;

  const input::Case& c_;
  system::Model& model_;
  Vec a_;
  const VibrationModes& modes_;
  record::Probes probes_;
  bool root_;
  Excitation excitation_;
  petsc::MatHandle damping_;
  std::optional<record::ResponseTable> table_;  ///< rank 0
};

double Run::density(double frequency) const {
  if (!is_random()) return 0.0;
  const double unit = excitation_.base.norm() > 0.0 ? excitation_.base.squaredNorm() : 1.0;
  return solve::SpectralDensity{c_.harmonic.psd_frequencies, c_.harmonic.psd_values}.at(frequency) / unit;
}

std::vector<Complex> Run::at(const solve::ReducedResponse& response, double frequency) const {
  const double omega = 2.0 * std::numbers::pi * frequency;
  const Complex factor(1.0, excitation_.mass_damping > 0.0 ? excitation_.shift(omega) : 0.0);
  const Eigen::VectorXcd u = factor * response.at(frequency);
  return {u.begin(), u.end()};
}

void Run::superpose() {
  const std::vector<solve::Mode>& modes = modes_.result.modes;
  check_modes(c_, model_, modes);
  solve::ModalBasis basis = solve::modal_basis(model_, a_, modes, modes_.mass, damping_, excitation_.force);
  (void)model_.potential().configuration(a_);  // changes are gathered about it
  std::vector<std::vector<double>> columns;
  for (const petsc::VecHandle& v : basis.vectors) columns.push_back(observe(v));
  mpi::on_root(model_.dofs().comm(), [&] {
    const auto count = static_cast<Eigen::Index>(columns.size());
    basis.system.rows.resize(static_cast<Eigen::Index>(columns.front().size()), count);
    for (Eigen::Index j = 0; j < count; ++j)
      basis.system.rows.col(j) =
          Eigen::Map<const Eigen::VectorXd>(columns[static_cast<std::size_t>(j)].data(), basis.system.rows.rows());
    const solve::ReducedResponse response(basis.system, c_.dynamics.ratios);
    std::optional<solve::ReducedResponse> fewer;
    if (columns.size() > modes.size()) fewer.emplace(basis.system.first(count - 1), c_.dynamics.ratios);
    tabulate(response, fewer ? &*fewer : nullptr, modes.size());
    if (is_random()) add_mean_squares(response);
  });
}

/// `fewer`: without the last correction, whose effect is an estimate of what is still missing.
void Run::tabulate(const solve::ReducedResponse& response, const solve::ReducedResponse* fewer, std::size_t modes) {
  const std::vector<double> frequencies = frequencies_of(c_.harmonic, &response);
  double error = 0.0, where = 0.0;
  for (const double f : frequencies) {
    table_->add(f, at(response, f), density(f));
    if (!fewer) continue;
    const Eigen::VectorXd size = response.size_at(f), change = (response.at(f) - fewer->at(f)).cwiseAbs();
    for (Eigen::Index i = 0; i < size.size(); ++i)
      if (size[i] > 0.0 && change[i] / size[i] > error) {
        error = change[i] / size[i];
        where = f;
      }
  }
  warn(undamped_within(response, modes, frequencies.front(), frequencies.back()), error, where);
}

void Run::add_mean_squares(const solve::ReducedResponse& response) {
  const solve::SpectralDensity table{c_.harmonic.psd_frequencies, c_.harmonic.psd_values};
  const double unit = excitation_.base.norm() > 0.0 ? excitation_.base.norm() : 1.0;
  const auto count = static_cast<Eigen::Index>(table_->peaks().size());
  const Eigen::VectorXd squares = solve::mean_squares(response, table, [&](double f) {
    const std::vector<Complex> u = at(response, f);
    Eigen::VectorXcd both(2 * count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const auto n = static_cast<std::size_t>(i);
      both[i] = u[n] / unit;
      both[count + i] = table_->acceleration(n, f, u[n]) / unit;
    }
    return both;
  });
  for (Eigen::Index i = 0; i < count; ++i) {
    record::ResponsePeak& peak = table_->peaks()[static_cast<std::size_t>(i)];
    peak.mean_displacement = std::sqrt(squares[i]);
    peak.mean_acceleration = std::sqrt(squares[count + i]);
  }
}

bool Run::solve_directly() {
  const solve::DirectResponse direct(model_, a_, modes_.mass, damping_);
  const petsc::VecHandle x = model_.dofs().create_vector(), y = model_.dofs().create_vector();
  for (const double f : frequencies_of(c_.harmonic, nullptr)) {
    if (SignalScope::stop_asked(model_.dofs().comm())) return false;
    const double omega = 2.0 * std::numbers::pi * f;
    direct.solve(omega, excitation_.force, excitation_.mass_damping > 0.0 ? excitation_.shift(omega) : 0.0, x, y);
    const std::vector<double> real = observe(x), imaginary = observe(y);
    mpi::on_root(model_.dofs().comm(), [&] {
      std::vector<Complex> u;
      for (std::size_t i = 0; i < real.size(); ++i) u.emplace_back(real[i], imaginary[i]);
      table_->add(f, u, 0.0);
    });
  }
  return true;
}

/// Whether a symmetry support holds what moves along a direction: half of a body cannot shake through its mirror plane.
bool mirror_is_crossed(const input::Case& c, const system::Model& model,
                       const std::function<bool(const Vec3&)>& along) {
  const auto& held = model.discretisation().constraints().vertices;
  for (const system::Support& support : c.supports) {
    if (support.kind != system::Support::Kind::symmetry) continue;
    for (const Index v : model.dofs().mesh().group(support.group).vertices) {
      const system::VertexSupport& s = held.at(v);
      if (std::count(s.fixed.begin(), s.fixed.end(), true) != 1) continue;  // others hold it too
      for (int k = 0; k < 3; ++k)
        if (s.fixed[static_cast<std::size_t>(k)] && along(s.axes.col(k))) return true;
    }
  }
  return false;
}

}  // namespace

void require_excitation(const input::Case& c, const system::Model& model) {
  if (c.analysis != "harmonic") return;
  const std::string file = c.file.string();
  if (c.harmonic.excitation == Section::Excitation::loads) {
    if (!model.conditions().has_prescribed()) return;
    throw UserError(file +
                    ": [[support]]: with analysis = \"harmonic\" supports do not move by `value`; set it to 0, or move "
                    "all of them with harmonic.excitation = \"base\"");
  }
  constexpr double across = 1e-6;  // cosine of what counts as square to the direction
  const Vec3 along = c.harmonic.direction->normalized();
  const auto leaves = [&](const Vec3& d) { return std::abs(d.dot(along)) > across; };
  for (const system::FreePiece& piece :
       system::free_pieces(model.dofs().mesh(), model.discretisation().constraints(), c.springs))
    if (std::any_of(piece.directions.begin(), piece.directions.end(), leaves))
      throw UserError(fmt::format(
          "{}: harmonic.direction: nothing holds the sheet along ({:g}, {:g}, {:g}), so that a moving base leaves it "
          "behind; add a [[support]] that holds it there, or choose another direction",
          file, along[0], along[1], along[2]));
  if (mirror_is_crossed(c, model, leaves))
    throw UserError(
        fmt::format("{}: harmonic.direction: the base cannot move through the plane of a [[support]] of type "
                    "\"symmetry\"; model the whole, or choose a direction in the plane",
                    file));
}

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
