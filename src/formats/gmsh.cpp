#include "gmsh.hpp"

#include <fmt/format.h>

#include <cctype>
#include <filesystem>
#include <fstream>

#include "base/child_process.hpp"
#include "base/plain_file.hpp"
#include "base/text.hpp"
#include "geo_safety.hpp"
#include "mesh_bytes.hpp"
#include "voile/errors.hpp"

namespace voile::formats {

namespace {

namespace fs = std::filesystem;

/// Checks what Gmsh would pass over in silence. Returns true for a .geo.
bool check_file(const std::string& file) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) throw UserError(fmt::format("{}: there is no such mesh file", file));
  require_plain_file(file);
  if (!fs::is_regular_file(file, ignored)) throw UserError(fmt::format("{}: this is not a file", file));
  const std::string extension = fs::path(file).extension().string();
  if (extension == ".med")
    throw UserError(fmt::format(
        "{}: MED files are not read, for Debian's Gmsh has no MED; convert it with a Gmsh that has: gmsh {} "
        "-save -o mesh.msh",
        file, fs::path(file).filename().string()));
  if (extension != ".msh" && extension != ".geo")
    throw UserError(
        fmt::format("{}: unknown kind of mesh file '{}'; give a Gmsh mesh (.msh) or geometry (.geo), or .bdf, .nas, "
                    ".dat, .inp, .obj, .vtk, .stl, .ply, .off",
                    file, extension));
  std::ifstream in = open_input(file);
  const int first = in.get();
  if (!in.is_open()) throw UserError(fmt::format("{}: the file cannot be read; check its permissions", file));
  if (first == std::char_traits<char>::eof()) throw UserError(fmt::format("{}: the file is empty", file));
  // Gmsh takes a file without a header for a .geo script.
  std::string header(1, static_cast<char>(first));
  while (header.size() < 20 && std::isprint(in.peek())) header += static_cast<char>(in.get());
  const bool is_mesh =
      header.starts_with("$MeshFormat") || header.starts_with("$Comments") || header.starts_with("$NOD");
  if (extension == ".msh" && !is_mesh)
    throw UserError(
        fmt::format("{}: this is no Gmsh mesh (it does not start with $MeshFormat); export it again", file));
  return extension == ".geo";
}

/// Gmsh counts physical names by dimension without looking whether it is one.
void check_physical_names(const std::string& file) {
  std::ifstream in = open_input(file);
  std::string line;
  while (std::getline(in, line) && !line.starts_with("$PhysicalNames"))
    if (line.starts_with("$Nodes") || line.starts_with("$Elements")) return;  // they come before
  long dimension = 0, tag = 0, count = 0;
  in >> count;
  for (long k = 0; k < count && in >> dimension >> tag && std::getline(in, line); ++k)
    if (dimension < 0 || dimension > 3)
      throw UserError(
          fmt::format("{}: physical name{} has the dimension {}, which there is not; it must be 0 (points), 1 "
                      "(curves), 2 (surfaces) or 3",
                      file, printable(line), dimension));
}

constexpr const char* reader = "voile-gmsh";  ///< program beside this one

}  // namespace

mesh::MeshData read_gmsh(const std::string& file, const MeshOptions& options) {
  const bool is_geo = check_file(file);
  if (!is_geo && !options.parameters.empty())
    throw UserError(fmt::format("{}: parameters can only be set for a .geo file, not for a finished mesh", file));
  if (is_geo) check_script_name(file);
  if (is_geo && !options.allow_system_call) refuse_dangerous_commands(file);
  if (!is_geo) try_in_child(file, [&] { check_physical_names(file); });
  std::vector<std::string> words{file,
                                 is_geo ? "geo" : "msh",
                                 fmt::format("{:a}", options.size),
                                 fmt::format("{}", options.algorithm),
                                 fmt::format("{:a}", options.scale),
                                 options.allow_system_call ? "trusted" : "confined"};
  for (const auto& [name, value] : options.parameters) words.insert(words.end(), {name, fmt::format("{:a}", value)});
  return mesh_from_bytes(run_beside(file, reader, words));
}

std::string gmsh_version() {
  return run_beside("Gmsh", reader, {});
}

}  // namespace voile::formats
