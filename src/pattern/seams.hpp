// Panels in space, and the lines along which they are sewn.
//
// Symbols   f   fraction of the length of a side of a seam, from 0 at one end to 1 at the other
// Points of the two sides with the same f meet; where corners of both sides lie nearly opposite to each other they meet,
// and f is interpolated between.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "pattern.hpp"

namespace voile::pattern {

/// Cells along a curved edge, at least.
constexpr int least_on_curve = 4;

/// A cylinder or cone onto which planes parallel to its axis are bent without stretch. The line of the plane that is nearest to
/// the axis becomes a straight line of the surface, on the same side of the axis; its point at the height of `point` comes to the distance `radius`
/// from the axis, and of a cone it leans about that point.
struct Wrap {
  Vec3 axis = Vec3::UnitZ();  ///< a unit vector
  Vec3 point = Vec3::Zero();  ///< on the axis [m]
  double radius = 0.0;        ///< at that point [m]; 0: the distance of the plane from the axis
  double half_angle = 0.0;    ///< of a cone [rad], positive if it widens along the axis; 0: a cylinder
};

/// A piece that is cut, and where it begins.
struct Panel {
  Piece piece;
  std::string file;              ///< for messages
  double size = 0.02;            ///< of cells [m]
  Mat3 turn = Mat3::Identity();  ///< of the scene against the file
  Vec3 shift = Vec3::Zero();     ///< [m]
  std::optional<Wrap> wrap{};
  double outwards = 0.0;  ///< of its place: away from the axis of its wrap, or to its right side [m]

  /// Place in the scene of a point of the piece. Not collective, as all of this layer. [m]
  [[nodiscard]] Vec3 place(const Vec2& x) const;
  [[nodiscard]] Vec3 flat_place(const Vec2& x) const;  ///< before it is wrapped
  /// Throws UserError if the piece cannot be wrapped as asked.
  void check_wrap() const;
};

/// Place of a point "PIECE@POINT" before its piece is wrapped [m]. Throws UserError that begins with `where`.
[[nodiscard]] Vec3 flat_place(const std::vector<Panel>& panels, const std::string& where, const std::string& point);

/// What is asked for: names as a case writes them, or a stitch of a file.
struct SeamRequest {
  std::string name{}, where;           ///< of the seam; empty: made of its edges. For messages
  std::vector<std::string> edges, to;  ///< "PANEL/EDGE", or "PANEL/POINT..POINT"
  std::vector<std::string> meet{};     ///< two points "PANEL@POINT", or empty
  Sense sense = Sense::nearest;        ///< of single edges, where `meet` is empty
};

/// One request for each text that the `*` in names of pieces stands for, the same on both sides; without a `*` the request itself.
/// Throws UserError where no piece matches, or other texts do on the two sides.
[[nodiscard]] std::vector<SeamRequest> with_stars_replaced(const std::vector<Panel>& panels,
                                                           const SeamRequest& request);

/// The name it was given, or one made of the first edge of each side.
[[nodiscard]] std::string seam_name(const std::string& given, const std::vector<std::string>& edges,
                                    const std::vector<std::string>& to);

/// One edge as part of a side.
struct EdgeUse {
  std::size_t panel = 0, edge = 0;
  bool reversed = false;
};

struct SeamLine {
  std::string name;
  std::array<std::vector<EdgeUse>, 2> sides;  ///< in the order in which they meet
  std::array<double, 2> lengths{};            ///< [m]
  double farthest = 0.0;                      ///< of two points that meet, at the start [m]
};

struct Seams {
  std::vector<SeamLine> lines;
  std::vector<std::string> notes;  ///< what was chosen, and ratios of lengths that are unusual
};

/// An edge in several seams is where more than two layers meet.
/// Throws UserError that names seam, panel and edge: unknown names, an edge sewn to itself or twice to another, a dart without a common tip,
/// lengths that differ more than fourfold, a chain of panels that closes with a twist.
[[nodiscard]] Seams resolve_seams(const std::vector<Panel>& panels, const std::vector<SeamRequest>& requests);

/// Of each seam: fractions of the length of each side at which its nodes lie, ascending from 0 to 1, as many on both. Cells are
/// at most as long as the smallest size of its panels asks for; seams with a common edge have the same nodes there. Throws
/// UserError where corners of three layers lie too near to each other.
[[nodiscard]] std::vector<std::array<std::vector<double>, 2>> seam_nodes(const std::vector<Panel>& panels,
                                                                         const std::vector<SeamLine>& seams);

[[nodiscard]] double length_of(const std::vector<Panel>& panels, const std::vector<EdgeUse>& side);

}  // namespace voile::pattern
