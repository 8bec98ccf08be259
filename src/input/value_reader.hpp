// A value of a case file into what its key is bound to; private to src/input.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "base/group_list.hpp"
#include "base/text.hpp"
#include "case_toml.hpp"
#include "voile/errors.hpp"

namespace voile::input {

/// A value as the user wrote it, or nearly so, kept short.
inline std::string text_of(const toml::node& node) {
  if (node.is_floating_point()) return fmt::format("{}", *node.value<double>());
  std::ostringstream out;
  node.visit([&](const auto& n) { out << n; });
  std::string text = out.str();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.size() <= 60 ? text : text.substr(0, 57) + "...";
}

/// Reads one value into one alternative of Slot.
class ValueReader {
 public:
  ValueReader(const SectionPlace& place, const Key& key, const toml::node& node, const std::string& type = "",
              const UnitSystem& units = {})
      : place_(place), key_(key), node_(node), unit_(unit_for(key.unit, type)), units_(units) {}

  void operator()(double* x) const { *x = measured_in_range(number(node_, number_hint())); }
  void operator()(const Degrees& x) const {
    *x.radians = in_range(number(node_, number_hint())) * (std::numbers::pi / 180.0);
  }
  void operator()(int* x) const {
    const auto value = node_.is_integer() ? node_.value<std::int64_t>() : std::nullopt;
    if (!value) refuse("a whole number is needed");
    (void)in_range(static_cast<double>(*value));
    if (std::abs(*value) > std::numeric_limits<int>::max()) refuse("the number is too large");
    *x = static_cast<int>(*value);
  }
  void operator()(bool* x) const {
    if (!node_.is_boolean()) refuse("write true or false, without quotes");
    *x = *node_.value<bool>();
  }
  void operator()(std::string* x) const { *x = filled(formula(node_)); }
  void operator()(std::filesystem::path* x) const { *x = filled(text(node_)); }
  void operator()(const Choice& x) const {
    const auto at = std::find(x.names.begin(), x.names.end(), text(node_));
    if (at == x.names.end()) refuse(fmt::format("unknown value:{}", suggestion(text(node_), x.names)));
    x.set(static_cast<int>(at - x.names.begin()));
  }
  void operator()(const Words& x) const {
    x.values->clear();
    for (const toml::node& item : array("a list of texts in quotes")) {
      const std::string word = filled(text(item));
      if (!x.allowed.empty() && std::find(x.allowed.begin(), x.allowed.end(), word) == x.allowed.end())
        refuse(fmt::format("unknown name '{}':{}", word, suggestion(word, x.allowed)));
      if (std::find(x.values->begin(), x.values->end(), word) != x.values->end())
        refuse(fmt::format("'{}' is there twice; keep one", word));
      x.values->push_back(word);
    }
  }
  void operator()(const GroupList& x) const {
    if (!node_.is_array()) {
      *x.name = filled(text(node_));
      return;
    }
    std::vector<std::string> groups;
    (*this)(Words{&groups, {}});
    *x.name = group_name(groups);
  }
  void operator()(std::vector<std::string>* x) const {
    x->clear();
    for (const toml::node& item : array("a list of texts in quotes")) x->push_back(filled(formula(item)));
  }
  void operator()(std::vector<double>* x) const {
    x->clear();
    for (const toml::node& item : array("a list of numbers"))
      x->push_back(measured_in_range(number(item, "a list of numbers is needed")));
  }
  void operator()(std::vector<int>* x) const { *x = axes(); }
  void operator()(std::array<bool, 3>* x) const {
    *x = {false, false, false};
    for (const int axis : axes()) (*x)[static_cast<std::size_t>(axis)] = true;
  }
  void operator()(Vec3* x) const { *x = vector(node_, "three numbers [x, y, z] are needed"); }
  void operator()(std::optional<Vec3>* x) const {
    *x = vector(node_, "three numbers [x, y, z] are needed");
    // All optional vectors are directions but the point of a probe, which may be the origin.
    if (key_.unit.empty() && (*x)->norm() == 0.0) refuse("a direction must not be zero");
  }
  void operator()(PointInput* x) const {
    *x = {};
    if (node_.is_string())
      x->landmark = filled(text(node_));
    else
      x->at = vector(node_, "three numbers [x, y, z], or a landmark \"OBSTACLE.NAME\" in quotes, are needed");
  }
  void operator()(std::optional<PointInput>* x) const { (*this)(&x->emplace()); }
  void operator()(Mat3* x) const {
    constexpr const char* wanted = "three rows of three numbers are needed: [[a, b, c], [b, d, e], [c, e, f]]";
    const toml::array& rows = array(wanted);
    if (rows.size() != 3) refuse(wanted);
    for (int i = 0; i < 3; ++i) x->row(i) = vector(rows[static_cast<std::size_t>(i)], wanted);
  }
  void operator()(std::map<std::string, double>* x) const {
    const toml::table* table = node_.as_table();
    if (!table) refuse("a table of numbers is needed: { name = 1.0 }");
    if (table->empty()) refuse("the table is empty; leave the key out");
    x->clear();
    for (const auto& [name, value] : *table)
      (*x)[std::string(name.str())] = number(value, fmt::format("'{}' must be a number", name.str()));
  }

 private:
  [[noreturn]] void refuse(const std::string& remedy) const {
    place_.fail(key_.name, fmt::format("{}: {}", text_of(node_), remedy));
  }
  [[nodiscard]] std::string number_hint() const {
    const std::string range = key_.range.text();
    return fmt::format("a number{}{} is needed{}", key_.unit.empty() ? "" : fmt::format(" in {}", key_.unit),
                       range.empty() ? "" : " " + range, node_.is_string() ? "; write it without quotes" : "");
  }
  [[nodiscard]] double number(const toml::node& node, const std::string& remedy) const {
    if (node.is_string() && !unit_.empty()) return measured(*node.value<std::string>());
    if (!node.is_number()) refuse(remedy);
    const double x = *node.value<double>();
    if (!std::isfinite(x)) refuse("the number must be finite");
    return x;
  }
  [[nodiscard]] double measured(const std::string& text) const {
    try {
      return units_.number(text, unit_);
    } catch (const UserError& e) {
      refuse(e.what());
    }
  }
  [[nodiscard]] double in_range(double x) const { return within(key_.range, x, key_.unit); }
  /// Limits are in SI.
  [[nodiscard]] double measured_in_range(double x) const {
    if (units_.is_si() || unit_.empty()) return in_range(x);
    Range own = key_.range;
    for (double* limit : {&own.low, &own.high})
      if (std::isfinite(*limit)) *limit = units_.own_default(*limit, unit_);
    return within(own, x, units_.label(unit_));
  }
  [[nodiscard]] double within(const Range& range, double x, const std::string& unit) const {
    if (!range.contains(x))
      refuse(fmt::format("must be {}{}", range.text(), unit.empty() ? "" : fmt::format(" [{}]", unit)));
    return x;
  }
  [[nodiscard]] std::string text(const toml::node& node) const {
    if (!node.is_string()) refuse("a text in quotes is needed");
    return *node.value<std::string>();
  }
  /// A text, which has a unit if it is an expression: then a number will do, or one with its unit.
  [[nodiscard]] std::string formula(const toml::node& node) const {
    if (key_.unit.empty()) return text(node);
    if (node.is_number()) return fmt::format("{}", number(node, ""));
    std::string written = text(node);
    if (unit_.empty() || written.find(' ') == std::string::npos) return written;
    try {
      return fmt::format("{}", units_.number(written, unit_));
    } catch (const UserError&) {
      return written;
    }
  }
  /// Optional texts may be empty in the echo of a case; names and files may not.
  [[nodiscard]] std::string filled(std::string value) const {
    const bool free_text = key_.name == "title" || key_.name == "options";
    if (value.empty() && !free_text) refuse("the text is empty");
    return value;
  }
  [[nodiscard]] const toml::array& array(const std::string& what) const {
    const toml::array* items = node_.as_array();
    if (!items) refuse(fmt::format("{} is needed, in square brackets", what));
    if (items->empty()) refuse("the list is empty; fill it or leave the key out");
    return *items;
  }
  [[nodiscard]] Vec3 vector(const toml::node& node, const char* wanted) const {
    const toml::array* items = node.as_array();
    if (!items || items->size() != 3) refuse(wanted);
    return {number((*items)[0], wanted), number((*items)[1], wanted), number((*items)[2], wanted)};
  }
  [[nodiscard]] std::vector<int> axes() const {
    std::vector<int> found;
    for (const toml::node& item : array("a list of \"x\", \"y\", \"z\"")) {
      const std::string name = text(item);
      const std::size_t axis = name.size() == 1 ? std::string("xyz").find(name) : std::string::npos;
      if (axis == std::string::npos) refuse(fmt::format("unknown axis '{}'; use \"x\", \"y\", \"z\"", name));
      if (std::find(found.begin(), found.end(), static_cast<int>(axis)) != found.end())
        refuse(fmt::format("axis '{}' is there twice; keep one", name));
      found.push_back(static_cast<int>(axis));
    }
    std::sort(found.begin(), found.end());
    return found;
  }

  const SectionPlace& place_;
  const Key& key_;
  const toml::node& node_;
  std::string unit_;
  UnitSystem units_;
};

}  // namespace voile::input
