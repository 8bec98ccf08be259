#include "text.hpp"

#include <algorithm>
#include <sstream>

namespace voile {

namespace {

/// Edit distance in which swapping two neighbouring letters counts once.
int distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<int>> d(a.size() + 1, std::vector<int>(b.size() + 1, 0));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = static_cast<int>(i);
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= a.size(); ++i)
    for (std::size_t j = 1; j <= b.size(); ++j) {
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

}  // namespace

std::string toml_text(const std::string& text) {
  std::string all = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') all += '\\';
    if (static_cast<unsigned char>(c) < 32 || c == 127)
      all += fmt::format("\\u{:04x}", static_cast<int>(c));
    else
      all += c;
  }
  return all + '"';
}

std::string csv_name(std::string name) {
  for (char& c : name)
    if (c == ',' || c == '"' || static_cast<unsigned char>(c) < 32) c = '_';
  return is_formula(name) ? "'" + name : name;
}

std::vector<std::string> csv_cells(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
  return cells;
}

std::string nearest(const std::string& word, const std::vector<std::string>& names) {
  std::string best;
  int best_distance = std::max(2, static_cast<int>(word.size()) / 3) + 1;
  for (const std::string& name : names)
    if (const int d = distance(word, name); d < best_distance && d < static_cast<int>(name.size())) {
      best = name;
      best_distance = d;
    }
  return best;
}

std::string suggestion(const std::string& word, const std::vector<std::string>& names) {
  if (names.empty()) return " there is none";
  const std::string near = nearest(word, names);
  return near.empty() ? fmt::format(" valid: {}", join(names, ", ")) : fmt::format(" did you mean '{}'?", near);
}

}  // namespace voile
