#include "discretisation_error.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "base/mpi.hpp"
#include "energy/biot_force.hpp"
#include "validity.hpp"

namespace voile::record {

namespace {

/// Fraction of a deflection beyond which the estimate is no number any more, only large.
constexpr double most_told = 0.99;

Vec3 of_triangle(const std::vector<double>& values, std::size_t t) {
  return Eigen::Map<const Vec3>(&values[3 * t]);
}

/// Side of an equilateral triangle.
double cell_size(double area) {
  return std::sqrt(4.0 * area / std::sqrt(3.0));
}

/// Factor by which cells have to be smaller, enough to be worth it.
double finer(double error) {
  return std::min(0.9, std::sqrt(error_limit / error));
}

/// The estimate takes the stiffness A without strain. Where yarns stiffen to A', differences of forces store less energy:
/// about by the ratio of N.A'^-1 N to N.A^-1 N. Of rubber, likewise, forces and tangent are those of stretches.
void stiffen(const energy::Sheet& sheet, const system::TriangleFields& fields, std::vector<double>& density) {
  for (std::size_t t = 0; t < density.size(); ++t) {
    const energy::Material& m = sheet.material(static_cast<Index>(t));
    const Vec3 strain = of_triangle(fields.membrane_strain, t);
    if (m.rubber.any()) {
      const energy::BiotForce biot = energy::biot_force(m.rubber, strain);
      if (biot.softness > 0.0) density[t] *= biot.softness / biot.force.dot(m.membrane.inverse() * biot.force);
      continue;
    }
    if (!m.yarns.any()) continue;
    const Vec3 force = of_triangle(fields.membrane_force, t);
    const Mat3 tangent = m.membrane + energy::added_tangent(m.yarns, strain);
    const double soft = force.dot(m.membrane.inverse() * force), stiff = force.dot(tangent.inverse() * force);
    if (soft > 0.0) density[t] *= std::min(1.0, stiff / soft);
  }
}

/// Of a change the ratio is that of the work of the changes, whose forces are those of the tangent, to dN.A^-1 dN.
void stiffen_change(const energy::Sheet& sheet, const system::TriangleFields& fields, std::vector<double>& density) {
  for (std::size_t t = 0; t < density.size(); ++t) {
    const energy::Material& m = sheet.material(static_cast<Index>(t));
    if (!m.rubber.any() && !m.yarns.any()) continue;
    const Vec3 force = of_triangle(fields.membrane_force, t);
    const double work = force.dot(of_triangle(fields.membrane_strain, t)),
                 soft = force.dot(m.membrane.inverse() * force);
    if (soft > 0.0 && work > 0.0) density[t] *= work / soft;
  }
}

/// Forces whose differences are judged; on rank 0.
std::vector<double> judged_forces(const energy::Sheet& sheet, const system::TriangleFields& fields) {
  std::vector<double> forces = fields.membrane_force;
  for (std::size_t t = 0; 3 * t < forces.size(); ++t) {
    const energy::Hyperelastic& law = sheet.material(static_cast<Index>(t)).rubber;
    if (!law.any()) continue;
    const Vec3 force = energy::biot_force(law, of_triangle(fields.membrane_strain, t)).force;
    for (std::size_t k = 0; k < 3; ++k) forces[3 * t + k] = force[static_cast<Eigen::Index>(k)];
  }
  return forces;
}

}  // namespace

double round_off_energy(const energy::Sheet& sheet, double strain) {
  double sum = 0.0;
  for (Index t = 0; t < sheet.mesh().triangle_count(); ++t)
    sum += 0.5 * sheet.mesh().area(t) * sheet.material(t).membrane.trace() * strain * strain;
  return sum;
}

double stored_energy(const energy::Sheet& sheet, const system::TriangleFields& f, FieldsOf what) {
  const bool in_plane = sheet.options().membrane == energy::MembraneOperator::six_node_corrected;
  double stored = 0.0;
  for (std::size_t t = 0; t < f.in_plane.size(); ++t) {
    const Vec3 strain = of_triangle(f.membrane_strain, t);
    const energy::Hyperelastic& rubber = sheet.material(static_cast<Index>(t)).rubber;
    const double density = (rubber.any() && what == FieldsOf::state ? 2.0 * energy::response(rubber, strain).energy
                                                                    : strain.dot(of_triangle(f.membrane_force, t))) +
                           of_triangle(f.curvature, t).dot(of_triangle(f.bending_moment, t));
    stored += sheet.mesh().area(static_cast<Index>(t)) * (0.5 * density + (in_plane ? f.in_plane[t] : 0.0));
  }
  return stored;
}

JudgedEnergy judged_energy(const energy::Sheet& sheet, const system::TriangleFields& f) {
  constexpr double least = 1e-4;  // of the stored energy: deflections of less are nothing beside what holds them back
  JudgedEnergy stored{stored_energy(sheet, f), 0.0}, from_rest = stored;
  for (std::size_t t = 0; t < f.in_plane.size(); ++t) {
    const energy::Material& m = sheet.material(static_cast<Index>(t));
    const double area = sheet.mesh().area(static_cast<Index>(t));
    const Vec3 strain = of_triangle(f.membrane_strain, t), bent = of_triangle(f.curvature, t);
    const double bending = 0.5 * area * bent.dot(of_triangle(f.bending_moment, t));
    stored.bending += bending;
    from_rest.bending += bending;
    const bool heated = !f.temperature.empty() && m.expands;
    if (m.rubber.any() || m.yarns.any() || (!heated && m.initial_strain.isZero(0.0))) continue;
    Vec3 e = strain + m.initial_strain, k = bent;
    if (heated) {
      e += f.temperature[2 * t] * m.expansion;
      k += f.temperature[2 * t + 1] * m.expansion_curvature;
    }
    const double stretching = 0.5 * area * strain.dot(of_triangle(f.membrane_force, t)),
                 whole_bending = 0.5 * area * k.dot(m.bending * k - m.coupling * e);
    from_rest.bending += whole_bending - bending;
    from_rest.whole += 0.5 * area * e.dot(m.membrane * e - m.coupling * k) - stretching + whole_bending - bending;
  }
  const auto judged = [](double with, double without) { return std::max(without, least * with); };
  return {judged(stored.whole, from_rest.whole), judged(stored.bending, from_rest.bending)};
}

DiscretisationError::Densities DiscretisationError::of(const system::Model& model, const system::TriangleFields& fields,
                                                       FieldsOf what) {
  const energy::Sheet& sheet = model.discretisation().sheet();
  const MPI_Comm comm = model.dofs().comm();
  if (!recovery_) recovery_.emplace(sheet);
  std::vector<double> force = what == FieldsOf::state ? judged_forces(sheet, fields) : fields.membrane_force,
                      moment = fields.bending_moment;
  mpi::broadcast(comm, force);
  mpi::broadcast(comm, moment);
  const auto count = static_cast<std::size_t>(sheet.mesh().triangle_count());
  Densities d{std::vector<double>(count, 0.0), std::vector<double>(count, 0.0)};
  const std::vector<int>& owner = model.dofs().partition().triangle_rank;
  const int own = mpi::rank(comm);
  for (std::size_t t = 0; t < count; ++t) {
    if (owner[t] != own) continue;
    const energy::RecoveryError::Density e = recovery_->of(static_cast<Index>(t), force, moment);
    d.membrane[t] = e.membrane;
    d.bending[t] = e.bending;
  }
  mpi::sum_to_root(comm, d.membrane);
  mpi::sum_to_root(comm, d.bending);
  if (own == 0) (what == FieldsOf::state ? stiffen : stiffen_change)(sheet, fields, d.membrane);
  return d;
}

DiscretisationError::Densities DiscretisationError::judged(const system::Model& model,
                                                           const system::TriangleFields& fields, const Judged& state) {
  Densities d = of(model, fields);
  if (mpi::rank(model.dofs().comm()) == 0) judge(model.discretisation().sheet(), fields, d, state);
  return d;
}

void DiscretisationError::judge(const energy::Sheet& sheet, const system::TriangleFields& fields, const Densities& d,
                                const Judged& state) {
  const mesh::SurfaceMesh& mesh = sheet.mesh();
  double membrane = 0.0, bending = 0.0, largest = 0.0;
  Index worst = 0;
  for (std::size_t t = 0; t < d.membrane.size(); ++t) {
    const double area = mesh.area(static_cast<Index>(t)), whole = area * (d.membrane[t] + d.bending[t]);
    membrane += area * d.membrane[t];
    bending += area * d.bending[t];
    if (whole <= largest) continue;
    largest = whole;
    worst = static_cast<Index>(t);
  }
  const auto [stored, bent] = judged_energy(sheet, fields);
  const double none = round_off_energy(sheet, state.strain);
  last_ = {0.0, std::nan(""), std::nan("")};
  if (stored > none) last_.whole = (membrane + bending) / stored;
  if (stored > none && stored - bent > none) last_.membrane = membrane / (stored - bent);
  if (stored > none && bent > 0.0) last_.bending = bending / bent;
  if (!(last_.whole <= largest_)) largest_ = last_.whole;
  warning_.clear();
  if (last_.whole <= error_limit) return;
  const Vec3 at = (mesh.start_corner(worst, 0) + mesh.start_corner(worst, 1) + mesh.start_corner(worst, 2)) / 3.0;
  const double size = cell_size(mesh.area(worst));
  const auto text = [&](const std::string& when) {
    return fmt::format(
        "{}cells do not resolve how {} change, most near ({:.4g}, {:.4g}, {:.4g}) m at {}: they are {} off in "
        "the "
        "mean, and "
        "deflections may be wrong by about {}, too large or too small; cells of about {:.2g} m are needed there, "
        "not {:.2g} m "
        "(summary.json: recovery_error; fields membrane_recovery_error and bending_recovery_error show where)",
        when, bending > membrane ? "bending moments" : "membrane forces", at[0], at[1], at[2],
        mesh.has_charts() ? "the start" : "rest", percent_text(std::sqrt(last_.whole)),
        percent_text(std::min(last_.whole, most_told)), size * finer(last_.whole), size);
  };
  warning_ = text("");
  if (last_.whole == largest_ && !state.place.empty()) worst_warning_ = text("at " + state.place + " ");
}

}  // namespace voile::record
