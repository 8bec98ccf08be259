#include "axis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "colour_map.hpp"
#include "voile/errors.hpp"

namespace voile::picture {

namespace {

/// 10^k
std::string power_text(int k) {
  if (k == 0) return "1";
  constexpr std::array digits{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = k < 0 ? "10⁻" : "10";
  for (const char c : std::to_string(std::abs(k))) text += digits[static_cast<std::size_t>(c - '0')];
  return text;
}

}  // namespace

bool Axis::can_show(double value) const {
  return std::isfinite(value) && (value > 0.0 || !options_.logarithmic);
}

double Axis::scaled(double value) const {
  return options_.logarithmic ? std::log10(value) : value;
}

double Axis::place(double value) const {
  return at(scaled(value));
}

double Axis::pixels() const {
  return std::abs(end - begin);
}

void Axis::add(double value) {
  low = std::min(low, scaled(value));
  high = std::max(high, scaled(value));
}

void Axis::finish() {
  if (options_.range) {
    low = scaled(options_.range->first);
    high = scaled(options_.range->second);
    if (resolved()) return;
    throw UserError(fmt::format("the range {}, {} of an axis is too narrow or too wide for double precision",
                                options_.range->first, options_.range->second));
  }
  if (!std::isfinite(width())) throw UserError("the values of the curves are too large to be drawn");
  if (!resolved()) {
    const double half = options_.logarithmic ? 0.5 : 0.5 * std::max(std::abs(low), 1e-12);
    low -= half;
    high += half;
  }
  const double old = width();
  if (!options_.logarithmic && low > 0.0 && low < 0.3 * old) low = 0.0;
  if (!options_.logarithmic && high < 0.0 && high > -0.3 * old) high = 0.0;
  if (low != 0.0 || options_.logarithmic) low -= 0.04 * old;
  if (high != 0.0 || options_.logarithmic) high += 0.04 * old;
}

bool Axis::resolved() const {
  return std::isfinite(width()) && width() > 1e-12 * std::max(std::abs(low), std::abs(high));
}

void Axis::widen_to(double width) {
  const double more = 0.5 * (width - this->width());
  low -= more;
  high += more;
}

std::vector<std::pair<double, std::string>> Axis::numbers(int count) const {
  std::vector<std::pair<double, std::string>> list;
  if (!options_.logarithmic) {
    for (const auto& [value, text] : ticks(low, high, count)) list.emplace_back(at(value), text);
    return list;
  }
  const double slack = 1e-9 * width();
  const int first = static_cast<int>(std::ceil(low - slack)), last = static_cast<int>(std::floor(high + slack));
  const int stride = std::max(1, (last - first + count) / count);
  const bool short_numbers = first >= -2 && last <= 3;
  // Of less than two decades the numbers between their ends, too.
  for (int k = last - first < 2 ? first - 1 : first; k <= last; k += stride)
    for (const int digit : {1, 2, 5}) {
      const double value = std::log10(digit) + k;
      if (value < low - slack || value > high + slack || (digit > 1 && last - first >= 2)) continue;
      list.emplace_back(at(value),
                        digit == 1 && !short_numbers ? power_text(k) : fmt::format("{:g}", digit * std::pow(10.0, k)));
    }
  return list;
}

}  // namespace voile::picture
