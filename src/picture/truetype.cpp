#include "truetype.hpp"

#define STB_TRUETYPE_IMPLEMENTATION
#define STBTT_STATIC
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_truetype.h>
#pragma GCC diagnostic pop

#include "voile/errors.hpp"

namespace voile::picture {

struct Typeface::Font {
  stbtt_fontinfo info{};
  [[nodiscard]] float scale(double size) const { return stbtt_ScaleForPixelHeight(&info, static_cast<float>(size)); }
};

Typeface::Typeface(const unsigned char* file) : font_(std::make_unique<Font>()) {
  if (!stbtt_InitFont(&font_->info, file, stbtt_GetFontOffsetForIndex(file, 0)))
    throw InternalError("the typeface of the program cannot be read");
}
Typeface::~Typeface() = default;

double Typeface::advance(std::uint32_t character, double size) const {
  int width = 0, bearing = 0;
  stbtt_GetCodepointHMetrics(&font_->info, static_cast<int>(character), &width, &bearing);
  return font_->scale(size) * width;
}

Typeface::Glyph Typeface::glyph(std::uint32_t character, double size, double shift) const {
  const float scale = font_->scale(size), right = static_cast<float>(shift);
  const int code = static_cast<int>(character);
  Glyph g;
  int x1 = 0, y1 = 0;
  stbtt_GetCodepointBitmapBoxSubpixel(&font_->info, code, scale, scale, right, 0.0F, &g.left, &g.top, &x1, &y1);
  g.width = x1 - g.left;
  g.height = y1 - g.top;
  if (g.width <= 0 || g.height <= 0) return Glyph{};
  g.cover.resize(static_cast<std::size_t>(g.width) * static_cast<std::size_t>(g.height));
  stbtt_MakeCodepointBitmapSubpixel(&font_->info, g.cover.data(), g.width, g.height, g.width, scale, scale, right, 0.0F,
                                    code);
  return g;
}

}  // namespace voile::picture
