#include "response_rows.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/decompositions.hpp"
#include "base/mpi.hpp"
#include "state_change.hpp"
#include "voile/errors.hpp"

namespace voile::record {

namespace {

using Complex = std::complex<double>;

void append(Eigen::MatrixXd& m, const std::vector<double>& column) {
  m.conservativeResize(static_cast<Eigen::Index>(column.size()), m.cols() + 1);
  m.col(m.cols() - 1) = Eigen::Map<const Eigen::VectorXd>(column.data(), m.rows());
}

}  // namespace

std::vector<Complex> ResponseRows::at(double frequency, const Eigen::VectorXcd& q, Complex factor) const {
  const double omega = 2.0 * std::numbers::pi * frequency;
  Eigen::VectorXcd h = stiffness * q + factor * constant.cast<Complex>();
  if (damping.size() > 0) h += Complex(0.0, omega) * (damping * q) - omega * omega * (inertia * q);
  return {h.begin(), h.end()};
}

ResponseObserver::ResponseObserver(const input::Case& c, const VibrationPlace& place, SupportForces& forces)
    : place_(place), forces_(forces), probes_(c, place.model) {}

/// Of a displacement (null: none), a force on what is held (null: none) and stresses.
std::vector<double> ResponseObserver::values(Vec displacement, Vec force, StateChange* stress) {
  const system::Dofs& dofs = place_.model.dofs();
  (void)place_.model.potential().configuration(place_.about);  // changes are gathered about it
  const std::vector<double> none(mpi::rank(dofs.comm()) == 0 ? static_cast<std::size_t>(dofs.unknowns()) : 0, 0.0);
  Observed o{
      displacement ? dofs.gather_change(displacement) : none, force ? dofs.gather_forces(force) : none, {}, {}, {}};
  const auto stresses = [&](const system::TriangleFields& t) {
    std::vector<double> all;
    for (const Vec3& s : probes_.stresses(place_.model, t)) all.insert(all.end(), s.begin(), s.end());
    return all;
  };
  std::vector<double> s;
  if (stress && probes_.need_stresses()) s = stress->of_fields(stresses);
  if (mpi::rank(dofs.comm()) != 0) return {};
  if (s.empty()) s.assign(3 * probes_.vibrating().size(), 0.0);
  for (std::size_t i = 0; i + 2 < s.size(); i += 3) o.stresses.emplace_back(s[i], s[i + 1], s[i + 2]);
  return probes_.vibrating_values(o);
}

void ResponseObserver::add_column(Vec v, ResponseRows& rows) {
  StateChange change(place_.model, place_.about, v);
  if (!probes_.need_reactions()) return append(rows.stiffness, values(v, nullptr, &change));
  const SupportForces::Rows forces = forces_.of(v);
  append(rows.stiffness, values(v, forces.stiffness, &change));
  append(rows.damping, values(nullptr, forces.damping, nullptr));
  append(rows.inertia, values(nullptr, forces.inertia, nullptr));
}

void ResponseObserver::add_constant(ResponseRows& rows) {
  StateChange loads(place_.model, place_.about);
  const petsc::VecHandle force = place_.by_loads ? forces_.of_loads() : forces_.of_base(place_.base);
  const std::vector<double> all = values(nullptr, force, place_.by_loads ? &loads : nullptr);
  rows.constant = Eigen::Map<const Eigen::VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
}

ResponseRows ResponseObserver::rows_of(const std::vector<petsc::VecHandle>& vectors) {
  ResponseRows rows;
  for (const petsc::VecHandle& v : vectors) add_column(v, rows);
  add_constant(rows);
  return rows;
}

ResponseRows ResponseObserver::rows_of(Vec x, Vec y) {
  ResponseRows rows;
  add_column(x, rows);
  add_column(y, rows);
  add_constant(rows);
  return rows;
}

Eigen::VectorXd largest_of_probes(const std::vector<Probes::Component>& components, Eigen::VectorXd sizes) {
  for (std::size_t i = 0; i < components.size(); ++i) {
    if (components[i].kind == input::Probe::Kind::displacement) continue;
    std::size_t end = i + 1;
    while (end < components.size() && components[end].probe == components[i].probe) ++end;
    auto part = sizes.segment(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(end - i));
    part.setConstant(part.maxCoeff());
    i = end - 1;
  }
  return sizes;
}

Eigen::MatrixXd root_of(const Eigen::MatrixXd& m) {
  const Eigen::VectorXd size = m.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd inverse = size.unaryExpr([](double x) { return x > 0.0 ? 1.0 / x : 0.0; });
  const Spectrum parts = spectrum(inverse.asDiagonal() * m * inverse.asDiagonal());
  return size.asDiagonal() * parts.vectors * parts.values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

}  // namespace voile::record
