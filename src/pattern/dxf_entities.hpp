// The entities of an ASCII DXF, before anything is made of them; private to src/pattern.
//
// A DXF is a list of groups, each a code and a text on two lines; code 0 begins an entity (Autodesk, DXF Reference).
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "curve.hpp"

namespace voile::pattern {

struct DxfGroup {
  int code = 0;
  std::string text;
  std::size_t line = 0;  ///< of the text, from 1
};

struct DxfEntity {
  std::string type, layer, where;  ///< where: for messages
  std::vector<DxfGroup> groups;
  std::vector<DxfEntity> vertices{};  ///< of a POLYLINE

  [[nodiscard]] bool has(int code) const;
  /// The first group of a code as a number. Throws UserError if it is none, or not finite.
  [[nodiscard]] double real(int code, double absent) const;
  [[nodiscard]] int whole(int code, int absent) const;
  [[nodiscard]] std::string text(int code) const;
  /// All groups of a code.
  [[nodiscard]] std::vector<double> reals(int code) const;
  /// The numbers of these two groups, which must be there.
  [[nodiscard]] Vec2 point(int x, int y) const;
  [[noreturn]] void fail(const std::string& message) const;
};

struct DxfBlock {
  std::string name;
  std::vector<DxfEntity> entities;
};

struct DxfFile {
  std::map<std::string, std::string> variables;  ///< of the header, those of one group
  std::vector<DxfBlock> blocks;
  std::vector<DxfEntity> entities;
  std::vector<std::string> notes;  ///< if it seems to be cut short
};

/// Not collective, as all of this layer. Throws UserError that names file and line.
[[nodiscard]] DxfFile read_dxf_entities(const std::filesystem::path& file);

/// What an entity draws, in the file's units, in the order in which it is drawn: nothing if it is no curve. A spline is one
/// curve. Points that repeat, or lie nearer than ends of curves that meet, are
/// left out, and so are slits: where a polyline goes out and back on the same way, as a notch; `slits` gets the points where
/// they begin, if it is not null. Throws UserError for curves of other kinds than lines, arcs and polynomial splines
/// of the third degree at most, and for those that do not lie in the plane of the drawing.
[[nodiscard]] std::vector<Curve> curves_of(const DxfEntity& entity, std::vector<Vec2>* slits = nullptr);

/// Joins curves to outlines, turning them where needed: each begins where the one before it ends, the last one ends where
/// the first one begins. `bridge`: straight lines, prolonged; an outline whose two
/// ends lie on one of them is closed along it. Throws UserError if one stays open or branches.
[[nodiscard]] std::vector<std::vector<Curve>> join_curves(const std::string& where, std::vector<Curve> curves,
                                                          const std::vector<Curve>& bridge);

}  // namespace voile::pattern
