#include "voile/energy/chord_correction.hpp"

#include <Eigen/Dense>
#include <algorithm>

namespace voile::energy {

namespace {

/// Averages of S from triangles to vertices and back.
constexpr int averages = 2;

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

/// Double contraction T:(a^T b) of column vectors a_A, b_B.
double contract(const Mat3& form, const Mat3& a, const Mat3& b) {
  return form.cwiseProduct(a.transpose() * b).sum();
}

}  // namespace

ChordForms::ChordForms(const Sheet& sheet) : sheet_(&sheet), even_(even_sizes(sheet)) {}

std::array<Mat3, 3> ChordForms::of(Index t, const std::array<Eigen::Matrix<double, 6, 6>, 3>& q) const {
  std::array<Mat3, 3> forms;
  forms.fill(Mat3::Zero());
  for (int s = 0; s < 3; ++s)
    if (sheet_->patches().apex(t, s) != no_index &&
        sheet_->patches().rest_dihedral(t, s) > sheet_->options().crease_angle)
      return forms;
  const mesh::Patch patch = sheet_->patches().patch(t, sheet_->frame(t));
  for (std::size_t r = 0; r < 3; ++r) {
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j) {
        const double weight = q[r](i, j);
        if (i == j || weight == 0.0) continue;
        const Vec2 l = patch.coordinates[static_cast<std::size_t>(j)] - patch.coordinates[static_cast<std::size_t>(i)];
        const Vec3 lam(l[0] * l[0], l[1] * l[1], l[0] * l[1]);
        forms[r] -= weight / 24.0 * lam * lam.transpose();
      }
  }
  const Mat2& even = even_[static_cast<std::size_t>(t)];
  const double a = even(0, 0), b = even(0, 1), c = even(1, 1);
  Mat3 first, second, both;
  first << 2 * a, 0, b, 0, 0, 0, b, 0, c / 2;
  second << 0, 0, 0, 0, 2 * c, b, 0, b, a / 2;
  both << 0, 2 * b, a, 2 * b, 0, c, a, c, b;
  forms[0] -= first;
  forms[1] -= second;
  forms[2] -= both;
  return forms;
}

void ChordCorrection::add(const Forms& forms, const BendingElement& element, const std::array<Index, nodes>& six,
                          const std::vector<Index>& points) {
  Element el{};
  el.start = points_.size();
  std::vector<Index> stencil(six.begin(), six.end());
  std::vector<Vec3> weight(nodes, Vec3::Zero());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto at = static_cast<std::size_t>(std::find(stencil.begin(), stencil.end(), points[i]) - stencil.begin());
    if (at == stencil.size()) {
      stencil.push_back(points[i]);
      weight.push_back(Vec3::Zero());
    }
    weight[at] += element.operator_.col(static_cast<Eigen::Index>(i));
  }
  const bool fits = stencil.size() <= most;
  if (!fits) {
    stencil.resize(nodes);
    weight.assign(nodes, Vec3::Zero());
  }
  el.count = static_cast<int>(stencil.size());
  el.start_curvature = element.start_normal * element.rest_curvature.transpose() + element.start_bend.transpose();
  for (const Strain which : {mean, own})
    for (int r = 0; r < 3; ++r) {
      const Mat3 form = fits ? forms[which][static_cast<std::size_t>(r)] : Mat3::Zero();
      el.forms[which][static_cast<std::size_t>(r)] = form;
      el.start_strain[which][r] = 0.5 * (contract(form, el.start_curvature, el.start_curvature) -
                                         element.rest_curvature.dot(form * element.rest_curvature));
    }
  points_.insert(points_.end(), stencil.begin(), stencil.end());
  weights_.insert(weights_.end(), weight.begin(), weight.end());
  elements_.push_back(el);
}

Mat3 ChordCorrection::change(Index e, const Vec3* u) const {
  const Element& el = elements_[e];
  Mat3 sum = Mat3::Zero();
  for (std::size_t i = el.start; i < el.start + static_cast<std::size_t>(el.count); ++i)
    sum.noalias() += u[points_[i]] * weights_[i].transpose();
  return sum;
}

Mat3 ChordCorrection::step(Index e, const Configuration& c) const {
  const Element& el = elements_[e];
  Mat3 sum = Mat3::Zero();
  for (std::size_t i = el.start; i < el.start + static_cast<std::size_t>(el.count); ++i)
    sum.noalias() += (c.x[points_[i]] - c.previous[points_[i]]) * weights_[i].transpose();
  return sum;
}

ChordCorrection::Corrected ChordCorrection::of(Index e, Strain which, const Mat3& change) const {
  const Element& el = elements_[e];
  const Mat3 k = el.start_curvature + change;
  Corrected s;
  for (int r = 0; r < 3; ++r) {
    const Mat3& form = el.forms[which][r];
    s.by[r].noalias() = k * form;
    s.strain[r] = el.start_strain[which][r] + 0.5 * change.cwiseProduct(s.by[r]).sum() +
                  0.5 * contract(form, change, el.start_curvature);
  }
  return s;
}

Vec3 ChordCorrection::quadratic(Index e, Strain which, const Mat3& change) const {
  const auto& form = elements_[e].forms[which];
  return 0.5 *
         Vec3(contract(form[0], change, change), contract(form[1], change, change), contract(form[2], change, change));
}

Mat3 ChordCorrection::geometric(Index e, Strain which, const Vec3& n, bool positive) const {
  const auto& forms = elements_[e].forms[which];
  const Mat3 form = n[0] * forms[0] + n[1] * forms[1] + n[2] * forms[2];
  if (!positive) return form;
  Eigen::SelfAdjointEigenSolver<Mat3> eigen;
  eigen.computeDirect(form);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * eigen.eigenvectors().transpose();
}

}  // namespace voile::energy
