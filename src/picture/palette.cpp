#include "palette.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace voile::picture {

namespace {

constexpr std::size_t most_colours = 256, most_sampled = 60'000, most_flat = 32;
constexpr std::size_t flat_part =
    300;  // a colour of so large a part of a picture (1 / this), such as white paper, stays as it is
constexpr int table_cells = 32;  // of the table of nearest colours, along each axis

using Colours = std::vector<Bytes3>;

/// The axis along which a range of colours is widest, and how wide.
std::pair<std::size_t, int> widest(Colours::const_iterator begin, Colours::const_iterator end) {
  std::pair<std::size_t, int> best{0, -1};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto [low, high] =
        std::minmax_element(begin, end, [k](const Bytes3& a, const Bytes3& b) { return a[k] < b[k]; });
    const int width = (*high)[k] - (*low)[k];
    if (width > best.second) best = {k, width};
  }
  return best;
}

struct Range {
  Colours::iterator begin, end;
  std::size_t axis = 0;
  double weight = 0.0;
};

Range range_of(Colours::iterator begin, Colours::iterator end) {
  const auto [axis, width] = widest(begin, end);
  return {begin, end, axis, end - begin > 1 ? width * std::sqrt(static_cast<double>(end - begin)) : 0.0};
}

Bytes3 mean(const Range& r) {
  std::array<long, 3> sum{};
  for (auto c = r.begin; c != r.end; ++c)
    for (std::size_t k = 0; k < 3; ++k) sum[k] += (*c)[k];
  Bytes3 m{};
  for (std::size_t k = 0; k < 3; ++k) m[k] = static_cast<std::uint8_t>(sum[k] / (r.end - r.begin));
  return m;
}

/// The commonest colours, which flat surfaces have.
Colours flat_colours(const Colours& colours) {
  std::map<Bytes3, std::size_t> counts;
  for (const Bytes3& c : colours) ++counts[c];
  std::vector<std::pair<std::size_t, Bytes3>> common;
  for (const auto& [colour, count] : counts)
    if (flat_part * count >= colours.size()) common.emplace_back(count, colour);
  std::sort(common.rbegin(), common.rend());
  Colours flat;
  for (std::size_t i = 0; i < std::min(common.size(), most_flat); ++i) flat.push_back(common[i].second);
  return flat;
}

Colours median_cut(Colours colours, std::size_t most) {
  if (colours.empty()) return {};
  std::vector<Range> ranges{range_of(colours.begin(), colours.end())};
  while (ranges.size() < most) {
    const auto widest_range = std::max_element(ranges.begin(), ranges.end(),
                                               [](const Range& a, const Range& b) { return a.weight < b.weight; });
    if (widest_range->weight <= 0.0) break;
    const Range r = *widest_range;
    const auto middle = r.begin + (r.end - r.begin) / 2;
    std::nth_element(r.begin, middle, r.end, [&](const Bytes3& a, const Bytes3& b) { return a[r.axis] < b[r.axis]; });
    *widest_range = range_of(r.begin, middle);
    ranges.push_back(range_of(middle, r.end));
  }
  Colours palette;
  for (const Range& r : ranges) palette.push_back(mean(r));
  return palette;
}

std::uint8_t nearest(const Colours& palette, const std::array<int, 3>& colour) {
  int best = std::numeric_limits<int>::max();
  std::size_t which = 0;
  for (std::size_t i = 0; i < palette.size(); ++i) {
    int distance = 0;
    for (std::size_t k = 0; k < 3; ++k) distance += (palette[i][k] - colour[k]) * (palette[i][k] - colour[k]);
    if (distance < best) {
      best = distance;
      which = i;
    }
  }
  return static_cast<std::uint8_t>(which);
}

}  // namespace

Reduced reduce(const Image& image) {
  const std::size_t count = static_cast<std::size_t>(image.width()) * static_cast<std::size_t>(image.height());
  const std::uint8_t* bytes = image.at(0, 0);
  Colours sampled;
  const std::size_t stride = 1 + count / most_sampled;
  for (std::size_t i = 0; i < count; i += stride) sampled.push_back({bytes[3 * i], bytes[3 * i + 1], bytes[3 * i + 2]});
  const Colours flat = flat_colours(sampled);
  std::erase_if(sampled, [&](const Bytes3& c) { return std::find(flat.begin(), flat.end(), c) != flat.end(); });
  Reduced result{flat, {}};
  for (const Bytes3& c : median_cut(std::move(sampled), most_colours - flat.size())) result.palette.push_back(c);
  result.pixels.resize(count);
  constexpr std::array<int, 16> bayer{0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5};
  constexpr int width = 256 / table_cells;
  std::vector<int> table(static_cast<std::size_t>(table_cells * table_cells * table_cells), -1);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      const std::uint8_t* p = image.at(x, y);
      std::uint8_t& pixel = result.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width()) +
                                          static_cast<std::size_t>(x)];
      const auto same = std::find(flat.begin(), flat.end(), Bytes3{p[0], p[1], p[2]});
      if (same != flat.end()) {
        pixel = static_cast<std::uint8_t>(same - flat.begin());
        continue;
      }
      const int dither = (2 * bayer[static_cast<std::size_t>(4 * (y % 4) + x % 4)] - 15) * width / 32;
      std::array<int, 3> cell{}, middle{};
      for (std::size_t k = 0; k < 3; ++k) {
        cell[k] = std::clamp(p[k] + dither, 0, 255) / width;
        middle[k] = cell[k] * width + width / 2;
      }
      const int place = (cell[0] * table_cells + cell[1]) * table_cells + cell[2];
      int& known = table[static_cast<std::size_t>(place)];
      if (known < 0) known = nearest(result.palette, middle);
      pixel = static_cast<std::uint8_t>(known);
    }
  return result;
}

}  // namespace voile::picture
