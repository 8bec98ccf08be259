#include "history_columns.hpp"

#include <fmt/format.h>

#include "base/text.hpp"

namespace voile::record {

namespace {

using Names = std::vector<std::string>;

/// Columns that are known as those of gases.
constexpr std::size_t most_gases = 99;

/// Those of every motion, and of every path.
const Names of_motion{"step",           "time",     "step_size",       "load_factor", "newton_iterations",
                      "factorisations", "residual", "negative_pivots", "rejections",  "kinetic_energy",
                      "wall_seconds"};
const Names of_path{"step",        "load_factor",     "newton_iterations", "factorisations",
                    "residual",    "negative_pivots", "critical",          "critical_load_factor",
                    "wall_seconds"};

}  // namespace

Names names_of(const HistoryColumns& columns) {
  Names names = columns.in_time ? of_motion : of_path;
  const auto add = [&](bool wanted, const Names& more) {
    if (wanted) names.insert(names.end(), more.begin(), more.end());
  };
  add(true, {"largest_strain", "largest_turn"});
  if (columns.energy_balance)
    for (const auto& [name, value] : named_parts({})) names.emplace_back(name);
  add(columns.fabric, {"fabric_loss"});
  add(columns.sewing, {"seam_gap"});
  add(columns.remeshing, {"vertices", "remeshings"});
  add(columns.contact, {"contact_pairs", "smallest_gap", "cut_short", "shortest_iteration", "intersections"});
  add(columns.passing, {"passing"});
  for (std::size_t k = 0; k < columns.gases.size(); ++k) {
    Names own{"gas_volume", "gas_pressure", "gas_energy"};
    if (columns.gases[k] != 0) own.insert(own.end(), {"gas_content", "gas_leak_loss"});
    for (const std::string& name : own) names.push_back(k > 0 ? fmt::format("{}_{}", name, k + 1) : name);
  }
  return names;
}

namespace {

Names names_of_parts(const std::string& name, const std::vector<const char*>& parts) {
  Names names;
  for (const char* part : parts)
    for (const char* axis : {"_x", "_y", "_z"}) names.push_back(name + part + axis);
  return names;
}

}  // namespace

Names names_of_rigid(const std::string& name) {
  return names_of_parts(name, {"", "_turn", "_force", "_moment"});
}

Names names_of_periodic(const std::string& name) {
  return names_of_parts(name, {"", "_force"});
}

std::array<std::pair<const char*, double>, 10> named_parts(const system::EnergyBalance& b) {
  return {{{"stored_energy", b.stored},
           {"work_of_loads", b.loads},
           {"work_of_supports", b.supports},
           {"work_of_obstacles", b.obstacles},
           {"damping_loss", b.damping},
           {"drag_loss", b.drag},
           {"friction_loss", b.friction},
           {"numerical_loss", b.numerical},
           {"remeshing_gain", b.remeshing},
           {"energy_unaccounted", b.unaccounted}}};
}

bool is_of_probe(const std::string& column) {
  static const Names others = names_of({.in_time = true,
                                        .energy_balance = true,
                                        .fabric = true,
                                        .sewing = true,
                                        .remeshing = true,
                                        .contact = true,
                                        .passing = true,
                                        .gases = std::vector<char>(most_gases, 1)});
  return !contains(others, column) && !contains(of_path, column);
}

}  // namespace voile::record
