#include "triangle_division.hpp"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Constrained_triangulation_face_base_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_data_structure_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <set>

namespace voile::geometry {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using NumberedVertices = CGAL::Triangulation_vertex_base_with_info_2<Index, Kernel>;
using PlaneStructure =
    CGAL::Triangulation_data_structure_2<NumberedVertices, CGAL::Constrained_triangulation_face_base_2<Kernel>>;
using PlaneTriangulation =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel, PlaneStructure, CGAL::No_constraint_intersection_tag>;

std::array<Index, 2> side_of(const PlaneTriangulation::Face_handle& face, int s) {
  const Index a = face->vertex((s + 1) % 3)->info(), b = face->vertex((s + 2) % 3)->info();
  return {std::min(a, b), std::max(a, b)};
}

/// Faces that can be reached from infinity without passing the outline.
std::set<PlaneTriangulation::Face_handle> outside(const PlaneTriangulation& t,
                                                  const std::set<std::array<Index, 2>>& outline) {
  std::set<PlaneTriangulation::Face_handle> found{t.infinite_face()};
  std::vector<PlaneTriangulation::Face_handle> next(found.begin(), found.end());
  while (!next.empty()) {
    const PlaneTriangulation::Face_handle face = next.back();
    next.pop_back();
    for (int s = 0; s < 3; ++s) {
      const PlaneTriangulation::Face_handle beyond = face->neighbor(s);
      const bool finite = !t.is_infinite(face->vertex((s + 1) % 3)) && !t.is_infinite(face->vertex((s + 2) % 3));
      if (finite && outline.count(side_of(face, s)) > 0) continue;
      if (found.insert(beyond).second) next.push_back(beyond);
    }
  }
  return found;
}

}  // namespace

std::vector<Corners> divide_polygon(const std::vector<Vec2>& points, const std::vector<Index>& outline,
                                    const std::vector<std::array<Index, 2>>& lines) {
  PlaneTriangulation t;
  std::vector<PlaneTriangulation::Vertex_handle> vertices;
  for (std::size_t i = 0; i < points.size(); ++i) {
    vertices.push_back(t.insert({points[i][0], points[i][1]}));
    vertices.back()->info() = static_cast<Index>(i);
  }
  if (t.number_of_vertices() != points.size()) return {};
  std::set<std::array<Index, 2>> rim, all;  // CGAL takes a line that is there for one that crosses it
  const auto put = [](std::set<std::array<Index, 2>>& to, Index a, Index b) {
    to.insert({std::min(a, b), std::max(a, b)});
  };
  for (std::size_t i = 0; i < outline.size(); ++i) put(rim, outline[i], outline[(i + 1) % outline.size()]);
  all = rim;
  for (const auto& [a, b] : lines) put(all, a, b);
  try {
    for (const auto& [a, b] : all) t.insert_constraint(vertices[a], vertices[b]);
  } catch (const PlaneTriangulation::Intersection_of_constraints_exception&) {
    return {};
  }
  const auto beyond = outside(t, rim);
  std::vector<Corners> triangles;
  for (auto face = t.finite_faces_begin(); face != t.finite_faces_end(); ++face)
    if (beyond.count(face) == 0)
      triangles.push_back({face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()});
  return triangles;
}

}  // namespace voile::geometry
