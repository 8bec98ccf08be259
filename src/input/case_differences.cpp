#include "case_differences.hpp"

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>

#include "base/text.hpp"
#include "case_toml.hpp"

namespace voile::input {

namespace {

std::string text_of(const toml::node* node) {
  std::ostringstream out;
  if (node) node->visit([&](const auto& n) { out << n; });
  return out.str();
}

/// Keys of two tables that differ; of plain values what they were and are.
std::vector<std::string> different_keys(const toml::table& was, const toml::table& is) {
  std::set<std::string> keys;
  for (const toml::table* table : {&was, &is})
    for (const auto& [key, node] : *table) keys.insert(std::string(key.str()));
  std::vector<std::string> found;
  for (const std::string& key : keys) {
    const toml::node *before = was.get(key), *now = is.get(key);
    if (text_of(before) == text_of(now)) continue;
    const bool plain = before && now && before->is_value() && now->is_value();
    found.push_back(plain ? fmt::format("{} {}, here {}", key, text_of(before), text_of(now)) : key);
  }
  return found;
}

std::vector<const toml::table*> tables_of(const toml::table& root, const char* section) {
  std::vector<const toml::table*> all;
  const toml::node* node = root.get(section);
  if (node && node->is_table()) all.push_back(node->as_table());
  if (const toml::array* items = node ? node->as_array() : nullptr)
    for (const toml::node& item : *items)
      if (item.is_table()) all.push_back(item.as_table());
  return all;
}

/// Its resolved keys are those of matrices.
bool is_fabric(const Case& c, const std::string& section, std::size_t n) {
  return section == "material" && n < c.written_materials.size() && c.written_materials[n].empty();
}

}  // namespace

std::vector<SectionDifference> different_sections(const Case& c, const std::filesystem::path& resolved) {
  toml::table was, is;
  const std::ifstream in(resolved);
  if (!in) return {};
  std::ostringstream text;
  text << in.rdbuf();
  try {
    was = toml::parse(text.str());
    is = toml::parse(echo_case(c));
  } catch (const toml::parse_error&) {
    return {};
  }
  std::vector<SectionDifference> found;
  for (const char* section : {"units", "element", "material", "hinge"}) {
    const std::vector<const toml::table*> before = tables_of(was, section), now = tables_of(is, section);
    if (before.size() != now.size())
      found.push_back({section, fmt::format("[{}]: {} of them, here {}", section, before.size(), now.size())});
    for (std::size_t n = 0; n < std::min(before.size(), now.size()); ++n)
      if (const std::vector<std::string> keys = different_keys(*before[n], *now[n]); !keys.empty())
        found.push_back(
            {section, fmt::format("[{}]{}: {}{}", section, now.size() > 1 ? fmt::format(" {}", n + 1) : "",
                                  is_fabric(c, section, n) ? "fabric or warp_angle, with " : "", join(keys, "; "))});
  }
  return found;
}

}  // namespace voile::input
