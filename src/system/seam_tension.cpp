#include "seam_tension.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>

namespace voile::system {

namespace {

/// Force across side s of a triangle, over its rest length. [N/m]
double side_tension(const energy::Sheet& sheet, Index t, int s, const std::vector<double>& force,
                    const std::vector<Vec3>& places) {
  const mesh::SurfaceMesh& mesh = sheet.mesh();
  const mesh::Frame frame = sheet.frame(t);
  const int i = (s + 1) % 3, j = (s + 2) % 3;
  const mesh::Triangle& v = mesh.triangles()[static_cast<std::size_t>(t)];
  const Vec2 apex = frame.to_plane(mesh.rest_corner(t, s));
  Mat2 rest;
  rest << frame.to_plane(mesh.rest_corner(t, i)) - apex, frame.to_plane(mesh.rest_corner(t, j)) - apex;
  Eigen::Matrix<double, 3, 2> now;
  now << places[v[i]] - places[v[s]], places[v[j]] - places[v[s]];
  const Vec2 along = (rest.col(1) - rest.col(0)).normalized();
  Vec2 normal(along[1], -along[0]);
  if (normal.dot(rest.col(0)) < 0.0) normal = -normal;
  const double* n = force.data() + 3 * static_cast<std::size_t>(t);
  Mat2 membrane;
  membrane << n[0], n[2], n[2], n[1];
  const Vec3 edge = (now.col(1) - now.col(0)).normalized();
  const Vec3 outward = (now.col(0) - edge * edge.dot(now.col(0))).normalized();
  return outward.dot(now * rest.inverse() * membrane * normal);
}

}  // namespace

SeamTension seam_tension(const energy::Sheet& sheet, const mesh::Group& line, const std::vector<double>& force,
                         const std::vector<Vec3>& places) {
  const mesh::SurfaceMesh& mesh = sheet.mesh();
  SeamTension tension{line.name};
  double sides = 0.0;
  for (const mesh::Segment& segment : line.segments) {
    double here_sides = 0.0;
    int layers = 0;
    for (const Index t : mesh.triangles_of_vertex(segment[0])) {
      const int s = mesh.side_of(t, segment[0], segment[1]);
      if (s < 0) continue;
      const double here = side_tension(sheet, t, s, force, places);
      const double length = (mesh.rest_corner(t, (s + 1) % 3) - mesh.rest_corner(t, (s + 2) % 3)).norm();
      here_sides += length;
      ++layers;
      tension.mean += length * here;
      tension.largest = std::max(tension.largest, here);
    }
    sides += here_sides;
    tension.length += here_sides / std::max(layers, 2);  // each side of an open seam is a segment of its own
  }
  if (sides > 0.0) tension.mean /= sides;
  return tension;
}

}  // namespace voile::system
