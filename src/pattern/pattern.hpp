// Sewing patterns as files hold them: pieces with their outlines, places and stitches.
//
// Symbols   (x, y)  coordinates in the plane of a piece [m], y up      X = R (x, y, 0) + t  its place in the file's space
// A piece has an outline and may have holes, each a closed loop of edges, either way round; edges count through all loops in the order of the
// file, and edge k begins at point k. A piece that unfolds across an edge is drawn to
// half: its edges count from the one after the fold, round the half and then round its mirror image; then come the holes. The right side of the
// fabric is where z > 0, or z < 0 if the piece is `turned`.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "curve.hpp"
#include "geometry/closest_triangle.hpp"

namespace voile::pattern {

struct Edge {
  Curve curve;
  std::string label{};  ///< of the file; may be empty or that of others too
};

/// A piece that its file does not lay flat in space: triangles in its plane, and where they are.
class BentShape {
 public:
  BentShape(const std::vector<Vec2>& plane, std::vector<Vec3> space, std::vector<mesh::Triangle> triangles);
  /// Linear in each triangle; beside them as at their nearest point. [m]
  [[nodiscard]] Vec3 at(const Vec2& x) const;

 private:
  std::vector<Vec3> plane_, space_;  ///< [m]
  std::vector<mesh::Triangle> triangles_;
  geometry::ClosestTriangle closest_;
};

struct Piece {
  std::string name;
  std::vector<Edge> edges;                   ///< of all loops
  std::vector<std::size_t> further_loops{};  ///< the first edge of each loop but the first
  /// Of the points, one each or none: of a DXF the corners c0, c1, ... and the notches n0, n1, ..., mirrored ones with '.
  std::vector<std::string> point_names{};
  Vec2 grain = Vec2::UnitY();  ///< direction of the grain line in the plane of the piece, a unit vector
  bool turned = false;
  Mat3 rotation = Mat3::Identity();         ///< R
  Vec3 translation = Vec3::Zero();          ///< t [m]
  std::shared_ptr<const BentShape> bent{};  ///< instead of R and t, which are then 1 and 0

  /// Edges begin to end - 1.
  struct Loop {
    std::size_t begin, end;
  };

  [[nodiscard]] Vec2 point(std::size_t k) const { return edges[k % edges.size()].curve.start(); }
  void add_loop(std::vector<Edge> loop);
  [[nodiscard]] std::vector<Loop> loops() const;
  [[nodiscard]] Loop loop_of(std::size_t edge) const;
  /// Of loops(), that which goes round the largest area; the others are holes.
  [[nodiscard]] std::size_t outline() const;
  [[nodiscard]] bool is_in_outline(std::size_t edge) const;
  /// The edge that begins where this one ends.
  [[nodiscard]] std::size_t next(std::size_t edge) const;
  /// By Green's theorem, positive if the loop goes round counter-clockwise. [m^2]
  [[nodiscard]] double signed_area(const Loop& loop) const;
  /// Without the holes, with the sign of the outline. [m^2]
  [[nodiscard]] double signed_area() const;
};

/// One edge of a file's stitch.
struct StitchEnd {
  std::string piece;
  std::size_t edge = 0;
};

/// Which ends of the two edges of a stitch meet.
enum class Sense {
  against,  ///< the start of one meets the end of the other, as between neighbours
  along,    ///< start meets start
  nearest   ///< the file does not say
};

struct Stitch {
  std::array<StitchEnd, 2> sides;
  Sense sense = Sense::against;
  std::size_t number = 0;  ///< in the file
};

struct Pattern {
  std::filesystem::path file;
  std::vector<Piece> pieces;
  std::vector<Stitch> stitches;    ///< those of which a side at least is among the pieces
  std::vector<std::string> notes;  ///< what a user should know
};

struct ReadOptions {
  double unit = 0.0;                  ///< length of the file's unit [m]; 0: as the file says
  bool euler_xyz = false;             ///< R = Rx Ry Rz instead of Rz Ry Rx
  std::vector<std::string> pieces{};  ///< names of those wanted; empty: all
  std::string unfold{};               ///< edge, by number or label, across which each piece unfolds; empty: none
  double texture_unit = 0.0;          ///< length of 1 in texture coordinates of an .obj [m]; 0: as its vertices say
  std::map<std::string, double> parameters{};  ///< of a .geo
  bool allow_system_call = false;              ///< of a .geo, see formats/geo_safety.hpp
  std::string nest_size{};                     ///< of a .dxf whose blocks are of several; empty: all
};

/// Reads a GarmentCode .json, an .svg, an ASCII .dxf, a Gmsh .geo or an .obj with texture coordinates. Loops are checked: closed, no edge without length, no crossing, holes inside of
/// the outline and not of each other. Stitches of
/// pieces that are not wanted are left out. Throws UserError that names file, piece, edge and remedy.
[[nodiscard]] Pattern read_pattern(const std::filesystem::path& file, const ReadOptions& options);

}  // namespace voile::pattern
