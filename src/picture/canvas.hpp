// Lines, marks and letters on paper or in pixels; private to src/picture.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "lettering.hpp"

namespace voile::picture {

/// Places are pixels from the upper left.
class Canvas {
 public:
  virtual ~Canvas() = default;
  virtual void line(const std::vector<Vec2>& points, const Bytes3& colour, double width) = 0;
  /// A filled rectangle; `cover` 0 to 1.
  virtual void box(const Vec2& low, const Vec2& high, const Bytes3& colour, double cover) = 0;
  /// A ring.
  virtual void mark(const Vec2& at, const Bytes3& colour, double radius) = 0;
  virtual void text(const Vec2& at, const std::string& text, double size, const Bytes3& colour, Align align) = 0;
  /// Throws UserError if the file cannot be written.
  virtual void write(const std::filesystem::path& file) = 0;
};

[[nodiscard]] std::unique_ptr<Canvas> svg_canvas(int width, int height);
[[nodiscard]] std::unique_ptr<Canvas> pixel_canvas(int width, int height);

}  // namespace voile::picture
