// The patch of a triangle: itself, its up to three neighbours, and mirror points beyond clamped or symmetric edges.
//
// Symbols   points     the mesh vertices, numbered as in the mesh, followed by the mirror points
//           A          vertex of a boundary triangle opposite to the mirrored side (a, b)
//           f          foot of the altitude of A on the side, f = (1-alpha) a + alpha b
//           alpha      from the rest shape of the triangle
// Mirror point          x_g = f + R (x_A - f), linear in the positions, so operators built on it stay constant
//   symmetry plane with unit normal nu:   R = I - 2 nu nu^T                       (Householder reflection)
//   clamped edge of a facet normal N:     R = 2 N N^T - I                         (even normal, odd in-plane
//   displacement)
// The reflection is that of the start: it acts in space. At rest the sheet goes on flat beyond a mirrored side of a
// triangle whose rest shape lies in a chart of its own, since the plane of symmetry is not in the chart.
// Unfolding: a neighbour is rotated about the shared side into the plane of the triangle; lengths are kept. Across a seam
// (surface_mesh.hpp) it is first carried into the chart of the triangle. Theory: docs/theory/patch.md.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "surface_mesh.hpp"

namespace voile::mesh {

/// A boundary side whose neighbour is a mirror image.
struct MirrorSide {
  Index triangle = no_index;
  int side = 0;
  Mat3 reflection = Mat3::Identity();  ///< R
};

struct MirrorPoint {
  Index apex = no_index, a = no_index, b = no_index;
  double foot = 0.0;  ///< alpha
  Mat3 reflection = Mat3::Identity();
  Vec3 rest = Vec3::Zero();   ///< in the chart of its triangle [m]
  Vec3 start = Vec3::Zero();  ///< [m]
};

/// Right-handed orthonormal axes in the plane of a triangle at rest, in its chart.
struct Frame {
  Vec3 origin, e1, e2, normal;
  [[nodiscard]] Vec2 to_plane(const Vec3& x) const { return {(x - origin).dot(e1), (x - origin).dot(e2)}; }
};

/// The six points of a patch in the plane of its triangle. Points 3, 4, 5 lie across sides 0, 1, 2.
struct Patch {
  std::array<Index, 6> points{};  ///< no_index where a neighbour is missing
  std::array<Vec2, 6> coordinates{};
  std::array<Vec3, 6> rest{};                    ///< rest positions in the chart of the triangle, not unfolded [m]
  std::array<double, 3> stretch{1.0, 1.0, 1.0};  ///< of the neighbour across each side, see Join
  double area = 0.0;                             ///< of the triangle [m^2]
  [[nodiscard]] bool complete() const { return points[3] >= 0 && points[4] >= 0 && points[5] >= 0; }
};

/// A surface mesh together with its mirror points. Keeps a reference to the mesh, which must outlive it.
class PatchMesh {
 public:
  /// Throws UserError if a mirrored side has a neighbour or is named twice.
  PatchMesh(const SurfaceMesh& mesh, const std::vector<MirrorSide>& mirrors);

  /// The same where these sides, each named from both of its triangles, are free edges: nothing reaches across them.
  [[nodiscard]] PatchMesh cut_along(const std::vector<TriangleSide>& sides) const;

  [[nodiscard]] const SurfaceMesh& mesh() const { return *mesh_; }
  [[nodiscard]] Index point_count() const { return mesh_->vertex_count() + static_cast<Index>(mirrors_.size()); }
  [[nodiscard]] bool is_mirror(Index p) const { return p >= mesh_->vertex_count(); }
  [[nodiscard]] const MirrorPoint& mirror(Index p) const { return mirrors_[p - mesh_->vertex_count()]; }
  [[nodiscard]] const std::vector<MirrorPoint>& mirrors() const { return mirrors_; }
  /// Place at the start [m].
  [[nodiscard]] Vec3 start(Index p) const { return is_mirror(p) ? mirror(p).start : mesh_->positions()[p]; }
  /// Point across side s of triangle t: a vertex, a mirror point, or no_index at a free edge or cut.
  [[nodiscard]] Index apex(Index t, int s) const;

  /// Axes of triangle t with its centroid as origin; e1 along the projection of `direction`, or of an axis of the chart.
  /// Throws UserError if the direction is normal to the triangle.
  [[nodiscard]] Frame frame(Index t, const std::optional<Vec3>& direction = std::nullopt) const;
  /// The unfolded patch of t in the axes of `frame`.
  [[nodiscard]] Patch patch(Index t, const Frame& frame) const;
  /// Vertices and mirror points of all triangles within `rings` rings of vertices around triangle t (and its neighbour
  /// across `side`, if side >= 0), unfolded along a tree of triangles into the plane of t.
  struct UnfoldedPoint {
    Index point;
    Vec2 coordinates;
    Vec3 rest;  ///< in the chart of t, not unfolded [m]
  };
  [[nodiscard]] std::vector<UnfoldedPoint> unfolded_rings(Index t, int side, int rings, const Frame& frame) const;

  /// Angle [rad] between the rest normals on both sides of side s of t; 0 at free edges and seams.
  [[nodiscard]] double rest_dihedral(Index t, int s) const;

 private:
  [[nodiscard]] MirrorPoint make_mirror(const MirrorSide& side) const;
  /// Rest position of the point across side s of t in the chart of t. Requires one.
  [[nodiscard]] Vec3 rest_apex(Index t, int s) const;

  const SurfaceMesh* mesh_;
  std::vector<MirrorPoint> mirrors_;
  std::vector<std::array<Index, 3>> mirror_of_side_;  ///< only for triangles with mirrors, see slot_
  std::vector<Index> slot_;                           ///< per triangle: row in mirror_of_side_, or no_index
  std::vector<std::array<bool, 3>> cut_;              ///< per triangle and side; empty: none
};

/// Place in the plane of the point `x` lying beyond the edge a -> b (plane coordinates pa, pb, outward normal to the
/// right of a -> b), keeping its distances to the edge, or these times `scale`.
[[nodiscard]] Vec2 unfold(const Vec3& a, const Vec3& b, const Vec2& pa, const Vec2& pb, const Vec3& x,
                          double scale = 1.0);

}  // namespace voile::mesh
