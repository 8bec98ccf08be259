#include "surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace voile::contact {

namespace {

/// Edges of triangles, each once, in ascending order of their points.
std::vector<mesh::Segment> edges_of(const std::vector<mesh::Triangle>& triangles) {
  std::vector<mesh::Segment> edges;
  for (const mesh::Triangle& t : triangles)
    for (int s = 0; s < 3; ++s) edges.push_back({std::min(t[s], t[(s + 1) % 3]), std::max(t[s], t[(s + 1) % 3])});
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

void add_edge(Surface& s, Index a, Index b, int body, bool bare) {
  s.edges.push_back({{a, b}, body, (s.rest[b] - s.rest[a]).squaredNorm(), bare});
}

double area_of(const Surface& s, const std::array<Index, 3>& p) {
  return mesh::triangle_area(s.rest[p[0]], s.rest[p[1]], s.rest[p[2]]);
}

void add_face(Surface& s, const std::array<Index, 3>& p, int body, double area) {
  s.faces.push_back({p, body});
  s.face_area.push_back(area);
  for (Index i : p) s.area[i] += area / 3.0;
}

}  // namespace

Surface make_surface(const mesh::SurfaceMesh& mesh, std::vector<Body> bodies, const std::vector<int>& body_of_triangle,
                     const std::vector<int>& body_of_vertex) {
  const auto curve_through = [&](const auto& points) {
    int last = -1;
    for (Index v : points) last = std::max(last, body_of_vertex.empty() ? -1 : body_of_vertex[v]);
    return last;
  };
  Surface s;
  s.sheet_points = mesh.vertex_count();
  s.rest = mesh.positions();
  s.bodies = std::move(bodies);
  s.rules.assign(s.bodies.size(), std::vector<Rule>(s.bodies.size()));
  s.body_of_point.assign(s.rest.size(), 0);
  s.area.assign(s.rest.size(), 0.0);
  for (Index t = mesh.triangle_count(); t-- > 0;)  // a point or edge belongs to the body of its first triangle
    for (Index v : mesh.triangles()[t]) s.body_of_point[v] = body_of_triangle.empty() ? 0 : body_of_triangle[t];
  for (Index v = 0; v < mesh.vertex_count(); ++v)
    if (const int curve = curve_through(std::array{v}); curve >= 0) s.body_of_point[v] = curve;
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const int curve = curve_through(mesh.triangles()[t]);
    add_face(s, mesh.triangles()[t],
             curve >= 0                 ? curve
             : body_of_triangle.empty() ? 0
                                        : body_of_triangle[t],
             mesh.area(t));
  }
  for (const mesh::Segment& e : edges_of(mesh.triangles())) {
    const int curve = curve_through(e);
    add_edge(s, e[0], e[1], curve >= 0 ? curve : s.body_of_point[std::min(e[0], e[1])], false);
    if (mesh.has_charts()) s.edges.back().rest_length_squared = std::pow(mesh.rest_length(e), 2);
  }
  s.sheet_edges = static_cast<Index>(s.edges.size());
  s.sheet_faces = static_cast<Index>(s.faces.size());
  return s;
}

double mean_edge(const Surface& s) {
  double sum = 0.0;
  for (Index e = 0; e < s.sheet_edges; ++e) sum += std::sqrt(s.edges[e].rest_length_squared);
  return sum / s.sheet_edges;
}

Index append(Surface& s, int body, const std::vector<Vec3>& points, const std::vector<mesh::Triangle>& triangles,
             const std::vector<mesh::Segment>& bare_edges) {
  const Index first = s.points();
  s.rest.insert(s.rest.end(), points.begin(), points.end());
  s.body_of_point.resize(s.rest.size(), body);
  s.area.resize(s.rest.size(), 0.0);
  for (const mesh::Triangle& t : triangles) {
    const std::array<Index, 3> p{first + t[0], first + t[1], first + t[2]};
    add_face(s, p, body, area_of(s, p));
  }
  for (const mesh::Segment& e : edges_of(triangles)) add_edge(s, first + e[0], first + e[1], body, false);
  if (triangles.empty())
    for (std::size_t i = 0; i < points.size(); ++i) s.bare_points.push_back(first + static_cast<Index>(i));
  for (const mesh::Segment& e : bare_edges) add_edge(s, first + e[0], first + e[1], body, true);
  return first;
}

}  // namespace voile::contact
