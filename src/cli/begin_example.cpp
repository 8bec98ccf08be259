// `voile init --example NAME`: the examples below share/voile/examples, whose meshes lie in share/voile/meshes.
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/plain_file.hpp"
#include "base/shipped_files.hpp"
#include "base/text.hpp"
#include "begin.hpp"
#include "input/case.hpp"
#include "voile/errors.hpp"

namespace voile::cli {

namespace {

namespace fs = std::filesystem;

/// A case of an example.
struct Example {
  fs::path file;
  std::string text;
  input::Case c;
};

/// All that are installed, by name: that of the folder, or that of the file where a folder has several. Throws UserError if
/// there are none.
std::map<std::string, Example> examples() {
  std::map<std::string, Example> all;
  const fs::path folder = shipped_folder("examples");
  std::error_code error;
  // Those of a build are links to the folders of the sources.
  for (fs::recursive_directory_iterator entry(folder, fs::directory_options::follow_directory_symlink, error), end;
       !error && entry != end; entry.increment(error)) {
    const fs::path& file = entry->path();
    if (file.extension() != ".toml") continue;
    const std::string text = text_of_file(file).value_or(""),
                      name = (file.filename() == "case.toml" ? file.parent_path().filename() : file.stem()).string();
    all.emplace(name, Example{file, text, input::parse_case(text, file)});
  }
  if (all.empty())
    throw UserError(fmt::format("{}: there are no examples; install the package voile-examples", folder.string()));
  return all;
}

std::vector<std::string> names_of(const std::map<std::string, Example>& all) {
  std::vector<std::string> names;
  for (const auto& [name, example] : all) names.push_back(name);
  return names;
}

/// Options of `voile render` that show the end of it.
std::string picture_of(const input::Case& c) {
  const input::Case& last = c.stages.empty() ? c : c.stages.back();
  const bool has_modes = last.finds_modes();
  return (c.stages.empty() ? "" : fmt::format("--stage {} ", last.stage.name)) +
         (has_modes ? "--mode 1 --no-ground" : "--no-ground");
}

}  // namespace

std::string example_list() {
  std::string out = "Examples of voile init FOLDER --example NAME:\n";
  for (const auto& [name, example] : examples()) out += fmt::format("  {:<20} {}.\n", name, example.c.title);
  return out;
}

void begin_from_example(const fs::path& folder, const std::string& name) {
  const std::map<std::string, Example> all = examples();
  const auto chosen = all.find(name);
  if (chosen == all.end())
    throw UserError(fmt::format("--example {}: there is no such example;{}; voile init --list describes them", name,
                                suggestion(name, names_of(all))));
  const Example& example = chosen->second;
  std::map<std::string, std::string> texts;
  std::string text = example.text;
  for (std::size_t at = 0; (at = text.find("\"../", at)) != std::string::npos; ++at) {
    const std::size_t end = text.find('"', at + 1);
    const std::string mesh = fs::path(text.substr(at + 1, end - at - 1)).filename().string();
    texts[mesh] = text_of_file(shipped_folder("meshes") / mesh).value_or("");
    text.replace(at + 1, end - at - 1, mesh);
  }
  texts["case.toml"] = text;
  write_new_files(folder, texts);
  print_next(folder, example.c.title + ".", picture_of(example.c));
}

}  // namespace voile::cli
