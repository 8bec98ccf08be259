// Triangles of the surface on which a function is zero.
//
// Delaunay refinement of points on the surface: J.-D. Boissonnat, S. Oudot, Provably good sampling and meshing of
// surfaces, Graphical Models 67 (2005) 405-451, as implemented in CGAL.
#pragma once

#include <functional>

#include "primitive_surface.hpp"

namespace voile::geometry {

struct ImplicitMeshing {
  Vec3 centre = Vec3::Zero();  ///< inside: the function is negative there
  double radius = 1.0;         ///< a ball about the centre with the whole surface inside [m]
  double size = 0.03;          ///< largest edges, about [m]
  double deviation = 0.002;    ///< largest distance of a triangle's middle from the surface [m]
};

/// A closed manifold with normals to where `f` grows; angles of at least 30 degrees where the size allows. Corners lie
/// on the surface as exactly as f can be evaluated, if its gradient is finite there. What f has besides the piece that
/// rays from the centre meet first is not found for certain. Not collective; the same input gives the same mesh.
/// Throws InternalError if f is not negative at the centre.
[[nodiscard]] TriangleSoup implicit_surface(const std::function<double(const Vec3&)>& f, const ImplicitMeshing& how);

}  // namespace voile::geometry
