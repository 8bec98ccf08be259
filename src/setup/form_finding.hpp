// Shapes in which a given membrane force is in equilibrium: form finding by an updated reference.
//
// Symbols   S    membrane force of a triangle, a tensor in its plane, positive definite                        [N/m]
//           A, g_i   area of a triangle and gradients of its three linear shape functions             [m^2], [1/m]
//           T, l     force and length of a cable's edge [N], [m];  p  pressure along the normals [Pa]
//   k_ij = sum over triangles of A g_i . S g_j,  of cables of T/l (1 on the diagonal, -1 beside it)
//   K(x) x* = f(x),  f_i = sum over triangles of p A n/3;   x <- x* until K(x) x = f(x)
// With an isotropic S each step minimises the Dirichlet integral over the last surface: the area decreases down to that of a
// discrete minimal surface (Pinkall & Polthier, Experimental Mathematics 2 (1993) 15-36). As a method for tents: updated
// reference strategy, Bletzinger & Ramm, Int. J. Space Structures 14 (1999) 131-146, without its homotopy.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "mesh/surface_mesh.hpp"

namespace voile::setup {

/// Of forces within a surface of constant isotropic force, see FormProblem::within: true forms have less than 0.0022 on 16
/// cells around a neck, false ones more than 0.02.
constexpr double largest_within = 3e-3;

struct FormProblem {
  struct Cable {
    mesh::Segment edge{};
    double force = 0.0;  ///< [N]
  };
  std::vector<Vec3> places;  ///< of the vertices at the beginning [m]
  std::vector<mesh::Triangle> triangles;
  std::vector<std::array<bool, 3>> held;  ///< components of each vertex
  std::vector<Cable> cables;
  /// Membrane force of triangle `t` with these corners, in global axes [N/m].
  std::function<Mat3(Index t, const std::array<Vec3, 3>& corners)> force;
  double pressure = 0.0;  ///< [Pa]
  double tolerance =
      1e-9;  ///< largest force out of balance across the surface over the largest sum of forces at a vertex
  /// The same in all free directions. Within the surface a constant isotropic force is in balance but for the error of the
  /// cells; where it is not, the cells keep from collapsing a surface that does.
  double within = 1.0;
  int most_iterations = 2000;
};

struct FormResult {
  std::vector<Vec3> places;  ///< [m]
  bool converged = false;
  int iterations = 0;
  double residual = 0.0, within = 0.0;  ///< as `tolerance` and `within` bound them
  Index collapsed = no_index;           ///< a triangle that has lost its area or folded onto a neighbour
};

/// Not collective. Every component of every connected piece must be held at a vertex.
[[nodiscard]] FormResult find_form(const FormProblem& problem);

}  // namespace voile::setup
