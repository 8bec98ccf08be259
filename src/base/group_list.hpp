// Several groups that count as one: a name made of theirs.
#pragma once

#include <string>
#include <vector>

#include "text.hpp"

namespace voile {

inline constexpr const char* group_separator = " + ";

[[nodiscard]] inline std::string group_name(const std::vector<std::string>& groups) {
  return join(groups, group_separator);
}

/// The names that group_name() has joined; a single one as it is.
[[nodiscard]] inline std::vector<std::string> groups_of(const std::string& name) {
  const std::string separator = group_separator;
  std::vector<std::string> groups;
  std::size_t from = 0;
  for (std::size_t at = name.find(separator); at != std::string::npos; at = name.find(separator, from)) {
    groups.push_back(name.substr(from, at - from));
    from = at + separator.size();
  }
  groups.push_back(name.substr(from));
  return groups;
}

}  // namespace voile
