// Figures of a sheet: which names it has, in which units; private to src/fit.
#pragma once

#include <toml++/toml.h>

#include <string>
#include <utility>
#include <vector>

#include "input/units.hpp"
#include "sheet.hpp"

namespace voile::fit {

/// A name of a sheet.
struct Column {
  std::string section;  ///< "", "kes", "fast"
  std::string key;
  std::vector<input::Dimension> dimensions;               ///< the first one named in messages; empty: a ratio
  std::string unit;                                       ///< of numbers without one; empty: they need one
  std::vector<std::pair<std::string, Instrument>> parts;  ///< by direction; one with the name "": it has none
};

[[nodiscard]] const std::vector<Column>& columns();
/// Figures of KES and FAST that no key of a fabric file depends on.
[[nodiscard]] const std::vector<std::string>& unused_names(const std::string& section);
[[nodiscard]] int line_of(const toml::node& node);

/// Reads a figure, a list of specimens, or a table of both by direction into the sheet.
void read_column(Sheet& sheet, const Column& column, const toml::node& node);
/// A number, a text or a list of one dimension. `unit`: as of a column.
[[nodiscard]] Figure read_figure(const Sheet& sheet, const std::string& key,
                                 const std::vector<input::Dimension>& dimensions, const std::string& unit,
                                 const toml::node& node);

}  // namespace voile::fit
