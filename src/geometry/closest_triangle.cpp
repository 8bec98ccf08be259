#include "closest_triangle.hpp"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <Eigen/Dense>
#include <algorithm>
#include <limits>
#include <utility>

#include "voile/errors.hpp"

namespace voile::geometry {

namespace {

using Cartesian = CGAL::Simple_cartesian<double>;
using Faces = std::vector<Cartesian::Triangle_3>;
using Tree =
    CGAL::AABB_tree<CGAL::AABB_traits<Cartesian, CGAL::AABB_triangle_primitive<Cartesian, Faces::const_iterator>>>;

Cartesian::Point_3 point(const Vec3& x) {
  return {x[0], x[1], x[2]};
}

}  // namespace

Vec3 nearest_weights(const Vec3& p, const std::array<Vec3, 3>& corners, double beside) {
  const auto& [a, b, c] = corners;
  Eigen::Matrix<double, 3, 2> sides;
  sides << b - a, c - a;
  const Vec2 w = (sides.transpose() * sides).ldlt().solve(sides.transpose() * (p - a));
  Vec3 best(1.0 - w[0] - w[1], w[0], w[1]);
  if (best.minCoeff() >= -beside) return best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const Vec3 side = corners[j] - corners[i], from = p - corners[i];
    const double along = std::clamp(side.dot(from) / side.squaredNorm(), 0.0, 1.0);
    const double away = (from - along * side).squaredNorm();
    if (away >= least) continue;
    least = away;
    best.setZero();
    best[static_cast<Eigen::Index>(i)] = 1.0 - along;
    best[static_cast<Eigen::Index>(j)] = along;
  }
  return best;
}

struct ClosestTriangle::Impl {
  Faces faces;
  std::vector<Index> number;
  Tree tree;
};

ClosestTriangle::ClosestTriangle(const std::vector<Vec3>& positions, const std::vector<mesh::Triangle>& triangles)
    : impl_(std::make_unique<Impl>()) {
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& [a, b, c] = triangles[t];
    const Cartesian::Triangle_3 face(point(positions[a]), point(positions[b]), point(positions[c]));
    if (face.is_degenerate()) continue;
    impl_->faces.push_back(face);
    impl_->number.push_back(static_cast<Index>(t));
  }
  if (impl_->faces.empty()) throw InternalError("closest triangle: there are no triangles with an area");
  impl_->tree.insert(impl_->faces.begin(), impl_->faces.end());
  impl_->tree.build();
  impl_->tree.accelerate_distance_queries();
}

ClosestTriangle::~ClosestTriangle() = default;
ClosestTriangle::ClosestTriangle(ClosestTriangle&&) noexcept = default;
ClosestTriangle& ClosestTriangle::operator=(ClosestTriangle&&) noexcept = default;

Index ClosestTriangle::find(const Vec3& x) const {
  const auto found = impl_->tree.closest_point_and_primitive(point(x));
  return impl_->number[static_cast<std::size_t>(found.second - impl_->faces.cbegin())];
}

}  // namespace voile::geometry
