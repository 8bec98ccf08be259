// PNG, GIF and WebP as others read them.
#include <doctest/doctest.h>
#include <fmt/format.h>
#include <gif_lib.h>
#include <unistd.h>
#include <webp/decode.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <set>

#include "../test_case_kit.hpp"
#include "picture/animation.hpp"
#include "voile/errors.hpp"

namespace test_image_files {

using namespace voile;
using namespace voile::picture;
namespace fs = std::filesystem;

namespace {

/// A disc that moves, on a gradient.
Image disc(int frame) {
  Image image(60, 40);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 60; ++x) {
      const bool inside = std::hypot(x - 10 - 4 * frame, y - 20) < 8;
      const Bytes3 colour = inside ? Bytes3{200, 30, 40}
                                   : Bytes3{static_cast<std::uint8_t>(4 * x), 220, static_cast<std::uint8_t>(5 * y)};
      std::copy(colour.begin(), colour.end(), image.at(x, y));
    }
  return image;
}

fs::path place(const char* ending) {
  return fs::temp_directory_path() / fmt::format("voile_picture_{}{}", ::getpid(), ending);
}

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void write(const fs::path& file, int frames) {
  const auto writer = make_animation(file, 25.0);
  for (int i = 0; i < frames; ++i) writer->add(disc(i));
  writer->finish();
}

}  // namespace

TEST_CASE("a PNG is read back as it was") {
  const fs::path file = place(".png");
  const Image image = disc(2);
  write_png(file, image);
  const Image again = read_png(file);
  CHECK(again.width() == 60);
  CHECK(std::memcmp(image.at(0, 0), again.at(0, 0), 3UL * 60 * 40) == 0);
  fs::remove(file);
  CHECK_THROWS_AS((void)read_png(file), UserError);
  CHECK_THROWS_AS(write_png("/proc/version/x.png", image), UserError);
  CHECK_THROWS_AS(Image(0, 5), UserError);
  CHECK_THROWS_AS(Image(40000, 5), UserError);
}

TEST_CASE("a PNG of 256 colours is smaller, near to the picture, and keeps what is flat as it is") {
  const fs::path file = place("_palette.png");
  Image image(200, 150);
  std::uint32_t noise = 1;
  for (int y = 0; y < 150; ++y)
    for (int x = 0; x < 100; ++x) {
      Bytes3 colour{};
      for (std::uint8_t& c : colour)
        c = static_cast<std::uint8_t>(x + y / 2 + (noise = noise * 1664525U + 1013904223U) / (1U << 28U));
      std::copy(colour.begin(), colour.end(), image.at(x, y));
    }
  write_png(file, image);
  const auto whole = fs::file_size(file);
  write_png(file, image, true);
  CHECK(fs::file_size(file) < 0.7 * static_cast<double>(whole));
  const Image again = read_png(file);
  double sum = 0.0;
  std::set<Bytes3> colours;
  for (int y = 0; y < 150; ++y)
    for (int x = 0; x < 200; ++x) {
      const std::uint8_t *a = image.at(x, y), *b = again.at(x, y);
      colours.insert({b[0], b[1], b[2]});
      for (int k = 0; k < 3; ++k) sum += std::abs(a[k] - b[k]) / (3.0 * 200 * 150);
    }
  CHECK(sum < 8.0);
  CHECK(colours.size() <= 256);
  CHECK(Bytes3{again.at(150, 70)[0], again.at(150, 70)[1], again.at(150, 70)[2]} == Bytes3{255, 255, 255});
  fs::remove(file);
}

TEST_CASE("pictures beside each other stand in the middle of their places") {
  const Image sheet = sheet_of({Image(10, 20, {1, 1, 1}), Image(30, 20, {2, 2, 2}), Image(20, 6, {3, 3, 3})}, 2);
  CHECK(sheet.width() == 50);
  CHECK(sheet.height() == 26);
  CHECK(sheet.at(0, 0)[0] == 255);
  CHECK(sheet.at(5, 0)[0] == 1);
  CHECK(sheet.at(14, 19)[0] == 1);
  CHECK(sheet.at(20, 0)[0] == 2);
  CHECK(sheet.at(19, 25)[0] == 3);
  CHECK(sheet.at(20, 25)[0] == 255);
  CHECK(sheet_of({Image(10, 20)}, 7).width() == 10);
  CHECK_THROWS_AS((void)sheet_of({}, 2), UserError);
  CHECK_THROWS_AS((void)sheet_of({Image(30000, 2), Image(30000, 2)}, 2), UserError);
}

TEST_CASE("a GIF has its frames, colours and times") {
  const fs::path file = place(".gif");
  write(file, 5);
  int error = 0;
  GifFileType* gif = DGifOpenFileName(file.c_str(), &error);
  REQUIRE(gif);
  REQUIRE(DGifSlurp(gif) == GIF_OK);
  CHECK(gif->ImageCount == 5);
  CHECK(gif->SWidth == 60);
  double worst = 0.0, sum = 0.0;
  for (int k = 0; k < 5; ++k) {
    GraphicsControlBlock control;
    REQUIRE(DGifSavedExtensionToGCB(gif, k, &control) == GIF_OK);
    CHECK(control.DelayTime == 4);
    const Image image = disc(k);
    const SavedImage& saved = gif->SavedImages[k];
    for (int i = 0; i < 60 * 40; ++i) {
      const GifColorType& c = saved.ImageDesc.ColorMap->Colors[saved.RasterBits[i]];
      const std::uint8_t* p = image.at(i % 60, i / 60);
      const double d = std::max({std::abs(c.Red - p[0]), std::abs(c.Green - p[1]), std::abs(c.Blue - p[2])});
      worst = std::max(worst, d);
      sum += d / (5 * 60 * 40);
    }
  }
  CHECK(worst < 30.0);
  CHECK(sum < 9.0);
  DGifCloseFile(gif, &error);
  fs::remove(file);
}

TEST_CASE("a WebP has its frames, size and times, and repeats") {
  const fs::path file = place(".webp");
  write(file, 5);
  const std::string bytes = bytes_of(file);
  WebPBitstreamFeatures features;
  REQUIRE(WebPGetFeatures(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), &features) ==
          VP8_STATUS_OK);
  CHECK(features.has_animation == 1);
  CHECK(features.width == 60);
  CHECK(features.height == 40);
  // Chunks: a name, a length, the content; a frame keeps its duration in three bytes after twelve.
  int frames = 0, milliseconds = 0;
  for (std::size_t at = 12; at + 8 <= bytes.size();) {
    const auto byte = [&](std::size_t i) {
      return static_cast<std::size_t>(static_cast<unsigned char>(bytes[at + i]));
    };
    const std::size_t size = byte(4) | byte(5) << 8U | byte(6) << 16U | byte(7) << 24U;
    if (bytes.compare(at, 4, "ANMF") == 0) {
      ++frames;
      milliseconds += static_cast<int>(byte(20) | byte(21) << 8U | byte(22) << 16U);
    }
    if (bytes.compare(at, 4, "ANIM") == 0) CHECK((byte(12) | byte(13)) == 0);
    at += 8 + size + size % 2;
  }
  CHECK(frames == 5);
  CHECK(milliseconds == 200);
  fs::remove(file);
}

TEST_CASE("animations that cannot be written say why") {
  CHECK_THROWS_AS((void)make_animation("x.avi", 25.0), UserError);
  CHECK_THROWS_AS((void)make_animation("/proc/version/x.gif", 25.0), UserError);
  CHECK_THROWS_AS((void)make_animation("/proc/version/x.webp", 25.0), UserError);
  CHECK_THROWS_AS((void)make_animation("x.gif", 0.0), UserError);
  const fs::path file = place(".gif");
  CHECK_THROWS_AS(make_animation(file, 10.0)->finish(), UserError);
  fs::remove(file);
}

}  // namespace test_image_files
