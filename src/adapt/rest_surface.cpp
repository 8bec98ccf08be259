#include "rest_surface.hpp"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/decompositions.hpp"
#include "chart_search.hpp"
#include "features.hpp"
#include "rest_curves.hpp"

namespace voile::adapt {

namespace {

/// Heights below this, relative to the ring, are those of a plane.
constexpr double flat = 1e-9;

/// A quadratic of height over the tangent plane at a corner of a smooth piece.
struct Height {
  Vec3 origin, e1, e2, normal;
  Eigen::Matrix<double, 5, 1> c;  ///< of x, y, x^2, xy, y^2
  bool flat = true;

  [[nodiscard]] Vec3 project(const Vec3& p) const {
    const double x = (p - origin).dot(e1), y = (p - origin).dot(e2);
    return origin + x * e1 + y * e2 + (c[0] * x + c[1] * y + c[2] * x * x + c[3] * x * y + c[4] * y * y) * normal;
  }
};

/// Which sides end a smooth piece.
std::vector<char> sharp_sides(const mesh::SurfaceMesh& mesh, const HalfEdges& edges, double crease) {
  std::vector<char> sharp(edges.twin.size(), 1);
  for (Index h = 0; h < static_cast<Index>(edges.twin.size()); ++h)
    if (edges.twin[h] != no_index)
      sharp[h] = !mesh.chart_join(h / 3, h % 3).same_chart || is_crease(mesh, h / 3, h % 3, crease);
  return sharp;
}

}  // namespace

struct RestSurface::Impl {
  Impl(const mesh::SurfaceMesh& mesh, const Options& options)
      : search(mesh),
        edges(half_edges(mesh)),
        curves(mesh, edges, find_features(mesh, edges, {}, options.crease)),
        sharp(sharp_sides(mesh, edges, options.crease)) {
    fit_corners();
    edges = {};
    sharp = {};
  }

  [[nodiscard]] const Vec3& corner(Index c) const { return search.rest(c / 3)[static_cast<std::size_t>(c % 3)]; }
  /// Corners of the smooth sector around a corner, it first.
  [[nodiscard]] std::vector<Index> sector(Index c) const;
  void fit_corners();
  [[nodiscard]] Height fit(const std::vector<Index>& sector) const;
  [[nodiscard]] std::vector<Vec3> ring_points(const std::vector<Index>& sector) const;

  ChartSearch search;
  HalfEdges edges;  ///< only while it is built, as `sharp`
  RestCurves curves;
  std::vector<char> sharp;
  std::vector<Height> heights;
  std::vector<Index> height_of;  ///< per corner
  bool curved = false;
};

std::vector<Index> RestSurface::Impl::sector(Index c) const {
  std::vector<Index> corners{c};
  // Counter-clockwise the next corner of the same vertex lies across the side before the corner, clockwise after it.
  for (Index at = c; !sharp[next(at)];) {
    at = next(edges.twin[next(at)]);
    if (at == c) return corners;
    corners.push_back(at);
  }
  for (Index at = c; !sharp[prev(at)];) {
    at = prev(edges.twin[prev(at)]);
    corners.push_back(at);
  }
  return corners;
}

std::vector<Vec3> RestSurface::Impl::ring_points(const std::vector<Index>& sector) const {
  constexpr std::size_t enough = 8;
  std::vector<Index> triangles, vertices{edges.vertex[sector.front()]};
  std::vector<Vec3> points;
  const auto take = [&](Index t) {
    if (std::find(triangles.begin(), triangles.end(), t) != triangles.end()) return;
    triangles.push_back(t);
    for (Index c = 3 * t; c < 3 * t + 3; ++c) {
      if (std::find(vertices.begin(), vertices.end(), edges.vertex[c]) != vertices.end()) continue;
      vertices.push_back(edges.vertex[c]);
      points.push_back(corner(c));
    }
  };
  for (Index c : sector) take(c / 3);
  for (int ring = 1; ring < 3 && points.size() < enough; ++ring) {
    // Two steps over sides reach nearly what a step over vertices would.
    for (int step = 0; step < 2; ++step)
      for (std::size_t k = 0, n = triangles.size(); k < n; ++k)
        for (Index h = 3 * triangles[k]; h < 3 * triangles[k] + 3; ++h)
          if (!sharp[h]) take(edges.twin[h] / 3);
  }
  return points;
}

Height RestSurface::Impl::fit(const std::vector<Index>& sector) const {
  Height f;
  f.origin = corner(sector.front());
  f.normal = Vec3::Zero();
  f.c.setZero();
  for (Index c : sector) {
    const Vec3 a = corner(next(c)) - f.origin, b = corner(prev(c)) - f.origin;
    f.normal += std::atan2(a.cross(b).norm(), a.dot(b)) * a.cross(b).normalized();
  }
  f.normal.normalize();
  f.e1 = f.normal.unitOrthogonal();
  f.e2 = f.normal.cross(f.e1);
  const std::vector<Vec3> points = ring_points(sector);
  const auto n = static_cast<Eigen::Index>(points.size());
  double reach = 0.0, highest = 0.0;
  for (const Vec3& p : points) {
    reach = std::max(reach, (p - f.origin).norm());
    highest = std::max(highest, std::abs((p - f.origin).dot(f.normal)));
  }
  f.flat = highest <= flat * reach;
  if (f.flat) return f;
  Eigen::MatrixXd v(n, 5);
  Eigen::VectorXd z(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vec3 d = (points[i] - f.origin) / reach;
    const double x = d.dot(f.e1), y = d.dot(f.e2), w = 1.0 / d.squaredNorm();
    v.row(i) << w * x, w * y, w * x * x, w * x * y, w * y * y;
    z[i] = w * d.dot(f.normal);
  }
  f.c = LeastSquares(v).solve(z);
  f.c.tail<3>() /= reach;
  return f;
}

void RestSurface::Impl::fit_corners() {
  height_of.assign(edges.vertex.size(), no_index);
  for (Index c = 0; c < static_cast<Index>(edges.vertex.size()); ++c) {
    if (height_of[c] != no_index) continue;
    const std::vector<Index> corners = sector(c);
    for (Index k : corners) height_of[k] = static_cast<Index>(heights.size());
    heights.push_back(fit(corners));
    curved = curved || !heights.back().flat;
  }
}

RestSurface::RestSurface(const mesh::SurfaceMesh& first) : impl_(std::make_unique<Impl>(first, Options{})) {}
RestSurface::~RestSurface() = default;
RestSurface::RestSurface(RestSurface&&) noexcept = default;
RestSurface& RestSurface::operator=(RestSurface&&) noexcept = default;

bool RestSurface::curved() const {
  return impl_->curved;
}

Index RestSurface::locate(const Vec3& rest, const Vec3& normal) const {
  return impl_->search.nearest(rest, impl_->search.locate(rest, normal)).triangle;
}

Vec3 RestSurface::on_surface(const Vec3& rest, Index& triangle) const {
  if (!impl_->curved) return rest;
  const ChartSearch::Hit hit = impl_->search.nearest(rest, triangle);
  triangle = hit.triangle;
  Vec3 sum = Vec3::Zero();
  bool flat_here = true;
  for (int i = 0; i < 3; ++i) {
    const Height& f = impl_->heights[impl_->height_of[3 * hit.triangle + i]];
    flat_here = flat_here && f.flat;
    sum += hit.weights[static_cast<std::size_t>(i)] * f.project(rest);
  }
  return flat_here ? rest : sum;
}

std::optional<Vec3> RestSurface::curve_middle(const Vec3& a, const Vec3& b) const {
  return impl_->curves.middle(a, b);
}

double RestSurface::curve_deviation(const Vec3& a, const Vec3& b) const {
  return impl_->curves.deviation(a, b);
}

}  // namespace voile::adapt
