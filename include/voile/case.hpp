// A case: what a case file says, as a value that can be changed. docs/reference/case.md lists sections and keys.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "voile/api.hpp"

namespace voile {

/// Nothing here is collective. Keys and values are checked by text() and by Simulation, so that keys which belong together can
/// be set one after the other.
class VOILE_API Case {
 public:
  /// Reads a case file (TOML). Throws UserError if it cannot be read.
  [[nodiscard]] static Case read(const std::filesystem::path& file);
  /// Takes the text of a case. Files that it names are looked for in `folder`.
  [[nodiscard]] static Case parse(std::string text, const std::filesystem::path& folder = ".");

  /// Sets a key by section and name, e.g. "mesh.parameters.n", "material.0.thickness" for the first [[material]]. Units are
  /// those of the case file. Later calls win.
  Case& set(const std::string& key, double value);
  Case& set(const std::string& key, int value);
  Case& set(const std::string& key, bool value);
  Case& set(const std::string& key, const char* value) { return set(key, std::string(value)); }
  Case& set(const std::string& key, const std::string& value);
  Case& set(const std::string& key, const std::vector<double>& value);
  Case& set(const std::string& key, std::initializer_list<double> value) {
    return set(key, std::vector<double>(value));
  }

  /// The case as TOML: every key with the value in force. Throws UserError that names file, line, key and remedy.
  [[nodiscard]] std::string text() const;

  // For who builds a simulation from it.
  [[nodiscard]] const std::string& source() const { return text_; }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  [[nodiscard]] const std::vector<std::string>& settings() const { return settings_; }

 private:
  Case(std::string text, std::filesystem::path file) : text_(std::move(text)), file_(std::move(file)) {}

  std::string text_;
  std::filesystem::path file_;         ///< its name is that of messages, its folder that of files
  std::vector<std::string> settings_;  ///< "key=value", as after --set
};

}  // namespace voile
