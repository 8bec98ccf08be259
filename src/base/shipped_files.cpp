#include "shipped_files.hpp"

#include <dlfcn.h>

#include <algorithm>

namespace voile {

namespace {

/// From lib/python3/dist-packages/voile to the prefix, and from python/voile to the folder of a build.
constexpr int folders_above = 6, folders_of_build = 3;

}  // namespace

std::filesystem::path program_of_ours(const std::string& name) {
  std::error_code ignored;
  std::filesystem::path beside = std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path() / name;
  Dl_info here{};
  if (std::filesystem::exists(beside, ignored) || dladdr(reinterpret_cast<void*>(&program_of_ours), &here) == 0)
    return beside;
  std::filesystem::path folder = std::filesystem::canonical(here.dli_fname, ignored).parent_path();
  for (int k = 0; k < folders_above && folder.has_relative_path(); ++k, folder = folder.parent_path()) {
    if (k < folders_of_build && std::filesystem::exists(folder / name, ignored)) return folder / name;
    if (std::filesystem::exists(folder / "bin" / name, ignored)) return folder / "bin" / name;
  }
  return beside;
}

std::filesystem::path shipped_folder(const std::string& name) {
  // A Python package or another program may have loaded us: voile-gmsh is always installed with us.
  const std::filesystem::path programs = program_of_ours("voile-gmsh").parent_path();
  const std::filesystem::path built = programs / "share" / "voile" / name;
  std::error_code ignored;
  if (std::filesystem::is_directory(built, ignored)) return std::filesystem::canonical(built, ignored);
  return programs.parent_path() / "share" / "voile" / name;
}

std::vector<std::string> shipped_names(const std::string& folder, const std::string& ending) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(shipped_folder(folder), ignored))
    if (entry.path().extension() == ending) names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace voile
