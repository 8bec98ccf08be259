#include "voile/energy/chord_error.hpp"

#include <Eigen/Dense>
#include <cmath>

#include "voile/energy/chord_forms.hpp"
#include "voile/energy/membrane.hpp"

namespace voile::energy {

namespace {

/// r at which a shell deflects half as much as it should.
constexpr double half_locked = 10.0;

}  // namespace

ChordError::ChordError(const Sheet& sheet) {
  if (sheet.options().membrane == MembraneOperator::six_node_corrected) {
    corrections_.assign(static_cast<std::size_t>(sheet.mesh().triangle_count()),
                        {Mat3::Zero(), Mat3::Zero(), Mat3::Zero()});
    return;
  }
  const ChordForms forms(sheet);
  const MembraneOperator kind = sheet.options().membrane;
  const double own = kind == MembraneOperator::cst        ? 1.0
                     : kind == MembraneOperator::six_node ? sheet.options().cst_share
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
    Vec3 feigned;
    for (int r = 0; r < 3; ++r) {
      const Mat3& form = corrections_[t][static_cast<std::size_t>(r)];
      feigned[r] = linear ? rest.dot(form * change) : 0.5 * (whole + rest).dot(form * change);
    }
    energies.push_back(0.5 * feigned.dot(sheet.material(static_cast<Index>(t)).membrane * feigned));
  }
  return energies;
}

double locking_estimate(const Sheet& sheet, const std::vector<double>& rest_curvature) {
  if (sheet.options().membrane == MembraneOperator::cst) return 0.0;
  const mesh::SurfaceMesh& mesh = sheet.mesh();
  double sum = 0.0, total = 0.0;
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const Vec3 k = Eigen::Map<const Vec3>(&rest_curvature[3 * static_cast<std::size_t>(t)]);
    const double largest = std::abs(0.5 * (k[0] + k[1])) + std::hypot(0.5 * (k[0] - k[1]), 0.5 * k[2]);
    double squared = 0.0;
    for (int i = 0; i < 3; ++i)
      squared += (mesh.rest_corner(t, (i + 1) % 3) - mesh.rest_corner(t, i)).squaredNorm() / 3.0;
    const Material& m = sheet.material(t);
    const double thickness_squared = 12.0 * m.bending.trace() / m.membrane.trace();
    sum += mesh.area(t) * std::pow(largest * squared, 2) / (12.0 * thickness_squared);
    total += mesh.area(t);
  }
  const double r = sum / total;
  return r / (r + half_locked);
}

}  // namespace voile::energy
