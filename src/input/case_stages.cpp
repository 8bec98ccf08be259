// Stages of a case file.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <sstream>

#include "base/text.hpp"
#include "case_keys.hpp"
#include "case_materials.hpp"
#include "case_toml.hpp"

namespace voile::input {

namespace {

/// Analyses that know no contact.
bool has_contact(Analysis analysis) {
  return analysis == Analysis::statics || analysis == Analysis::dynamic || analysis == Analysis::drape;
}

/// Names of the stages; each is a folder of its own.
std::vector<std::string> stage_names(const std::string& file, const toml::array& stages) {
  std::vector<std::string> names;
  for (const toml::node& node : stages) {
    const toml::table& stage = *node.as_table();
    const toml::node* name = stage.get("name");
    const int line = line_of(node.source());
    if (!name || !name->is_string())
      fail_at(file, line, "[[stage]] name: the key is missing; give each stage a name in quotes");
    const std::string word = *name->value<std::string>();
    const bool good = !word.empty() && std::all_of(word.begin(), word.end(), [](unsigned char c) {
      return std::isalnum(c) || c == '_' || c == '-';
    });
    if (!good || word == "steps" || word == "modes")
      fail_at(file, line,
              fmt::format("[[stage]] name '{}': it becomes the name of a folder; use letters, digits, '_' and '-', and "
                          "neither 'steps' nor 'modes'",
                          word));
    if (contains(names, word)) fail_at(file, line, fmt::format("[[stage]] name '{}': another stage has it", word));
    names.push_back(word);
  }
  return names;
}

/// Moves the keys of `from` over those of `to`. A key that is there already would keep its old line number.
void overlay(toml::table& from, toml::table& to) {
  for (auto&& [key, node] : from)
    node.visit([&, &name = key](auto& value) {
      to.erase(name.str());
      to.insert_or_assign(name, std::move(value));
    });
}

/// Moves the stage's own tables to the root.
void take_tables(const std::string& file, toml::table& stage, toml::table& root) {
  std::vector<std::string> valid = stage_tables();
  valid.insert(valid.end(), {"name", "analysis", "sew"});
  for (auto&& [key, node] : stage) {
    const std::string name(key.str());
    if (!contains(valid, name))
      fail_at(file, line_of(key.source()),
              fmt::format("[[stage]]: unknown key or table '{}':{}", name, suggestion(name, valid)));
    if (!contains(stage_tables(), name)) continue;
    toml::table* own = node.as_table();
    if (!own) fail_at(file, line_of(key.source()), fmt::format("it must be written [stage.{}]", name));
    if (toml::table* there = root[name].as_table())
      overlay(*own, *there);
    else
      root.insert_or_assign(name, std::move(*own));
  }
}

/// The seams that a stage closes.
void take_sew(const std::string& file, const toml::table& stage, StageSection& s) {
  const toml::node* given = stage.get("sew");
  if (!given) return;
  const int line = line_of(given->source());
  const toml::array* list = given->as_array();
  if (!list || list->empty())
    fail_at(file, line, "[[stage]] sew: a list of names of seams is needed, or [\"all\"]; leave the key out for none");
  for (const toml::node& node : *list) {
    if (!node.is_string()) fail_at(file, line, "[[stage]] sew: names of seams are texts in quotes");
    s.sew.push_back(*node.value<std::string>());
  }
  if (s.analysis != Analysis::dynamic)
    fail_at(file, line,
            fmt::format("[[stage]] '{}' sew: seams are closed in time, and analysis = \"{}\" has none; choose "
                        "\"dynamic\"",
                        s.name, word_of(s.analysis)));
}

/// Whether an item with the key `stages` holds in a stage; takes the key away.
bool holds(const std::string& file, const std::string& section, toml::table& item, const std::string& stage,
           const std::vector<std::string>& names) {
  const toml::node* given = item.get("stages");
  if (!given) return true;
  const toml::array* list = given->as_array();
  const int line = line_of(given->source());
  if (!list || list->empty())
    fail_at(file, line, fmt::format("{}.stages: a list of names of stages is needed; leave it out for all", section));
  bool found = false;
  for (const toml::node& node : *list) {
    const std::string name = node.is_string() ? *node.value<std::string>() : "";
    if (!contains(names, name))
      fail_at(file, line, fmt::format("{}.stages: there is no stage '{}':{}", section, name, suggestion(name, names)));
    found = found || name == stage;
  }
  item.erase("stages");
  return found;
}

/// Throws UserError for initial velocities that are only for a stage which goes on from a motion: it has velocities.
void refuse_late_velocities(const std::string& file, toml::table& root, const std::string& stage) {
  toml::array* items = root["initial_velocity"].as_array();
  for (std::size_t i = 0; items && i < items->size(); ++i) {
    const toml::node* given = items->get(i)->as_table()->get("stages");
    const toml::array* list = given ? given->as_array() : nullptr;
    if (list && list->size() == 1 && list->get(0)->value<std::string>() == stage)
      fail_at(file, line_of(given->source()),
              fmt::format("initial_velocity.stages: stage '{}' continues a motion, with its velocities; name the first "
                          "motion, or push by a [[load]] with a history",
                          stage));
  }
}

/// Takes away what does not hold in a stage; returns the numbers of what is left.
std::vector<std::size_t> select_items(const std::string& file, const std::string& section, toml::table& root,
                                      const std::string& stage, const std::vector<std::string>& names) {
  std::vector<std::size_t> kept;
  toml::array* items = root[section].as_array();
  if (!items) return kept;
  std::size_t number = 0;
  for (std::size_t i = 0; i < items->size(); ++number) {
    if (holds(file, section, *items->get(i)->as_table(), stage, names)) {
      kept.push_back(number);
      ++i;
    } else {
      items->erase(items->begin() + static_cast<std::ptrdiff_t>(i));
    }
  }
  if (items->empty()) root.erase(section);
  return kept;
}

}  // namespace

StageSection CaseReader::select_stage(std::size_t n) {
  toml::table& root = impl_->root;
  const std::string& file = impl_->file;
  if (const toml::node* own = root.get("analysis"))
    fail_at(file, line_of(own->source()), "analysis: each [[stage]] has its own; remove this one");
  const std::vector<std::string> names = stage_names(file, *root["stage"].as_array());
  StageSection s;
  s.number = n;
  toml::table stage = std::move(*root["stage"].as_array()->get(n)->as_table());
  s.name = names[n];
  const toml::node* analysis = stage.get("analysis");
  if (!analysis || !analysis->is_string())
    fail_at(file, line_of(stage.source()), fmt::format("[[stage]] '{}': the key analysis is missing", s.name));
  const std::string word = *analysis->value<std::string>();
  s.analysis = analysis_of(word, Analysis::statics);  // an unknown one is refused with the keys
  if (s.analysis == Analysis::linear && n > 0)
    fail_at(file, line_of(analysis->source()),
            "analysis = \"linear\" starts from the unloaded state; make it the first stage, or choose \"static\"");
  if (n > 0 && s.analysis == Analysis::dynamic &&
      (*root["stage"].as_array()->get(n - 1)->as_table())["analysis"].value<std::string>() == "dynamic")
    refuse_late_velocities(file, root, s.name);
  take_sew(file, stage, s);
  take_tables(file, stage, root);
  root.insert_or_assign("analysis", word);
  for (const std::string& section : staged_items()) {
    std::vector<std::size_t> kept = select_items(file, section, root, s.name, names);
    if (section == "support")
      s.supports = std::move(kept);
    else if (section == "load")
      s.loads = std::move(kept);
    else if (section == "temperature")
      s.temperatures = std::move(kept);
    else if (section == "obstacle")
      s.obstacles = std::move(kept);
    else if (section == "spring")
      s.springs = std::move(kept);
    else if (section == "rigid")
      s.rigids = std::move(kept);
    else if (section == "periodic")
      s.periodics = std::move(kept);
    else if (section == "attachment")
      s.attachments = std::move(kept);
  }
  if (s.analysis != Analysis::dynamic) root.erase("initial_velocity");
  if (!has_contact(s.analysis))
    for (const char* section : {"contact", "obstacle", "contact_rule", "attachment"}) root.erase(section);
  root.erase("stage");
  return s;
}

std::string CaseReader::text(const std::filesystem::path& folder) const {
  toml::table root = impl_->root;
  const auto make_absolute = [&](toml::table* item, const char* key) {
    if (!item || !(*item)[key].is_string()) return;
    const std::filesystem::path path = *(*item)[key].value<std::string>();
    std::filesystem::path file = (folder / path).lexically_normal();
    std::error_code ignored;
    if (std::string_view(key) == "fabric" || std::string_view(key) == "interlining")
      for (const std::filesystem::path& place : fabric_places(folder / "case.toml", path))
        if (std::filesystem::is_regular_file(place, ignored)) {
          file = place;
          break;
        }
    item->insert_or_assign(key, file.string());
  };
  const std::array paths{
      std::pair{"mesh", "file"},          std::pair{"mesh", "start"},           std::pair{"panel", "file"},
      std::pair{"material", "fabric"},    std::pair{"obstacle", "file"},        std::pair{"obstacle", "frames"},
      std::pair{"obstacle", "landmarks"}, std::pair{"material", "interlining"}, std::pair{"imperfection", "results"},
      std::pair{"remesh", "background"}};
  for (const auto& [section, key] : paths) {
    if (toml::array* items = root[section].as_array())
      for (toml::node& item : *items) make_absolute(item.as_table(), key);
    make_absolute(root[section].as_table(), key);
  }
  if (toml::array* stages = root["stage"].as_array())
    for (toml::node& stage : *stages)
      if (toml::table* remesh = (*stage.as_table())["remesh"].as_table()) make_absolute(remesh, "background");
  std::ostringstream out;
  out << toml::toml_formatter(root) << '\n';
  return out.str();
}

}  // namespace voile::input
