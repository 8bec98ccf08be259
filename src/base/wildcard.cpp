#include "wildcard.hpp"

#include <algorithm>

namespace voile {

std::string with_star(std::string name, const std::string& text) {
  for (std::size_t at = name.find('*'); at != std::string::npos; at = name.find('*', at + text.size()))
    name.replace(at, 1, text);
  return name;
}

std::optional<std::string> star_of(const std::string& pattern, const std::string& name) {
  const auto stars = static_cast<std::size_t>(std::count(pattern.begin(), pattern.end(), '*'));
  const std::size_t fixed = pattern.size() - stars;
  if (stars == 0 || name.size() < fixed + stars || (name.size() - fixed) % stars != 0) return std::nullopt;
  std::string text = name.substr(pattern.find('*'), (name.size() - fixed) / stars);
  if (with_star(pattern, text) != name) return std::nullopt;
  return text;
}

}  // namespace voile
