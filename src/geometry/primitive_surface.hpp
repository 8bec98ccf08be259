// Triangles of a primitive.
//
// Symbols   a, b   ends of an axis [m]      r   radius [m]      n   corners around a circle
//
// An inscribed tessellation has all its vertices on the (convex) primitive, so it lies inside: what is outside the
// primitive cannot touch it. It falls short by the sagitta of its longest edge h, about h^2/(8 r) for an edge and
// h^2/(6 r) inside an equilateral triangle.
#pragma once

#include <vector>

#include "base/types.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::geometry {

/// Triangles without any promise of topology: open, not manifold, not oriented, in several pieces as the file has it.
struct TriangleSoup {
  std::vector<Vec3> positions;            ///< [m] (the file's numbers are taken as metres)
  std::vector<mesh::Triangle> triangles;  ///< of non-zero area
  Index degenerate_count = 0;             ///< triangles of exactly zero area that the file had and that were dropped
};

/// An icosahedron inscribed in the sphere (up to round-off), each triangle divided `refinement` times (0 to 8) into
/// four: 20 x 4^refinement triangles, h at most 1.33 r / 2^refinement. Closed, normals outwards.
/// Not collective. Throws InternalError if the radius is not positive or the refinement is out of range.
[[nodiscard]] TriangleSoup sphere_surface(const Vec3& centre, double radius, int refinement);

/// A capsule (all points at the distance r from the segment a b), inscribed up to round-off: n = 8 x 2^refinement
/// (0 to 7) corners around the axis, n/4 rings on each hemisphere, the cylinder in between of triangles as long as it.
/// Closed, normals outwards. a = b gives a sphere. Not collective. Throws as sphere_surface does.
[[nodiscard]] TriangleSoup capsule_surface(const Vec3& a, const Vec3& b, double radius, int refinement);

/// A cylinder with flat ends: n corners around the axis, from 12 to 720, so many that the sagitta of a facet is at most
/// `sagitta` [m]. Corners lie half of the sagitta outside the true cylinder and middles of facets half of it inside, so
/// that loads and friction find no radius that is off to one side. Side and ends are divided into triangles at most
/// 8 times as long as wide, of a very long cylinder longer ones: the side has at most 200 000.
/// Closed, normals outwards. Not collective. Throws InternalError if the radius or the sagitta is not positive or a = b.
[[nodiscard]] TriangleSoup cylinder_surface(const Vec3& a, const Vec3& b, double radius, double sagitta);

}  // namespace voile::geometry
