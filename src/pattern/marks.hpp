// Points of pieces that have a name: buttons, what is held or measured there.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "seams.hpp"

namespace voile::pattern {

/// As a case writes it.
struct MarkRequest {
  std::string name, where;  ///< of the mark; for messages
  std::string point{};      ///< a point of an outline, "PANEL@POINT"; empty: `panel` and `at`
  std::string panel{};
  Vec2 at = Vec2::Zero();  ///< in the plane of the panel [m]
};

/// A mark becomes a vertex, and a point group of its name.
struct Mark {
  std::string name;
  std::size_t panel = 0;
  std::optional<std::size_t> point;  ///< of the panel; nothing: inside of it
  Vec2 at = Vec2::Zero();            ///< [m]
};

/// Throws UserError that names mark, panel and remedy: unknown names, a place that is not inside of the panel's fabric or too
/// near to its edges or another mark for cells, in parts of `Panel::size`. Not collective.
[[nodiscard]] std::vector<Mark> resolve_marks(const std::vector<Panel>& panels,
                                              const std::vector<MarkRequest>& requests);

}  // namespace voile::pattern
