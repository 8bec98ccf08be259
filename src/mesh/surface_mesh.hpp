// Triangulated surface: connectivity, named groups, edge adjacency; its shape at rest and its place at the start.
//
// Symbols   x_v   place of vertex v at the start, from which displacements count                                   [m]
//           X_Ti  rest position of corner i of triangle T; x_v of its vertex unless the mesh says otherwise        [m]
//           T     triangle with vertices (v0, v1, v2), counter-clockwise seen from the side its normal points to
//           side s of T is opposite to its vertex s: from v_(s+1) to v_(s+2) (indices modulo 3)
//           apex across side s: the vertex of the neighbouring triangle that is not on the side
// A chart is a part of the surface whose rest corners lie in one space: a panel of a garment. Neighbours are in the same
// chart if their rest corners agree on the common side; otherwise that side is a seam. Across a seam the sheet is flat at
// rest, and the chart of one neighbour is carried to that of the other by the rigid motion, and if the lengths of the side
// differ the similarity, that puts side on side.
// A joint is an edge of three or more triangles, of two that cannot be oriented alike, or a hinge. A sheet ends there: a
// triangle has no neighbour across it. Charts meet in joints where a seam has three layers or more: at rest each lies on one
// of two sides of the edge, flat against those on the other side.
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "base/types.hpp"

namespace voile::mesh {

using Triangle = std::array<Index, 3>;
using Segment = std::array<Index, 2>;

/// An edge as a key: the lower vertex first.
[[nodiscard]] inline Segment ascending(Index a, Index b) {
  return {std::min(a, b), std::max(a, b)};
}

/// A side of a triangle.
struct TriangleSide {
  Index triangle = no_index;
  int side = 0;
  auto operator<=>(const TriangleSide&) const = default;
};

/// An edge at which sheets are joined.
struct Joint {
  Segment edge{};                   ///< ascending
  std::vector<TriangleSide> sides;  ///< that meet there, by ascending triangle
};

/// A physical group of the mesh file. Only the members of its own dimension are stored by the reader.
struct Group {
  std::string name;
  int dimension = 0;              ///< 0 points, 1 curves, 2 surfaces
  std::vector<Index> vertices;    ///< all vertices of the group, ascending, without repetition
  std::vector<Segment> segments;  ///< its line elements (dimension 1)
  std::vector<Index> triangles;   ///< its triangles (dimension 2), ascending
  std::vector<Index> added{};     ///< of the vertices those that the file does not name: a tie divides its lines there

  /// Where what acts on each of its vertices does: those that the file names.
  [[nodiscard]] std::vector<Index> places() const {
    std::vector<Index> of;
    std::set_difference(vertices.begin(), vertices.end(), added.begin(), added.end(), std::back_inserter(of));
    return of;
  }
};

/// Vertices that are to become one: the two sides of a line along which pieces are sewn together. Open until weld()
/// (mesh/weld.hpp) has made one of each pair.
struct Seam {
  std::string name;
  std::vector<std::array<Index, 2>> pairs;  ///< two different vertices each
  std::vector<double> lengths;              ///< rest length of the seam that each pair stands for [m]
  std::vector<double> stations{};           ///< of each pair along the seam, from its beginning [m]
};

/// What a mesh file holds, before any check of topology.
struct MeshData {
  std::string source;           ///< file name for messages
  std::vector<Vec3> positions;  ///< [m]
  std::vector<Triangle> triangles;
  std::vector<Group> groups;
  std::vector<std::size_t> vertex_tags;    ///< number of each vertex in the file, for messages
  std::vector<std::size_t> triangle_tags;  ///< number of each triangle in the file, for messages
  /// Texture coordinates of each corner, where the file has them: the flat piece that a garment is cut from. Empty:
  /// none.
  std::vector<std::array<Vec2, 3>> texture;
  /// Rest position of each corner [m]: charts. Empty: the positions are the rest shape too.
  std::vector<std::array<Vec3, 3>> rest;
  std::vector<Seam> seams;       ///< that are open
  std::vector<Segment> hinges;   ///< edges of two triangles that are joints, each ascending, in order
  std::vector<Segment> borders;  ///< likewise, round what is clamped
  /// Of charts: sides of triangles on seams of three layers that lie on the second side of the edge at rest; all other sides there
  /// lie on the first.
  std::vector<TriangleSide> folded;
  bool finds_boundary = false;     ///< groups 'boundary', 'boundary-1', ... are whatever boundary edges there are
  std::vector<std::string> notes;  ///< what the reader changed or made up, for the user; on the rank that read
};

/// How the chart of a neighbour joins that of a triangle across their common side.
struct Join {
  bool same_chart = true;
  double stretch = 1.0;          ///< length of the side in the chart of the triangle over that in the neighbour's
  Mat3 turn = Mat3::Identity();  ///< takes directions in the neighbour's chart to that of the triangle
};

/// Area of a triangle in space [m^2].
[[nodiscard]] double triangle_area(const Vec3& a, const Vec3& b, const Vec3& c);

/// Immutable triangulation with boundary, oriented between its joints. Replicated on every rank.
class SurfaceMesh {
 public:
  /// Checks topology and geometry, repairs inconsistent orientation and drops nothing.
  /// Throws UserError naming the entities: duplicate or degenerate triangles, vertices without a triangle, segments of a
  /// group that are no edges, seams whose two sides differ too much in length, joints where the rest shape is apart.
  explicit SurfaceMesh(MeshData data);

  [[nodiscard]] Index vertex_count() const { return static_cast<Index>(data_.positions.size()); }
  [[nodiscard]] Index triangle_count() const { return static_cast<Index>(data_.triangles.size()); }
  /// Places at the start, the origin of displacements [m].
  [[nodiscard]] const std::vector<Vec3>& positions() const { return data_.positions; }
  /// Whether the rest shape is given apart from the positions.
  [[nodiscard]] bool has_charts() const { return !data_.rest.empty(); }
  [[nodiscard]] const std::vector<Triangle>& triangles() const { return data_.triangles; }
  [[nodiscard]] const std::vector<Group>& groups() const { return data_.groups; }
  [[nodiscard]] const MeshData& data() const { return data_; }
  [[nodiscard]] const std::string& source() const { return data_.source; }

  /// Neighbour of triangle t across its side s, or no_index on the boundary and at joints.
  [[nodiscard]] Index neighbour(Index t, int s) const { return neighbours_[static_cast<std::size_t>(t)][s]; }
  /// Vertex of that neighbour opposite to the shared side, or no_index.
  [[nodiscard]] Index apex(Index t, int s) const;
  /// Side of neighbour(t, s) that it shares with t. Requires a neighbour.
  [[nodiscard]] int side_in_neighbour(Index t, int s) const { return shared_side_[static_cast<std::size_t>(t)][s]; }

  /// Edges at which sheets are joined, ascending.
  [[nodiscard]] const std::vector<Joint>& joints() const { return joints_; }
  [[nodiscard]] bool is_joint(Index t, int s) const;
  /// Whether a side is among data().folded.
  [[nodiscard]] bool is_folded(const TriangleSide& side) const {
    return std::binary_search(data_.folded.begin(), data_.folded.end(), side);
  }

  /// Group of that name and dimension (dimension -1: the lowest that there is). Throws UserError that lists the names there are.
  [[nodiscard]] const Group& group(const std::string& name, int dimension = -1) const;
  [[nodiscard]] bool has_group(const std::string& name) const;

  /// How many triangles were turned round to orient the surface consistently.
  [[nodiscard]] Index reoriented_count() const { return reoriented_; }
  /// Number of pieces of the surface that are connected through edges.
  [[nodiscard]] Index component_count() const { return components_; }

  /// Triangles around vertex v, ascending.
  [[nodiscard]] std::vector<Index> triangles_of_vertex(Index v) const;

  // The rest shape, in the chart of triangle t
  [[nodiscard]] Vec3 rest_corner(Index t, int i) const {
    return data_.rest.empty() ? start_corner(t, i)
                              : data_.rest[static_cast<std::size_t>(t)][static_cast<std::size_t>(i)];
  }
  [[nodiscard]] Vec3 rest_normal(Index t) const;
  /// Rest area [m^2].
  [[nodiscard]] double area(Index t) const;
  /// Rest length of an edge [m]: the mean where its two sides differ.
  [[nodiscard]] double rest_length(const Segment& edge) const;
  /// How the neighbour across side s joins t. Requires a neighbour.
  [[nodiscard]] Join chart_join(Index t, int s) const;
  /// Whether the rest corners of t are its places at the start.
  [[nodiscard]] bool starts_at_rest(Index t) const;

  // The start
  [[nodiscard]] Vec3 start_corner(Index t, int i) const { return data_.positions[data_.triangles[t][i]]; }
  [[nodiscard]] Vec3 start_normal(Index t) const;

  /// Side of triangle t whose end points are {a, b} in either order, or -1.
  [[nodiscard]] int side_of(Index t, Index a, Index b) const;
  /// Diagonal of the bounding box at the start [m].
  [[nodiscard]] double extent() const;

 private:
  void check_geometry() const;
  void check_charts() const;
  void build_adjacency();
  void orient();
  void spread_orientation(Index t, std::vector<Index>& members, std::vector<char>& seen, std::vector<char>& flip);
  void count_components();
  void check_joints_of_charts() const;
  [[nodiscard]] std::string joint_text(const Joint& joint) const;
  void build_vertex_triangles();
  void check_groups() const;

  MeshData data_;
  std::vector<std::array<Index, 3>> neighbours_;
  std::vector<std::array<int, 3>> shared_side_;
  std::vector<Joint> joints_;
  std::vector<Segment> twisted_;  ///< edges of two triangles that cannot be oriented alike, ascending
  std::vector<Index> vertex_triangle_start_, vertex_triangles_;
  Index reoriented_ = 0;
  Index components_ = 0;
};

}  // namespace voile::mesh
