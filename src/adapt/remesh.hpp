// Local remeshing in the rest charts towards wanted edge lengths: splits, collapses, flips, smoothing.
//
// Symbols   L/h   rest length of an edge over the mean of the wanted sizes at its ends (the longer side of a seam)
// Rounds, until the number of vertices changes by less than 1 %:
//   split the longest edge first, while L/h > split
//   collapse the shortest first, while L/h < collapse and every edge made stays below `longest_after`
//   flips towards Delaunay and towards valence six; smoothing of vertices beside changes
// Then edges with L/h < shortest, in sweeps with flips towards Delaunay: an end is moved, or the edge collapsed into its middle or an
// end, if every edge made stays below `longest_at_last`
// Features are kept: boundaries, group lines, borders between groups and of frozen regions, seams, creases (rest dihedral
// angle above `crease`). Vertices are made and removed along them, on the geometry of the RestSurface. Corners stay: group
// points, junctions, ends, turns above `crease`, changes of group along a curve, pinned vertices.
// Open seams: the vertices of both sides stay, and an edge is halved together with the one that it is sewn to, so that the
// sides have as many nodes at the same fractions; new nodes are new pairs. No edges are made that would coincide after a weld.
// The vertices of a group of dimension 1 or 2 are those of its segments or triangles, and others that it has, which stay.
//
// Contact. `clearance` says how far the surface may move. A split moves nothing, but on a curved rest shape or line its new
// vertex lies off the edge as it does at rest, where there is room, and is charged with that. Every other operation is measured:
// the old and the new piecewise linear surface at equal material points, largest at the corners of their overlay. Each
// triangle carries what its points have moved at most and what they may; an operation beyond that is left out.
//
// The same on every machine that rounds the same; ties go to the lower number. Operations are serial.
// Source: Botsch & Kobbelt, Symp. Geometry Processing (2004); Narain, Samii & O'Brien, ACM TOG 31 (2012).
#pragma once

#include <array>
#include <vector>

#include "mesh/surface_mesh.hpp"
#include "rest_surface.hpp"

namespace voile::adapt {

/// What must be respected, on the mesh as it is. Every list may be empty: nothing.
struct Limits {
  std::vector<char> frozen;       ///< per triangle: stays as it is
  std::vector<char> pinned;       ///< per vertex: stays where it is
  std::vector<double> clearance;  ///< per vertex [m]: how far the surface beside it may move; infinity: anywhere
};

struct Options {
  double split = 1.4;             ///< of L/h
  double collapse = 0.65;         ///< of L/h
  double longest_after = 1.26;    ///< of L/h of the edges that a collapse makes: 0.9 of `split`
  double shortest = 0.72;         ///< of L/h of the edges that are left, where that can be
  double longest_at_last = 1.38;  ///< as `longest_after`, for edges below `shortest` that nothing else has made longer
  int rounds = 4;                 ///< at most
  bool only_splits = false;       ///< neither collapses nor flips nor smoothing
  bool smoothing = true;
  double crease = 0.5235987755982988;          ///< [rad] 30 degrees
  double largest_flip = 0.6981317007977318;    ///< [rad] dihedral angle in space above which no edge is flipped
  double smallest_angle = 0.3490658503988659;  ///< [rad] that no operation may go below, unless it was below before
};

struct Counts {
  Index splits = 0, collapses = 0, flips = 0, smoothed = 0;
  Index refused_by_clearance = 0, refused_by_quality = 0, refused_by_feature = 0;
  int rounds = 0;
};

/// Of the new mesh, in the rest charts.
struct Quality {
  double smallest_angle = 0.0;                ///< [rad]
  double percent_angle = 0.0;                 ///< [rad] below which 1 % of the triangles have their smallest angle
  double largest_condition = 0.0;             ///< of complete patches, see energy/curvature.hpp
  Index ill_conditioned = 0;                  ///< complete patches of a condition above 30
  Index valence_three = 0, valence_four = 0;  ///< inner vertices
};

struct Remeshed {
  /// A place in the old mesh: a triangle and barycentric weights, none negative.
  struct Source {
    Index triangle = no_index;
    std::array<double, 3> weights{};
  };
  mesh::MeshData mesh;            ///< positions: at rest, or where the mesh has charts, interpolated from the old ones;
                                  ///< open seams with their pairs in new numbers
  std::vector<Index> kept;        ///< per vertex: the old vertex that it is, or no_index
  std::vector<Source> source;     ///< per vertex: its material point; on features, a point of the old feature
  std::vector<Vec3> places;       ///< per vertex [m]: on the surface that `clearance` speaks of; kept: bitwise
  std::vector<double> clearance;  ///< per vertex [m]: what is left of it; empty if there was none
  std::vector<Index> same_triangle;  ///< per triangle: the old triangle with the same corners, or no_index
  Counts counts;
  Quality quality;
};

/// `places` per vertex [m]: where vertices are now. `size` per vertex [m] > 0. Kept vertices come first, in their old
/// order, then new ones; triangles that stay come first in their old order.
/// Not collective. Throws InternalError if the lengths of arrays do not fit.
[[nodiscard]] Remeshed remesh(const mesh::SurfaceMesh& mesh, const RestSurface& rest, const std::vector<Vec3>& places,
                              const std::vector<double>& size, const Limits& limits, const Options& options = {});

}  // namespace voile::adapt
