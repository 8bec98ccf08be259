// What the declarations of the keys share; private to src/input.
#pragma once

#include <algorithm>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "case_keys.hpp"

namespace voile::input {

inline const Range positive{0.0, std::numeric_limits<double>::infinity(), true};
inline const Range not_negative{0.0};

/// Binds an enumeration to the words that stand for its values.
template <class Enum>
Choice choice(Enum& value, const std::vector<std::pair<std::string, Enum>>& words) {
  Choice c;
  for (const auto& entry : words) c.names.push_back(entry.first);
  c.get = [&value, words] {
    const auto at = std::find_if(words.begin(), words.end(), [&](const auto& entry) { return entry.second == value; });
    return static_cast<int>(at - words.begin());
  };
  c.set = [&value, words](int i) { value = words[static_cast<std::size_t>(i)].second; };
  return c;
}

/// Keys that put the points of a file in place; `types`: of the section that has files.
[[nodiscard]] std::vector<Key> placement_keys(formats::Placement& placement, const std::vector<std::string>& types);

/// `first` with `second` behind it.
[[nodiscard]] std::vector<Key> joined(std::vector<Key> first, const std::vector<Key>& second);

/// `first` with `second` after the key `name`.
[[nodiscard]] std::vector<Key> with_keys_after(const std::string& name, std::vector<Key> first,
                                               const std::vector<Key>& second);

/// Keys of a motion in time; `types`: as above.
[[nodiscard]] std::vector<Key> motion_keys(MotionInput& motion, const std::vector<std::string>& types);

}  // namespace voile::input
