// Lists and foreign words in messages.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

namespace voile {

/// The items as text with a separator between them. (fmt::join makes GCC 12 warn falsely about an overflow at -O3.)
template <class List>
[[nodiscard]] std::string join(const List& items, std::string_view separator) {
  std::string text;
  for (bool first = true; const auto& item : items) {
    if (!first) text += separator;
    first = false;
    text += fmt::format("{}", item);
  }
  return text;
}

template <class List, class Item>
[[nodiscard]] bool contains(const List& list, const Item& item) {
  return std::find(std::begin(list), std::end(list), item) != std::end(list);
}

/// What a terminal can show: other characters become question marks.
[[nodiscard]] inline std::string printable(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32 || static_cast<unsigned char>(c) > 126) c = '?';
  return text;
}

/// A string as TOML has it, in quotes.
[[nodiscard]] std::string toml_text(const std::string& text);

/// Whether a spreadsheet takes a cell for a formula, which may run programs.
[[nodiscard]] inline bool is_formula(std::string_view cell) {
  return !cell.empty() && std::string_view("=+-@\t\r").find(cell.front()) != std::string_view::npos;
}
/// A name as a cell of a CSV file: one cell, and no formula.
[[nodiscard]] std::string csv_name(std::string name);
/// The cells of a line of a CSV file as csv_name() and numbers make it: no quotes. An empty one at the end does not count.
[[nodiscard]] std::vector<std::string> csv_cells(const std::string& line);

/// The name of `names` nearest to a misspelt one, or "" if none is near.
[[nodiscard]] std::string nearest(const std::string& word, const std::vector<std::string>& names);
/// " did you mean 'x'?" or, if nothing is near, " valid: a, b, c", or " there is none".
[[nodiscard]] std::string suggestion(const std::string& word, const std::vector<std::string>& names);

}  // namespace voile
