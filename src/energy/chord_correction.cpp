#include "voile/energy/chord_correction.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "voile/energy/chord_forms.hpp"

namespace voile::energy {

namespace {

/// Points of a patch at the ends of its chords: sides, then across each side.
constexpr std::array<std::array<int, 2>, Chords::count> ends{
    {{0, 1}, {1, 2}, {2, 0}, {1, 3}, {2, 3}, {0, 3}, {2, 4}, {0, 4}, {1, 4}, {0, 5}, {1, 5}, {2, 5}}};

/// Of the chords, the triangle's sides: only these count in its own strain.
constexpr int own_chords = 3;
int chords_of(ChordCorrection::Strain which) {
  return which == ChordCorrection::own ? own_chords : Chords::count;
}

/// Bends along each chord. Eigen's product for large matrices, which it would take here, is several times slower.
using ChordBends = Eigen::Matrix<double, 3, Chords::count>;
ChordBends bends_of(const Chords& chords, const Bends& k) {
  return k.lazyProduct(chords.along);
}

/// Half the difference of the squared bends along each chord between `from` and `from + change`.
Eigen::Matrix<double, Chords::count, 1> half_squares(const Chords& chords, const Bends& from, const Bends& change) {
  return bends_of(chords, change).cwiseProduct(bends_of(chords, from + 0.5 * change)).colwise().sum().transpose();
}

/// sum_AB form_AB a_A.b_B
double contract(const Mat3& form, const Mat3& a, const Mat3& b) {
  return (a * form).cwiseProduct(b).sum();
}

}  // namespace

Chords make_chords(const Sheet& sheet, Index t, const PatchCubic& cubic,
                   const std::array<std::array<Eigen::Matrix<double, 6, 6>, 3>, 2>& quadratic) {
  Chords chords{};
  chords.along.setZero();
  for (Chords::Share& share : chords.share) share.setZero();
  if (beside_crease(sheet, t)) return chords;
  const mesh::Patch patch = sheet.patches().patch(t, sheet.frame(t));
  for (int c = 0; c < Chords::count; ++c) {
    const auto i = static_cast<std::size_t>(ends[c][0]), j = static_cast<std::size_t>(ends[c][1]);
    if (patch.points[j] == no_index) continue;
    chords.along.col(c) = cubic.along(patch.coordinates[i], patch.coordinates[j]);
    for (std::size_t which = 0; which < 2; ++which)
      for (int r = 0; r < 3; ++r)
        chords.share[which](r, c) = -quadratic[which][static_cast<std::size_t>(r)](ends[c][0], ends[c][1]) / 12.0;
  }
  return chords;
}

void ChordCorrection::add(const Input& input) {
  Element el{};
  el.start = points_.size();
  std::vector<Index> stencil(input.six.begin(), input.six.end());
  std::vector<BendWeights> weight(nodes, BendWeights::Zero());
  const auto place = [&](Index p) {
    const auto at = static_cast<std::size_t>(std::find(stencil.begin(), stencil.end(), p) - stencil.begin());
    if (at == stencil.size()) {
      stencil.push_back(p);
      weight.push_back(BendWeights::Zero());
    }
    return at;
  };
  for (std::size_t i = 0; i < input.of_cubic.size(); ++i) weight[place(input.of_cubic[i])] += input.cubic.weights[i];
  const bool fits = stencil.size() <= most;
  if (!fits) {
    stencil.resize(nodes);
    weight.assign(nodes, BendWeights::Zero());
  }
  el.count = static_cast<int>(stencil.size());
  el.left_out = !fits;
  el.chords = input.chords;
  if (!fits)
    for (Chords::Share& share : el.chords.share) share.setZero();
  el.start_bends = input.cubic.start;
  const Bends rest = Vec3::UnitZ() * input.cubic.rest.transpose();  // only its products matter
  for (const Strain which : {mean, own})
    el.start_strain[which] = el.chords.share[which] * (half_squares(el.chords, Bends::Zero(), el.start_bends) -
                                                       half_squares(el.chords, Bends::Zero(), rest));
  el.stiffness = fits ? input.stiffness : Mat3::Zero();
  el.trace = input.trace;
  const Mat3 start = el.start_bends.leftCols<3>(), before = rest.leftCols<3>();
  el.start_bending = contract(el.stiffness, start, start) - contract(el.stiffness, before, before);
  el.start_trace = contract(el.trace, start, start) - contract(el.trace, before, before);
  points_.insert(points_.end(), stencil.begin(), stencil.end());
  weights_.insert(weights_.end(), weight.begin(), weight.end());
  elements_.push_back(el);
}

Bends ChordCorrection::change(Index e, const Vec3* u) const {
  const Element& el = elements_[e];
  Eigen::Matrix<double, 4, bend_vectors> sum = Eigen::Matrix<double, 4, bend_vectors>::Zero();
  for (std::size_t i = el.start; i < el.start + static_cast<std::size_t>(el.count); ++i) {
    const Vec3& of_point = u[points_[i]];
    const Eigen::Vector4d v(of_point[0], of_point[1], of_point[2], 0.0);
    for (int b = 0; b < bend_vectors; ++b) sum.col(b) += weights_[i][b] * v;
  }
  return sum.topRows<3>();
}

Bends ChordCorrection::step(Index e, const Configuration& c) const {
  const Element& el = elements_[e];
  Bends sum = Bends::Zero();
  for (std::size_t i = el.start; i < el.start + static_cast<std::size_t>(el.count); ++i)
    sum.noalias() += (c.x[points_[i]] - c.previous[points_[i]]) * weights_[i].transpose();
  return sum;
}

ChordCorrection::ChordBends ChordCorrection::along_chords(Index e, const Bends& change) const {
  const Element& el = elements_[e];
  Eigen::Matrix<double, 4, bend_vectors> before, more;
  before << el.start_bends, Eigen::Matrix<double, 1, bend_vectors>::Zero();
  more << change, Eigen::Matrix<double, 1, bend_vectors>::Zero();
  ChordBends bends;
  for (int c = 0; c < Chords::count; ++c) {
    Eigen::Vector4d start = Eigen::Vector4d::Zero(), difference = Eigen::Vector4d::Zero();
    for (int b = 0; b < bend_vectors; ++b) {
      start += el.chords.along(b, c) * before.col(b);
      difference += el.chords.along(b, c) * more.col(b);
    }
    bends.change.col(c) = difference;
    bends.now.col(c) = start + difference;
  }
  return bends;
}

Vec3 ChordCorrection::strain(Index e, Strain which, const ChordBends& bends) const {
  const Element& el = elements_[e];
  Vec3 strain = el.start_strain[which];
  for (int c = 0; c < chords_of(which); ++c)
    strain += bends.change.col(c).dot(bends.now.col(c) - 0.5 * bends.change.col(c)) * el.chords.share[which].col(c);
  return strain;
}

ChordCorrection::Slopes ChordCorrection::slopes(Index e, Strain which, const ChordBends& bends) const {
  const Chords& chords = elements_[e].chords;
  Slopes slopes;
  for (int r = 0; r < 3; ++r) {
    slopes[r].setZero();
    for (int c = 0; c < chords_of(which); ++c) {
      const Eigen::Vector4d pull = chords.share[which](r, c) * bends.now.col(c);
      for (int b = 0; b < bend_vectors; ++b) slopes[r].col(b) += chords.along(b, c) * pull;
    }
  }
  return slopes;
}

Bends ChordCorrection::pull(Index e, Strain which, const ChordBends& bends, const Vec3& n) const {
  const Chords& chords = elements_[e].chords;
  Eigen::Matrix<double, 4, bend_vectors> sum = Eigen::Matrix<double, 4, bend_vectors>::Zero();
  for (int c = 0; c < chords_of(which); ++c) {
    const Eigen::Vector4d pull = chords.share[which].col(c).dot(n) * bends.now.col(c);
    for (int b = 0; b < bend_vectors; ++b) sum.col(b) += chords.along(b, c) * pull;
  }
  return sum.topRows<3>();
}

Vec3 ChordCorrection::quadratic(Index e, Strain which, const Bends& change) const {
  const Chords& chords = elements_[e].chords;
  return chords.share[which] * half_squares(chords, Bends::Zero(), change);
}

ChordCorrection::Form ChordCorrection::geometric(Index e, Strain which, const Vec3& n, bool positive) const {
  const Chords& chords = elements_[e].chords;
  Eigen::Matrix<double, Chords::count, 1> weight = chords.share[which].transpose() * n;
  if (positive) weight = weight.cwiseMax(0.0);
  const Eigen::Matrix<double, bend_vectors, Chords::count> weighted = chords.along * weight.asDiagonal();
  return which == own
             ? Form(weighted.leftCols<own_chords>().lazyProduct(chords.along.leftCols<own_chords>().transpose()))
             : Form(weighted.lazyProduct(chords.along.transpose()));
}

ChordCorrection::Invariants ChordCorrection::invariants(const Element& el, const Bends& change) {
  const Mat3 from = el.start_bends.leftCols<3>(), more = change.leftCols<3>(), now = from + more,
             middle = from + 0.5 * more;
  return {el.start_bending + 2.0 * contract(el.stiffness, more, middle),
          el.start_trace + 2.0 * contract(el.trace, more, middle), now * el.stiffness, now * el.trace};
}

double ChordCorrection::energy(Index e, const Bends& change) const {
  const Invariants v = invariants(elements_[e], change);
  return v.bending * v.trace;
}

Bends ChordCorrection::pull(Index e, const Bends& change) const {
  const Invariants v = invariants(elements_[e], change);
  Bends pull = Bends::Zero();
  pull.leftCols<3>() = 2.0 * (v.trace * v.of_bending + v.bending * v.of_trace);
  return pull;
}

ChordCorrection::Curvature ChordCorrection::curvature(Index e, const Bends& change, bool positive) const {
  const Element& el = elements_[e];
  const Invariants v = invariants(el, change);
  const auto clipped = [&](double x) { return positive ? std::max(x, 0.0) : x; };
  Curvature c;
  c.form.setZero();
  c.form.topLeftCorner<3, 3>() = 2.0 * (clipped(v.trace) * el.stiffness + clipped(v.bending) * el.trace);
  for (std::size_t k = 0; k < 2; ++k) {
    c.first[k].setZero();
    c.second[k].setZero();
  }
  const double bending = v.of_bending.norm(), trace = v.of_trace.norm();
  if (!(bending > 0.0 && trace > 0.0)) return c;
  if (positive) {  // a b^T + b a^T = ((a + b)(a + b)^T - (a - b)(a - b)^T) / 2 of vectors of equal length
    const double balance = std::sqrt(trace / bending);
    c.first[0].leftCols<3>() = std::sqrt(2.0) * (balance * v.of_bending + v.of_trace / balance);
    c.second[0] = c.first[0];
  } else {
    c.first[0].leftCols<3>() = c.second[1].leftCols<3>() = 2.0 * v.of_bending;
    c.second[0].leftCols<3>() = c.first[1].leftCols<3>() = 2.0 * v.of_trace;
  }
  return c;
}

}  // namespace voile::energy
