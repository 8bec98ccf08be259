#include "case_lines.hpp"

#include <fstream>
#include <sstream>

#include "case_toml.hpp"

namespace voile::input {

namespace {

bool has_text(const toml::node& node, const std::string& text) {
  if (const toml::array* list = node.as_array()) {
    for (const toml::node& item : *list)
      if (has_text(item, text)) return true;
    return false;
  }
  return node.value<std::string>() == text;
}

int line_in(const toml::table& root, const std::string& section, const std::string& key, const std::string& text) {
  const toml::node* node = root.get(section);
  const auto look = [&](const toml::node& item) {
    const toml::table* table = item.as_table();
    const toml::node* value = table ? table->get(key) : nullptr;
    return value && has_text(*value, text) ? line_of(value->source()) : 0;
  };
  if (node && node->is_table()) return look(*node);
  if (const toml::array* items = node ? node->as_array() : nullptr)
    for (const toml::node& item : *items)
      if (const int line = look(item); line > 0) return line;
  return 0;
}

}  // namespace

std::string place_in_case(const std::filesystem::path& file, const std::string& section, const std::string& key,
                          const std::string& text) {
  toml::table root;
  try {
    const std::ifstream in(file);
    std::ostringstream all;
    all << in.rdbuf();
    root = toml::parse(all.str());
  } catch (const toml::parse_error&) {
    return file.string();
  }
  int line = line_in(root, section, key, text);
  const toml::node* stages = root.get("stage");
  if (stages && stages->is_array())
    for (const toml::node& stage : *stages->as_array())
      if (line == 0 && stage.is_table()) line = line_in(*stage.as_table(), section, key, text);
  return line > 0 ? fmt::format("{}:{}", file.string(), line) : file.string();
}

}  // namespace voile::input
