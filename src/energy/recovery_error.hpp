// Error of a state by recovery: the stress resultants of its triangles against smooth ones fitted to them.
//
// Symbols   N, M     membrane force and bending moment of a triangle T, one value each, Voigt (11, 22, 12)   [N/m], [N]
//           c, J     centroid of T; mean over T of (p - c)(p - c)^T                                          [m], [m^2]
//           N*, M*   a + g.(p - c): fitted by least squares, weighted by areas, to the values at the centroids of the triangles
//                    that share a vertex with T, unfolded into its plane
//   e_N = 1/2 (a_N - N).C^-1 (a_N - N)                                          per area
//   e_M = 1/2 [ (a_M - M).D^-1 (a_M - M) + sum_ab J_ab g_a.D^-1 g_b ]
// are the complementary energies of N* - N, M* - M. Curvature is constant in T, so that what M* varies by in T is error of M. The mean
// strain of the membranes with six nodes is that of a quadratic at the centroid, and what N* varies by is none; for `cst` it is.
// Over the stored energy they estimate the square of the relative error in the energy norm, and for one force the fraction by which its
// deflection is wrong, too stiff or too soft. Theory: docs/theory/error-estimates.md (1).
// The fit ends at free edges, creases, gathers, seams across which a material with a direction turns, and where another material begins.
// Source: Zienkiewicz & Zhu, Int. J. Numer. Meth. Engng 24 (1987) 337-357; patches: 33 (1992) 1331-1364.
#pragma once

#include <array>
#include <complex>
#include <vector>

#include "sheet.hpp"

namespace voile::energy {

class RecoveryError {
 public:
  struct Density {
    double membrane = 0.0, bending = 0.0;  ///< e_N, e_M [J/m^2]
  };

  /// `sheet` must outlive it. Passes over all triangles. Not collective.
  explicit RecoveryError(const Sheet& sheet);

  /// Of triangle t, from N and M of all triangles in material axes, three per triangle. Not collective.
  [[nodiscard]] Density of(Index t, const std::vector<double>& force, const std::vector<double>& moment) const;

  /// At corner i of triangle t and in its material axes: the value there of a quadratic fitted to the symmetric tensors `values` of
  /// the triangles around (three per triangle, in material axes), of two or three rings that end where those above do. Not
  /// collective.
  /// `bending`: they are of bending, which a triangle at a clamped edge has as at that edge, since the slope there is exact.
  [[nodiscard]] Vec3 at_corner(Index t, int i, const std::vector<double>& values, bool bending) const;
  /// Whether tensors are smooth across side s of triangle t.
  [[nodiscard]] bool is_smooth(Index t, int s) const { return flat_[static_cast<std::size_t>(t)].goes_on[s]; }

 private:
  using Complex = std::complex<double>;
  /// Triangles around one; more are left out.
  static constexpr int most = 64;
  /// A triangle unfolded into the plane of another one: `turn` takes its material axes to those of that one.
  struct Piece {
    Index triangle;
    std::array<Complex, 3> corner;
    Complex centre, turn;
  };
  /// A triangle in its own plane and axes, centroid at 0.
  struct Flat {
    std::array<Complex, 3> corner;  ///< [m]
    std::array<bool, 3> goes_on;    ///< whether stresses are smooth across a side
    double area;                    ///< [m^2]
  };
  struct Compliance {
    Mat3 membrane, bending;
  };

  [[nodiscard]] bool goes_on(Index t, int s) const;
  [[nodiscard]] Piece beyond(const Piece& from, int s) const;
  /// Where the bending of a triangle is that of the fit.
  [[nodiscard]] Complex place_of_bending(const Piece& p) const;
  int pieces_around(Index t, std::array<Piece, most>& pieces) const;
  /// Adds to the `count` pieces those connected with them that touch one of the vertices `core`.
  int grow(std::array<Piece, most>& pieces, int count, const std::vector<Index>& core) const;

  const Sheet* sheet_;
  std::vector<Flat> flat_;
  std::vector<Compliance> compliance_;  ///< of each material
};

}  // namespace voile::energy
