// A picture in memory, its file formats, and colours.
//
// Colours are linear light (Rgb, 0 to 1) while they are mixed, and sRGB bytes in an Image.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "base/types.hpp"

namespace voile::picture {

using Rgb = Eigen::Vector3f;
using Vec3f = Eigen::Vector3f;
using Bytes3 = std::array<std::uint8_t, 3>;

[[nodiscard]] std::vector<Vec3f> single(const std::vector<Vec3>& points);

/// From linear light to sRGB and back; values outside 0 to 1 are cut off.
[[nodiscard]] Bytes3 to_bytes(const Rgb& linear);
[[nodiscard]] Rgb from_bytes(const Bytes3& srgb);

/// Rows from top to bottom, three bytes a pixel.
class Image {
 public:
  Image() = default;
  /// Throws UserError if the size is not sensible.
  Image(int width, int height, const Bytes3& colour = {255, 255, 255});

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] std::uint8_t* at(int x, int y) { return bytes_.data() + 3 * offset(x, y); }
  [[nodiscard]] const std::uint8_t* at(int x, int y) const { return bytes_.data() + 3 * offset(x, y); }
  [[nodiscard]] bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < width_ && y < height_; }
  /// Mixes a colour in; what lies outside is left away. `cover` 0 to 1.
  void blend(int x, int y, const Bytes3& colour, float cover);
  /// A filled rectangle of w x h pixels.
  void fill(int x, int y, int w, int h, const Bytes3& colour, float cover = 1.0F);
  /// Puts another picture with its upper left corner there; what lies outside is left away.
  void paste(const Image& other, int x, int y);

 private:
  [[nodiscard]] std::size_t offset(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  int width_ = 0, height_ = 0;
  std::vector<std::uint8_t> bytes_;
};

/// `palette`: with 256 colours at most, which makes the file two to three times smaller. Throws UserError if the name
/// ends in anything but .png (or .part, for what is renamed later), or the file cannot be written.
void write_png(const std::filesystem::path& file, const Image& image, bool palette = false);
/// The same in memory.
[[nodiscard]] std::vector<char> png_bytes(const Image& image);
/// Throws UserError if the file is not a PNG that can be read.
[[nodiscard]] Image read_png(const std::filesystem::path& file);

/// Pictures beside each other, row by row; each in the middle of its place, which is as large as the largest in its row and column.
/// Throws UserError if there are none or they are too large together.
[[nodiscard]] Image sheet_of(const std::vector<Image>& pictures, int columns);

}  // namespace voile::picture
