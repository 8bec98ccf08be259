#include "gmsh_script.hpp"

#include <fmt/format.h>
#include <gmsh.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <vector>

#include "voile/base/error.hpp"
#include "voile/base/text.hpp"
#include "voile/io/geo_parameters.hpp"

namespace voile::io {

void check_log(const std::string& file, const char* doing) {
  constexpr std::size_t shown = 4;
  std::vector<std::string> log, errors;
  gmsh::logger::get(log);
  for (const std::string& line : log)
    if (line.rfind("Error", 0) == 0) errors.push_back(printable(line.substr(std::min<std::size_t>(7, line.size()))));
  if (errors.empty()) return;
  const std::size_t n = errors.size();
  errors.resize(std::min(n, shown));
  throw UserError(fmt::format("{}: Gmsh failed while {} it: {}{}", file, doing, join(errors, "; "),
                              n > shown ? fmt::format(" (and {} more errors)", n - shown) : ""));
}

std::string group_name(int dimension, int tag) {
  std::string name;
  gmsh::model::getPhysicalName(dimension, tag, name);
  constexpr const char* kinds[] = {"point", "curve", "surface"};
  return name.empty() ? fmt::format("{}-{}", kinds[dimension], tag) : name;
}

namespace {

namespace fs = std::filesystem;

/// Throws if a parameter is not among the known ones or not finite.
void check_parameters(const std::string& file, const std::map<std::string, double>& given, const GeoParameters& known) {
  for (const auto& [name, value] : given) {
    if (!std::isfinite(value)) throw UserError(fmt::format("{}: parameter '{}' is {}", file, name, value));
    if (known.count(name)) continue;
    std::vector<std::string> names;
    for (const auto& entry : known) names.push_back(entry.first);
    throw UserError(fmt::format("{}: there is no parameter '{}'; {}", file, name,
                                names.empty() ? "the file declares none (use DefineConstant[ name = value ];)"
                                              : fmt::format("the file declares: {}", join(names, ", "))));
  }
}

/// Removes the file on destruction.
struct TemporaryFile {
  fs::path path;
  ~TemporaryFile() {
    std::error_code ignored;
    fs::remove(path, ignored);
  }
};

/// Of a last line without a line feed Gmsh leaves out what it has not read yet, without a word, but not of an included file.
bool ends_within_line(const std::string& file) {
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in || in.tellg() <= 0) return false;
  in.seekg(-1, std::ios::end);
  return in.get() != '\n';
}

/// Opens the script with its parameters preset: DefineConstant keeps a variable that exists already. (The option
/// -setnumber is no alternative: Gmsh never forgets its values, not even after finalize.)
void open_script(const std::string& file, const std::map<std::string, double>& parameters) {
  const GeoParameters known = geo_parameters(file);
  check_parameters(file, parameters, known);
  if (parameters.empty() && !ends_within_line(file)) return gmsh::open(file);
  const std::string pattern = (fs::temp_directory_path() / "voile_XXXXXX.geo").string();
  std::vector<char> name(pattern.begin(), pattern.end());
  name.push_back('\0');
  const int descriptor = mkstemps(name.data(), 4);
  if (descriptor < 0) throw UserError(fmt::format("{}: no temporary file can be created there", pattern));
  close(descriptor);
  const TemporaryFile wrapper{name.data()};
  std::ofstream out(wrapper.path);
  for (const auto& [variable, value] : parameters) {
    const std::string& onelab_name = known.at(variable);
    if (onelab_name.empty())
      out << fmt::format("{} = {};\n", variable, value);
    else
      gmsh::onelab::setNumber(onelab_name, {value});
  }
  out << fmt::format("Include \"{}\";\n", fs::absolute(file).string());
  out.close();
  gmsh::open(wrapper.path.string());
}

}  // namespace

void open_geo(const std::string& file, const std::map<std::string, double>& parameters) {
  open_script(file, parameters);
  check_log(file, "reading");
}

}  // namespace voile::io
