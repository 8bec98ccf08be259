// A new case from a template that is shipped: what `voile init` does.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace voile::app {

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

/// Runs a program of ours in a folder, without its output. Throws UserError if it fails. Not collective.
void run_silently(const std::string& name, std::vector<std::string> words, const std::filesystem::path& folder = ".");

/// What `voile init --list` prints.
[[nodiscard]] std::string template_list();

/// Copies the files of a template into a folder, which is made if it is not there, with the figure that a garment needs, and
/// prints what to type next. Replaces nothing. Throws UserError for an unknown template, a file that exists or cannot be
/// written, and an installation without templates. Not collective.
void begin_case(const std::filesystem::path& folder, const std::string& name);

}  // namespace voile::app
