#include "ray_tracer.hpp"

#include <algorithm>
#include <cmath>
#include <thread>

#include "light_filter.hpp"
#include "tracing.hpp"

namespace voile::picture {

namespace {

/// A picture in the making.
class Exposure {
 public:
  Exposure(const Scene& scene, const Camera& camera, int width, int height, const Quality& quality, int threads)
      : width_(width),
        height_(height),
        threads_(threads),
        quality_(quality),
        tracer_(scene, camera, height, threads),
        pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}

  void expose() {
    for_rows(height_, threads_, [&](int row) {
      for (int column = 0; column < width_; ++column) take(column, row, 0, quality_.samples);
    });
    std::vector<char> edges(pixels_.size(), 0);
    for_rows(height_, threads_, [&](int row) {
      for (int column = 0; column < width_; ++column) edges[place(column, row)] = is_edge(column, row) ? 1 : 0;
    });
    for_rows(height_, threads_, [&](int row) {
      for (int column = 0; column < width_; ++column)
        if (edges[place(column, row)]) take(column, row, quality_.samples, quality_.edge_samples);
    });
    filter_light(pixels_, width_, height_, quality_.passes, threads_);
  }

  [[nodiscard]] Image develop() const {
    Image image(width_, height_);
    for_rows(height_, threads_, [&](int row) {
      for (int column = 0; column < width_; ++column) {
        const Pixel& p = pixels_[place(column, row)];
        Rgb colour = p.pure ? Rgb(p.light.cwiseProduct(p.colour)) : p.seen;
        colour += p.shine;
        const Bytes3 bytes = to_bytes(colour);
        std::copy(bytes.begin(), bytes.end(), image.at(column, row));
      }
    });
    return image;
  }

 private:
  [[nodiscard]] std::size_t place(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(column);
  }

  /// Adds samples `first` to `first + count` to what the pixel has.
  void take(int column, int row, int first, int count) {
    Pixel& p = pixels_[place(column, row)];
    Noise noise(static_cast<std::uint32_t>(place(column, row) * 64 + static_cast<std::size_t>(first)));
    for (int i = first; i < first + count; ++i) {
      // Places that fill the pixel evenly however many they are (R2 sequence); a single one in the middle.
      const float s = static_cast<float>(i);
      float dx = 0.5F + 0.7548777F * s, dy = 0.5F + 0.5698403F * s;
      dx -= std::floor(dx);
      dy -= std::floor(dy);
      const Sample sample =
          tracer_.look((static_cast<float>(column) + dx) / static_cast<float>(width_),
                       (static_cast<float>(row) + dy) / static_cast<float>(height_), quality_.sky_rays, noise);
      add(p, sample, i);
    }
  }

  /// Sample number i.
  static void add(Pixel& p, const Sample& s, int i) {
    if (i == 0) {
      p.surface = s.surface;
      p.normal = s.normal;
      p.point = s.point;
      p.width = s.width;
    } else if (s.surface != p.surface || (s.surface >= 0 && s.normal.dot(p.normal) < 0.8F)) {
      p.pure = false;
    }
    const float w = 1.0F / static_cast<float>(i + 1);
    p.light += w * (s.light - p.light);
    p.colour += w * (s.colour - p.colour);
    p.shine += w * (s.shine - p.shine);
    p.seen += w * (s.light.cwiseProduct(s.colour) - p.seen);
  }

  /// Whether something begins or ends between this pixel and a neighbour.
  [[nodiscard]] bool is_edge(int column, int row) const {
    const Pixel& p = pixels_[place(column, row)];
    if (!p.pure) return true;
    for (const auto& [i, j] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      const int x = column + i, y = row + j;
      if (x < 0 || y < 0 || x >= width_ || y >= height_) continue;
      const Pixel& q = pixels_[place(x, y)];
      if (q.surface != p.surface) return true;
      if (p.surface >= 0 && (q.normal.dot(p.normal) < 0.8F ||
                             std::abs((q.point - p.point).dot(p.normal)) > 6.0F * std::max(p.width, q.width)))
        return true;
    }
    return false;
  }

  int width_, height_, threads_;
  Quality quality_;
  Tracer tracer_;
  std::vector<Pixel> pixels_;
};

}  // namespace

Image render(const Scene& scene, const Camera& camera, int width, int height, const Quality& quality, int threads) {
  (void)Image(width, height);  // refuses senseless sizes
  const int used = threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  Exposure exposure(scene, camera, width, height, quality, used);
  exposure.expose();
  return exposure.develop();
}

}  // namespace voile::picture
