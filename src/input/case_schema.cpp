// JSON schema of the case file.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/text.hpp"
#include "case_declarations.hpp"

namespace voile::input {

namespace {

using Json = nlohmann::ordered_json;

Json number_type(const Range& range) {
  Json j{{"type", "number"}};
  if (std::isfinite(range.low)) j[range.low_open ? "exclusiveMinimum" : "minimum"] = range.low;
  if (std::isfinite(range.high)) j["maximum"] = range.high;
  return j;
}

Json array_of(Json items, int count = 0) {
  Json j{{"type", "array"}, {"items", std::move(items)}};
  if (count > 0) j["minItems"] = j["maxItems"] = count;
  return j;
}

/// What may be written for a key.
struct Type {
  const Key& key;

  Json operator()(const double*) const { return measured(number_type(key.range)); }
  Json operator()(const Degrees&) const { return measured(number_type(key.range)); }
  Json operator()(const int*) const {
    Json j = number_type(key.range);
    j["type"] = "integer";
    return j;
  }
  Json operator()(const bool*) const { return {{"type", "boolean"}}; }
  Json operator()(const std::string*) const { return formula(); }
  Json operator()(const std::filesystem::path*) const { return {{"type", "string"}}; }
  Json operator()(const Choice& c) const { return {{"enum", c.names}}; }
  Json operator()(const Words& w) const {
    return array_of(w.allowed.empty() ? Json{{"type", "string"}} : Json{{"enum", w.allowed}});
  }
  Json operator()(const std::vector<std::string>*) const { return array_of(formula()); }
  Json operator()(const GroupList&) const {
    const Json text{{"type", "string"}};
    return {{"anyOf", {text, array_of(text)}}};
  }
  Json operator()(const std::vector<double>*) const { return array_of(measured(number_type(key.range))); }
  Json operator()(const std::vector<int>*) const { return axes(); }
  Json operator()(const std::array<bool, 3>*) const { return axes(); }
  Json operator()(const Vec3*) const { return array_of(measured({{"type", "number"}}), 3); }
  Json operator()(const std::optional<Vec3>*) const { return array_of(measured({{"type", "number"}}), 3); }
  Json operator()(const PointInput*) const {
    return {{"anyOf", {array_of({{"type", "number"}}, 3), {{"type", "string"}}}}};
  }
  Json operator()(const std::optional<PointInput>*) const { return (*this)(static_cast<PointInput*>(nullptr)); }
  Json operator()(const Mat3*) const { return array_of(array_of({{"type", "number"}}, 3), 3); }
  Json operator()(const std::map<std::string, double>*) const {
    return {{"type", "object"}, {"additionalProperties", {{"type", "number"}}}};
  }
  /// A text with a unit does as well.
  [[nodiscard]] Json measured(Json number) const {
    return key.unit.empty() ? number : Json{{"anyOf", {std::move(number), {{"type", "string"}}}}};
  }
  /// An expression has a unit; then a number does as well.
  [[nodiscard]] Json formula() const {
    const Json text{{"type", "string"}};
    return key.unit.empty() ? text : Json{{"anyOf", {text, {{"type", "number"}}}}};
  }
  static Json axes() { return array_of({{"enum", {"x", "y", "z"}}}); }
};

Json table_of(const std::vector<Key>& keys) {
  Json properties = Json::object(), required = Json::array();
  for (const Key& key : keys) {
    Json j = std::visit(Type{key}, key.slot);
    j["description"] = key.unit.empty() ? key.meaning : key.meaning + " [" + key.unit + "]";
    properties[key.name] = std::move(j);
    // What depends on `type` is left to the program.
    if (key.required && key.types.empty()) required.push_back(key.name);
  }
  Json table{{"type", "object"}, {"additionalProperties", false}, {"properties", std::move(properties)}};
  if (!required.empty()) table["required"] = std::move(required);
  return table;
}

}  // namespace

std::string case_schema() {
  const Declarations declared;
  Json root = table_of(declared.top());
  for (const SectionInfo& section : sections()) {
    Json table = table_of(declared.of(section.name));
    if (contains(staged_items(), section.name)) table["properties"]["stages"] = array_of({{"type", "string"}});
    if (section.name == "stage")
      for (const std::string& own : stage_tables()) {
        table["properties"][own] = table_of(declared.of(own));
        table["properties"][own].erase("required");
      }
    if (section.repeated) table = array_of(std::move(table));
    table["description"] = section.meaning;
    root["properties"][section.name] = std::move(table);
  }
  root["required"] = Json::array({"material"});
  Json out{{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", "Voile case"}};
  out.update(root);
  return out.dump(2) + "\n";
}

}  // namespace voile::input
