// Readers of pattern files, before any check of outlines; private to src/pattern.
#pragma once

#include "voile/pattern/pattern.hpp"

namespace voile::pattern {

[[nodiscard]] Pattern read_garmentcode(const std::filesystem::path& file, const ReadOptions& options);
[[nodiscard]] Pattern read_svg(const std::filesystem::path& file, const ReadOptions& options);

/// Commands of an SVG path as curves in its own coordinates, lines to close it included. `where`: for messages. Throws
/// UserError for what is no path, for several outlines, and for one that is open.
[[nodiscard]] std::vector<Curve> read_svg_path(const std::string& where, const std::string& commands);
/// An arc as SVG gives it, from a to b: half axes, turn of the first axis [rad], flags.
[[nodiscard]] Curve svg_arc(const Vec2& a, const Vec2& b, Vec2 radii, double turn, bool large, bool sweep);

/// A whole file. Throws UserError if it cannot be read or is empty.
[[nodiscard]] std::string text_of(const std::filesystem::path& file);

}  // namespace voile::pattern
