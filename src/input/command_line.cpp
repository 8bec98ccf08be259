#include "command_line.hpp"

#include <fmt/format.h>

#include <cctype>
#include <sstream>

#include "voile/errors.hpp"

namespace voile::input {

namespace {

bool letter_at(const std::string& word, std::size_t i) {
  return word.size() > i && std::isalpha(static_cast<unsigned char>(word[i]));
}

bool is_petsc_option(const std::string& word) {
  return word.size() > 2 && word[0] == '-' && letter_at(word, 1);
}

bool is_own_option(const std::string& word) {
  return (word.rfind("--", 0) == 0 && letter_at(word, 2)) || (word.size() == 2 && word[0] == '-' && letter_at(word, 1));
}

bool is_value(const std::string& word) {
  return !is_petsc_option(word) && !is_own_option(word);
}

}  // namespace

SplitArguments split_arguments(const std::vector<std::string>& arguments) {
  SplitArguments split;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (!is_petsc_option(arguments[i])) {
      split.own.push_back(arguments[i]);
      continue;
    }
    split.petsc.push_back(arguments[i]);
    if (i + 1 < arguments.size() && is_value(arguments[i + 1])) split.petsc.push_back(arguments[++i]);
  }
  return split;
}

std::vector<std::pair<std::string, std::string>> petsc_pairs(const std::string& text) {
  std::vector<std::pair<std::string, std::string>> pairs;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (is_petsc_option(word))
      pairs.emplace_back(word, "");
    else if (!pairs.empty() && pairs.back().second.empty())
      pairs.back().second = word;
    else
      throw UserError(fmt::format("'{}' is neither an option (-name) nor the value of one", word));
  }
  return pairs;
}

}  // namespace voile::input
