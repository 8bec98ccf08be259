#include "petsc_allowed.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

#include "base/text.hpp"

namespace voile::input {

namespace {

/// Objects whose options a case may set.
constexpr std::array<std::string_view, 11> objects{"snes", "ksp", "pc", "ts",        "eps", "st",
                                                   "bv",   "ds",  "rg", "mat_mumps", "path"};
/// Prefixes that PETSc, SLEPc and this program put before those of solvers inside solvers.
constexpr std::array<std::string_view, 19> nests{
    "sub",        "mg_levels",      "mg_coarse", "mg_fine",   "esteig",    "st",         "npc",   "inner",
    "fas_levels", "fas_coarse",     "pc",        "redundant", "telescope", "fieldsplit", "relax", "mixed_double",
    "mixed",      "inexact_factor", "inexact"};
/// Monitors that print; others draw, write files or open ports.
constexpr std::array<std::string_view, 13> monitors{
    "monitor",           "monitor_short", "monitor_true_residual", "monitor_singular_value", "monitor_residual",
    "monitor_field",     "monitor_error", "monitor_cancel",        "monitor_pause_final",    "monitor_all",
    "monitor_frequency", "monitor_conv",  "monitor_default"};
/// In names: what writes files or leaves PETSc.
constexpr std::array<std::string_view, 17> forbidden_parts{
    "python", "draw",    "vtk",  "saws", "trajectory", "matlab", "file",     "dirname", "tmpdir",
    "dump",   "on_disk", "plot", "dll",  "hpddm",      "socket", "debugger", "attach"};
/// Files and folders of MUMPS: streams of its output, factors on disk.
constexpr std::array<std::string_view, 4> streams_of_mumps{"icntl_1", "icntl_2", "icntl_3", "icntl_22"};
/// Values that name a viewer with a file or a window, or a type that runs foreign code.
constexpr std::array<std::string_view, 18> forbidden_values{
    "binary", "draw",        "socket", "hdf5",     "vtk",    "glvis", "saws",   "matlab", "ams",
    "string", "mathematica", "cgns",   "exodusii", "exodus", "adios", "python", "shell",  "hpddm"};

bool in_name(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_';
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// Whether a name begins with `word` and an underscore; takes both away.
bool take(std::string_view& name, std::string_view word) {
  if (name.size() <= word.size() + 1 || !name.starts_with(word) || name[word.size()] != '_') return false;
  name.remove_prefix(word.size() + 1);
  return true;
}

/// The number of a level or block, or the name of a field, behind a prefix.
void take_number(std::string_view& name) {
  const std::size_t end = name.find('_');
  if (end != name.npos && end > 0 &&
      std::all_of(name.begin(), name.begin() + static_cast<std::ptrdiff_t>(end),
                  [](unsigned char c) { return std::isdigit(c); }))
    name.remove_prefix(end + 1);
}

bool is_of_solver(std::string_view name) {
  for (;;) {
    for (const std::string_view object : objects)
      if (std::string_view rest = name; take(rest, object)) return true;
    const bool nested =
        std::any_of(nests.begin(), nests.end(), [&](std::string_view nest) { return take(name, nest); });
    if (!nested) return false;
    take_number(name);
  }
}

/// Whether a text prints a view on the screen: nothing, or the viewer without a file.
bool prints(const std::string& value) {
  if (value.empty() || value == "ascii" || value == "stdout" || value == "true" || value == "false") return true;
  if (std::all_of(value.begin(), value.end(), [](unsigned char c) { return std::isdigit(c); })) return true;
  std::string_view format = value;
  if (format.starts_with("ascii")) format.remove_prefix(5);
  if (!format.starts_with("::ascii_")) return false;
  format.remove_prefix(2);
  return std::all_of(format.begin(), format.end(), in_name);
}

bool has(std::string_view name, std::string_view part) {
  return name.find(part) != name.npos;
}

bool is_forbidden_monitor(std::string_view name) {
  const std::size_t at = name.find("monitor");
  return at != name.npos && !contains(monitors, name.substr(at));
}

}  // namespace

std::string refusal_of_petsc_option(const std::string& given, const std::string& given_value) {
  const std::string name = lower(given.substr(std::min<std::size_t>(1, given.size()))), value = lower(given_value);
  constexpr const char* rule = "options of a case file choose and tune solvers and print to the screen";
  if (!std::all_of(name.begin(), name.end(), in_name) || !is_of_solver(name))
    return fmt::format("{}, and '{}' is not one of these", rule, printable(given));
  for (const std::string_view part : forbidden_parts)
    if (has(name, part)) return fmt::format("{}; '{}' could do more", rule, given);
  if (is_forbidden_monitor(name)) return fmt::format("{}; '{}' is a monitor that does not print", rule, given);
  for (const std::string_view stream : streams_of_mumps)
    if (name.ends_with(fmt::format("mat_mumps_{}", stream))) return fmt::format("{}; '{}' writes files", rule, given);
  const bool shows = has(name, "view") || has(name, "monitor") || has(name, "reason") || has(name, "converged_rate");
  if (shows && prints(value)) return "";
  const bool plain = std::all_of(value.begin(), value.end(),
                                 [](char c) { return in_name(c) || c == '.' || c == ',' || c == '+' || c == '-'; });
  if (shows || !plain || contains(forbidden_values, value))
    return fmt::format("{}; the value '{}' of {} names a file, a window or foreign code", rule, printable(given_value),
                       given);
  return "";
}

}  // namespace voile::input
