#include "case_read.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "base/text.hpp"
#include "case_settings.hpp"
#include "case_toml.hpp"
#include "value_reader.hpp"
#include "voile/errors.hpp"

namespace voile::input {

namespace {

std::vector<std::string> names_of(const std::vector<Key>& keys, const std::string& type) {
  std::vector<std::string> names;
  for (const Key& key : keys)
    if (applies(key, type)) names.push_back(key.name);
  return names;
}

const Key* find_key(const std::vector<Key>& keys, std::string_view name) {
  const auto at = std::find_if(keys.begin(), keys.end(), [&](const Key& k) { return k.name == name; });
  return at == keys.end() ? nullptr : &*at;
}

/// Reads the section's type, on which the meaning of its other keys depends. "" if it has none.
std::string read_type(const SectionPlace& place, const std::vector<Key>& keys, const toml::table& table) {
  const Key* key = find_key(keys, "type");
  if (!key) return "";
  const Choice& choice = std::get<Choice>(key->slot);
  const toml::node* node = table.get("type");
  if (!node && key->required) {
    for (const auto& [k, other] : table)
      if (const std::string hint = suggestion(std::string(k.str()), {"type"});
          !find_key(keys, k) && hint.ends_with('?'))
        fail_at(place.file, line_of(k.source()), fmt::format("[{}] unknown key '{}':{}", place.name, k.str(), hint));
    place.fail("type", fmt::format("the key is missing; choose one of: {}", join(choice.names, ", ")));
  }
  if (node) ValueReader(place, *key, *node)(choice);
  return choice.names[static_cast<std::size_t>(choice.get())];
}

/// What to write instead of a key of an earlier version; empty if there was none of that name.
std::string successor(const std::string& section, std::string_view key) {
  struct Former {
    const char *section, *key, *instead;
  };
  static constexpr Former former[] = {
      {"element", "membrane",
       "element.type names the whole element: \"corrected\" is the default, \"six_node\" that of 0.1"},
      {"element", "bending", "element.type names the whole element: \"angles\" is what was edge_angle"},
      {"element", "cst_share", "the key is called cst_fraction"},
      {"time", "radius", "the key is called spectral_radius"}};
  for (const Former& f : former)
    if (section == f.section && key == f.key) return f.instead;
  return "";
}

/// Defaults are kept in SI.
void convert_default(const Key& key, const std::string& type, const UnitSystem& units) {
  double* const* number = std::get_if<double*>(&key.slot);
  const std::string unit = unit_for(key.unit, type);
  if (number && !unit.empty()) **number = units.own_default(**number, unit);
}

/// What is wrong, by line.
using Mistakes = std::vector<std::pair<int, std::string>>;

/// With `mistakes`, what is wrong goes there, and the work goes on.
template <class Work>
void attempt(Mistakes* mistakes, int line, const Work& work) {
  if (!mistakes) return work();
  try {
    work();
  } catch (const UserError& e) {
    mistakes->emplace_back(line, e.what());
  }
}

/// Whether one of the mistakes is a misspelling of this key, so that it is not missing too.
bool is_misspelt(const Mistakes& mistakes, const std::string& key) {
  const std::string hint = fmt::format("did you mean '{}'?", key);
  return std::any_of(mistakes.begin(), mistakes.end(), [&](const auto& m) { return m.second.ends_with(hint); });
}

/// Reads one key that is there.
void read_key(const SectionPlace& place, const std::pair<std::string, const toml::node*>& given,
              const std::vector<Key>& keys, const std::string& type, const UnitSystem& units) {
  const auto& [name, node] = given;
  const int line = place.key_lines.at(name);
  const Key* key = find_key(keys, name);
  const std::string section = place.name.empty() ? "" : fmt::format("[{}] ", place.name);
  if (const std::string instead = key ? "" : successor(place.name, name); !instead.empty())
    fail_at(place.file, line, fmt::format("{}key '{}' is of version 0.1: {}", section, name, instead));
  const std::vector<std::string> valid = names_of(keys, type);
  if (!key) fail_at(place.file, line, fmt::format("{}unknown key '{}':{}", section, name, suggestion(name, valid)));
  if (!applies(*key, type))
    fail_at(
        place.file, line,
        fmt::format("{}key '{}' does not belong to type '{}'; that has: {}", section, name, type, join(valid, ", ")));
  if (name != "type") std::visit(ValueReader(place, *key, *node, type, units), key->slot);
}

SectionPlace read_table(SectionPlace place, const toml::table& table, const std::vector<Key>& keys,
                        const UnitSystem& units, Mistakes* mistakes = nullptr) {
  for (const auto& [name, node] : table) place.key_lines[std::string(name.str())] = line_of(name.source());
  std::optional<std::string> type;
  attempt(mistakes, place.line, [&] { type = read_type(place, keys, table); });
  if (!type) return place;
  for (const auto& [name, node] : table) {
    const std::pair<std::string, const toml::node*> given{std::string(name.str()), &node};
    attempt(mistakes, line_of(name.source()), [&] { read_key(place, given, keys, *type, units); });
  }
  for (const Key& key : keys) {
    if (place.has(key.name)) continue;
    if (mistakes && is_misspelt(*mistakes, key.name)) continue;
    attempt(mistakes, place.line, [&] {
      if (is_required(key, *type)) place.fail(key.name, fmt::format("the key is missing; {}", key.meaning));
    });
    convert_default(key, *type, units);
  }
  return place;
}

}  // namespace

void SectionPlace::fail(const std::string& key, const std::string& message) const {
  const auto at = key_lines.find(key);
  const int where = at == key_lines.end() ? line : at->second;
  throw UserError(fmt::format("{}{}: {}{}: {}", file, where > 0 ? fmt::format(":{}", where) : "", name,
                              name.empty() ? key : "." + key, message));
}

void require_column_name(const SectionPlace& place, const std::string& name) {
  for (const char c : name)
    if (c == ',' || c == '"' || static_cast<unsigned char>(c) < 32)
      place.fail("name", fmt::format("'{}': a column name must not contain commas, quotes or line breaks", name));
  if (is_formula(name))
    place.fail("name",
               fmt::format("'{}': a column name must not begin with =, +, - or @: spreadsheets would run it", name));
}

CaseReader::CaseReader(const std::string& text, const std::filesystem::path& file, const std::vector<Key>& top,
                       const std::vector<std::string>& settings)
    : impl_(std::make_unique<Impl>()) {
  impl_->file = file.string();
  try {
    impl_->root = toml::parse(text);
  } catch (const toml::parse_error& e) {
    fail_at(impl_->file, line_of(e.source()), fmt::format("this is not valid TOML: {}", e.description()));
  }
  for (const std::string& setting : settings) apply_setting(impl_->root, setting);
  std::vector<std::string> known;
  for (const SectionInfo& info : sections()) known.push_back(info.name);
  for (const Key& key : top) known.push_back(key.name);
  for (const auto& [name, node] : impl_->root) {
    const int line = line_of(name.source());
    const std::string key(name.str());
    if (find_key(top, key)) continue;
    const auto info = std::find_if(sections().begin(), sections().end(), [&](const auto& s) { return s.name == key; });
    if (info == sections().end())
      fail_at(impl_->file, line,
              fmt::format("unknown {} '{}':{}", node.is_value() ? "key" : "section", key, suggestion(key, known)));
    const bool right = info->repeated ? node.is_array_of_tables() : node.is_table();
    if (!right)
      fail_at(
          impl_->file, line,
          fmt::format("section '{}' must be written {}", key, info->repeated ? "[[" + key + "]]" : "[" + key + "]"));
  }
}

CaseReader::~CaseReader() = default;

void CaseReader::set_units(const UnitSystem& units) {
  impl_->units = units;
}

const UnitSystem& CaseReader::units() const {
  return impl_->units;
}

std::size_t CaseReader::count(const std::string& section) const {
  const toml::node* node = impl_->root.get(section);
  return !node ? 0 : node->is_table() ? 1 : node->as_array()->size();
}

SectionPlace CaseReader::read(const std::string& section, std::size_t n, const std::vector<Key>& keys) const {
  static const toml::table none;
  const toml::table* table = impl_->section(section, n);
  return read_table({impl_->file, section, table ? line_of(table->source()) : 0, {}}, table ? *table : none, keys,
                    impl_->units);
}

std::vector<std::string> CaseReader::mistakes(const KeysOf& keys) const {
  Mistakes found;
  const auto look = [&](const std::string& section, const toml::node& node) {
    if (const toml::table* table = node.as_table())
      read_table({impl_->file, section, line_of(node.source()), {}}, *table, keys(section), impl_->units, &found);
  };
  const auto look_in = [&](const toml::table& tables) {
    for (const SectionInfo& info : sections()) {
      const toml::node* node = info.name == "stage" ? nullptr : tables.get(info.name);
      if (node && node->is_table()) look(info.name, *node);
      if (node && node->is_array())
        for (const toml::node& item : *node->as_array()) look(info.name, item);
    }
  };
  look_in(impl_->root);
  if (const toml::node* stages = impl_->root.get("stage"); stages && stages->is_array())
    for (const toml::node& stage : *stages->as_array())
      if (stage.is_table()) look_in(*stage.as_table());
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> texts;
  for (auto& [line, text] : found) texts.push_back(std::move(text));
  return texts;
}

SectionPlace CaseReader::read_top(const std::vector<Key>& keys) const {
  toml::table table;
  SectionPlace place{impl_->file, "", 0, {}};
  for (const Key& key : keys)
    if (const toml::node* node = impl_->root.get(key.name)) {
      place.key_lines[key.name] = line_of(node->source());
      std::visit(ValueReader(place, key, *node), key.slot);
    }
  return place;
}

}  // namespace voile::input
