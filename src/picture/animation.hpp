// Animations as files: WebP and GIF by their libraries, MP4 by the program ffmpeg if it is there.
#pragma once

#include <filesystem>
#include <memory>

#include "image.hpp"

namespace voile::picture {

class AnimationWriter {
 public:
  virtual ~AnimationWriter() = default;
  /// Pictures of one size.
  virtual void add(const Image& frame) = 0;
  /// Ends the file. Throws UserError if it cannot be written.
  virtual void finish() = 0;
};

/// The ending of `file` says which: .webp, .gif or .mp4. `rate`: frames per second. Animations repeat for ever.
/// Throws UserError for another ending, and for .mp4 without ffmpeg.
[[nodiscard]] std::unique_ptr<AnimationWriter> make_animation(const std::filesystem::path& file, double rate);

}  // namespace voile::picture
