#include "chord_error.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "chord_forms.hpp"
#include "membrane.hpp"

namespace voile::energy {

namespace {

/// r at which a shell deflects half as much as it should.
constexpr double half_locked = 10.0;

bool corrects(const Sheet& sheet) {
  return sheet.options().membrane == MembraneOperator::six_node_corrected;
}

double largest_principal(const Vec3& kappa) {
  return std::abs(0.5 * (kappa[0] + kappa[1])) + std::hypot(0.5 * (kappa[0] - kappa[1]), 0.5 * kappa[2]);
}

/// L^2
double mean_squared_side(const mesh::SurfaceMesh& mesh, Index t) {
  double squared = 0.0;
  for (int i = 0; i < 3; ++i)
    squared += (mesh.rest_corner(t, (i + 1) % 3) - mesh.rest_corner(t, i)).squaredNorm() / 3.0;
  return squared;
}

/// Fraction of the spurious energy of chords that the correction by a cubic leaves: for a rest shape of curvature kappa0 the angle
/// kappa0 L per cell, for bending to kappa its square.
double left_over(const Sheet& sheet, Index t, const Vec3& rest, const Vec3& kappa) {
  const double squared = mean_squared_side(sheet.mesh(), t);
  return std::min(
      1.0, std::pow(largest_principal(rest), 2) * squared + std::pow(largest_principal(kappa), 4) * squared * squared);
}

}  // namespace

ChordError::ChordError(const Sheet& sheet) {
  const ChordForms forms(sheet);
  const MembraneOperator kind = sheet.options().membrane;
  const double own = kind == MembraneOperator::cst                           ? 1.0
                     : kind == MembraneOperator::six_node || corrects(sheet) ? sheet.options().cst_fraction
                                                                             : 0.0;
  corrections_.reserve(static_cast<std::size_t>(sheet.mesh().triangle_count()));
  for (Index t = 0; t < sheet.mesh().triangle_count(); ++t)
    corrections_.push_back(forms.of(t, MembraneTerm::forms(sheet, t, own)));
}

std::vector<double> ChordError::energies(const Sheet& sheet, const std::vector<double>& curvature,
                                         const std::vector<double>& whole_curvature, bool linear) const {
  std::vector<double> energies;
  energies.reserve(corrections_.size());
  for (std::size_t t = 0; t < corrections_.size(); ++t) {
    const Vec3 whole = Eigen::Map<const Vec3>(&whole_curvature[3 * t]),
               change = Eigen::Map<const Vec3>(&curvature[3 * t]), rest = whole - change;
    Vec3 spurious;
    for (int r = 0; r < 3; ++r) {
      const Mat3& form = corrections_[t][static_cast<std::size_t>(r)];
      spurious[r] = linear ? rest.dot(form * change) : 0.5 * (whole + rest).dot(form * change);
    }
    const double left = corrects(sheet) ? left_over(sheet, static_cast<Index>(t), rest, linear ? rest : whole) : 1.0;
    energies.push_back(0.5 * left * spurious.dot(sheet.material(static_cast<Index>(t)).membrane * spurious));
  }
  return energies;
}

namespace {

/// Triangles at creases of the rest shape, and beside those: their curvature is that of the fold, not of a curved shell.
std::vector<char> beside_creases(const Sheet& sheet) {
  const mesh::SurfaceMesh& mesh = sheet.mesh();
  std::vector<char> beside(static_cast<std::size_t>(mesh.triangle_count()), 0);
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    for (int s = 0; s < 3; ++s) {
      if (mesh.neighbour(t, s) == no_index || !sheet.is_crease(t, s)) continue;
      beside[static_cast<std::size_t>(t)] = 1;
      for (int k = 0; k < 3; ++k)
        if (mesh.neighbour(t, k) != no_index) beside[static_cast<std::size_t>(mesh.neighbour(t, k))] = 1;
    }
  return beside;
}

}  // namespace

double locking_estimate(const Sheet& sheet, const std::vector<double>& rest_curvature) {
  if (sheet.options().membrane == MembraneOperator::cst) return 0.0;
  const mesh::SurfaceMesh& mesh = sheet.mesh();
  const std::vector<char> folded = beside_creases(sheet);
  double sum = 0.0, total = 0.0;
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    total += mesh.area(t);
    if (folded[static_cast<std::size_t>(t)] != 0) continue;
    const Vec3 k = Eigen::Map<const Vec3>(&rest_curvature[3 * static_cast<std::size_t>(t)]);
    const Material& m = sheet.material(t);
    const double thickness_squared = 12.0 * m.bending.trace() / m.membrane.trace();
    const double left = corrects(sheet) ? left_over(sheet, t, k, k) : 1.0;
    sum += mesh.area(t) * left * std::pow(largest_principal(k) * mean_squared_side(mesh, t), 2) /
           (12.0 * thickness_squared);
  }
  const double r = sum / total;
  return r / (r + half_locked);
}

}  // namespace voile::energy
