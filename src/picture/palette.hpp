// Pictures of 256 colours, for GIF; private to src/picture.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "image.hpp"

namespace voile::picture {

/// Up to 256 colours for a picture, by cutting the box of its colours at medians, and the nearest of them for each pixel,
/// with an ordered dither that stays where it is from frame to frame.
struct Reduced {
  std::vector<Bytes3> palette;
  std::vector<std::uint8_t> pixels;
};
[[nodiscard]] Reduced reduce(const Image& image);

}  // namespace voile::picture
