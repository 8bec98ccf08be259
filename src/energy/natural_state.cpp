#include "natural_state.hpp"

#include <Eigen/Dense>
#include <cmath>

namespace voile::energy {

namespace {

/// (t11, t22, 2 t12) of a symmetric tensor, and back.
Mat2 tensor(const Vec3& v) {
  return (Mat2() << v[0], 0.5 * v[2], 0.5 * v[2], v[1]).finished();
}
Vec3 numbers(const Mat2& t) {
  return {t(0, 0), t(1, 1), t(0, 1) + t(1, 0)};
}

/// Of a symmetric, positive definite tensor of two dimensions (Cayley-Hamilton).
Mat2 square_root(const Mat2& u) {
  const double root = std::sqrt(u.determinant());
  return (u + root * Mat2::Identity()) / std::sqrt(u.trace() + 2.0 * root);
}

}  // namespace

Vec3 NaturalState::metric(const Vec3& rest) const {
  const Mat2 m = tensor(rest), e = stretch - Mat2::Identity();
  return (first_order ? numbers(m + e * m + m * e) : numbers(stretch * m * stretch)) + prestrain;
}

Vec3 NaturalState::bent(const Vec3& rest) const {
  const Mat2 k = tensor(rest);
  if (first_order) {
    const Mat2 e = 0.5 * (stretch - Mat2::Identity());
    return numbers(k + e * k + k * e) + curvature;
  }
  const Mat2 root = square_root(stretch);
  return numbers(root * k * root) + curvature;
}

NaturalState natural_state(const Material& material, double change, double difference) {
  NaturalState s;
  s.stretch += tensor(material.initial_strain + change * material.expansion + difference * material.coupled_strain);
  s.curvature = difference * material.expansion_curvature + change * material.coupled_curvature;
  if (material.prestress.isZero(0.0)) return s;
  const Released r = released(material, material.prestress, Vec3::Zero());
  s.prestrain = -r.strain;
  s.curvature -= r.curvature;
  return s;
}

Material in_natural_frame(Material m) {
  if ((!m.yarns.any() && !m.rubber.any()) || m.initial_strain.isZero(0.0)) return m;
  const Mat2 stretch = Mat2::Identity() + tensor(m.initial_strain);
  const Mat2 back = stretch.inverse();
  Mat3 to_natural;
  for (Eigen::Index k = 0; k < 3; ++k) to_natural.col(k) = numbers(back * tensor(Vec3::Unit(k)) * back);
  m.yarns.natural = to_natural;
  m.yarns.area = stretch.determinant();
  m.rubber.natural = to_natural;
  m.rubber.area = m.yarns.area;
  // The thickness of rubber is that of its natural state, and so is its volume; a fabric keeps the mass of what was cut.
  if (m.rubber.any()) m.areal_density *= m.rubber.area;
  m.membrane = m.yarns.area * (to_natural.transpose() * m.membrane * to_natural);
  return m;
}

bool has_initial_state(const Material& material) {
  return !material.initial_strain.isZero(0.0) || !material.prestress.isZero(0.0);
}

}  // namespace voile::energy
