#include "voile/energy/membrane.hpp"

#include <Eigen/Dense>
#include <algorithm>

namespace voile::energy {

namespace {

/// Gradient of the linear interpolation on a triangle: row alpha, column corner.
std::array<std::array<double, 3>, 2> linear_gradient(const Vec2& a, const Vec2& b, const Vec2& c) {
  const double twice = (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
  return {{{(b.y() - c.y()) / twice, (c.y() - a.y()) / twice, (a.y() - b.y()) / twice},
           {(c.x() - b.x()) / twice, (a.x() - c.x()) / twice, (b.x() - a.x()) / twice}}};
}

double area_of(const Vec2& a, const Vec2& b, const Vec2& c) {
  return 0.5 * std::abs((b - a).x() * (c - a).y() - (b - a).y() * (c - a).x());
}

/// Half metric (a1.a1/2, a2.a2/2, a1.a2): Green strain before the rest metric is taken off.
Vec3 half_metric(const Vec3& a1, const Vec3& a2) {
  return {0.5 * a1.squaredNorm(), 0.5 * a2.squaredNorm(), a1.dot(a2)};
}

/// Principal stress resultants below zero are removed.
Vec3 tensile_part(const Vec3& n) {
  const double mean = 0.5 * (n[0] + n[1]), radius = std::hypot(0.5 * (n[0] - n[1]), n[2]);
  if (mean - radius >= 0.0) return n;
  if (mean + radius <= 0.0) return Vec3::Zero();
  // One tensile direction p: N+ = (mean + radius) p (x) p, with 2 p p^T = I + (N - mean I)/radius.
  const double half = 0.5 * (mean + radius);
  return {half * (1.0 + 0.5 * (n[0] - n[1]) / radius), half * (1.0 - 0.5 * (n[0] - n[1]) / radius),
          half * n[2] / radius};
}

/// Base vectors of one sample.
struct Base {
  Vec3 a1, a2;
};

template <class Weights>
Base side_base(const Weights& d, const Vec3* x, const Index* points, int side) {
  Base b{Vec3::Zero(), Vec3::Zero()};
  for (int k = 0; k < 3; ++k) {
    b.a1 += d[0][k] * x[points[k]];
    b.a2 += d[1][k] * x[points[k]];
  }
  b.a1 += d[0][3] * x[points[3 + side]];
  b.a2 += d[1][3] * x[points[3 + side]];
  return b;
}

template <class Weights>
Base own_base(const Weights& d, const Vec3* x, const Index* points) {
  Base b{Vec3::Zero(), Vec3::Zero()};
  for (int k = 0; k < 3; ++k) {
    b.a1 += d[0][k] * x[points[k]];
    b.a2 += d[1][k] * x[points[k]];
  }
  return b;
}

/// Adds weight * d(N.E)/dx of one sample: force on each node with gradient weights (d1, d2).
Vec3 pull(const Base& a, const Vec3& n, double d1, double d2) {
  return (n[0] * d1 + n[2] * d2) * a.a1 + (n[1] * d2 + n[2] * d1) * a.a2;
}

/// Derivative of (E11, E22, 2 E12) with respect to a node with gradient weights (d1, d2).
Mat3 strain_rows(const Base& a, double d1, double d2) {
  Mat3 b;
  b.row(0) = d1 * a.a1.transpose();
  b.row(1) = d2 * a.a2.transpose();
  b.row(2) = (d2 * a.a1 + d1 * a.a2).transpose();
  return b;
}

/// Adds b_i^T C b_j to the upper blocks; `node` ascends.
template <class Blocks, std::size_t n>
void add_material(Blocks& k, const std::array<Mat3, n>& b, const std::array<int, n>& node, const Mat3& stiffness) {
  for (std::size_t j = 0; j < n; ++j) {
    const Mat3 cb = stiffness * b[j];
    for (std::size_t i = 0; i <= j; ++i) k[node[i]][node[j]].noalias() += b[i].transpose() * cb;
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

MembraneTerm::MembraneTerm(const Sheet& sheet)
    : kind_(sheet.options().membrane),
      cst_share_(sheet.options().membrane == MembraneOperator::six_node ? sheet.options().cst_share : 0.0) {
  for (const Material& m : sheet.materials()) {
    stiffness_.push_back(m.membrane);
    viscous_time_.push_back(m.viscous_time);
  }
}

std::array<Index, MembraneTerm::nodes> MembraneTerm::stencil_of(const Sheet& sheet, Index t) {
  std::array<Index, nodes> points{};
  for (int i = 0; i < 3; ++i) {
    points[i] = sheet.mesh().triangles()[t][i];
    const Index apex = sheet.patches().apex(t, i);
    points[3 + i] = apex == no_index ? sheet.mesh().triangles()[t][0] : apex;
  }
  return points;
}

MembraneTerm::Element MembraneTerm::element_of(const Sheet& sheet, Index t) {
  const mesh::Frame frame = sheet.frame(t);
  const mesh::Patch patch = sheet.patches().patch(t, frame);
  const auto& p = patch.coordinates;
  Element el{};
  el.area = patch.area;
  el.material = sheet.material_index(t);
  el.own = linear_gradient(p[0], p[1], p[2]);
  el.own_metric = Vec3(0.5, 0.5, 0.0);
  for (int s = 0; s < 3; ++s) {
    SideWeights& d = el.side[s];
    for (int alpha = 0; alpha < 2; ++alpha) d[alpha] = {el.own[alpha][0], el.own[alpha][1], el.own[alpha][2], 0.0};
    el.side_metric[s] = el.own_metric;
    if (patch.points[3 + s] == no_index || sheet.patches().rest_dihedral(t, s) > sheet.options().crease_angle) continue;
    const int a = (s + 1) % 3, b = (s + 2) % 3;
    // The neighbour's gradient belongs to its own rest shape, the patch has this `stretch` times as long.
    const double stretch = patch.stretch[s];
    const auto far = linear_gradient(p[b], p[a], p[3 + s]);
    const double far_area = area_of(p[a], p[b], p[3 + s]) / (stretch * stretch),
                 share = patch.area / (patch.area + far_area);
    const auto mix = [&](double far_share) {
      SideWeights m = d;
      for (int alpha = 0; alpha < 2; ++alpha) {
        for (int k = 0; k < 3; ++k) m[alpha][k] *= share;
        m[alpha][b] += far_share * far[alpha][0];
        m[alpha][a] += far_share * far[alpha][1];
        m[alpha][3] = far_share * far[alpha][2];
      }
      return m;
    };
    const SideWeights at_rest = mix(1.0 - share);
    Vec3 a1 = Vec3::Zero(), a2 = Vec3::Zero();
    for (int k = 0; k < 4; ++k) {
      const Vec3 x = patch.rest[k < 3 ? k : 3 + s];
      a1 += at_rest[0][k] * x;
      a2 += at_rest[1][k] * x;
    }
    el.side_metric[s] = half_metric(a1, a2);
    d = mix((1.0 - share) * stretch);
  }
  return el;
}

void MembraneTerm::add(const Sheet& sheet, Index t, const std::array<Index, nodes>& local, bool owned) {
  Element el = element_of(sheet, t);
  el.points = local;
  el.owned = owned;
  elements_.push_back(el);
}

std::array<Eigen::Matrix<double, MembraneTerm::nodes, MembraneTerm::nodes>, 3> MembraneTerm::forms(const Sheet& sheet,
                                                                                                   Index t) {
  using Weights = Eigen::Matrix<double, 2, nodes>;
  const Element el = element_of(sheet, t);
  std::array<Eigen::Matrix<double, nodes, nodes>, 3> forms;
  forms.fill(Eigen::Matrix<double, nodes, nodes>::Zero());
  const auto add = [&](double share, const Weights& d) {
    forms[0] += share * d.row(0).transpose() * d.row(0);
    forms[1] += share * d.row(1).transpose() * d.row(1);
    forms[2] += share * (d.row(0).transpose() * d.row(1) + d.row(1).transpose() * d.row(0));
  };
  const ElementOptions& options = sheet.options();
  const double own = options.membrane == MembraneOperator::cst        ? 1.0
                     : options.membrane == MembraneOperator::six_node ? options.cst_share
                                                                      : 0.0;
  for (int s = 0; s < 3; ++s) {
    Weights d = Weights::Zero(), of_triangle = Weights::Zero();
    for (int alpha = 0; alpha < 2; ++alpha) {
      for (int k = 0; k < 3; ++k) {
        d(alpha, k) = el.side[s][alpha][k];
        of_triangle(alpha, k) = el.own[alpha][k];
      }
      d(alpha, 3 + s) = el.side[s][alpha][3];
    }
    add((1.0 - own) / 3.0, d);
    add(own / 3.0, of_triangle);
  }
  return forms;
}

MembraneTerm::Samples MembraneTerm::samples(Index e, const Configuration& c) const {
  const Element& el = elements_[e];
  Samples f;
  const Base own = own_base(el.own, c.x, el.points.data());
  f.own = half_metric(own.a1, own.a2) - el.own_metric;
  if (kind_ == MembraneOperator::cst) return f;
  for (int s = 0; s < 3; ++s) {
    const Base a = side_base(el.side[s], c.x, el.points.data(), s);
    f.side[s] = half_metric(a.a1, a.a2) - el.side_metric[s];
  }
  if (kind_ == MembraneOperator::six_node) f.side[0] = (f.side[0] + f.side[1] + f.side[2]) / 3.0;
  return f;
}

void MembraneTerm::start_step(const Configuration& c, double ratio, double inverse_step) {
  viscosity_.clear();
  for (const double time : viscous_time_) viscosity_.push_back(ratio + time * inverse_step);
  if (std::all_of(viscosity_.begin(), viscosity_.end(), [](double v) { return v == 0.0; })) {
    viscosity_.clear();
    return;
  }
  start_.resize(elements_.size());
  for (Index e = 0; e < size(); ++e) start_[e] = samples(e, c);
}

double MembraneTerm::energy(Index e, const Configuration& c) const {
  const Element& el = elements_[e];
  const Mat3& stiffness = stiffness_[el.material];
  const Samples f = samples(e, c);
  const double viscosity = viscosity_of(el);
  const Samples* before = viscosity > 0.0 ? &start_[e] : nullptr;
  const auto density = [&](const Vec3& strain, const Vec3& start) {
    const double w = 0.5 * strain.dot(stiffness * strain);
    return before ? w + 0.5 * viscosity * (strain - start).dot(stiffness * (strain - start)) : w;
  };
  const Samples& at = before ? *before : f;
  if (kind_ == MembraneOperator::cst) return el.area * density(f.own, at.own);
  if (kind_ == MembraneOperator::six_node) {
    const double own = cst_share_ > 0.0 ? cst_share_ * density(f.own, at.own) : 0.0;
    return el.area * (own + (1.0 - cst_share_) * density(f.side[0], at.side[0]));
  }
  double w = 0.0;
  for (int s = 0; s < 3; ++s) w += density(f.side[s], at.side[s]) / 3.0;
  return el.area * w;
}

Vec3 MembraneTerm::strain(Index e, const Configuration& c) const {
  const Element& el = elements_[e];
  const Base own = own_base(el.own, c.x, el.points.data());
  Vec3 constant = half_metric(own.a1, own.a2) - el.own_metric;
  if (kind_ == MembraneOperator::cst) return constant;
  Vec3 mean = Vec3::Zero();
  for (int s = 0; s < 3; ++s) {
    const Base a = side_base(el.side[s], c.x, el.points.data(), s);
    mean += (half_metric(a.a1, a.a2) - el.side_metric[s]) / 3.0;
  }
  return (1.0 - cst_share_) * mean + cst_share_ * constant;
}

Vec3 MembraneTerm::force(Index e, const Configuration& c) const {
  return stiffness_[elements_[e].material] * strain(e, c);
}

void MembraneTerm::gradient_of(Index e, const Configuration& c, std::array<Vec3, nodes>& g) const {
  g.fill(Vec3::Zero());
  const Element& el = elements_[e];
  static const Samples none{};
  const double viscosity = viscosity_of(el);
  const Samples& before = viscosity > 0.0 ? start_[e] : none;
  const Mat3& stiffness = stiffness_[el.material];
  if (kind_ == MembraneOperator::cst || cst_share_ > 0.0) {
    const Base a = own_base(el.own, c.x, el.points.data());
    const double weight = el.area * (kind_ == MembraneOperator::cst ? 1.0 : cst_share_);
    const Vec3 n = weight * (stiffness * effective(half_metric(a.a1, a.a2) - el.own_metric, before.own, viscosity));
    for (int k = 0; k < 3; ++k) g[k] += pull(a, n, el.own[0][k], el.own[1][k]);
  }
  if (kind_ == MembraneOperator::cst) return;
  std::array<Base, 3> base;
  std::array<Vec3, 3> strain;
  Vec3 mean = Vec3::Zero();
  for (int s = 0; s < 3; ++s) {
    base[s] = side_base(el.side[s], c.x, el.points.data(), s);
    strain[s] = half_metric(base[s].a1, base[s].a2) - el.side_metric[s];
    mean += strain[s] / 3.0;
  }
  for (int s = 0; s < 3; ++s) {
    const bool three = kind_ == MembraneOperator::six_node_three_point;
    const Vec3 n = (el.area * (1.0 - cst_share_) / 3.0) *
                   (stiffness * effective(three ? strain[s] : mean, before.side[three ? s : 0], viscosity));
    for (int k = 0; k < 3; ++k) g[k] += pull(base[s], n, el.side[s][0][k], el.side[s][1][k]);
    g[3 + s] += pull(base[s], n, el.side[s][0][3], el.side[s][1][3]);
  }
}

void MembraneTerm::prepare(Index e, const Configuration& c, Workspace& w) const {
  const Element& el = elements_[e];
  const Mat3& stiffness = stiffness_[el.material];
  const double viscosity = viscosity_of(el);
  const Mat3 material = (1.0 + viscosity) * stiffness;
  static const Samples none{};
  const Samples& start = viscosity > 0.0 ? start_[e] : none;
  const Index* points = el.points.data();
  for (int i = 0; i < nodes; ++i)
    for (int j = i; j < nodes; ++j) w.k[i][j].setZero();
  // Stress for the geometric part: from the strain at x_k plus its linear change if that tangent is asked for. The
  // strain is quadratic in x: E(x) = E(x_k) + B(x_k) dx + half_metric of the increment.
  const bool linearised = c.tangent == Tangent::linearised_stress && c.previous;
  const auto stress = [&](const Vec3& strain, const Vec3& quadratic, const Vec3& before) -> Vec3 {
    const Vec3 n = stiffness * effective(linearised ? Vec3(strain - quadratic) : strain, before, viscosity);
    return c.tangent == Tangent::positive ? tensile_part(n) : n;
  };
  if (kind_ == MembraneOperator::cst || cst_share_ > 0.0) {
    const double weight = el.area * (kind_ == MembraneOperator::cst ? 1.0 : cst_share_);
    const Base a = own_base(el.own, c.x, points);
    Vec3 quadratic = Vec3::Zero();
    if (linearised) {
      const Base before = own_base(el.own, c.previous, points);
      quadratic = half_metric(a.a1 - before.a1, a.a2 - before.a2);
    }
    std::array<Mat3, 3> b;
    for (int k = 0; k < 3; ++k) b[k] = strain_rows(a, el.own[0][k], el.own[1][k]);
    add_material(w.k, b, std::array{0, 1, 2}, weight * material);
    add_geometric(w.k, weight * stress(half_metric(a.a1, a.a2) - el.own_metric, quadratic, start.own), el.own,
                  std::array{0, 1, 2});
  }
  if (kind_ == MembraneOperator::cst) return;
  const double weight = el.area * (1.0 - cst_share_);
  std::array<Base, 3> base;
  std::array<Vec3, 3> strain, quadratic;
  for (int s = 0; s < 3; ++s) {
    base[s] = side_base(el.side[s], c.x, points, s);
    strain[s] = half_metric(base[s].a1, base[s].a2) - el.side_metric[s];
    quadratic[s].setZero();
    if (!linearised) continue;
    const Base before = side_base(el.side[s], c.previous, points, s);
    quadratic[s] = half_metric(base[s].a1 - before.a1, base[s].a2 - before.a2);
  }
  if (kind_ == MembraneOperator::six_node_three_point) {
    for (int s = 0; s < 3; ++s) {
      const std::array<int, 4> node{0, 1, 2, 3 + s};
      std::array<Mat3, 4> b;
      for (int k = 0; k < 4; ++k) b[k] = strain_rows(base[s], el.side[s][0][k], el.side[s][1][k]);
      add_material(w.k, b, node, weight / 3.0 * material);
      add_geometric(w.k, weight / 3.0 * stress(strain[s], quadratic[s], start.side[s]), el.side[s], node);
    }
    return;
  }
  std::array<Mat3, nodes> b;
  for (int k = 0; k < 3; ++k) {
    b[k].setZero();
    for (int s = 0; s < 3; ++s) b[k] += strain_rows(base[s], el.side[s][0][k], el.side[s][1][k]);
    b[3 + k] = strain_rows(base[k], el.side[k][0][3], el.side[k][1][3]);
  }
  add_material(w.k, b, std::array{0, 1, 2, 3, 4, 5}, weight / 9.0 * material);
  const Vec3 n = weight / 3.0 *
                 stress((strain[0] + strain[1] + strain[2]) / 3.0, (quadratic[0] + quadratic[1] + quadratic[2]) / 3.0,
                        start.side[0]);
  for (int s = 0; s < 3; ++s) add_geometric(w.k, n, el.side[s], std::array{0, 1, 2, 3 + s});
}

}  // namespace voile::energy
