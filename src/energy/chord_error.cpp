#include "voile/energy/chord_error.hpp"

#include <Eigen/Dense>
#include <cmath>

#include "voile/energy/membrane.hpp"

namespace voile::energy {

namespace {

/// Averages of S from triangles to vertices and back.
constexpr int averages = 2;
/// r at which a shell deflects half as much as it should.
constexpr double half_locked = 10.0;

/// Sides of a triangle at the start and at rest: what takes a tensor in space to the plane of the triangle.
struct Sides {
  Eigen::Matrix<double, 3, 2> start;
  Mat2 rest;  ///< in its own axes

  Sides(const Sheet& sheet, Index t) {
    const mesh::SurfaceMesh& mesh = sheet.mesh();
    const mesh::Patch patch = sheet.patches().patch(t, sheet.frame(t));
    for (int k = 0; k < 2; ++k) {
      start.col(k) = mesh.start_corner(t, k + 1) - mesh.start_corner(t, 0);
      rest.col(k) = patch.coordinates[static_cast<std::size_t>(k + 1)] - patch.coordinates[0];
    }
  }
  [[nodiscard]] Mat3 to_space(const Mat2& s) const {
    const Eigen::Matrix<double, 3, 2> map = start * rest.inverse();
    return map * s * map.transpose();
  }
  [[nodiscard]] Mat2 from_space(const Mat3& s) const {
    const Eigen::Matrix<double, 2, 3> map = rest * (start.transpose() * start).inverse() * start.transpose();
    return map * s * map.transpose();
  }
};

/// S of each triangle in its own axes. Averaged in space, where charts are side by side.
std::vector<Mat2> even_sizes(const Sheet& sheet) {
  const mesh::SurfaceMesh& mesh = sheet.mesh();
  const auto count = static_cast<std::size_t>(mesh.triangle_count());
  std::vector<Mat3> size;
  size.reserve(count);
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const Sides sides(sheet, t);
    const Vec2 a = sides.rest.col(0), b = sides.rest.col(1), c = b - a;
    size.push_back(sides.to_space((a * a.transpose() + b * b.transpose() + c * c.transpose()) / 24.0));
  }
  for (int pass = 0; pass < averages; ++pass) {
    std::vector<Mat3> at(static_cast<std::size_t>(mesh.vertex_count()), Mat3::Zero());
    std::vector<double> area(at.size(), 0.0);
    for (std::size_t t = 0; t < count; ++t)
      for (const Index v : mesh.triangles()[t]) {
        const double share = mesh.area(static_cast<Index>(t));
        at[v] += share * size[t];
        area[v] += share;
      }
    for (std::size_t t = 0; t < count; ++t) {
      size[t].setZero();
      for (const Index v : mesh.triangles()[t]) size[t] += at[v] / (3.0 * area[v]);
    }
  }
  std::vector<Mat2> result;
  for (std::size_t t = 0; t < count; ++t) result.push_back(Sides(sheet, static_cast<Index>(t)).from_space(size[t]));
  return result;
}

/// T^r of a triangle without its even part.
std::array<Mat3, 3> corrections_of(const Sheet& sheet, Index t, const Mat2& even) {
  const mesh::Patch patch = sheet.patches().patch(t, sheet.frame(t));
  const auto forms = MembraneTerm::forms(sheet, t);
  std::array<Mat3, 3> corrections;
  for (std::size_t r = 0; r < 3; ++r) {
    corrections[r].setZero();
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j) {
        const double q = forms[r](i, j);
        if (i == j || q == 0.0) continue;
        const Vec2 l = patch.coordinates[static_cast<std::size_t>(j)] - patch.coordinates[static_cast<std::size_t>(i)];
        const Vec3 lam(l[0] * l[0], l[1] * l[1], l[0] * l[1]);
        corrections[r] -= q / 24.0 * lam * lam.transpose();
      }
  }
  const double a = even(0, 0), b = even(0, 1), c = even(1, 1);
  Mat3 first, second, both;
  first << 2 * a, 0, b, 0, 0, 0, b, 0, c / 2;
  second << 0, 0, 0, 0, 2 * c, b, 0, b, a / 2;
  both << 0, 2 * b, a, 2 * b, 0, c, a, c, b;
  corrections[0] -= first;
  corrections[1] -= second;
  corrections[2] -= both;
  return corrections;
}

}  // namespace

ChordError::ChordError(const Sheet& sheet) {
  const std::vector<Mat2> even = even_sizes(sheet);
  corrections_.reserve(even.size());
  for (std::size_t t = 0; t < even.size(); ++t)
    corrections_.push_back(corrections_of(sheet, static_cast<Index>(t), even[t]));
}

std::vector<double> ChordError::energies(const Sheet& sheet, const std::vector<double>& curvature,
                                         const std::vector<double>& whole_curvature) const {
  std::vector<double> energies;
  energies.reserve(corrections_.size());
  for (std::size_t t = 0; t < corrections_.size(); ++t) {
    const Vec3 whole = Eigen::Map<const Vec3>(&whole_curvature[3 * t]),
               rest = whole - Eigen::Map<const Vec3>(&curvature[3 * t]);
    Vec3 feigned;
    for (int r = 0; r < 3; ++r) {
      const Mat3& form = corrections_[t][static_cast<std::size_t>(r)];
      feigned[r] = 0.5 * (whole.dot(form * whole) - rest.dot(form * rest));
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
