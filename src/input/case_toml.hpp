// A case file as a tree of TOML; private to src/input.
#pragma once

#include <fmt/format.h>
#include <toml++/toml.h>

#include <string>

#include "case_read.hpp"
#include "voile/errors.hpp"

namespace voile::input {

struct CaseReader::Impl {
  std::string file;
  toml::table root;
  UnitSystem units;

  [[nodiscard]] const toml::table* section(const std::string& name, std::size_t n) const {
    const toml::node* node = root.get(name);
    if (!node) return nullptr;
    return node->is_table() ? node->as_table() : (*node->as_array())[n].as_table();
  }
};

[[nodiscard]] inline int line_of(const toml::source_region& source) {
  return static_cast<int>(source.begin.line);
}

[[noreturn]] inline void fail_at(const std::string& file, int line, const std::string& message) {
  throw UserError(fmt::format("{}{}: {}", file, line > 0 ? fmt::format(":{}", line) : "", message));
}

}  // namespace voile::input
