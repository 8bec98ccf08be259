#include "lettering.hpp"

#include <cmath>
#include <cstdint>

#include "truetype.hpp"
#include "voile/errors.hpp"

// The typeface's file, as the assembler has put it into the program (CMakeLists.txt).
extern "C" const unsigned char voile_typeface[];

namespace voile::picture {

namespace {

/// Unicode of the next character; a broken sequence gives its bytes one by one.
std::uint32_t next_character(const std::string& text, std::size_t& at) {
  const auto byte = [&](std::size_t i) -> std::uint32_t { return static_cast<unsigned char>(text[i]); };
  const std::uint32_t first = byte(at++);
  const int more = first >= 0xF0U ? 3 : first >= 0xE0U ? 2 : first >= 0xC0U ? 1 : 0;
  std::uint32_t code = more == 0 ? first : first & (0x3FU >> static_cast<unsigned>(more));
  for (int i = 0; i < more && at < text.size() && (byte(at) & 0xC0U) == 0x80U; ++i)
    code = code << 6U | (byte(at++) & 0x3FU);
  return code;
}

const Typeface& typeface() {
  static const Typeface face(voile_typeface);
  return face;
}

}  // namespace

double text_width(const std::string& text, double size) {
  double width = 0.0;
  for (std::size_t at = 0; at < text.size();) width += typeface().advance(next_character(text, at), size);
  return width;
}

void draw_text(Image& image, double x, double y, const std::string& text, double size, const Bytes3& colour,
               Align align) {
  if (align != Align::left) x -= text_width(text, size) * (align == Align::right ? 1.0 : 0.5);
  for (std::size_t at = 0; at < text.size();) {
    const std::uint32_t character = next_character(text, at);
    const Typeface::Glyph glyph = typeface().glyph(character, size, x - std::floor(x));
    for (int j = 0; j < glyph.height; ++j)
      for (int i = 0; i < glyph.width; ++i) {
        const float cover = static_cast<float>(glyph.cover[static_cast<std::size_t>(j * glyph.width + i)]) / 255.0F;
        image.blend(static_cast<int>(std::floor(x)) + glyph.left + i, static_cast<int>(std::lround(y)) + glyph.top + j,
                    colour, cover);
      }
    x += typeface().advance(character, size);
  }
}

}  // namespace voile::picture
