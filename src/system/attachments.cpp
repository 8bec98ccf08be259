#include "voile/system/attachments.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "voile/geometry/closest_triangle.hpp"

namespace voile::system {

namespace {

constexpr std::size_t row_length = 8;

Mat3 axes_of(const Vec3& a, const Vec3& b, const Vec3& c) {
  Mat3 f;
  f.col(0) = (b - a).normalized();
  f.col(2) = (b - a).cross(c - a).normalized();
  f.col(1) = Vec3(f.col(2)).cross(Vec3(f.col(0)));
  return f;
}

}  // namespace

std::vector<double> numbers_of(const std::vector<Anchor>& anchors) {
  std::vector<double> all;
  for (const Anchor& a : anchors)
    all.insert(all.end(),
               {static_cast<double>(a.attachment), static_cast<double>(a.vertex), static_cast<double>(a.triangle),
                a.weights[0], a.weights[1], a.offset[0], a.offset[1], a.offset[2]});
  return all;
}

std::vector<Anchor> anchors_of(const std::vector<double>& numbers) {
  std::vector<Anchor> all;
  for (std::size_t i = 0; i + row_length <= numbers.size(); i += row_length) {
    const double* n = numbers.data() + i;
    all.push_back({static_cast<int>(n[0]), static_cast<Index>(n[1]), static_cast<Index>(n[2]), Vec2(n[3], n[4]),
                   Vec3(n[5], n[6], n[7])});
  }
  return all;
}

Vec3 anchor_place(const Anchor& anchor, const mesh::Triangle& triangle, const std::vector<Vec3>& points) {
  const Vec3 &a = points[triangle[0]], &b = points[triangle[1]], &c = points[triangle[2]];
  return a + anchor.weights[0] * (b - a) + anchor.weights[1] * (c - a) + axes_of(a, b, c) * anchor.offset;
}

std::vector<Anchor> make_anchors(const Attachment& attachment, const std::vector<Index>& vertices,
                                 const std::vector<Vec3>& places, const std::vector<Vec3>& points,
                                 const std::vector<mesh::Triangle>& triangles) {
  const geometry::ClosestTriangle closest(points, triangles);
  std::vector<Anchor> anchors;
  for (const Index v : vertices) {
    const Index t = closest.find(places[v]);
    const std::array corners{points[triangles[t][0]], points[triangles[t][1]], points[triangles[t][2]]};
    const Vec3 weights = geometry::nearest_weights(places[v], corners);
    Anchor anchor{attachment.number, v, t, Vec2(weights[1], weights[2]), Vec3::Zero()};
    const Vec3 away = places[v] - anchor_place(anchor, triangles[t], points);
    anchor.offset = axes_of(corners[0], corners[1], corners[2]).transpose() * away;
    if (!std::isnan(attachment.gap)) anchor.offset = {0.0, 0.0, std::copysign(attachment.gap, anchor.offset.z())};
    anchors.push_back(anchor);
  }
  return anchors;
}

std::vector<Index> vertices_of(const mesh::SurfaceMesh& mesh, const Attachment& attachment) {
  std::vector<Index> all;
  for (const std::string& name : attachment.groups) {
    const std::vector<Index>& some = mesh.group(name).vertices;
    all.insert(all.end(), some.begin(), some.end());
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

}  // namespace voile::system
