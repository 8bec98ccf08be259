// Shapes of letters, from a TrueType file in memory; private to src/picture.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

namespace voile::picture {

class Typeface {
 public:
  /// `file` must stay. Throws InternalError if it is no TrueType file.
  explicit Typeface(const unsigned char* file);
  ~Typeface();
  Typeface(const Typeface&) = delete;
  Typeface& operator=(const Typeface&) = delete;

  /// How far the pen goes on [pixels].
  [[nodiscard]] double advance(std::uint32_t character, double size) const;
  /// How much of each pixel a letter covers (0 to 255), and where its upper left pixel is from the pen.
  struct Glyph {
    int left = 0, top = 0, width = 0, height = 0;
    std::vector<std::uint8_t> cover;
  };
  /// `shift`: of the pen to the right, 0 to 1 pixel.
  [[nodiscard]] Glyph glyph(std::uint32_t character, double size, double shift) const;

 private:
  struct Font;
  std::unique_ptr<Font> font_;
};

}  // namespace voile::picture
