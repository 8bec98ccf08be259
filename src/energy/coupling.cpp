#include "coupling.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "chord_correction.hpp"
#include "membrane.hpp"
#include "voile/errors.hpp"

namespace voile::energy {

namespace {

/// Fraction of the strain of the triangle alone in that of the groups together.
double own_fraction(const Sheet& sheet) {
  return sheet.options().membrane == MembraneOperator::cst ? 1.0 : sheet.options().cst_fraction;
}

}  // namespace

void CouplingTerm::add(const Sheet& sheet, Index t, const BendingElement& bending, const std::vector<Index>& local_of,
                       bool owned) {
  const std::array<Index, MembraneTerm::nodes> six = MembraneTerm::stencil_of(sheet, t);
  std::vector<Index> points = bending.points;
  const auto place = [&](Index p) {
    const auto at = std::find(points.begin(), points.end(), p);
    if (at != points.end()) return static_cast<Eigen::Index>(at - points.begin());
    points.push_back(p);
    return static_cast<Eigen::Index>(points.size()) - 1;
  };
  std::array<Eigen::Index, MembraneTerm::nodes> at{};
  std::transform(six.begin(), six.end(), at.begin(), place);
  const auto n = static_cast<Eigen::Index>(points.size());
  if (n > most)
    throw UserError(
        fmt::format("{}: triangle {} has {} neighbours, too many for a laminate that couples stretching and bending; "
                    "mesh it more evenly",
                    sheet.mesh().source(), sheet.mesh().data().triangle_tags[t], n));
  Forms f;
  f.curvature = Weights::Zero(3, n);
  f.curvature.leftCols(bending.operator_.cols()) = bending.operator_;
  const auto forms = MembraneTerm::forms(sheet, t, own_fraction(sheet));
  const Vec3 origin = sheet.patches().start(points[0]);
  Vec3 metric = Vec3::Zero();
  for (std::size_t r = 0; r < 3; ++r) {
    f.quadratic[r] = Eigen::MatrixXd::Zero(n, n);
    f.linear[r] = Weights::Zero(3, n);
    for (Eigen::Index i = 0; i < MembraneTerm::nodes; ++i)
      for (Eigen::Index j = 0; j < MembraneTerm::nodes; ++j) {
        const Vec3 arm = sheet.patches().start(six[j]) - origin;
        f.quadratic[r](at[i], at[j]) += forms[r](i, j);
        f.linear[r].col(at[i]) += forms[r](i, j) * arm;
        metric[static_cast<int>(r)] += 0.5 * forms[r](i, j) * arm.dot(sheet.patches().start(six[i]) - origin);
      }
  }
  if (sheet.options().membrane == MembraneOperator::six_node_corrected)
    for (const BentChord& chord : bent_chords(sheet, t, bending, forms))
      for (std::size_t r = 0; r < 3; ++r) {
        Eigen::VectorXd along = Eigen::VectorXd::Zero(n);
        for (std::size_t k = 0; k < chord.points.size(); ++k) along[place(chord.points[k])] += chord.weights[k];
        f.quadratic[r] += chord.fraction[r] * along * along.transpose();
        f.linear[r] += chord.fraction[r] * chord.start * along.transpose();
      }
  const Material& m = sheet.material(t);
  elements_.push_back({points_.size(), static_cast<int>(n), owned, sheet.mesh().area(t) * m.coupling,
                       bending.start_bend + bending.rest_curvature * bending.start_normal.transpose(), metric,
                       Vec3::Zero(), bending.rest_curvature});
  for (const Index p : points) points_.push_back(local_of[p]);
  forms_.push_back(std::move(f));
}

void CouplingTerm::set_natural(Index e, const Vec3& metric, const Vec3& curvature) {
  elements_[e].strain = metric - elements_[e].metric;
  elements_[e].curvature = curvature;
}

/// e, k, p and q, with the derivatives of e and k.
void CouplingTerm::evaluate(Index e, const Configuration& c) const {
  const Element& el = elements_[e];
  const Forms& f = forms_[e];
  const Index* points = stencil(e);
  const auto n = static_cast<std::size_t>(el.count);
  d_.resize(n);
  for (std::size_t i = 0; i < n; ++i) d_[i] = c.u[points[i]] - c.u[points[0]];
  const Vec3 a = c.x[points[1]] - c.x[points[0]], b = c.x[points[2]] - c.x[points[0]], cross = a.cross(b);
  const double length = cross.norm();
  const Vec3 normal = cross / length;
  const std::array<Vec3, 3> arms{b - a, -b, a};
  for (std::size_t r = 0; r < 3; ++r) {
    by_strain_[r].resize(n);
    by_curvature_[r].resize(n);
    double strain = -el.strain[static_cast<int>(r)];
    Vec3 bend = el.start.row(static_cast<int>(r));
    for (std::size_t i = 0; i < n; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      Vec3 s = f.linear[r].col(k);
      strain += 0.5 * s.dot(d_[i]);
      for (std::size_t j = 0; j < n; ++j) s += f.quadratic[r](k, static_cast<Eigen::Index>(j)) * d_[j];
      strain += 0.5 * s.dot(d_[i]);
      by_strain_[r][i] = s;
      const double weight = f.curvature(static_cast<Eigen::Index>(r), k);
      bend += weight * d_[i];
      by_curvature_[r][i] = weight * normal;
    }
    const double along = normal.dot(bend);
    const Vec3 across = (bend - along * normal) / length;
    for (std::size_t i = 0; i < 3; ++i) by_curvature_[r][i] -= arms[i].cross(across);
    strain_[static_cast<int>(r)] = strain;
    curvature_[static_cast<int>(r)] = along - el.curvature[static_cast<int>(r)];
  }
  p_ = el.coupling * strain_;
  q_ = el.coupling * curvature_;
}

double CouplingTerm::energy(Index e, const Configuration& c) const {
  evaluate(e, c);
  return -p_.dot(curvature_);
}

void CouplingTerm::find_gradient(Index e, const Configuration& c) const {
  evaluate(e, c);
  const auto n = static_cast<std::size_t>(elements_[e].count);
  force_.assign(n, Vec3::Zero());
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t i = 0; i < n; ++i)
      force_[i] -= q_[static_cast<int>(r)] * by_strain_[r][i] + p_[static_cast<int>(r)] * by_curvature_[r][i];
}

CurvedBatch CouplingTerm::curved(Index e) const {
  const Element& el = elements_[e];
  const auto n = static_cast<std::size_t>(el.count);
  fields_.assign(batch_lanes * (static_cast<std::size_t>(curved_fields::coupling) + n), 0.0);
  const auto set = [&](std::size_t field, double value) { fields_[batch_lanes * field] = value; };
  const Vec3 start = el.start.transpose() * p_;
  for (int k = 0; k < 3; ++k)
    set(static_cast<std::size_t>(curved_fields::start_coupling) + static_cast<std::size_t>(k), start[k]);
  for (std::size_t i = 0; i < n; ++i)
    set(static_cast<std::size_t>(curved_fields::coupling) + i,
        forms_[e].curvature.col(static_cast<Eigen::Index>(i)).dot(p_));
  gather_.assign(batch_lanes * n, 0);
  for (std::size_t i = 0; i < n; ++i) gather_[batch_lanes * i] = stencil(e)[i];
  return {fields_.data(), gather_.data(), own_positions(), own_pairs(), el.count, 0, 1};
}

void CouplingTerm::find_hessian(Index e, const Configuration& now) const {
  evaluate(e, now);
  Configuration c = now;
  if (now.tangent == Tangent::stress_alone) {
    const Vec3 p = p_, q = q_;
    c = {now.previous, now.previous_u};
    evaluate(e, c);
    p_ = p;
    q_ = q;
  }
  const Element& el = elements_[e];
  const auto n = static_cast<std::size_t>(el.count);
  hessian_.assign(n * n, Mat3::Zero());
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t s = 0; s < 3; ++s) {
      Vec3 mixed = Vec3::Zero(), other = Vec3::Zero();
      for (std::size_t r = 0; r < 3; ++r) {
        const double b = el.coupling(static_cast<int>(r), static_cast<int>(s));
        mixed += b * by_strain_[r][i];
        other += b * by_curvature_[r][i];
      }
      for (std::size_t j = 0; j < n; ++j)
        hessian_[i * n + j] -= mixed * by_curvature_[s][j].transpose() + other * by_strain_[s][j].transpose();
    }
  if (c.tangent == Tangent::positive) return;
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j)
        hessian_[i * n + j].diagonal().array() -=
            q_[static_cast<int>(r)] *
            forms_[e].quadratic[r](static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  blocks_.assign(numbers_per_block * n * (n + 1) / 2, 0.0);
  scalar_kernels().curved.tangent(curved(e), {c.x->data(), c.u->data()}, blocks_.data());
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = i; j < n; ++j) {
      const auto place = static_cast<std::size_t>(pair_place(static_cast<int>(i), static_cast<int>(j), el.count));
      const Mat3 block =
          Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(blocks_.data() + numbers_per_block * place);
      hessian_[i * n + j] += block;
      if (j != i) hessian_[j * n + i] += block.transpose();
    }
}

}  // namespace voile::energy
