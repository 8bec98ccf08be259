#include "light_filter.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>

namespace voile::picture {

void for_rows(int rows, int threads, const std::function<void(int)>& work) {
  std::atomic<int> next{0};
  std::exception_ptr failure;
  std::mutex guard;
  const auto loop = [&] {
    try {
      for (int row = next++; row < rows; row = next++) work(row);
    } catch (...) {
      const std::scoped_lock lock(guard);
      failure = std::current_exception();
    }
  };
  std::vector<std::thread> others;
  try {
    for (int i = 1; i < threads; ++i) others.emplace_back(loop);
  } catch (const std::system_error&) {  // those that the machine gives do all rows
  }
  loop();
  for (std::thread& t : others) t.join();
  if (failure) std::rethrow_exception(failure);
}

namespace {

/// How much two pixels belong to the same smooth piece.
float likeness(const Pixel& a, const Pixel& b, int distance) {
  if (a.surface != b.surface || !b.pure) return 0.0F;
  const float turn = a.normal.dot(b.normal);
  if (turn < 0.7F) return 0.0F;
  const float apart = std::abs((b.point - a.point).dot(a.normal)) / (a.width * static_cast<float>(distance));
  if (apart > 2.0F) return 0.0F;
  const float light = (a.light - b.light).cwiseAbs().maxCoeff();
  const float t2 = turn * turn, t8 = t2 * t2 * t2 * t2;
  return t8 / (1.0F + 12.0F * light * light + apart * apart);
}

Rgb filtered(const std::vector<Pixel>& pixels, int width, int height, int column, int row, int reach) {
  const auto at = [&](int x, int y) -> const Pixel& {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  };
  const Pixel& own = at(column, row);
  // In turns the neighbours beside and those across corners: together they are all.
  constexpr std::array<std::array<int, 2>, 4> beside{{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}},
      across{{{-1, -1}, {1, -1}, {-1, 1}, {1, 1}}};
  Rgb sum = own.light;
  float weight = 1.0F;
  for (const auto& [i, j] : reach % 3 == 1 ? across : beside) {
    const int x = column + i * reach, y = row + j * reach;
    if (x < 0 || y < 0 || x >= width || y >= height) continue;
    const float w = likeness(own, at(x, y), reach);
    sum += w * at(x, y).light;
    weight += w;
  }
  return sum / weight;
}

}  // namespace

void filter_light(std::vector<Pixel>& pixels, int width, int height, int passes, int threads) {
  std::vector<Rgb> result(pixels.size());
  for (int pass = 0; pass < passes; ++pass) {
    for_rows(height, threads, [&](int row) {
      for (int column = 0; column < width; ++column) {
        const std::size_t i =
            static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column);
        const Pixel& p = pixels[i];
        result[i] = p.surface >= 0 && p.pure ? filtered(pixels, width, height, column, row, 1 << pass) : p.light;
      }
    });
    for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i].light = result[i];
  }
}

}  // namespace voile::picture
