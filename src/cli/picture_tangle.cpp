#include "picture_tangle.hpp"

#include <fstream>
#include <iterator>

#include "base/bytes.hpp"
#include "picture/tangle.hpp"

namespace voile::cli {

namespace {

constexpr int width = 1280, height = 960;

}  // namespace

std::string draw_tangle(const std::string& message, const std::string& picture) {
  std::ifstream stream(message, std::ios::binary);
  ByteReader in(std::string(std::istreambuf_iterator<char>(stream), {}));
  picture::Tangle tangle;
  in.get(tangle.positions);
  in.get(tangle.triangles);
  in.get(tangle.piece);
  in.get(tangle.hit);
  picture::write_png(picture, picture::picture_of(tangle, width, height));
  return "";
}

}  // namespace voile::cli
