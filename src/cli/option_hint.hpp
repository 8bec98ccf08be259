// Reading the options of a command: what a misspelt one may have meant.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <vector>

#include "base/text.hpp"
#include "voile/errors.hpp"

namespace voile::cli {

/// " (did you mean --output?)" for the first word that is no command or option of those chosen, or "".
inline std::string option_hint(const CLI::App& cli, const std::vector<std::string>& words) {
  std::vector<std::string> commands, options{"--help"};
  for (const CLI::App* sub : cli.get_subcommands([](const CLI::App*) { return true; }))
    commands.push_back(sub->get_name());
  const auto add = [&](const CLI::App& app) {
    for (const CLI::Option* o : app.get_options())
      for (const std::string& name : o->get_lnames()) options.push_back("--" + name);
  };
  add(cli);
  if (!words.empty())
    for (const CLI::App* sub : cli.get_subcommands([&](const CLI::App* a) { return a->get_name() == words.front(); }))
      add(*sub);
  for (std::size_t k = 0; k < words.size(); ++k) {
    const bool option = words[k].starts_with("--");
    if (!option && k > 0) continue;
    const std::string word = words[k].substr(0, words[k].find('='));
    const std::vector<std::string>& known = option ? options : commands;
    if (contains(known, word)) continue;
    const std::string near = nearest(word, known);
    if (!near.empty()) return fmt::format(" (did you mean {}?)", near);
  }
  return "";
}

/// Reads the arguments of a program with one command. False after its help, which was asked for. Throws UserError.
inline bool parse_command(CLI::App& cli, int argc, char** argv) {
  std::vector<std::string> words(argv + 1, argv + argc);
  std::reverse(words.begin(), words.end());
  try {
    cli.parse(words);
  } catch (const CLI::CallForHelp&) {
    fmt::print("{}", cli.get_subcommands().front()->help("voile"));
    return false;
  } catch (const CLI::ParseError& e) {
    throw UserError(
        fmt::format("{}{}; see voile {} --help", e.what(), option_hint(cli, {argv + 1, argv + argc}), argv[1]));
  }
  return true;
}

}  // namespace voile::cli
