// Smoothing of noisy light along surfaces; private to src/picture.
#pragma once

#include <functional>
#include <vector>

#include "image.hpp"

namespace voile::picture {

/// What a pixel shows, means over its samples.
struct Pixel {
  Rgb light{0, 0, 0};   ///< what falls on it
  Rgb colour{0, 0, 0};  ///< what it sends back of that
  Rgb seen{0, 0, 0};    ///< the mean of the products
  Rgb shine{0, 0, 0};   ///< light that does not take on the colour
  Vec3f normal{0, 0, 0};
  Vec3f point{0, 0, 0};
  float width = 0.0F;  ///< of the pixel at that depth [m]
  int surface = -1;    ///< which; -1: background, nothing to light
  bool pure = true;    ///< all samples saw the same smooth piece
};

/// Calls work(row) for every row, from that many threads.
void for_rows(int rows, int threads, const std::function<void(int)>& work);

/// Replaces the light of pure pixels by means over neighbours on the same smooth piece, `passes` times with twice the
/// reach each time (edge-avoiding a-trous wavelets: H. Dammertz et al., High Performance Graphics 2010).
void filter_light(std::vector<Pixel>& pixels, int width, int height, int passes, int threads);

}  // namespace voile::picture
