#include "chord_forms.hpp"

#include <Eigen/Dense>

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
      rest.col(k) = patch.coordinates[static_cast<std::size_t>(k) + 1] - patch.coordinates[0];
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

/// Where the sizes of triangles are averaged: the vertices, and where sheets are joined one place for each sheet.
struct Places {
  std::vector<mesh::Triangle> of;  ///< per corner
  Index count;

  explicit Places(const mesh::SurfaceMesh& mesh) : of(mesh.triangles()), count(mesh.vertex_count()) {
    std::vector<char> at_joint(static_cast<std::size_t>(count), 0);
    for (const mesh::Joint& j : mesh.joints()) at_joint[j.edge[0]] = at_joint[j.edge[1]] = 1;
    if (mesh.joints().empty()) return;
    for (Index t = 0; t < mesh.triangle_count(); ++t)
      for (std::size_t i = 0; i < 3; ++i)
        if (const Index v = mesh.triangles()[t][i]; at_joint[v] && of[t][i] == v) part(mesh, t, i, count++);
  }

 private:
  /// Gives the corners around a vertex that are connected through sides the place `to`.
  void part(const mesh::SurfaceMesh& mesh, Index t, std::size_t i, Index to) {
    const Index v = of[t][i];
    of[t][i] = to;
    for (std::size_t s = 0; s < 3; ++s) {
      const Index n = s == i ? no_index : mesh.neighbour(t, static_cast<int>(s));
      if (n == no_index) continue;
      for (std::size_t k = 0; k < 3; ++k)
        if (of[n][k] == v) part(mesh, n, k, to);
    }
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
  const Places places(mesh);
  for (int pass = 0; pass < averages; ++pass) {
    std::vector<Mat3> at(static_cast<std::size_t>(places.count), Mat3::Zero());
    std::vector<double> area(at.size(), 0.0);
    for (std::size_t t = 0; t < count; ++t)
      for (const Index v : places.of[t]) {
        const double fraction = mesh.area(static_cast<Index>(t));
        at[v] += fraction * size[t];
        area[v] += fraction;
      }
    for (std::size_t t = 0; t < count; ++t) {
      size[t].setZero();
      for (const Index v : places.of[t]) size[t] += at[v] / (3.0 * area[v]);
    }
  }
  std::vector<Mat2> result;
  for (std::size_t t = 0; t < count; ++t) result.push_back(Sides(sheet, static_cast<Index>(t)).from_space(size[t]));
  return result;
}

/// R^r of k_ac S_cd k_bd = sum_AB R^r_AB k_A.k_B.
std::array<Mat3, 3> even_forms(const Mat2& even) {
  const double a = even(0, 0), b = even(0, 1), c = even(1, 1);
  std::array<Mat3, 3> forms;
  forms[0] << 2 * a, 0, b, 0, 0, 0, b, 0, c / 2;
  forms[1] << 0, 0, 0, 0, 2 * c, b, 0, b, a / 2;
  forms[2] << 0, 2 * b, a, 2 * b, 0, c, a, c, b;
  return forms;
}

}  // namespace

ChordForms::ChordForms(const Sheet& sheet) : sheet_(&sheet), even_(even_sizes(sheet)) {}

std::array<Mat3, 3> ChordForms::of(Index t, const std::array<Eigen::Matrix<double, 6, 6>, 3>& q) const {
  std::array<Mat3, 3> forms;
  forms.fill(Mat3::Zero());
  if (beside_crease(*sheet_, t)) return forms;
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
  const std::array<Mat3, 3> even = even_forms(even_[static_cast<std::size_t>(t)]);
  for (std::size_t r = 0; r < 3; ++r) forms[r] -= even[r];
  return forms;
}

Mat3 ChordForms::trace(Index t) const {
  const std::array<Mat3, 3> even = even_forms(even_[static_cast<std::size_t>(t)]);
  return 0.5 * (even[0] + even[1]);
}

bool beside_crease(const Sheet& sheet, Index t) {
  for (int s = 0; s < 3; ++s)
    if (sheet.patches().apex(t, s) != no_index && sheet.is_crease(t, s)) return true;
  return false;
}

}  // namespace voile::energy
