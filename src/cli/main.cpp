// voile run | check | info | reference | init | doctor, and through other programs render | export | plot | view | manikin
//
// Start-up order: MPI, the command line, the case file, then PETSc. The case's PETSc options are set before PETSc
// starts, so that PETSC_OPTIONS and the command line override them; only `run` applies them. A .petscrc, which may come
// with a foreign folder, is read only where the user asks for it on the command line.
#include <fmt/format.h>
#include <mpi.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>

#include "base/mpi.hpp"
#include "base/plain_file.hpp"
#include "base/terminal.hpp"
#include "base/threads.hpp"
#include "begin.hpp"
#include "begin_deck.hpp"
#include "check.hpp"
#include "compare_command.hpp"
#include "delegate.hpp"
#include "doctor.hpp"
#include "drape_test.hpp"
#include "fabric_test.hpp"
#include "faster_program.hpp"
#include "fit_command.hpp"
#include "input/case.hpp"
#include "input/case_declarations.hpp"
#include "input/command_line.hpp"
#include "launched_ranks.hpp"
#include "option_hint.hpp"
#include "petsc_session.hpp"
#include "record/report.hpp"
#include "setup/mesh_transfer.hpp"
#include "simulation/run.hpp"
#include "temporary_folder.hpp"
#include "version.hpp"
#include "voile/errors.hpp"

namespace {

using namespace voile;

/// What the user asked for.
struct Request {
  enum class Command { nothing, run, check, info, reference, init, doctor, version };
  Command command = Command::nothing;
  std::string file;
  record::RunOptions options;
  bool allow_system_call = false;     ///< for scripts of Gmsh
  std::vector<std::string> settings;  ///< --set
  bool schema = false;
  bool list = false;  ///< of `init`, as the name of the template
  std::string chosen, deck, example;
  std::vector<std::string> petsc;  ///< PETSc's words of the command line
};

bool is_root() {
  return mpi::rank(MPI_COMM_WORLD) == 0;
}

void print_on_root(const std::string& text) {
  if (is_root()) fmt::print("{}", text);
}

/// A missing file name may have been taken for the value of an option of PETSc.
std::string swallowed_hint(const std::vector<std::string>& petsc) {
  for (std::size_t i = 1; i < petsc.size(); ++i)
    for (const char* ending : {".toml", ".msh", ".geo"})
      if (petsc[i].size() > 5 && petsc[i].ends_with(ending) && petsc[i - 1][0] == '-')
        return fmt::format(" ('{}' was taken for the value of {}: put the file first)", petsc[i], petsc[i - 1]);
  return "";
}

void declare_init(CLI::App& init, Request& request) {
  init.add_option("folder", request.file, "Folder for the files of the case");
  init.add_flag("--list", request.list, "List the templates and examples");
  init.add_option("--from", request.deck, "Make the case from an Abaqus (.inp) or Nastran (.bdf) deck");
  init.add_option("--example", request.example, "Copy an example that is installed");
  for (const cli::Template& t : cli::templates)
    init.add_flag_callback(
        fmt::format("--{}", t.name),
        [&request, name = std::string(t.name)] {
          if (!request.chosen.empty())
            throw UserError(fmt::format("--{} and --{}: a case has one template; keep one", request.chosen, name));
          request.chosen = name;
        },
        t.what);
  init.add_option_function<std::string>(
          "--analysis",
          [](const std::string&) {
            throw UserError(fmt::format("--analysis is no option of init. {}", cli::template_list()));
          })
      ->group("");
}

void declare(CLI::App& cli, Request& request) {
  using Command = Request::Command;
  cli.require_subcommand(0, 1);
  cli.add_flag_callback(
      "--version", [&] { request.command = Command::version; }, "Print the versions of Voile and its libraries");
  const auto add = [&](const char* name, const char* what, Command command) {
    CLI::App* sub = cli.add_subcommand(name, what);
    sub->callback([&request, command] { request.command = command; });
    return sub;
  };
  CLI::App* run = add("run", "Solve a case and write its results", Command::run);
  run->add_option("case", request.file, "Case file (TOML)")->required();
  run->add_option("--output", request.options.output, "Folder of the results [CASE_results]");
  run->add_flag("--overwrite", request.options.overwrite, "Replace an earlier run in that folder");
  CLI::Option* restart = run->add_option("--restart", request.options.restart,
                                         "Continue from an earlier run: its results.vtkhdf or checkpoint.h5");
  run->add_option("--restart-step", request.options.restart_step, "Number of that step [the last]")
      ->needs(restart)
      ->check(CLI::NonNegativeNumber);
  run->add_option("--from", request.options.from,
                  "Begin with this stage, from the end of the one before in the output folder, or from --restart");
  // As a script has it whose variable is not set: the run would silently begin anew.
  for (const char* name : {"--output", "--restart", "--from"})
    run->get_option(name)->check(
        [](const std::string& text) { return text.empty() ? std::string("the name is empty") : std::string(); }, "");
  auto& verbosity = request.options.verbosity;
  CLI::Option* quiet = run->add_flag_callback(
      "--quiet", [&] { verbosity = record::Verbosity::quiet; }, "Print warnings and errors only");
  run->add_flag_callback(
         "--verbose", [&] { verbosity = record::Verbosity::verbose; }, "Print every iteration")
      ->excludes(quiet);
  run->add_flag_callback(
      "--plain", [] { use_plain_output(false); }, "Print lines without colour or rewriting");
  CLI::App* check = add("check", "Validate a case without solving it", Command::check);
  check->add_option("case", request.file, "Case file (TOML)")->required();
  CLI::App* info = add("info", "Describe a mesh: sizes, groups, quality", Command::info);
  info->add_option("file", request.file, "Case file (TOML) or mesh (.msh, .geo, .obj, .stl, .ply, .off, .vtk, .inp)")
      ->required();
  for (CLI::App* sub : {run, check, info})
    sub->add_flag("--allow-system-call", request.allow_system_call,
                  "Let a .geo run programs and write files (SystemCall, Save, ...)");
  for (CLI::App* sub : {run, check, info})
    sub->add_option("--set", request.settings, "Values that win over the case file, e.g. --set mesh.parameters.n=40")
        ->allow_extra_args(false);
  add("reference", "Print the reference of the case file", Command::reference)
      ->add_flag("--schema", request.schema, "Print it as a JSON schema, for editors");
  declare_init(*add("init", "Begin a new case from a template", Command::init), request);
  cli.add_subcommand("drape-test", "Measure the drape coefficient of a fabric file");
  cli.add_subcommand("fabric-test", "Measure a fabric file on virtual instruments of a laboratory");
  cli.add_subcommand("compare", "Find which modes of two runs are the same");
  cli.add_subcommand("fit", "Make a fabric file from the measurements of a laboratory");
  add("doctor", "Check this installation in a few seconds", Command::doctor);
  for (const cli::DelegatedCommand& c : cli::delegated_commands) cli.add_subcommand(c.name, c.what);
}

/// Parses the command line. Prints help and returns Command::nothing if that is all there is to do.
Request parse_command_line(int argc, char** argv) {
  const input::SplitArguments split = input::split_arguments({argv + 1, argv + argc});
  Request request;
  request.petsc = split.petsc;
  CLI::App cli(
      "Voile: nonlinear thin shells in parallel\n\n"
      "Every option of PETSc works as well, e.g. -snes_monitor -snes_rtol 1e-9 -log_view; -help lists those in force.\n"
      "Options also come from PETSC_OPTIONS and the case file, in this order of precedence, and with -skip_petscrc 0 "
      "from .petscrc.\n"
      "Exit codes: 0 done, 2 error in the input, 3 not converged, 4 internal error, 5 ended unstable.\n",
      "voile");
  declare(cli, request);
  std::vector<std::string> words(split.own.rbegin(), split.own.rend());  // CLI11 wants them reversed
  try {
    cli.parse(words);
  } catch (const CLI::CallForHelp&) {
    const auto chosen = cli.get_subcommands();
    print_on_root(chosen.empty() ? cli.help() : chosen.front()->help("voile"));
    return {};
  } catch (const CLI::ParseError& e) {
    throw UserError(fmt::format("{}{}{}; see voile --help", e.what(), cli::option_hint(cli, split.own),
                                swallowed_hint(split.petsc)));
  }
  if (request.command == Request::Command::nothing) {
    // PETSc's users ask a program for its options with -help.
    const bool asks = std::find(split.petsc.begin(), split.petsc.end(), "-help") != split.petsc.end();
    if (!asks) throw UserError("no command is given; see voile --help");
    print_on_root(cli.help());
  }
  return request;
}

/// Reads the case on rank 0 and parses it everywhere. Collective.
input::Case read_case(const std::string& file, const std::vector<std::string>& settings) {
  std::string text;
  mpi::on_root(MPI_COMM_WORLD, [&] {
    const std::optional<std::string> read = text_of_file(file);
    text = read ? *read : throw UserError(fmt::format("{}: there is no such case file", file));
  });
  mpi::broadcast(MPI_COMM_WORLD, text);
  return input::parse_case(text, file, settings);
}

/// Ends all ranks: the failure may have hit this rank only.
[[noreturn]] void abort_all(const char* kind, const std::string& what, Exit code) {
  fmt::print(stderr, "voile: {} on rank {}: {}\n", kind, mpi::rank(MPI_COMM_WORLD), what);
  std::fflush(nullptr);
  MPI_Abort(MPI_COMM_WORLD, static_cast<int>(code));
  std::abort();
}

[[noreturn]] void abort_for_memory(const std::string& what) {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  abort_all("error: out of memory",
            fmt::format("{}; the process held {:.2f} GB. More ranks or a coarser mesh need less per rank; so does "
                        "-pc_type voile_mixed (single precision, the default of large symmetric statics) and "
                        "-mat_mumps_icntl_22 1 (factor on disk)",
                        what, 1e-6 * static_cast<double>(usage.ru_maxrss)),
            Exit::user_error);
}

/// Calls `work`; anything but a UserError ends the program here, before PETSc is left collectively.
template <class Work>
auto or_abort(const Work& work) {
  try {
    return work();
  } catch (const UserError&) {
    throw;
  } catch (const OutOfMemory& e) {
    abort_for_memory(e.what());
  } catch (const std::bad_alloc&) {
    abort_for_memory("an array could not be had");
  } catch (const std::filesystem::filesystem_error& e) {  // of a name or a folder that the user has chosen
    abort_all("error", e.what(), Exit::user_error);
  } catch (const std::exception& e) {
    abort_all("internal error", e.what(), Exit::internal_error);
  } catch (...) {
    abort_all("internal error", "unknown exception", Exit::internal_error);
  }
}

Exit run_case(const input::Case& c, record::RunOptions options) {
  if (options.output.empty()) options.output = c.file.stem().string() + "_results";
  cli::PetscSession::check_tolerances();
  const Exit result = simulation::run(c, options);
  cli::PetscSession::report_unused_options();
  return result;
}

void show_info(const Request& request, const std::optional<input::Case>& c) {
  if (c && !c->panels.empty())
    throw UserError(fmt::format("{}: info is for mesh files; use check for panels", request.file));
  const std::filesystem::path mesh_file = c ? c->mesh.file : std::filesystem::path(request.file);
  formats::MeshOptions options = c ? c->mesh.options : formats::MeshOptions{};
  options.allow_system_call = request.allow_system_call;
  const mesh::SurfaceMesh mesh = setup::load_mesh(MPI_COMM_WORLD, mesh_file, options);
  if (c) mpi::on_root(MPI_COMM_WORLD, [&] { fmt::print("{}", record::units_text(*c)); });
  cli::info(MPI_COMM_WORLD, mesh, c ? c->element : energy::ElementOptions{});
}

/// voile init. Not collective.
void begin(const Request& request) {
  if (request.list) return fmt::print("{}{}", cli::template_list(), cli::example_list());
  if (request.file.empty()) throw UserError("init needs a folder; see voile init --help");
  std::vector<std::string> given;
  if (!request.chosen.empty()) given.push_back("--" + request.chosen);
  if (!request.deck.empty()) given.emplace_back("--from");
  if (!request.example.empty()) given.emplace_back("--example");
  if (given.size() > 1) throw UserError(fmt::format("{}: a case has one beginning; keep one", join(given, " and ")));
  if (!request.deck.empty()) return cli::begin_from_deck(request.file, request.deck);
  if (!request.example.empty()) return cli::begin_from_example(request.file, request.example);
  cli::begin_case(request.file, request.chosen);
}

/// What is wrong with a section is found where its file is no longer known: the message gets it here.
Exit naming_file(const std::string& file, const std::function<Exit()>& work) {
  try {
    return work();
  } catch (const UserError& e) {
    const std::string text = e.what();
    const bool names_section = text.starts_with("[") || text.starts_with("stage '");
    throw UserError(names_section ? file + ": " + text : text);
  }
}

Exit execute(const Request& request, const char* program) {
  using Command = Request::Command;
  if (request.command == Command::version && is_root()) fmt::print("{}", cli::version_text());
  if (request.command == Command::reference)
    print_on_root(request.schema ? input::case_schema() : input::case_reference_markdown());
  if (request.command == Command::init) {
    if (is_root()) begin(request);
    return Exit::done;
  }
  if (request.command == Command::doctor) {
    const cli::PetscSession petsc(program, request.petsc, "");
    return or_abort([] { return cli::doctor() ? Exit::done : Exit::user_error; });
  }
  const bool is_mesh = request.command == Command::info && !request.file.ends_with(".toml");
  if (request.command == Command::run || request.command == Command::check || request.command == Command::info) {
    if (request.file.empty()) throw UserError("the name of the file is empty; see voile --help");
  } else {
    return Exit::done;
  }
  std::optional<input::Case> c;
  if (!is_mesh) c = read_case(request.file, request.settings);
  if (c) c->mesh.options.allow_system_call = request.allow_system_call;
  const cli::PetscSession petsc(program, request.petsc, request.command == Command::run ? c->petsc_options : "");
  return or_abort([&] {
    return naming_file(request.file, [&] {
      if (request.command == Command::run) return run_case(*c, request.options);
      if (request.command == Command::check) cli::check(MPI_COMM_WORLD, *c);
      if (request.command == Command::info) show_info(request, c);
      return Exit::done;
    });
  });
}

}  // namespace

int main(int argc, char** argv) {
  cli::use_faster_program(argv);
  keep_output_streams();
  if (cli::is_launched()) use_plain_output(false);
  use_one_thread();
  try {
    cli::delegate_command(argc, argv);
    cli::check_temporary_folder();
    if (cli::is_drape_test(argc, argv)) return static_cast<int>(cli::drape_test_command(argc, argv));
    if (cli::is_fabric_test(argc, argv)) return static_cast<int>(cli::fabric_test_command(argc, argv));
    if (cli::is_compare(argc, argv)) return static_cast<int>(cli::compare_command(argc, argv));
    if (cli::is_fit(argc, argv)) return static_cast<int>(cli::fit_command(argc, argv));
  } catch (const UserError& e) {
    if (cli::launched_rank().rank == 0) fmt::print(stderr, "voile: error: {}\n", e.what());
    return static_cast<int>(Exit::user_error);
  }
  MPI_Init(&argc, &argv);
  Exit result = Exit::done;
  bool is_run = false;
  try {
    result = or_abort([&] {
      const Request request = parse_command_line(argc, argv);
      is_run = request.command == Request::Command::run;
      return execute(request, argv[0]);
    });
  } catch (const UserError& e) {
    if (is_root()) fmt::print(stderr, "voile: error: {}\n", e.what());
    result = Exit::user_error;
  }
  // Of a run the results count; what other commands print is all there is of them.
  if (result == Exit::done && !is_run && is_root() && output_was_lost()) {
    fmt::print(stderr, "voile: error: standard output cannot be written; is the disk full?\n");
    result = Exit::user_error;
  }
  std::fflush(nullptr);
  MPI_Finalize();
  return static_cast<int>(result);
}
