// Quadratics through patches and rings of points; private to src/energy.
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <optional>
#include <vector>

#include "mesh/patch.hpp"

namespace voile::energy {

using Row6 = Eigen::Matrix<double, 1, 6>;

/// A side in the plane of its triangle.
struct Side {
  double length;
  Vec2 middle, tangent, normal;
};

[[nodiscard]] Side side_of(const mesh::Patch& p, int s);

/// Coefficients of a quadratic (rows: monomials) as functionals of points (columns), about the triangle's centroid.
struct Fit {
  std::vector<Index> points;
  std::vector<Vec3> rest;  ///< of the points, from the triangle's centroid, in its chart [m]
  Eigen::Matrix<double, 6, Eigen::Dynamic> coefficients;
  double condition = std::numeric_limits<double>::infinity();
  bool complete = false;
};

/// Bending stiffness beyond each side, in the axes of the triangle, where it is another one than within.
using Beyond = std::array<std::optional<Mat3>, 3>;

/// Normal stiffness D_nn = nn.D nn across a side of normal n, nn = (n1^2, n2^2, 2 n1 n2) [N m].
[[nodiscard]] double normal_stiffness(const Mat3& bending, const Vec2& n);

/// The quadratic of the patch. A missing neighbour's row is replaced by M_nn = 0 on that side. Where the stiffness jumps,
/// by balance of moments: q goes on beyond the side as q + c d^2/2, d the distance from it, with
///   c = nn.(D - D_O) k / D_O,nn,
/// so that M_nn, k_tt and k_tn are those of both sides; exact for constant moments.
[[nodiscard]] Fit fit_patch(const mesh::Patch& patch, const Vec3& centroid, const Mat3& bending, const Beyond& beyond);

/// Weighted least-squares quadratic about `origin` over the points.
[[nodiscard]] Fit fit_rings(const std::vector<mesh::PatchMesh::UnfoldedPoint>& points, const Vec3& centroid,
                            const Vec2& origin, double scale);

}  // namespace voile::energy
