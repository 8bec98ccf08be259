// The folder of a run's results: nobody's files are lost in it, and one run at a time writes into it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "input/case.hpp"
#include "run_options.hpp"

namespace voile::record {

/// Takes the folder for one run while it lives. A folder is taken if it is new or empty, or holds an earlier run of
/// ours and the user allows it to be replaced; then that run's files go, and only these. A run that begins with a later
/// stage (--from) keeps those of the stages before. Not collective: rank 0 only.
class OutputFolder {
 public:
  /// Name under which a run writes its case with every value in force; it also marks a folder as ours.
  static constexpr const char* echo_name = "resolved_case.toml";

  /// Creates and locks the folder. Throws UserError if another run writes into it, if it holds what is not ours, or an
  /// earlier run that may not be replaced, or if it cannot be written.
  OutputFolder(const input::Case& c, const RunOptions& options);
  ~OutputFolder();
  /// Makes the folder of a stage. Throws UserError.
  void add(const input::Case& stage) const;
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

 private:
  void create() const;
  void refuse_input(const std::filesystem::path& input) const;
  void lock();
  void unlock();
  void replace(bool allowed) const;
  void replace_stages(const input::Case& c, const RunOptions& options) const;
  [[nodiscard]] std::string holder() const;

  std::filesystem::path folder_, lock_file_;
  int descriptor_ = -1;
};

}  // namespace voile::record
