// Readers of pattern files, before any check of outlines; private to src/pattern.
#pragma once

#include <optional>

#include "pattern.hpp"

namespace voile::pattern {

[[nodiscard]] Pattern read_garmentcode(const std::filesystem::path& file, const ReadOptions& options);
[[nodiscard]] Pattern read_svg(const std::filesystem::path& file, const ReadOptions& options);

[[nodiscard]] Pattern read_dxf(const std::filesystem::path& file, const ReadOptions& options);

[[nodiscard]] Pattern read_geo(const std::filesystem::path& file, const ReadOptions& options);

[[nodiscard]] Pattern read_obj(const std::filesystem::path& file, const ReadOptions& options);

/// A half becomes the whole: its edges from the one after `fold` on, then their mirror images, whose names end in '; then
/// each hole and its mirror image, or one hole of both where an edge of it lies on the fold line.
/// Returns the new number of each edge, `no_edge` for those on the fold line. `where`: for messages. Throws UserError if the
/// fold is not straight, or an edge of a hole.
std::vector<std::size_t> unfold(const std::string& where, Piece& piece, std::size_t fold);
inline constexpr std::size_t no_edge = static_cast<std::size_t>(-1);
/// The same for all pieces, by number or label of the edge. Stitches follow, those of the fold line are left out. Throws
/// UserError for unknown edges.
void unfold_pieces(Pattern& pattern, const std::string& edge);

/// Throws UserError unless a piece has a size that patterns have, and an outline and holes that do not cross.
void check_piece(const Pattern& pattern, const Piece& piece);

/// A whole number below `end`, or nothing.
[[nodiscard]] std::optional<std::size_t> number_below(const std::string& text, std::size_t end);

/// Closed loops of an SVG path as curves in its own coordinates, lines to close them included. `where`: for messages. Throws
/// UserError for what is no path, and for a loop that is open.
[[nodiscard]] std::vector<std::vector<Curve>> read_svg_path(const std::string& where, const std::string& commands);
/// An arc as SVG gives it, from a to b: half axes, turn of the first axis [rad], flags.
[[nodiscard]] Curve svg_arc(const Vec2& a, const Vec2& b, Vec2 radii, double turn, bool large, bool sweep);

/// A whole file. Throws UserError if it cannot be read or is empty.
[[nodiscard]] std::string text_of(const std::filesystem::path& file);

}  // namespace voile::pattern
