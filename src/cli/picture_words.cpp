#include "picture_words.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <sstream>

#include "voile/errors.hpp"

namespace voile::cli {

std::vector<std::string> words_of(const std::string& text, char separator) {
  std::vector<std::string> words;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, separator);)
    if (!word.empty()) words.push_back(word);
  return words;
}

/// Numbers separated by commas.
std::vector<double> numbers_of(const std::string& option, const std::string& text, std::size_t count) {
  std::vector<double> numbers;
  for (const std::string& word : words_of(text, ',')) {
    char* end = nullptr;
    const double x = std::strtod(word.c_str(), &end);
    if (*end != '\0' || !std::isfinite(x)) throw UserError(fmt::format("{} {}: '{}' is no number", option, text, word));
    numbers.push_back(x);
  }
  if (numbers.size() != count)
    throw UserError(fmt::format("{} {}: {} numbers are needed, with commas between them", option, text, count));
  return numbers;
}

void take_size(const std::string& text, int& width, int& height) {
  char end = '\0';
  if (std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &end) != 2 || width < 16 || height < 16)
    throw UserError(fmt::format("--size {}: it is WIDTHxHEIGHT in pixels, at least 16x16, e.g. 1280x960", text));
}

}  // namespace voile::cli
