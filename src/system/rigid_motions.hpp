// Rigid-body motions that the supports leave free, counted for each piece of the surface.
//
// Symbols   v, w     velocity at the piece's centre c and rotation of a piece, both in units of length:
//                    u(X) = v + w x (X - c) / L, with L the piece's radius of gyration                        [m]
//           d        direction in which a vertex is held, or a spring acts on it: d . u = 0
//           t        tangent of a clamped or mirrored edge, about which nothing turns: t . w = 0
//           j        vertex that two pieces share without sharing an edge: u_1(X_j) = u_2(X_j)
//           n        direction of a spring between vertices i and j: n . (u(X_i) - u(X_j)) = 0, for all n if it has no
//                    length
// The free motions are the null space of these equations, found by singular values. Pieces that hang together by single
// vertices or by springs are counted together. Contact and loads do not enter.
// Source: G.H. Golub & C.F. Van Loan, Matrix Computations, 4th ed. (2013), 2.4 (null space by singular values).
#pragma once

#include <vector>

#include "constraints.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::system {

/// A piece (or pieces that share vertices) that can move without straining.
struct FreePiece {
  Index triangles = 0;
  Vec3 centre = Vec3::Zero();    ///< mean of its vertices at rest [m]
  int translations = 0;          ///< free motions without any rotation: no load can ever balance along them
  std::vector<Vec3> directions;  ///< of the translations, orthonormal; of the first body where several hang together
  int rotations = 0;             ///< the other free motions: about an axis, or parts that turn against each other
  [[nodiscard]] int motions() const { return translations + rotations; }
};

/// The pieces that are not held completely by supports and springs. Not collective.
[[nodiscard]] std::vector<FreePiece> free_pieces(const mesh::SurfaceMesh& mesh, const Constraints& constraints,
                                                 const std::vector<Spring>& springs = {});

}  // namespace voile::system
