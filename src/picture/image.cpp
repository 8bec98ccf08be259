#include "image.hpp"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <numeric>

#include "base/plain_file.hpp"
#include "palette.hpp"
#include "unfinished.hpp"
#include "voile/errors.hpp"

namespace voile::picture {

namespace {

constexpr int largest_side = 32768;

float encode(float x) {
  return x <= 0.0031308F ? 12.92F * x : 1.055F * std::pow(x, 1.0F / 2.4F) - 0.055F;
}

float decode(float x) {
  return x <= 0.04045F ? x / 12.92F : std::pow((x + 0.055F) / 1.055F, 2.4F);
}

/// sRGB of evenly spaced linear values: powers are slow.
const std::vector<std::uint8_t>& encoding() {
  static const std::vector<std::uint8_t> table = [] {
    std::vector<std::uint8_t> t(8193);
    for (std::size_t i = 0; i < t.size(); ++i)
      t[i] = static_cast<std::uint8_t>(std::lround(255.0F * encode(static_cast<float>(i) / 8192.0F)));
    return t;
  }();
  return table;
}

}  // namespace

std::vector<Vec3f> single(const std::vector<Vec3>& points) {
  std::vector<Vec3f> result;
  result.reserve(points.size());
  for (const Vec3& x : points) result.push_back(x.cast<float>());
  return result;
}

Bytes3 to_bytes(const Rgb& linear) {
  const std::vector<std::uint8_t>& table = encoding();
  Bytes3 bytes{};
  for (int k = 0; k < 3; ++k) {
    const float x = linear[k] > 0.0F ? std::min(linear[k], 1.0F) : 0.0F;
    bytes[static_cast<std::size_t>(k)] = table[static_cast<std::size_t>(std::lround(8192.0F * x))];
  }
  return bytes;
}

Rgb from_bytes(const Bytes3& srgb) {
  Rgb linear;
  for (int k = 0; k < 3; ++k) linear[k] = decode(static_cast<float>(srgb[static_cast<std::size_t>(k)]) / 255.0F);
  return linear;
}

Image::Image(int width, int height, const Bytes3& colour) : width_(width), height_(height) {
  if (width < 1 || height < 1 || width > largest_side || height > largest_side)
    throw UserError(
        fmt::format("a picture of {} x {} pixels cannot be made: each side has 1 to {}", width, height, largest_side));
  bytes_.resize(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (std::size_t i = 0; i < bytes_.size(); ++i) bytes_[i] = colour[i % 3];
}

void Image::blend(int x, int y, const Bytes3& colour, float cover) {
  if (!contains(x, y)) return;
  std::uint8_t* p = at(x, y);
  for (std::size_t k = 0; k < 3; ++k) {
    const float mixed = static_cast<float>(p[k]) + cover * (static_cast<float>(colour[k]) - static_cast<float>(p[k]));
    p[k] = static_cast<std::uint8_t>(std::lround(std::clamp(mixed, 0.0F, 255.0F)));
  }
}

void Image::fill(int x, int y, int w, int h, const Bytes3& colour, float cover) {
  for (int j = y; j < y + h; ++j)
    for (int i = x; i < x + w; ++i) blend(i, j, colour, cover);
}

void Image::paste(const Image& other, int x, int y) {
  const int begin = std::max(0, -x), end = std::min(other.width_, width_ - x);
  for (int j = std::max(0, -y); j < std::min(other.height_, height_ - y) && begin < end; ++j)
    std::memcpy(at(x + begin, y + j), other.at(begin, j), 3 * static_cast<std::size_t>(end - begin));
}

void write_png(const std::filesystem::path& file, const Image& image, bool palette) {
  if (file.has_extension() && file.extension() != ".png" && file.extension() != ".part")
    throw UserError(fmt::format("{}: pictures are written as PNG: the name must end in .png", file.string()));
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width());
  png.height = static_cast<png_uint_32>(image.height());
  png.format = PNG_FORMAT_RGB;
  Reduced reduced;
  if (palette) {
    reduced = reduce(image);
    png.format = PNG_FORMAT_RGB_COLORMAP;
    png.colormap_entries = static_cast<png_uint_32>(reduced.palette.size());
  }
  const std::uint8_t* pixels = palette ? reduced.pixels.data() : image.at(0, 0);
  // Not png_image_write_to_file, which removes what it could not write to: a device, if it is told so by root.
  require_no_link(file);
  Unfinished unfinished;
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> out(std::fopen(file.c_str(), "wb"), std::fclose);
  if (!out)
    throw UserError(
        fmt::format("{}: cannot be written ({}); is the folder there?", file.string(), std::strerror(errno)));
  unfinished.begin(file);
  if (!png_image_write_to_stdio(&png, out.get(), 0, pixels, 0, palette ? reduced.palette.data() : nullptr) ||
      std::fflush(out.get()) != 0)
    throw UserError(fmt::format("{}: cannot be written ({}); is there room on the disk?", file.string(),
                                errno != 0 ? std::strerror(errno) : png.message));
  unfinished.finish();
}

std::vector<char> png_bytes(const Image& image) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width());
  png.height = static_cast<png_uint_32>(image.height());
  png.format = PNG_FORMAT_RGB;
  std::vector<char> bytes(PNG_IMAGE_PNG_SIZE_MAX(png));
  png_alloc_size_t size = bytes.size();
  if (!png_image_write_to_memory(&png, bytes.data(), &size, 0, image.at(0, 0), 0, nullptr))
    throw InternalError(png.message);
  bytes.resize(size);
  return bytes;
}

Image read_png(const std::filesystem::path& file) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  require_plain_file(file);
  if (!png_image_begin_read_from_file(&png, file.c_str()))
    throw UserError(fmt::format("{}: is no PNG that can be read ({})", file.string(), png.message));
  png.format = PNG_FORMAT_RGB;
  Image image(static_cast<int>(png.width), static_cast<int>(png.height));
  if (!png_image_finish_read(&png, nullptr, image.at(0, 0), 0, nullptr))
    throw UserError(fmt::format("{}: is damaged ({})", file.string(), png.message));
  return image;
}

Image sheet_of(const std::vector<Image>& pictures, int columns) {
  if (pictures.empty() || columns < 1) throw UserError("a sheet needs one picture at least, and one column");
  const auto across = std::min(static_cast<std::size_t>(columns), pictures.size());
  std::vector<int> left(across + 1, 0), top((pictures.size() + across - 1) / across + 1, 0);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    // Widths and heights first, places afterwards.
    int &width = left[i % across + 1], &height = top[i / across + 1];
    width = std::max(width, pictures[i].width());
    height = std::max(height, pictures[i].height());
  }
  std::partial_sum(left.begin(), left.end(), left.begin());
  std::partial_sum(top.begin(), top.end(), top.begin());
  Image sheet(left.back(), top.back());
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const std::size_t c = i % across, r = i / across;
    sheet.paste(pictures[i], (left[c] + left[c + 1] - pictures[i].width()) / 2,
                (top[r] + top[r + 1] - pictures[i].height()) / 2);
  }
  return sheet;
}

}  // namespace voile::picture
