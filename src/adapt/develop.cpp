#include "develop.hpp"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/decompositions.hpp"
#include "features.hpp"
#include "mesh/patch.hpp"

namespace voile::adapt {

namespace {

/// Singular values below this fraction of the largest are none: points near a conic or on a line.
constexpr double rank_threshold = 1e-4;

struct Placed {
  Index triangle;
  std::array<Vec2, 3> at;
};

/// Places the neighbour across side s of a triangle that has its place; its scale is that of the side.
Placed place_neighbour(const mesh::SurfaceMesh& mesh, const Placed& from, int s) {
  const Index n = mesh.neighbour(from.triangle, s);
  const int sn = mesh.side_in_neighbour(from.triangle, s);
  const auto a = static_cast<std::size_t>((s + 1) % 3), b = static_cast<std::size_t>((s + 2) % 3);
  // The side runs the other way in the neighbour.
  const Vec3 xa = mesh.rest_corner(n, (sn + 2) % 3), xb = mesh.rest_corner(n, (sn + 1) % 3);
  Placed to{n, {}};
  to.at[static_cast<std::size_t>((sn + 2) % 3)] = from.at[a];
  to.at[static_cast<std::size_t>((sn + 1) % 3)] = from.at[b];
  const double scale = (from.at[b] - from.at[a]).norm() / (xb - xa).norm();
  to.at[static_cast<std::size_t>(sn)] = mesh::unfold(xa, xb, from.at[a], from.at[b], mesh.rest_corner(n, sn), scale);
  return to;
}

bool crossable(const mesh::SurfaceMesh& mesh, Index t, int s) {
  if (mesh.neighbour(t, s) == no_index) return false;
  return !mesh.chart_join(t, s).same_chart || !is_crease(mesh, t, s, Options{}.crease);
}

Eigen::RowVectorXd monomials(const Vec2& p, int degree) {
  Eigen::RowVectorXd row(degree == 1 ? 2 : degree == 2 ? 5 : 9);
  const double x = p.x(), y = p.y();
  row[0] = x;
  row[1] = y;
  if (degree > 1) row.segment<3>(2) << x * x, x * y, y * y;
  if (degree > 2) row.segment<4>(5) << x * x * x, x * x * y, x * y * y, y * y * y;
  return row;
}

}  // namespace

std::array<Vec2, 3> plane_of(const mesh::SurfaceMesh& mesh, Index t) {
  const Vec3 a = mesh.rest_corner(t, 0), ab = mesh.rest_corner(t, 1) - a, ac = mesh.rest_corner(t, 2) - a;
  const Vec3 along = ab.normalized();
  return {Vec2(0, 0), Vec2(ab.norm(), 0), Vec2(ac.dot(along), ab.cross(ac).norm() / ab.norm())};
}

std::vector<DevelopedPoint> develop(const mesh::SurfaceMesh& mesh, Index t, int i, int rings) {
  std::vector<Placed> placed{{t, plane_of(mesh, t)}};
  std::vector<DevelopedPoint> points;
  std::vector<Index> inner{mesh.triangles()[t][i]};
  const auto known = [&](Index v) {
    return std::any_of(points.begin(), points.end(), [&](const DevelopedPoint& p) { return p.vertex == v; });
  };
  const auto add = [&](const Placed& p) {
    for (std::size_t k = 0; k < 3; ++k)
      if (!known(mesh.triangles()[p.triangle][k])) points.push_back({mesh.triangles()[p.triangle][k], p.at[k]});
  };
  add(placed.front());
  for (int ring = 0; ring < rings; ++ring) {
    for (std::size_t k = 0; k < placed.size(); ++k)
      for (int s = 0; s < 3; ++s) {
        if (!crossable(mesh, placed[k].triangle, s)) continue;
        const Index n = mesh.neighbour(placed[k].triangle, s);
        const mesh::Triangle& v = mesh.triangles()[n];
        if (std::none_of(v.begin(), v.end(),
                         [&](Index x) { return std::find(inner.begin(), inner.end(), x) != inner.end(); }) ||
            std::any_of(placed.begin(), placed.end(), [&](const Placed& p) { return p.triangle == n; }))
          continue;
        placed.push_back(place_neighbour(mesh, placed[k], s));
        add(placed.back());
      }
    inner.clear();
    for (const DevelopedPoint& p : points) inner.push_back(p.vertex);
  }
  return points;
}

Eigen::Matrix<double, 3, 2> corner_gradient(const mesh::SurfaceMesh& mesh, Index t, int i,
                                            const std::vector<Vec3>& field, int degree) {
  const Index v = mesh.triangles()[t][i];
  const Vec2 origin = plane_of(mesh, t)[static_cast<std::size_t>(i)];
  for (int d = degree; d > 0; --d)
    for (int rings = d - 1 > 0 ? d - 1 : 1; rings <= 3; ++rings) {
      std::vector<DevelopedPoint> points = develop(mesh, t, i, rings);
      const auto unknowns = monomials(Vec2::Zero(), d).size();
      const auto n = static_cast<Eigen::Index>(points.size()) - 1;
      // A cubic is fitted, not interpolated.
      if (n < unknowns + (d == 3 ? 2 : 0)) continue;
      double reach = 0.0;
      for (const DevelopedPoint& p : points) reach = std::max(reach, (p.at - origin).norm());
      Eigen::MatrixXd m(n, unknowns), values(n, 3);
      Eigen::Index r = 0;
      for (const DevelopedPoint& p : points) {
        if (p.vertex == v) continue;
        const Vec2 x = (p.at - origin) / reach;
        const double w = 1.0 / x.squaredNorm();
        m.row(r) = w * monomials(x, d);
        values.row(r++) = w * (field[p.vertex] - field[v]).transpose();
      }
      const LeastSquares fit(m, rank_threshold);
      if (fit.rank() < unknowns) continue;
      const Eigen::MatrixXd c = fit.solve(values);
      return c.topRows<2>().transpose() / reach;
    }
  return Eigen::Matrix<double, 3, 2>::Zero();
}

}  // namespace voile::adapt
