#include "cloth_images.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace voile::picture {

namespace {

constexpr int print_pixels = 64;     // of a repeat
constexpr float same_place = 1e-6F;  // [m]

std::uint8_t byte_of(float x) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(x, 0.0F, 1.0F) * 255.0F));
}

/// A picture of the texels of a weave.
template <class Colour>
Image texels(Weave weave, const Colour& colour) {
  const WeaveTile tile(weave, false);
  Image image(tile.size(), tile.size());
  for (int row = 0; row < tile.size(); ++row)
    for (int column = 0; column < tile.size(); ++column) {
      const Vec3f c = colour(tile.texel(column, tile.size() - 1 - row));
      for (int k = 0; k < 3; ++k) image.at(column, row)[k] = byte_of(c[k]);
    }
  return image;
}

}  // namespace

Image normal_image(Weave weave) {
  return texels(weave, [](const Relief& r) {
    const Vec3f n = Vec3f(-r.across, -r.along, 1.0F).normalized();
    return Vec3f(0.5F * (n + Vec3f::Ones()));
  });
}

Image shade_image(Weave weave) {
  return texels(weave, [](const Relief& r) { return Vec3f(Vec3f::Constant(r.shade)); });
}

Image print_image(Print print, const Rgb& ground) {
  Image image(print_pixels, print_pixels);
  for (int row = 0; row < print_pixels; ++row)
    for (int column = 0; column < print_pixels; ++column) {
      const Vec2f at(static_cast<float>(column) + 0.5F, static_cast<float>(print_pixels - row) - 0.5F);
      const float second = second_colour(print, 0.5 * print_pixels, at, Vec2f::Zero(), Vec2f::Zero());
      const Bytes3 bytes = to_bytes(ground + second * (print_colour() - ground));
      std::copy(bytes.begin(), bytes.end(), image.at(column, row));
    }
  return image;
}

SplitSheet split_at_seams(const std::vector<mesh::Triangle>& triangles, const std::vector<std::array<Vec2f, 3>>& flat) {
  SplitSheet split;
  std::map<std::tuple<Index, long, long>, Index> known;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    mesh::Triangle& corners = split.triangles.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec2f& at = flat[t][i];
      const auto [entry, is_new] =
          known.try_emplace({triangles[t][i], std::lround(at[0] / same_place), std::lround(at[1] / same_place)},
                            static_cast<Index>(split.origin.size()));
      if (is_new) {
        split.origin.push_back(triangles[t][i]);
        split.flat.push_back(at);
      }
      corners[i] = entry->second;
    }
  }
  return split;
}

std::vector<Vec3f> tangents_of(const SplitSheet& split, const std::vector<Vec3f>& x,
                               const std::vector<Vec3f>& normals) {
  std::vector<Vec3f> sums(x.size(), Vec3f::Zero());
  for (const mesh::Triangle& t : split.triangles) {
    const auto i = static_cast<std::size_t>(t[0]), j = static_cast<std::size_t>(t[1]),
               k = static_cast<std::size_t>(t[2]);
    const Vec2f a = split.flat[j] - split.flat[i], b = split.flat[k] - split.flat[i];
    const float det = a[0] * b[1] - a[1] * b[0];
    const Vec3f across = (b[1] * (x[j] - x[i]) - a[1] * (x[k] - x[i])) * (det < 0.0F ? -1.0F : 1.0F);
    for (const std::size_t v : {i, j, k}) sums[v] += across;
  }
  for (std::size_t v = 0; v < sums.size(); ++v) {
    const Vec3f across = sums[v] - sums[v].dot(normals[v]) * normals[v];
    sums[v] = across.norm() > 1e-12F * sums[v].norm() ? Vec3f(across.normalized()) : normals[v].unitOrthogonal();
  }
  return sums;
}

}  // namespace voile::picture
