// Reading the declared keys of one section from TOML, with errors that say where.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "case_keys.hpp"

namespace voile::input {

/// Where a section stands in the file, for messages about it after it is read.
struct SectionPlace {
  std::string file;
  std::string name;  ///< "" for the keys outside every section
  int line = 0;      ///< of its header; 0 if the section is not there
  std::map<std::string, int> key_lines;

  /// Whether the file has the section, or --set gives a key of it, for which there is no header.
  [[nodiscard]] bool is_there() const { return line > 0 || !key_lines.empty(); }
  [[nodiscard]] bool has(const std::string& key) const { return key_lines.count(key) > 0; }
  /// Throws UserError "file:line: section.key: message".
  [[noreturn]] void fail(const std::string& key, const std::string& message) const;
};

/// Throws UserError for a name that cannot begin a column of history.csv.
void require_column_name(const SectionPlace& place, const std::string& name);

/// A parsed file.
class CaseReader {
 public:
  /// Throws UserError if the text is not TOML or has sections or keys outside sections that do not exist.
  /// `settings`: see parse_case.
  CaseReader(const std::string& text, const std::filesystem::path& file, const std::vector<Key>& top,
             const std::vector<std::string>& settings);
  ~CaseReader();
  CaseReader(const CaseReader&) = delete;
  CaseReader& operator=(const CaseReader&) = delete;

  /// Texts with a unit are converted to this system by read(), and defaults that have a unit; SI before the call.
  void set_units(const UnitSystem& units);
  [[nodiscard]] const UnitSystem& units() const;

  /// How many stages the file has.
  [[nodiscard]] std::size_t stage_count() const { return count("stage"); }
  /// Turns the file into the case of one of its stages: with its analysis and its own tables, without what does not
  /// hold in it. Once. Throws UserError for stages that make no sense.
  [[nodiscard]] StageSection select_stage(std::size_t n);
  /// The file as it is in force, as TOML, with paths counted from `folder`.
  [[nodiscard]] std::string text(const std::filesystem::path& folder) const;

  /// How often a section occurs.
  [[nodiscard]] std::size_t count(const std::string& section) const;
  /// Reads the keys of the n-th occurrence of a section; a section that does not occur has no keys.
  SectionPlace read(const std::string& section, std::size_t n, const std::vector<Key>& keys) const;
  using KeysOf = std::function<const std::vector<Key>&(const std::string& section)>;
  /// What is wrong with single keys, in all sections, in the order of the file. `keys`: of each, for values that nobody needs.
  [[nodiscard]] std::vector<std::string> mistakes(const KeysOf& keys) const;
  /// Reads the keys outside all sections.
  SectionPlace read_top(const std::vector<Key>& keys) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Notes on the sections that the analysis of a case that has been read does not look at.
[[nodiscard]] std::vector<std::string> idle_sections(const CaseReader& reader, const Case& c);

/// Notes on what the analysis leaves out of materials.
[[nodiscard]] std::vector<std::string> material_notes(const Case& c);
/// [output], of materials that have what it asks for.
void read_output(const CaseReader& reader, Case& c);

/// The first mistake in a case and those of other keys, a line each. Sections are not compared with each other.
[[nodiscard]] std::string with_other_mistakes(const CaseReader& reader, const std::string& first);

}  // namespace voile::input
