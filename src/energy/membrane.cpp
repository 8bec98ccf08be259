#include "voile/energy/membrane.hpp"

#include <Eigen/Dense>
#include <algorithm>

#include "membrane_samples.hpp"
#include "voile/energy/chord_forms.hpp"

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

/// Adds weight * d(N.E)/dx of one sample: force on each node with gradient weights (d1, d2).
Vec3 pull(const Base& a, const Vec3& n, double d1, double d2) {
  return (n[0] * d1 + n[2] * d2) * a.a1 + (n[1] * d2 + n[2] * d1) * a.a2;
}

}  // namespace

MembraneTerm::MembraneTerm(const Sheet& sheet)
    : kind_(sheet.options().membrane), cst_share_(takes_mean() ? sheet.options().cst_share : 0.0) {
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
    if (patch.points[3 + s] == no_index || sheet.is_crease(t, s)) continue;
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
                                                                                                   Index t,
                                                                                                   double own) {
  using Weights = Eigen::Matrix<double, 2, nodes>;
  const Element el = element_of(sheet, t);
  std::array<Eigen::Matrix<double, nodes, nodes>, 3> forms;
  forms.fill(Eigen::Matrix<double, nodes, nodes>::Zero());
  const auto add = [&](double share, const Weights& d) {
    forms[0] += share * d.row(0).transpose() * d.row(0);
    forms[1] += share * d.row(1).transpose() * d.row(1);
    forms[2] += share * (d.row(0).transpose() * d.row(1) + d.row(1).transpose() * d.row(0));
  };
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

void MembraneTerm::add_gather(const Sheet& sheet, const mesh::PatchMesh& before, Index t) {
  const Element& el = elements_.back();
  constexpr std::array<Index, nodes> order{0, 1, 2, 3, 4, 5};
  const auto bases = [&](const mesh::PatchMesh& of) {
    const mesh::Patch patch = of.patch(t, of.frame(t));
    std::array<std::array<Vec3, 2>, 4> all;
    for (int s = 0; s < 3; ++s) {
      const Base a = side_base(el.side[s], patch.rest.data(), order.data(), s);
      all[s] = {a.a1, a.a2};
    }
    const Base own = own_base(el.own, patch.rest.data(), order.data());
    all[3] = {own.a1, own.a2};
    return all;
  };
  const Gathered g{size() - 1, bases(before), bases(sheet.patches())};
  constexpr double same = 1e-9;
  double change = 0.0;
  for (std::size_t k = 0; k < 4; ++k)
    for (std::size_t i = 0; i < 2; ++i) change = std::max(change, (g.before[k][i] - g.drawn_in[k][i]).norm());
  if (change > same) gathered_.push_back(g);
}

void MembraneTerm::gather(double share) {
  for (const Gathered& g : gathered_) {
    Element& el = elements_[g.element];
    const auto metric = [&](std::size_t k) {
      const auto base = [&](std::size_t i) { return Vec3((1.0 - share) * g.before[k][i] + share * g.drawn_in[k][i]); };
      return half_metric(base(0), base(1));
    };
    const Samples metric_before{el.side_metric, el.own_metric};
    for (std::size_t s = 0; s < 3; ++s) el.side_metric[s] = metric(s);
    el.own_metric = metric(3);
    if (!viscosity_.empty()) move_start(g.element, metric_before);
  }
}

/// Viscosity acts against strains, not against a rest shape that changes in the step.
void MembraneTerm::move_start(Index e, const Samples& metric) {
  const Element& el = elements_[e];
  Samples& start = start_[e];
  start.own += metric.own - el.own_metric;
  std::array<Vec3, 3> change;
  for (std::size_t s = 0; s < 3; ++s) change[s] = metric.side[s] - el.side_metric[s];
  if (takes_mean())
    start.side[0] += (change[0] + change[1] + change[2]) / 3.0;
  else
    for (std::size_t s = 0; s < 3; ++s) start.side[s] += change[s];
}

void MembraneTerm::correct(const Sheet& sheet, const Mat3& trace, Index t, const BendingElement& bending,
                           const std::vector<Index>& local) {
  const PatchCubic cubic = make_patch_cubic(sheet, t, bending);
  const Chords chords = make_chords(sheet, t, cubic, {forms(sheet, t, 0.0), forms(sheet, t, 1.0)});
  const Element& el = elements_.back();
  ChordCorrection::Input input{cubic, chords, el.area * sheet.material(t).bending, trace, el.points, {}};
  if (beside_crease(sheet, t)) input.stiffness.setZero();
  for (const Index p : cubic.points)
    input.of_cubic.push_back(local[static_cast<std::size_t>(std::find(bending.points.begin(), bending.points.end(), p) -
                                                            bending.points.begin())]);
  correction_.add(input);
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
  if (takes_mean()) f.side[0] = (f.side[0] + f.side[1] + f.side[2]) / 3.0;
  if (corrects()) {
    const ChordCorrection::ChordBends bends = correction_.along_chords(e, correction_.change(e, c.u));
    f.side[0] += correction_.strain(e, ChordCorrection::mean, bends);
    f.own += correction_.strain(e, ChordCorrection::own, bends);
  }
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
  if (takes_mean()) {
    const double own = cst_share_ > 0.0 ? cst_share_ * density(f.own, at.own) : 0.0;
    const double fourth = corrects() ? correction_.energy(e, correction_.change(e, c.u)) : 0.0;
    return fourth + el.area * (own + (1.0 - cst_share_) * density(f.side[0], at.side[0]));
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
  if (corrects()) {
    const ChordCorrection::ChordBends bends = correction_.along_chords(e, correction_.change(e, c.u));
    mean += correction_.strain(e, ChordCorrection::mean, bends);
    constant += correction_.strain(e, ChordCorrection::own, bends);
  }
  return (1.0 - cst_share_) * mean + cst_share_ * constant;
}

Vec3 MembraneTerm::force(Index e, const Configuration& c) const {
  return stiffness_[elements_[e].material] * strain(e, c);
}

void MembraneTerm::gradient_of(Index e, const Configuration& c, std::array<Vec3, nodes>& g, Bends& bent) const {
  g.fill(Vec3::Zero());
  const Element& el = elements_[e];
  static const Samples none{};
  const double viscosity = viscosity_of(el);
  const Samples& before = viscosity > 0.0 ? start_[e] : none;
  const Mat3& stiffness = stiffness_[el.material];
  ChordCorrection::ChordBends bends;
  if (corrects()) {
    const Bends change = correction_.change(e, c.u);
    bends = correction_.along_chords(e, change);
    bent = correction_.pull(e, change);
  }
  // A strain with its correction; its stress, which pulls at the curvatures too.
  const auto corrected_stress = [&](ChordCorrection::Strain which, double weight, Vec3 strain, const Vec3& start) {
    if (!corrects()) return Vec3(weight * (stiffness * effective(strain, start, viscosity)));
    strain += correction_.strain(e, which, bends);
    Vec3 n = weight * (stiffness * effective(strain, start, viscosity));
    bent += correction_.pull(e, which, bends, n);
    return n;
  };
  if (kind_ == MembraneOperator::cst || cst_share_ > 0.0) {
    const Base a = own_base(el.own, c.x, el.points.data());
    const double weight = el.area * (kind_ == MembraneOperator::cst ? 1.0 : cst_share_);
    const Vec3 n = corrected_stress(ChordCorrection::own, weight, half_metric(a.a1, a.a2) - el.own_metric, before.own);
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
  const double weight = el.area * (1.0 - cst_share_);
  Vec3 n = Vec3::Zero();
  if (takes_mean()) n = corrected_stress(ChordCorrection::mean, weight, mean, before.side[0]) / 3.0;
  for (int s = 0; s < 3; ++s) {
    if (!takes_mean()) n = weight / 3.0 * (stiffness * effective(strain[s], before.side[s], viscosity));
    for (int k = 0; k < 3; ++k) g[k] += pull(base[s], n, el.side[s][0][k], el.side[s][1][k]);
    g[3 + s] += pull(base[s], n, el.side[s][0][3], el.side[s][1][3]);
  }
}

}  // namespace voile::energy
