#include "vibration_fields.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/mpi.hpp"
#include "energy/sheet.hpp"
#include "response.hpp"
#include "state_change.hpp"
#include "stresses.hpp"

namespace voile::record {

namespace {

using results::Centre;
using Complex = std::complex<double>;

/// Three numbers per triangle each, in this order.
struct Quantity {
  const char *name, *unit;
};
constexpr std::array<Quantity, 4> quantities{
    {{"membrane_force", "N/m"}, {"bending_moment", "N"}, {"stress_top", "Pa"}, {"stress_bottom", "Pa"}}};
constexpr std::size_t first_stress = 2;

std::vector<double> all_of(const energy::Sheet& sheet, const system::TriangleFields& t) {
  std::vector<double> all = t.membrane_force;
  all.insert(all.end(), t.bending_moment.begin(), t.bending_moment.end());
  for (const bool top : {true, false})
    for (Index k = 0; k < sheet.mesh().triangle_count(); ++k) {
      const Vec3 s = face_stress(sheet, t, k, top);
      all.insert(all.end(), s.begin(), s.end());
    }
  return all;
}

/// of `to` += factor `from`; of two empty ones nothing.
void add_to(std::vector<double>& to, double factor, const std::vector<double>& from) {
  for (std::size_t i = 0; i < from.size(); ++i) to[i] += factor * from[i];
}

}  // namespace

VibrationFields::VibrationFields(const VibrationPlace& place, SupportForces& forces)
    : place_(place), forces_(forces), root_(mpi::rank(place.model.dofs().comm()) == 0) {
  const std::vector<energy::Material>& materials = place.model.discretisation().materials();
  layered_ = std::any_of(materials.begin(), materials.end(), [](const auto& m) { return !m.layers.empty(); });
  const energy::Sheet& sheet = place.model.discretisation().sheet();
  if (place.by_loads)
    of_loads_ = StateChange(place.model, place.about).of_fields([&](const auto& t) { return all_of(sheet, t); });
  held_ = place.by_loads ? forces.of_loads() : forces.of_base(place.base);
}

std::vector<double> VibrationFields::change(Vec u) {
  const energy::Sheet& sheet = place_.model.discretisation().sheet();
  return StateChange(place_.model, place_.about, u).of_fields([&](const auto& t) { return all_of(sheet, t); });
}

void VibrationFields::open(std::optional<results::ResultsWriter>& writer, const char* name) const {
  if (!root_ || writer || place_.folder.empty()) return;
  const mesh::Partition& p = place_.model.dofs().partition();
  writer.emplace(place_.folder / name, results::ObstacleTriangles{}, place_.units.label("m"));
  writer->begin_epoch(place_.model.dofs().mesh(), p.vertex_rank, p.triangle_rank);
}

void VibrationFields::add(std::vector<results::Field>& fields, const std::string& name, const char* unit, Centre centre,
                          int components, std::vector<double> values) const {
  fields.push_back({name, place_.units.label(unit), centre, components, std::move(values)});
}

/// Amplitudes of each quantity, and behind them those of von Mises's stress of the last two.
std::vector<double> VibrationFields::combined(const std::vector<double>& real,
                                              const std::vector<double>& imaginary) const {
  std::vector<double> all(real.size());
  for (std::size_t i = 0; i < real.size(); ++i) all[i] = std::hypot(real[i], imaginary[i]);
  const std::size_t each = real.size() / quantities.size();
  for (std::size_t i = first_stress * each; i < real.size(); i += 3) {
    Eigen::Vector3cd s;
    for (std::size_t k = 0; k < 3; ++k) s[static_cast<Eigen::Index>(k)] = Complex(real[i + k], imaginary[i + k]);
    all.push_back(largest_von_mises(s));
  }
  return all;
}

/// Of what combined() gives, or the root mean squares in the same order.
void VibrationFields::add_stresses(const std::vector<double>& all, std::vector<results::Field>& fields,
                                   const char* suffix) const {
  const auto triangles = static_cast<std::ptrdiff_t>(place_.model.dofs().mesh().triangle_count());
  auto at = all.begin();
  const auto take = [&](const std::string& name, const char* unit, int components) {
    const auto end = at + components * triangles;
    if (layered_ || components == 3) add(fields, name + suffix, unit, Centre::triangle, components, {at, end});
    at = end;
  };
  for (std::size_t q = 0; q < quantities.size() && (layered_ || q < first_stress); ++q)
    take(quantities[q].name, quantities[q].unit, 3);
  if (!layered_) return;
  take("von_mises_top", "Pa", 1);
  take("von_mises_bottom", "Pa", 1);
}

/// R of support_forces.hpp.
void VibrationFields::add_reactions(Vec x, Vec y, double omega, Complex of_base, std::vector<results::Field>& fields) {
  const SupportForces::Rows a = forces_.of(x), b = forces_.of(y);
  for (const auto& [to, other, sign, part] :
       {std::tuple(&a, &b, -1.0, of_base.real()), std::tuple(&b, &a, 1.0, of_base.imag())}) {
    VOILE_PETSC(VecAXPY(to->stiffness, -omega * omega, to->inertia));
    VOILE_PETSC(VecAXPY(to->stiffness, sign * omega, other->damping));
    VOILE_PETSC(VecAXPY(to->stiffness, part, held_));
  }
  const std::vector<double> real = place_.model.dofs().gather_forces(a.stiffness),
                            imaginary = place_.model.dofs().gather_forces(b.stiffness);
  std::vector<double> size(real.size());
  for (std::size_t i = 0; i < real.size(); ++i) size[i] = std::hypot(real[i], imaginary[i]);
  if (root_) add(fields, "reaction_amplitude", "N", Centre::vertex, 3, std::move(size));
}

void VibrationFields::write(double frequency, Vec x, Vec y, Complex of_base) {
  if (place_.folder.empty()) return;
  constexpr double degree = std::numbers::pi / 180.0;
  open(response_, "response");
  results::StepFields step{++steps_, frequency, place_.model.conditions().load_factor(), {}};
  (void)place_.model.potential().configuration(place_.about);
  const std::vector<double> u = place_.model.dofs().gather_change(x), v = place_.model.dofs().gather_change(y);
  std::vector<double> real = change(x);
  const std::vector<double> imaginary = change(y);
  if (root_) {
    add_to(real, 1.0, of_loads_);
    std::vector<double> size, phase;
    for (std::size_t i = 0; i < u.size(); ++i) {
      size.push_back(std::hypot(u[i], v[i]));
      phase.push_back(std::atan2(v[i], u[i]) / degree);
    }
    add(step.fields, "displacement_amplitude", "m", Centre::vertex, 3, std::move(size));
    add(step.fields, "displacement_phase", "degree", Centre::vertex, 3, std::move(phase));
    add_stresses(combined(real, imaginary), step.fields, "_amplitude");
  }
  add_reactions(x, y, 2.0 * std::numbers::pi * frequency, of_base, step.fields);
  mpi::on_root(place_.model.dofs().comm(), [&] { response_->write(step); });
}

void VibrationFields::write_mean(const std::vector<petsc::VecHandle>& basis, const Eigen::MatrixXd& w,
                                 const Eigen::MatrixXd& accelerations) {
  if (place_.folder.empty()) return;
  const auto count = static_cast<Eigen::Index>(basis.size());
  std::vector<double> u, a, s;
  const petsc::VecHandle x = place_.model.dofs().create_vector();
  const auto superpose = [&](const Eigen::MatrixXd& of, Eigen::Index column) {
    VOILE_PETSC(VecZeroEntries(x));
    for (Eigen::Index j = 0; j < count; ++j) VOILE_PETSC(VecAXPY(x, of(j, column), basis[static_cast<std::size_t>(j)]));
  };
  const auto add_squares = [](std::vector<double>& to, const std::vector<double>& from) {
    to.resize(from.size(), 0.0);
    for (std::size_t i = 0; i < from.size(); ++i) to[i] += from[i] * from[i];
  };
  for (Eigen::Index k = 0; k < w.cols(); ++k) {
    superpose(w, k);
    (void)place_.model.potential().configuration(place_.about);
    add_squares(u, place_.model.dofs().gather_change(x));
    std::vector<double> stresses = change(x);
    if (root_) add_to(stresses, w(count, k), of_loads_);
    add_squares(s, combined(stresses, std::vector<double>(stresses.size(), 0.0)));
  }
  for (Eigen::Index k = 0; k < accelerations.cols(); ++k) {
    superpose(accelerations, k);
    (void)place_.model.potential().configuration(place_.about);
    std::vector<double> one = place_.model.dofs().gather_change(x);
    for (std::size_t i = 0; i < one.size(); ++i)
      one[i] += accelerations(count, k) * place_.base[static_cast<Eigen::Index>(i % 3)];
    add_squares(a, one);
  }
  mpi::on_root(place_.model.dofs().comm(), [&] {
    for (auto* values : {&u, &a, &s})
      for (double& value : *values) value = std::sqrt(value);
    std::optional<results::ResultsWriter> writer;
    open(writer, "random");
    results::StepFields step{1, 1.0, place_.model.conditions().load_factor(), {}};
    add(step.fields, "displacement_rms", "m", Centre::vertex, 3, std::move(u));
    add(step.fields, "acceleration_rms", "m/s^2", Centre::vertex, 3, std::move(a));
    add_stresses(s, step.fields, "_rms");
    writer->write(step);
    writer->finish();
  });
}

void VibrationFields::finish() {
  mpi::on_root(place_.model.dofs().comm(), [&] {
    if (response_) response_->finish();
  });
}

}  // namespace voile::record
