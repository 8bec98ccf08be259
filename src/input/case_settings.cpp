#include "case_settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <sstream>
#include <utility>

#include "base/text.hpp"
#include "case_keys.hpp"
#include "voile/errors.hpp"

namespace voile::input {

namespace {

/// The name of a stage with a value of its own for a key that is set for all, and the key that sets it there; empty: none.
std::pair<std::string, std::string> stage_with(const toml::table& root, const std::vector<std::string>& path) {
  const toml::array* stages = root["stage"].as_array();
  if (!stages || path.size() < 2 || !contains(stage_tables(), path.front())) return {};
  for (std::size_t k = 0; k < stages->size(); ++k) {
    const toml::table* stage = stages->get(k)->as_table();
    if (stage && (*stage)[path[0]][path[1]])
      return {(*stage)["name"].value_or(std::to_string(k)), fmt::format("stage.{}.{}", k, join(path, "."))};
  }
  return {};
}

}  // namespace

void apply_setting(toml::table& root, const std::string& setting) {
  const auto fail = [&](const std::string& why) { throw UserError(fmt::format("--set {}: {}", setting, why)); };
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos || equals == 0) fail("write key=value, e.g. mesh.parameters.n=40");
  std::vector<std::string> path;
  std::istringstream words(setting.substr(0, equals));
  for (std::string word; std::getline(words, word, '.');) path.push_back(word);
  const std::string written = setting.substr(equals + 1);
  if (const auto [stage, key] = stage_with(root, path); !key.empty())
    fail(fmt::format("stage '{}' has its own value, which would stay; set {} instead", stage, key));
  toml::table value;
  try {
    value = toml::parse("value = " + written);
  } catch (const toml::parse_error&) {
    value.insert_or_assign("value", written);
  }
  toml::node* node = &root;
  for (std::size_t k = 0; k + 1 < path.size(); ++k) {
    if (toml::array* list = node->as_array()) {
      const bool number = !path[k].empty() && std::all_of(path[k].begin(), path[k].end(), ::isdigit);
      const std::size_t n = number ? std::stoul(path[k]) : list->size();
      if (n >= list->size())
        fail(fmt::format("'{}' is not the number of one of its {} sections, counted from 0", path[k], list->size()));
      node = list->get(n);
    } else if (toml::table* table = node->as_table()) {
      if (!table->contains(path[k])) table->insert(path[k], toml::table{});
      node = table->get(path[k]);
    } else {
      fail(fmt::format("'{}' lies in a plain value", path[k]));
    }
  }
  toml::table* table = node->as_table();
  if (!table)
    fail(fmt::format("'{}' has no keys; a section that can repeat needs its number, counted from 0", path.front()));
  value.get("value")->visit([&](auto& v) { table->insert_or_assign(path.back(), v); });
}

}  // namespace voile::input
