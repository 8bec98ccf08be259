#include "canvas.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "exporting.hpp"

namespace voile::picture {

namespace {

std::string hex(const Bytes3& c) {
  return fmt::format("#{:02x}{:02x}{:02x}", c[0], c[1], c[2]);
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  return out;
}

class Svg : public Canvas {
 public:
  Svg(int width, int height)
      : text_(fmt::format(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
            "font-family=\"DejaVu Sans, Verdana, sans-serif\">\n<rect width=\"{0}\" height=\"{1}\" "
            "fill=\"#ffffff\"/>\n",
            width, height)) {}
  void line(const std::vector<Vec2>& points, const Bytes3& colour, double width) override {
    text_ +=
        fmt::format("<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\" points=\"",
                    hex(colour), width);
    for (const Vec2& p : points) text_ += fmt::format("{:.2f},{:.2f} ", p[0], p[1]);
    text_ += "\"/>\n";
  }
  void box(const Vec2& low, const Vec2& high, const Bytes3& colour, double cover) override {
    text_ += fmt::format(
        "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\" fill-opacity=\"{}\"/>\n",
        low[0], low[1], high[0] - low[0], high[1] - low[1], hex(colour), cover);
  }
  void mark(const Vec2& at, const Bytes3& colour, double radius) override {
    text_ += fmt::format(
        "<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{}\" fill=\"#ffffff\" stroke=\"{}\" stroke-width=\"1.5\"/>\n", at[0],
        at[1], radius, hex(colour));
  }
  void text(const Vec2& at, const std::string& text, double size, const Bytes3& colour, Align align) override {
    const char* anchor = align == Align::left ? "start" : align == Align::right ? "end" : "middle";
    // The height of a line is larger than what SVG calls the size.
    text_ +=
        fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" font-size=\"{:.2f}\" fill=\"{}\" text-anchor=\"{}\">{}</text>\n",
                    at[0], at[1], 0.86 * size, hex(colour), anchor, escaped(text));
  }
  void write(const std::filesystem::path& file) override {
    OutFile out(file);
    Files written;
    out.stream() << text_ << "</svg>\n";
    out.finish(written);
  }

 private:
  std::string text_;
};

class Pixels : public Canvas {
 public:
  Pixels(int width, int height) : image_(width, height) {}
  /// Each pixel is covered once, however many pieces of the line touch it.
  void line(const std::vector<Vec2>& points, const Bytes3& colour, double width) override {
    Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (const Vec2& p : points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    const double reach = 0.5 * width + 1.0;
    const int left = std::max(0, static_cast<int>(low[0] - reach)), top = std::max(0, static_cast<int>(low[1] - reach));
    const int right = std::min(image_.width() - 1, static_cast<int>(high[0] + reach));
    const int bottom = std::min(image_.height() - 1, static_cast<int>(high[1] + reach));
    if (points.empty() || right < left || bottom < top) return;
    const auto columns = static_cast<std::size_t>(right - left) + 1, rows = static_cast<std::size_t>(bottom - top) + 1;
    std::vector<float> cover(columns * rows, 0.0F);
    for (std::size_t i = 1; i < points.size(); ++i)
      around(points[i - 1], points[i], reach, [&](int x, int y, const Vec2& p) {
        const Vec2 along = points[i] - points[i - 1];
        const double t = along.squaredNorm() > 0.0
                             ? std::clamp((p - points[i - 1]).dot(along) / along.squaredNorm(), 0.0, 1.0)
                             : 0.0;
        const double far = (p - points[i - 1] - t * along).norm();
        float& c = cover[static_cast<std::size_t>(y - top) * columns + static_cast<std::size_t>(x - left)];
        c = std::max(c, static_cast<float>(std::clamp(0.5 * width + 0.5 - far, 0.0, 1.0)));
      });
    for (std::size_t i = 0; i < cover.size(); ++i)
      if (cover[i] > 0.0F)
        image_.blend(left + static_cast<int>(i % columns), top + static_cast<int>(i / columns), colour, cover[i]);
  }
  void box(const Vec2& low, const Vec2& high, const Bytes3& colour, double cover) override {
    image_.fill(static_cast<int>(low[0]), static_cast<int>(low[1]), static_cast<int>(high[0] - low[0]),
                static_cast<int>(high[1] - low[1]), colour, static_cast<float>(cover));
  }
  void mark(const Vec2& at, const Bytes3& colour, double radius) override {
    around(at, at, radius + 2.0, [&](int x, int y, const Vec2& p) {
      const double far = (p - at).norm();
      image_.blend(x, y, {255, 255, 255}, static_cast<float>(std::clamp(radius + 0.5 - far, 0.0, 1.0)));
      image_.blend(x, y, colour, static_cast<float>(std::clamp(1.25 - std::abs(far - radius), 0.0, 1.0)));
    });
  }
  void text(const Vec2& at, const std::string& text, double size, const Bytes3& colour, Align align) override {
    draw_text(image_, at[0], at[1], text, size, colour, align);
  }
  void write(const std::filesystem::path& file) override { write_png(file, image_); }

 private:
  /// Calls work(x, y, centre of the pixel) for the pixels about a piece of a line.
  template <class Work>
  void around(const Vec2& a, const Vec2& b, double reach, const Work& work) {
    const int x0 = std::max(0, static_cast<int>(std::min(a[0], b[0]) - reach)),
              x1 = std::min(image_.width() - 1, static_cast<int>(std::max(a[0], b[0]) + reach));
    const int y0 = std::max(0, static_cast<int>(std::min(a[1], b[1]) - reach)),
              y1 = std::min(image_.height() - 1, static_cast<int>(std::max(a[1], b[1]) + reach));
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) work(x, y, Vec2(x + 0.5, y + 0.5));
  }
  Image image_;
};

}  // namespace

std::unique_ptr<Canvas> svg_canvas(int width, int height) {
  return std::make_unique<Svg>(width, height);
}

std::unique_ptr<Canvas> pixel_canvas(int width, int height) {
  return std::make_unique<Pixels>(width, height);
}

}  // namespace voile::picture
