// Names in which `*` stands for a text.
#pragma once

#include <optional>
#include <string>

namespace voile {

[[nodiscard]] inline bool has_star(const std::string& name) {
  return name.find('*') != std::string::npos;
}
/// The name with every `*` replaced by `text`.
[[nodiscard]] std::string with_star(std::string name, const std::string& text);
/// What each `*` of a pattern, the same everywhere and at least a letter, stands for in a name; nothing if it has none or does not match.
[[nodiscard]] std::optional<std::string> star_of(const std::string& pattern, const std::string& name);

}  // namespace voile
