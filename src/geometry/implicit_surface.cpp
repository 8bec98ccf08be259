#include "implicit_surface.hpp"

#include <CGAL/Complex_2_in_triangulation_3.h>
#include <CGAL/IO/facets_in_complex_2_to_triangle_mesh.h>
#include <CGAL/Implicit_surface_3.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_default_triangulation_3.h>
#include <CGAL/make_surface_mesh.h>

#include <Eigen/Geometry>

#include <cmath>

#include "voile/errors.hpp"

namespace voile::geometry {

namespace {

using Triangulation = CGAL::Surface_mesh_default_triangulation_3;
using Complex = CGAL::Complex_2_in_triangulation_3<Triangulation>;
using Traits = Triangulation::Geom_traits;
using Function = std::function<double(Traits::Point_3)>;
using Polyhedron = CGAL::Surface_mesh<Traits::Point_3>;

Vec3 gradient(const std::function<double(const Vec3&)>& f, const Vec3& p, double h) {
  Vec3 g;
  for (int c = 0; c < 3; ++c) g[c] = (f(p + h * Vec3::Unit(c)) - f(p - h * Vec3::Unit(c))) / (2.0 * h);
  return g;
}

/// A few steps of Newton's method along the gradient.
Vec3 projected(const std::function<double(const Vec3&)>& f, Vec3 p, double size) {
  for (int k = 0; k < 4; ++k) {
    const Vec3 g = gradient(f, p, 1e-5 * size);
    const double slope = g.squaredNorm();
    if (!(slope > 0.0)) break;
    Vec3 step = -f(p) / slope * g;
    if (step.norm() > 0.2 * size) step *= 0.2 * size / step.norm();
    p += step;
  }
  return p;
}

/// Moves corners to the middle of their neighbours within the surface, which evens out angles.
void smooth(const std::function<double(const Vec3&)>& f, double size, TriangleSoup& soup) {
  constexpr int rounds = 8;
  for (int k = 0; k < rounds; ++k) {
    std::vector<Vec3> sum(soup.positions.size(), Vec3::Zero());
    std::vector<double> weight(soup.positions.size(), 0.0);
    for (const mesh::Triangle& t : soup.triangles) {
      const Vec3 &a = soup.positions[t[0]], &b = soup.positions[t[1]], &c = soup.positions[t[2]];
      const double area = (b - a).cross(c - a).norm();
      for (const Index v : t) {
        sum[v] += area / 3.0 * (a + b + c);
        weight[v] += area;
      }
    }
    for (std::size_t v = 0; v < sum.size(); ++v) {
      Vec3& p = soup.positions[v];
      const Vec3 normal = gradient(f, p, 1e-5 * size).normalized(), d = sum[v] / weight[v] - p;
      if (normal.allFinite()) p = projected(f, p + 0.7 * (d - d.dot(normal) * normal), size);
    }
  }
}

double volume(const TriangleSoup& soup) {
  double sum = 0.0;
  for (const mesh::Triangle& t : soup.triangles)
    sum += soup.positions[t[0]].dot(soup.positions[t[1]].cross(soup.positions[t[2]])) / 6.0;
  return sum;
}

TriangleSoup soup_of(const Polyhedron& polyhedron) {
  TriangleSoup soup;
  std::vector<Index> number(polyhedron.num_vertices() + polyhedron.number_of_removed_vertices(), no_index);
  for (const auto v : polyhedron.vertices()) {
    number[v] = static_cast<Index>(soup.positions.size());
    const auto& p = polyhedron.point(v);
    soup.positions.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto face : polyhedron.faces()) {
    mesh::Triangle t{};
    std::size_t i = 0;
    for (const auto v : CGAL::vertices_around_face(polyhedron.halfedge(face), polyhedron)) t[i++] = number[v];
    soup.triangles.push_back(t);
  }
  return soup;
}

}  // namespace

TriangleSoup implicit_surface(const std::function<double(const Vec3&)>& f, const ImplicitMeshing& how) {
  if (!(f(how.centre) < 0.0)) throw InternalError("implicit_surface: the centre is not inside");
  const Function at = [&](const Traits::Point_3& p) { return f(Vec3(p.x(), p.y(), p.z())); };
  const Vec3& c = how.centre;
  const CGAL::Implicit_surface_3<Traits, Function> surface(
      at, Traits::Sphere_3(Traits::Point_3(c.x(), c.y(), c.z()), how.radius * how.radius),
      1e-3 * how.deviation / how.radius);
  // The radius of the circumscribed circle of an equilateral triangle.
  const CGAL::Surface_mesh_default_criteria_3<Triangulation> criteria(30.0, how.size / std::sqrt(3.0), how.deviation);
  Triangulation triangulation;
  Complex complex(triangulation);
  constexpr int first_points = 20;
  CGAL::get_default_random() = CGAL::Random(0);
  CGAL::make_surface_mesh(complex, surface, criteria, CGAL::Manifold_tag(), first_points);
  Polyhedron polyhedron;
  CGAL::facets_in_complex_2_to_triangle_mesh(complex, polyhedron);
  TriangleSoup soup = soup_of(polyhedron);
  smooth(f, how.size, soup);
  if (volume(soup) < 0.0)
    for (mesh::Triangle& t : soup.triangles) std::swap(t[1], t[2]);
  return soup;
}

}  // namespace voile::geometry
