#include "mode_error.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "base/mpi.hpp"
#include "energy/slope_error.hpp"
#include "linear_values.hpp"
#include "state_change.hpp"

namespace voile::record {

namespace {

Vec3 three(const std::vector<double>& values, std::size_t i) {
  return Eigen::Map<const Vec3>(&values[3 * i]);
}

/// On rank 0.
std::vector<std::array<Vec2, 3>> corners_of(const system::Model& model) {
  std::vector<std::array<Vec2, 3>> corners;
  if (mpi::rank(model.dofs().comm()) != 0) return corners;
  const energy::Sheet& sheet = model.discretisation().sheet();
  for (Index t = 0; t < model.dofs().mesh().triangle_count(); ++t) {
    const mesh::Patch patch = sheet.patches().patch(t, sheet.frame(t));
    corners.push_back({patch.coordinates[0], patch.coordinates[1], patch.coordinates[2]});
  }
  return corners;
}

/// Part of the work of a change that bends.
double bending_of(const energy::Sheet& sheet, const system::TriangleFields& f) {
  double sum = 0.0;
  for (std::size_t t = 0; t < f.in_plane.size(); ++t)
    sum += 0.5 * sheet.mesh().area(static_cast<Index>(t)) * three(f.curvature, t).dot(three(f.bending_moment, t));
  return sum;
}

}  // namespace

ModeErrors::ModeErrors(system::Model& model, Vec a, system::Mass kind)
    : model_(model),
      a_(a),
      vibration_(true),
      lumped_(kind == system::Mass::lumped),
      force_(model.triangle_fields(a).membrane_force),
      place_(model.dofs().gather(a)),
      corners_(corners_of(model)) {}

ModeErrors::ModeErrors(system::Model& model, Vec a, Vec response)
    : model_(model),
      a_(a),
      vibration_(false),
      force_(model.triangle_fields(a).membrane_force),
      place_(model.dofs().gather(a)),
      corners_(corners_of(model)) {
  if (!response) return;  // then there are no modes
  force_per_load_ = LinearValues(model, response, a).triangle_changes().membrane_force;
  if (!model.potential().natural_states_change()) return;
  const std::vector<double> held =
      StateChange(model, a).of_fields([](const system::TriangleFields& f) { return f.membrane_force; });
  for (std::size_t i = 0; i < held.size(); ++i) force_per_load_[i] += held[i];
}

ModeErrors::Excess ModeErrors::excess_of(const solve::Mode& mode, const system::TriangleFields& fields,
                                         const std::vector<double>& force) const {
  const std::vector<double> shape = model_.dofs().gather_change(mode.shape);
  if (mpi::rank(model_.dofs().comm()) != 0) return {};
  const energy::Sheet& sheet = model_.discretisation().sheet();
  const mesh::SurfaceMesh& mesh = model_.dofs().mesh();
  Excess sum;
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const auto number = static_cast<std::size_t>(t);
    const Vec3 curvature = three(fields.curvature, number);
    std::array<Vec3, 3> u, x;
    for (std::size_t i = 0; i < 3; ++i) {
      const Index v = mesh.triangles()[t][i];
      u[i] = three(shape, v);
      x[i] = mesh.positions()[v] + three(place_, v);
    }
    const double area = mesh.area(t);
    sum.slopes += area * energy::excess_of_slopes(corners_[number], three(force, number), curvature);
    if (vibration_)
      sum.mass += area * sheet.material(t).areal_density *
                  energy::excess_of_mass(corners_[number], u, (x[1] - x[0]).cross(x[2] - x[0]).normalized(), curvature,
                                         lumped_);
  }
  return sum;
}

double ModeErrors::of(const solve::Mode& mode) {
  LinearValues change(model_, mode.shape, a_);
  const system::TriangleFields fields = change.triangle_changes();
  const double whole = 0.5 * change.stiffness();
  const DiscretisationError::Densities error = recovery_.of(model_, fields, FieldsOf::change);
  std::vector<double> force = force_;
  for (std::size_t i = 0; i < force_per_load_.size(); ++i)
    force[i] += (mode.value - model_.conditions().load_factor()) * force_per_load_[i];
  const Excess excess = excess_of(mode, fields, force);
  if (mpi::rank(model_.dofs().comm()) != 0) return 0.0;
  const energy::Sheet& sheet = model_.discretisation().sheet();
  double sum = 0.0;
  for (std::size_t t = 0; t < error.membrane.size(); ++t)
    sum += sheet.mesh().area(static_cast<Index>(t)) * (error.membrane[t] + error.bending[t]);
  const double energy = vibration_ ? whole : stored_energy(sheet, fields, FieldsOf::change);
  if (!(energy > 0.0)) return std::nan("");
  const double counted = lumped_ ? 1.0 : std::clamp(1.0 - bending_of(sheet, fields) / energy, 0.0, 1.0);
  return (sum + std::abs(excess.slopes - 0.5 * counted * mode.eigenvalue * excess.mass)) / energy;
}

}  // namespace voile::record
