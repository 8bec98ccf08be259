#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>

#include "base/plain_file.hpp"
#include "base/text.hpp"
#include "plot.hpp"
#include "voile/errors.hpp"

namespace voile::picture {

namespace fs = std::filesystem;

namespace {

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> row;
  std::string cell;
  for (std::istringstream in(line + ","); std::getline(in, cell, ',');) {
    while (!cell.empty() && (cell.back() == ' ' || cell.back() == '\r')) cell.pop_back();
    while (!cell.empty() && cell.front() == ' ') cell.erase(0, 1);
    row.push_back(cell);
  }
  return row;
}

/// Stages of a run, each with a table of its own.
std::string folders_with_tables(const fs::path& place) {
  std::vector<std::string> found;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(place, ignored))
    if (fs::exists(entry.path() / "history.csv", ignored)) found.push_back(entry.path().string());
  std::sort(found.begin(), found.end());
  return join(found, ", ");
}

}  // namespace

bool Table::has(const std::string& name) const {
  return std::find(names.begin(), names.end(), name) != names.end();
}

const std::vector<double>& Table::column(const std::string& name) const {
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end())
    throw UserError(fmt::format("{}: there is no column '{}':{}", file.string(), name, suggestion(name, names)));
  return columns[static_cast<std::size_t>(at - names.begin())];
}

Table read_table(const fs::path& place) {
  std::error_code ignored;
  Table table;
  table.file = fs::is_directory(place, ignored) ? place / "history.csv" : place;
  std::ifstream in = open_input(table.file);
  if (!in) {
    const std::string stages = folders_with_tables(place);
    throw UserError(
        fmt::format("{}: there is no such table; give {}", table.file.string(),
                    stages.empty() ? "the output folder of a run, or a CSV file" : "that of a stage: " + stages));
  }
  for (std::string line; std::getline(in, line);) {
    if (line.find('\0') != std::string::npos)
      throw UserError(fmt::format("{}: this is no CSV file: it is not text", table.file.string()));
    if (line.empty() || line[0] == '#') continue;
    const std::vector<std::string> row = cells(line);
    if (table.names.empty()) {
      table.names = row;
      table.columns.resize(row.size());
    } else if (row.size() == table.names.size()) {
      for (std::size_t i = 0; i < row.size(); ++i) {
        char* end = nullptr;
        const double x = std::strtod(row[i].c_str(), &end);
        table.columns[i].push_back(row[i].empty() || *end != '\0' ? std::numeric_limits<double>::quiet_NaN() : x);
      }
    }
  }
  if (table.names.empty()) throw UserError(fmt::format("{}: the table is empty", table.file.string()));
  return table;
}

}  // namespace voile::picture
