#include "names.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.hpp"
#include "readers.hpp"
#include "voile/errors.hpp"

namespace voile::pattern {

std::size_t find_panel(const std::vector<Panel>& panels, const std::string& name, const std::string& where,
                       const std::string& given) {
  std::vector<std::string> names;
  for (std::size_t p = 0; p < panels.size(); ++p) {
    if (panels[p].piece.name == name) return p;
    names.push_back(panels[p].piece.name);
  }
  throw UserError(fmt::format("{}: '{}': there is no piece '{}':{}", where, given, name, suggestion(name, names)));
}

std::optional<std::size_t> find_point(const Panel& panel, const std::string& word) {
  const std::vector<std::string>& names = panel.piece.point_names;
  if (const auto at = std::find(names.begin(), names.end(), word); at != names.end())
    return static_cast<std::size_t>(at - names.begin());
  return number_below(word, panel.piece.edges.size());
}

Vec3 flat_place(const std::vector<Panel>& panels, const std::string& where, const std::string& point) {
  const auto [p, k] = find_point(panels, where, point);
  return panels[p].flat_place(panels[p].piece.point(k));
}

std::string named_points(const Panel& panel) {
  const std::vector<std::string>& names = panel.piece.point_names;
  return names.empty() ? "" : fmt::format(", named {}", join(names, ", "));
}

std::pair<std::size_t, std::size_t> find_point(const std::vector<Panel>& panels, const std::string& where,
                                               const std::string& given) {
  const std::size_t at = given.rfind('@');
  if (at == std::string::npos) throw UserError(fmt::format("{}: '{}': write a point as PIECE@POINT", where, given));
  const std::size_t p = find_panel(panels, given.substr(0, at), where, given);
  if (const auto k = find_point(panels[p], given.substr(at + 1))) return {p, *k};
  throw UserError(fmt::format("{}: '{}': the piece has points 0 to {}{}", where, given,
                              panels[p].piece.edges.size() - 1, named_points(panels[p])));
}

}  // namespace voile::pattern
