// A new case from a template that is shipped: what `voile init` does.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace voile::cli {

struct Template {
  const char* name;     ///< of its folder in share/voile/templates, and of its option
  const char* what;     ///< one sentence
  const char* picture;  ///< options of `voile render` for the end of its run
};
inline constexpr std::array templates{
    Template{"drape", "Drapes a disc of measured cotton as a drape tester does.",
             "--view three-quarter/top --no-ground --size 960x480"},
    Template{"garment", "Sews a skirt from two SVG drawings and drapes it on a figure.",
             "--stage settle --view front/three-quarter/back --size 960x480"},
    Template{"shell", "Lifts a slit ring of spring steel with large deflections.", "--no-ground --size 720x540"},
    Template{"modal", "Finds the first modes of vibration of a curved steel blade.",
             "--mode 4 --mesh --no-ground --size 720x540"}};

/// Runs a program of ours in a folder, without its output, or with all that it prints in the file `log`. Throws UserError if it
/// fails. Not collective.
void run_silently(const std::string& name, std::vector<std::string> words, const std::filesystem::path& folder = ".",
                  const std::filesystem::path& log = {});

/// The options of the templates, with a sentence each.
[[nodiscard]] std::string template_list();
/// The names of the examples that are installed, with their titles; what `voile init --list` prints below that.
[[nodiscard]] std::string example_list();

/// Copies the files of a template into a folder, which is made if it is not there, with the figure that a garment needs, and
/// prints what to type next. Replaces nothing. Throws UserError for an unknown template, a file that exists or cannot be
/// written, and an installation without templates. Not collective.
void begin_case(const std::filesystem::path& folder, const std::string& name);

/// Copies the case of an example and the meshes that it names into a folder, as begin_case() does with a template. Throws
/// UserError likewise. Not collective.
void begin_from_example(const std::filesystem::path& folder, const std::string& name);

/// Makes the folder, and writes files into it by name. Throws UserError if one of them exists, before any is written, or
/// cannot be written. Not collective.
void write_new_files(const std::filesystem::path& folder, const std::map<std::string, std::string>& texts);

/// What was begun, and what to type next: check, run, render with these options.
void print_next(const std::filesystem::path& folder, const std::string& what, const std::string& picture);

}  // namespace voile::cli
