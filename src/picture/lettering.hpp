// Text in pictures: one typeface (DejaVu Sans), which is part of the program.
#pragma once

#include <string>

#include "image.hpp"

namespace voile::picture {

/// Colour of letters and lines.
inline constexpr Bytes3 ink{38, 42, 48};

enum class Align { left, centre, right };

/// Width in pixels. `size`: height of a line [pixels]; `text` in UTF-8.
[[nodiscard]] double text_width(const std::string& text, double size);

/// Writes with the base line at y. Characters that the typeface lacks show as boxes.
void draw_text(Image& image, double x, double y, const std::string& text, double size, const Bytes3& colour,
               Align align = Align::left);

}  // namespace voile::picture
