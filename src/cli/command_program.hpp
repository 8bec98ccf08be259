// What the programs beside voile, which do commands of it, have in common: words, help, errors and exit codes.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include "launched_ranks.hpp"
#include "option_hint.hpp"
#include "voile/errors.hpp"

namespace voile::cli {

/// Declares the subcommands; what it returns is done once the words are read.
using Declare = std::function<std::function<void()>(CLI::App&)>;

inline void run_commands(int argc, char** argv, const char* what, const Declare& declare) {
  CLI::App cli(what, "voile");
  cli.require_subcommand(1);
  const std::function<void()> act = declare(cli);
  std::vector<std::string> words(argv + 1, argv + argc);
  std::reverse(words.begin(), words.end());
  try {
    cli.parse(words);
  } catch (const CLI::CallForHelp&) {
    const auto chosen = cli.get_subcommands();
    fmt::print("{}", chosen.empty() ? cli.help() : chosen.front()->help("voile"));
    return;
  } catch (const CLI::ParseError& e) {
    throw UserError(fmt::format("{}{}; see voile {} --help", e.what(), option_hint(cli, {argv + 1, argv + argc}),
                                argc > 1 ? argv[1] : ""));
  }
  act();
}

/// Several ranks find the same mistakes: the first says so, and what has started them ends the others meanwhile.
constexpr std::chrono::seconds after_the_first{10};

inline int fail(Exit code, const std::string& text) {
  if (launched_rank().rank != 0) std::this_thread::sleep_for(after_the_first);
  fmt::print(stderr, "voile: {}\n", text);
  return static_cast<int>(code);
}

/// The exit code. `too_large`: what to do when memory is out.
inline int command_program(int argc, char** argv, const char* what, const char* too_large, const Declare& declare) {
  try {
    run_commands(argc, argv, what, declare);
    return 0;
  } catch (const UserError& e) {
    return fail(Exit::user_error, fmt::format("error: {}", e.what()));
  } catch (const std::filesystem::filesystem_error& e) {
    return fail(Exit::user_error, fmt::format("error: {}: {}", e.path1().string(), e.code().message()));
  } catch (const std::bad_alloc&) {
    return fail(Exit::user_error, fmt::format("error: out of memory: {}", too_large));
  } catch (const std::exception& e) {
    return fail(Exit::internal_error, fmt::format("internal error: {}", e.what()));
  }
}

}  // namespace voile::cli
