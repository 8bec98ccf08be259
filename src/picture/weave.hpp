// The relief of a fabric as a tile that repeats: threads of warp and weft, or loops of a knit.
//
// Symbols   a, l   places across the warp and along it, in repeats of the tile
//           h      height of the surface over the sheet, in distances of threads
// What is finer than a pixel is replaced by its mean over the pixel (L. Williams, Pyramidal parametrics, SIGGRAPH 1983), taken
// at several places along the pixel's longer axis (as OpenGL's anisotropic filter), so that nothing flickers at a distance.
#pragma once

#include <vector>

#include "image.hpp"

namespace voile::picture {

enum class Weave { plain, twill, knit };

using Vec2f = Eigen::Vector2f;

/// What the relief is at a place, or its mean over one.
struct Relief {
  float shade = 1.0F;   ///< light that reaches it, of a mean of 1
  float across = 0.0F;  ///< slope dh/da
  float along = 0.0F;   ///< slope dh/dl
  float warp = 0.5F;    ///< fraction that is warp
};

/// Immutable; may be asked by several threads at once.
class WeaveTile {
 public:
  /// `back`: seen from the wrong side, in the same coordinates.
  WeaveTile(Weave weave, bool back);
  /// Size of a repeat in distances of threads: across and along.
  [[nodiscard]] static Vec2f repeat(Weave weave);
  /// Mean over a pixel that reaches from `place` - (u + v)/2 to `place` + (u + v)/2, all in repeats.
  [[nodiscard]] Relief mean(const Vec2f& place, const Vec2f& u, const Vec2f& v) const;
  /// Texels of the finest level along a side, and each of them: row along the warp, column across.
  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] const Relief& texel(int column, int row) const {
    return levels_
        .front()[static_cast<std::size_t>(row) * static_cast<std::size_t>(size_) + static_cast<std::size_t>(column)];
  }

 private:
  void add_levels();
  [[nodiscard]] Relief between(std::size_t level, const Vec2f& place) const;
  [[nodiscard]] Relief at_level(float level, const Vec2f& place) const;

  int size_;
  std::vector<std::vector<Relief>> levels_;  ///< each of half the side of the one before, down to 1
};

}  // namespace voile::picture
