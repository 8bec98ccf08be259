// Pieces and points by the names that a case writes; private to src/pattern.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "seams.hpp"

namespace voile::pattern {

/// Panel of that name. Throws UserError that begins with `where` and tells what was `given`.
[[nodiscard]] std::size_t find_panel(const std::vector<Panel>& panels, const std::string& name,
                                     const std::string& where, const std::string& given);

/// The point of a panel that has this number or name.
[[nodiscard]] std::optional<std::size_t> find_point(const Panel& panel, const std::string& word);

/// Panel and number of a point "PIECE@POINT". Throws UserError as find_panel() does.
[[nodiscard]] std::pair<std::size_t, std::size_t> find_point(const std::vector<Panel>& panels, const std::string& where,
                                                             const std::string& given);

/// ", named c0, c1, ..." or nothing.
[[nodiscard]] std::string named_points(const Panel& panel);

}  // namespace voile::pattern
