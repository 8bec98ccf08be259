#include "material.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <numbers>

#include "base/decompositions.hpp"

namespace voile::energy {

Mat3 isotropic_membrane(double youngs_modulus, double poisson_ratio, double thickness) {
  const double c = youngs_modulus * thickness / (1.0 - poisson_ratio * poisson_ratio);
  Mat3 a = Mat3::Zero();
  a(0, 0) = a(1, 1) = c;
  a(0, 1) = a(1, 0) = c * poisson_ratio;
  a(2, 2) = 0.5 * c * (1.0 - poisson_ratio);
  return a;
}

Mat3 bending_from_membrane(const Mat3& membrane, double thickness) {
  return membrane * (thickness * thickness / 12.0);
}

Mat3 orthotropic_membrane(double e1, double e2, double nu12, double g12, double thickness) {
  // Reciprocity: nu21 / E2 = nu12 / E1.
  const double nu21 = nu12 * e2 / e1;
  const double c = thickness / (1.0 - nu12 * nu21);
  Mat3 a = Mat3::Zero();
  a(0, 0) = c * e1;
  a(1, 1) = c * e2;
  a(0, 1) = a(1, 0) = c * nu12 * e2;
  a(2, 2) = g12 * thickness;
  return a;
}

void fuse(Material& material, const FusedLayer& layer) {
  const Mat3 both = material.membrane + layer.membrane;
  const Mat3 apart = material.membrane * Eigen::LLT<Mat3>(both).solve(layer.membrane);
  const double square = layer.bond * layer.distance * layer.distance;
  material.bending += layer.bending + square * 0.5 * (apart + apart.transpose());
  material.membrane = both;
  material.areal_density += layer.areal_density;
}

std::vector<YarnFriction::Slider> sliders_of(const Vec3& loop, double spread, int count) {
  std::vector<YarnFriction::Slider> sliders;
  if (loop == Vec3::Zero()) return sliders;
  for (int j = 1; j <= count; ++j) {
    const Vec3 limit = 0.5 * loop / count;
    sliders.push_back({2.0 * limit / (spread * 2.0 * j / (count + 1)), limit});
  }
  return sliders;
}

Mat3 turned_strain(double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  Mat3 t;
  t << c * c, s * s, c * s,  //
      s * s, c * c, -c * s,  //
      -2 * c * s, 2 * c * s, c * c - s * s;
  return t;
}

Mat3 rotated_stiffness(const Mat3& stiffness, double angle) {
  // Energies agree: Q = T^T Q' T.
  const Mat3 t = turned_strain(angle);
  return t.transpose() * stiffness * t;
}

Vec3 rotated_strain(const Vec3& strain, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  Mat3 t;
  t << c * c, s * s, -c * s,  //
      s * s, c * c, c * s,    //
      2 * c * s, -2 * c * s, c * c - s * s;
  return t * strain;
}

Vec3 rotated_force(const Vec3& force, double angle) {
  const Vec3 like_strain = rotated_strain(Vec3(force[0], force[1], 2.0 * force[2]), angle);
  return {like_strain[0], like_strain[1], 0.5 * like_strain[2]};
}

namespace {

/// [A, -B; -B, D]
Eigen::Matrix<double, 6, 6> whole_stiffness(const Material& m) {
  Eigen::Matrix<double, 6, 6> k;
  k << m.membrane, -m.coupling, -m.coupling, m.bending;
  return k;
}

}  // namespace

Released released(const Material& material, const Vec3& force, const Vec3& moment) {
  if (!couples(material))
    return {Eigen::LLT<Mat3>(material.membrane).solve(force), Eigen::LLT<Mat3>(material.bending).solve(moment)};
  Eigen::VectorXd right(6);
  right << force, moment;
  const Eigen::VectorXd both = solve_positive(whole_stiffness(material), right);
  return {both.head<3>(), both.tail<3>()};
}

bool is_stable(const Material& material) {
  if (!is_positive_definite(material.membrane) || !is_positive_definite(material.bending)) return false;
  if (!couples(material)) return true;
  const Mat3 left = material.bending - material.coupling * Eigen::LLT<Mat3>(material.membrane).solve(material.coupling);
  return is_positive_definite(left);
}

void set_expansion(Material& material, const Vec3& expansion, const std::vector<double>& angles) {
  std::vector<Layer>& layers = material.layers;
  std::array<Vec3, 3> sums{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};  // of Q a dz, Q a z dz, Q a z^2 dz
  const double thickness = layers.back().high - layers.front().low;
  for (std::size_t k = 0; k < layers.size(); ++k) {
    Layer& l = layers[k];
    l.expansion = angles.empty() ? expansion : rotated_strain(expansion, angles[k] * (std::numbers::pi / 180.0));
    const Vec3 stress = l.stiffness * l.expansion;
    for (int n = 1; n <= 3; ++n) sums[n - 1] += (std::pow(l.high, n) - std::pow(l.low, n)) / n * stress;
  }
  const Vec3 none = Vec3::Zero(), first = couples(material) ? sums[1] : none;  // of symmetric stacks round-off
  const Released change = released(material, sums[0], -first),
                 difference = released(material, first / thickness, -sums[2] / thickness);
  material.expansion = change.strain;
  material.coupled_curvature = change.curvature;
  material.coupled_strain = difference.strain;
  material.expansion_curvature = difference.curvature;
}

LaminateStiffness laminate(const Mat3& ply_stiffness, const std::vector<Ply>& plies) {
  LaminateStiffness sum;
  for (const Ply& ply : plies) sum.thickness += ply.thickness;
  double low = -0.5 * sum.thickness;
  for (const Ply& ply : plies) {
    const double high = low + ply.thickness;
    const Mat3 q = rotated_stiffness(ply_stiffness, ply.angle);
    sum.membrane += q * (high - low);
    sum.coupling += q * (0.5 * (high * high - low * low));
    sum.bending += q * ((high * high * high - low * low * low) / 3.0);
    sum.layers.push_back({low, high, q, Vec3::Zero(), ply.angle});
    low = high;
  }
  return sum;
}

bool is_positive_definite(const Mat3& m) {
  if (!m.allFinite()) return false;
  const Eigen::VectorXd values = eigenvalues(Eigen::MatrixXd(0.5 * (m + m.transpose())));
  // A singular matrix comes out with a smallest eigenvalue of either sign at round-off.
  return values[0] > 1e-14 * values[2];
}

}  // namespace voile::energy
