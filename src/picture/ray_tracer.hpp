// Pictures of a scene by rays, on the processor alone (Embree): soft shadow of one lamp, light of the sky, ground.
//
// Light and colour of a pixel are kept apart. The light is noisy, being taken from a few rays, and is smoothed along surfaces
// before it meets the colour, so that edges, lines and colours stay sharp.
#pragma once

#include "camera.hpp"
#include "scene.hpp"

namespace voile::picture {

struct Quality {
  int samples = 4;       ///< rays from the eye per pixel
  int edge_samples = 4;  ///< further ones where something ends
  int sky_rays = 2;      ///< per ray from the eye, for ambient occlusion
  int passes = 3;        ///< of the filter of light
  static Quality draft() { return {1, 3, 2, 4}; }
  static Quality final() { return {5, 5, 3, 4}; }
};

/// `threads`: 0 takes one for each core. The same picture for any number of threads.
[[nodiscard]] Image render(const Scene& scene, const Camera& camera, int width, int height, const Quality& quality,
                           int threads = 0);

}  // namespace voile::picture
