// Second derivatives of the membrane energy.
#include <Eigen/Dense>
#include <cmath>

#include "membrane_samples.hpp"

namespace voile::energy {

namespace {

/// Principal stress resultants below zero are removed.
Vec3 tensile_part(const Vec3& n) {
  const double mean = 0.5 * (n[0] + n[1]), half_difference = 0.5 * (n[0] - n[1]);
  const double radius = std::sqrt(half_difference * half_difference + n[2] * n[2]);
  if (mean - radius >= 0.0) return n;
  if (mean + radius <= 0.0) return Vec3::Zero();
  // One tensile direction p: N+ = (mean + radius) p (x) p, with 2 p p^T = I + (N - mean I)/radius.
  const double half = 0.5 * (mean + radius);
  return {half * (1.0 + half_difference / radius), half * (1.0 - half_difference / radius), half * n[2] / radius};
}

using Quad = Eigen::Vector4d;

Quad quad(const Vec3& a) {
  return {a[0], a[1], a[2], 0.0};
}

/// Derivatives of (E11, E22, 2 E12), one in each column, with respect to a node with gradient weights (d1, d2).
class StrainSlopes {
 public:
  explicit StrainSlopes(const Base& a) : a1_(quad(a.a1)), a2_(quad(a.a2)) {}
  Quads operator()(double d1, double d2) const {
    Quads b;
    b.col(0) = d1 * a1_;
    b.col(1) = d2 * a2_;
    b.col(2) = d2 * a1_ + d1 * a2_;
    return b;
  }

 private:
  Quad a1_, a2_;
};

/// Adds b_i C b_j^T to the upper blocks, C symmetric; `node` ascends.
template <class Blocks, std::size_t n>
void add_material(Blocks& k, const std::array<Quads, n>& b, const std::array<int, n>& node, const Mat3& stiffness) {
  for (std::size_t j = 0; j < n; ++j) {
    const Mat3 cb = stiffness.lazyProduct(b[j].template topRows<3>().transpose());
    for (std::size_t i = 0; i <= j; ++i) {
      Quads& block = k[node[i]][node[j]];
      for (int c = 0; c < 3; ++c)
        block.col(c) += cb(0, c) * b[i].col(0) + cb(1, c) * b[i].col(1) + cb(2, c) * b[i].col(2);
    }
  }
}

/// Adds the geometric part sum_ab N_ab d_a,i d_b,j I to the upper blocks.
template <class Blocks, class Weights, std::size_t n>
void add_geometric(Blocks& k, const Vec3& stress, const Weights& d, const std::array<int, n>& node) {
  for (std::size_t i = 0; i < n; ++i) {
    const double p = stress[0] * d[0][i] + stress[2] * d[1][i], q = stress[1] * d[1][i] + stress[2] * d[0][i];
    for (std::size_t j = i; j < n; ++j) k[node[i]][node[j]].diagonal().array() += p * d[0][j] + q * d[1][j];
  }
}

}  // namespace

/// Stress for the geometric part: from the strain at x_k plus its linear change if that tangent is asked for. The strain
/// is quadratic in x: E(x) = E(x_k) + B(x_k) dx + half_metric of the increment.
struct MembraneTerm::Stress {
  const Mat3& stiffness;
  double viscosity;
  bool positive, linearised;

  Vec3 operator()(const Vec3& strain, const Vec3& quadratic, const Vec3& before) const {
    return stiffness * effective(linearised ? Vec3(strain - quadratic) : strain, before, viscosity);
  }
  [[nodiscard]] Vec3 clipped(const Vec3& n) const { return positive ? tensile_part(n) : n; }
};

void MembraneTerm::prepare(Index e, const Configuration& c, Workspace& w) const {
  const Element& el = elements_[e];
  const double viscosity = viscosity_of(el);
  const Stress stress{stiffness_[el.material], viscosity, c.tangent == Tangent::positive,
                      c.tangent == Tangent::linearised_stress && c.previous};
  static const Samples none{};
  const Samples& start = viscosity > 0.0 ? start_[e] : none;
  const Index* points = el.points.data();
  for (int i = 0; i < nodes; ++i)
    for (int j = i; j < nodes; ++j) w.k[i][j].setZero();
  if (corrects()) prepare_bends(e, c, w);
  if (kind_ == MembraneOperator::cst || cst_share_ > 0.0) prepare_own(e, c, stress, w);
  if (kind_ == MembraneOperator::cst) return;
  if (takes_mean()) return prepare_mean(e, c, stress, w);
  for (int s = 0; s < 3; ++s) {
    const Base base = side_base(el.side[s], c.x, points, s);
    Vec3 quadratic = Vec3::Zero();
    if (stress.linearised) {
      const Base before = side_base(el.side[s], c.previous, points, s);
      quadratic = half_metric(base.a1 - before.a1, base.a2 - before.a2);
    }
    const std::array<int, 4> node{0, 1, 2, 3 + s};
    std::array<Quads, 4> b;
    const StrainSlopes slopes(base);
    for (int k = 0; k < 4; ++k) b[k] = slopes(el.side[s][0][k], el.side[s][1][k]);
    add_material(w.k, b, node, el.area / 3.0 * (1.0 + viscosity) * stress.stiffness);
    const Vec3 strain = half_metric(base.a1, base.a2) - el.side_metric[s];
    add_geometric(w.k, el.area / 3.0 * stress.clipped(stress(strain, quadratic, start.side[s])), el.side[s], node);
  }
}

void MembraneTerm::prepare_bends(Index e, const Configuration& c, Workspace& w) const {
  const Bends change = correction_.change(e, c.u);
  w.bends = correction_.along_chords(e, change);
  const ChordCorrection::Curvature fourth = correction_.curvature(e, change, c.tangent == Tangent::positive);
  w.geometric = fourth.form;
  for (int i = 0; i < correction_.stencil_size(e); ++i) {
    const BendWeights& weight = correction_.weight(e, i);
    w.b[i].setZero();
    w.stiff[i].setZero();
    for (int k = 0; k < 2; ++k) {  // the first three vectors, which alone are in the term of fourth order
      w.b[i].col(6 + k).head<3>().noalias() = fourth.first[k].leftCols<3>() * weight.head<3>();
      w.stiff[i].row(6 + k).noalias() = (fourth.second[k].leftCols<3>() * weight.head<3>()).transpose();
    }
  }
}

template <std::size_t n>
Vec3 MembraneTerm::corrected(Index e, ChordCorrection::Strain which, const Vec3& strain,
                             const std::array<Quads, n>& own, const Mat3& material, Workspace& w) const {
  const ChordCorrection::Slopes slopes = correction_.slopes(e, which, w.bends);
  for (int i = 0; i < correction_.stencil_size(e); ++i) {
    const BendWeights& weight = correction_.weight(e, i);
    for (int r = 0; r < 3; ++r) {
      Eigen::Vector4d sum = Eigen::Vector4d::Zero();
      for (int a = 0; a < bend_vectors; ++a) sum += weight[a] * slopes[r].col(a);
      w.b[i].col(3 * which + r) = sum;
    }
    if (i < static_cast<int>(n)) w.b[i].middleCols<3>(3 * which) += own[static_cast<std::size_t>(i)];
    const auto b = w.b[i].block<3, 3>(0, 3 * which);
    w.stiff[i].block<3, 3>(3 * which, 0).noalias() = material.lazyProduct(b.transpose());
  }
  return strain + correction_.strain(e, which, w.bends);
}

void MembraneTerm::prepare_own(Index e, const Configuration& c, const Stress& stress, Workspace& w) const {
  const Element& el = elements_[e];
  const Index* points = el.points.data();
  const Vec3 start = stress.viscosity > 0.0 ? start_[e].own : Vec3::Zero();
  const double weight = el.area * (kind_ == MembraneOperator::cst ? 1.0 : cst_share_);
  const Mat3 material = weight * (1.0 + stress.viscosity) * stress.stiffness;
  const Base a = own_base(el.own, c.x, points);
  Vec3 strain = half_metric(a.a1, a.a2) - el.own_metric, quadratic = Vec3::Zero();
  if (stress.linearised) {
    const Base before = own_base(el.own, c.previous, points);
    quadratic = half_metric(a.a1 - before.a1, a.a2 - before.a2);
  }
  std::array<Quads, 3> b;
  const StrainSlopes slopes(a);
  for (int k = 0; k < 3; ++k) b[k] = slopes(el.own[0][k], el.own[1][k]);
  if (corrects()) {
    constexpr auto which = ChordCorrection::own;
    strain = corrected(e, which, strain, b, material, w);
    if (stress.linearised) quadratic += correction_.quadratic(e, which, correction_.step(e, c));
    w.geometric += correction_.geometric(e, which, weight * stress(strain, quadratic, start), stress.positive);
  } else {
    add_material(w.k, b, std::array{0, 1, 2}, material);
  }
  add_geometric(w.k, weight * stress.clipped(stress(strain, quadratic, start)), el.own, std::array{0, 1, 2});
}

void MembraneTerm::prepare_mean(Index e, const Configuration& c, const Stress& stress, Workspace& w) const {
  const Element& el = elements_[e];
  const Mat3 material = (1.0 + stress.viscosity) * stress.stiffness;
  const Vec3 start = stress.viscosity > 0.0 ? start_[e].side[0] : Vec3::Zero();
  const Index* points = el.points.data();
  const double weight = el.area * (1.0 - cst_share_);
  std::array<Base, 3> base;
  Vec3 strain = Vec3::Zero(), quadratic = Vec3::Zero();
  for (int s = 0; s < 3; ++s) {
    base[s] = side_base(el.side[s], c.x, points, s);
    strain += (half_metric(base[s].a1, base[s].a2) - el.side_metric[s]) / 3.0;
    if (!stress.linearised) continue;
    const Base before = side_base(el.side[s], c.previous, points, s);
    quadratic += half_metric(base[s].a1 - before.a1, base[s].a2 - before.a2) / 3.0;
  }
  const std::array slopes{StrainSlopes(base[0]), StrainSlopes(base[1]), StrainSlopes(base[2])};
  std::array<Quads, nodes> b;
  for (int k = 0; k < 3; ++k) {
    b[k].setZero();
    for (int s = 0; s < 3; ++s) b[k] += slopes[s](el.side[s][0][k], el.side[s][1][k]);
    b[3 + k] = slopes[k](el.side[k][0][3], el.side[k][1][3]);
  }
  if (corrects()) {
    constexpr auto which = ChordCorrection::mean;
    for (Quads& node : b) node /= 3.0;
    strain = corrected(e, which, strain, b, weight * material, w);
    if (stress.linearised) quadratic += correction_.quadratic(e, which, correction_.step(e, c));
    w.geometric += correction_.geometric(e, which, weight * stress(strain, quadratic, start), stress.positive);
  } else {
    add_material(w.k, b, std::array{0, 1, 2, 3, 4, 5}, weight / 9.0 * material);
  }
  const Vec3 n = weight / 3.0 * stress.clipped(stress(strain, quadratic, start));
  for (int s = 0; s < 3; ++s) add_geometric(w.k, n, el.side[s], std::array{0, 1, 2, 3 + s});
}

}  // namespace voile::energy
