// Sections that an analysis does not look at.
#include <fmt/format.h>

#include <algorithm>

#include "base/text.hpp"
#include "case_declarations.hpp"
#include "case_read.hpp"

namespace voile::input {

namespace {

struct Readers {
  const char* section;
  std::vector<Analysis> analyses;
};

const std::vector<Readers>& readers() {
  static const std::vector<Readers> list{
      {"time", {Analysis::dynamic}},
      {"air", {Analysis::dynamic}},
      {"damping", {Analysis::dynamic, Analysis::harmonic}},
      {"drape", {Analysis::drape}},
      {"steps", {Analysis::statics, Analysis::linear, Analysis::modal, Analysis::buckling, Analysis::harmonic}},
      {"eigen", {Analysis::modal, Analysis::buckling, Analysis::harmonic}},
      {"harmonic", {Analysis::harmonic}}};
  return list;
}

/// Keys to which a section gives another value than the default; the echo of a case has every section.
std::vector<std::string> changed_keys(const CaseReader& reader, const std::string& section) {
  const Declarations given, usual;
  const SectionPlace place = reader.read(section, 0, given.of(section));
  CaseReader empty("", "", {}, {});
  empty.set_units(reader.units());
  (void)empty.read(section, 0, usual.of(section));  // defaults, in the units of the case
  std::vector<std::string> names;
  for (std::size_t k = 0; k < given.of(section).size(); ++k)
    if (place.has(given.of(section)[k].name) &&
        toml_value(given.of(section)[k].slot) != toml_value(usual.of(section)[k].slot))
      names.emplace_back(given.of(section)[k].name);
  return names;
}

bool says_something(const CaseReader& reader, const std::string& section) {
  return reader.count(section) > 0 && !changed_keys(reader, section).empty();
}

/// Notes of keys that a choice in the case leaves without effect.
void note_idle(const CaseReader& reader, const std::string& section, const std::vector<std::string>& keys,
               const std::string& with, std::vector<std::string>& notes) {
  if (reader.count(section) == 0) return;
  for (const std::string& key : changed_keys(reader, section))
    if (contains(keys, key)) notes.push_back(fmt::format("[{}] {} has no effect with {}", section, key, with));
}

}  // namespace

std::vector<std::string> idle_sections(const CaseReader& reader, const Case& c) {
  std::vector<std::string> notes;
  if (c.is_staged()) return notes;  // what stands outside of stages is for all of them
  for (const auto& [section, analyses] : readers())
    if (!contains(analyses, c.analysis) && says_something(reader, section))
      notes.push_back(fmt::format("[{}] has no effect with analysis = \"{}\"", section, word_of(c.analysis)));
  if (c.analysis == Analysis::linear)
    note_idle(reader, "steps",
              {"control", "initial_step", "min_step", "max_step", "max_steps", "stops", "target_iterations"},
              "analysis = \"linear\"", notes);
  if (c.analysis == Analysis::dynamic && c.time.options.method == solve::TimeOptions::Method::central_difference)
    note_idle(reader, "time", {"step_error", "spectral_radius", "velocity_tolerance", "target_iterations"},
              "method = \"central_difference\"", notes);
  if (c.panels.empty() && says_something(reader, "sewing"))
    notes.emplace_back("[sewing] has no effect without [[panel]]");
  return notes;
}

}  // namespace voile::input
