#include "script.hpp"

#include <fmt/format.h>
#include <gmsh.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "base/plain_file.hpp"
#include "base/text.hpp"
#include "formats/geo_parameters.hpp"
#include "voile/errors.hpp"

namespace voile::formats {

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

/// Of a last line without a line feed Gmsh silently leaves out what it has not read yet, but not of an included file.
bool ends_within_line(const std::string& file) {
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in || in.tellg() <= 0) return false;
  in.seekg(-1, std::ios::end);
  return in.get() != '\n';
}

}  // namespace

MemoryFile::MemoryFile(const std::string& bytes) : descriptor_(memfd_create("voile", 0)) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t count = descriptor_ < 0 ? -1 : write(descriptor_, bytes.data() + done, bytes.size() - done);
    if (count <= 0) throw InternalError("a file in memory cannot be made for Gmsh");
    done += static_cast<std::size_t>(count);
  }
}

MemoryFile::~MemoryFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

std::string MemoryFile::name() const {
  return fmt::format("/proc/self/fd/{}", descriptor_);
}

std::unique_ptr<MemoryFile> without_byte_order_mark(const std::string& file) {
  std::ifstream in = open_input(file);
  if (in.tellg() == std::streampos(0)) return nullptr;
  std::stringstream rest;
  rest << in.rdbuf();
  return std::make_unique<MemoryFile>(rest.str());
}

Script::Script(const std::string& file, const std::map<std::string, double>& parameters) : file_(file) {
  const GeoParameters known = geo_parameters(file);
  check_parameters(file, parameters, known);
  if (parameters.empty() && !ends_within_line(file)) return;
  std::string text;
  for (const auto& [variable, value] : parameters) {
    const std::string& onelab_name = known.at(variable);
    if (onelab_name.empty())
      text += fmt::format("{} = {};\n", variable, value);
    else
      numbers_[onelab_name] = value;
  }
  text += fmt::format("Include \"{}\";\n", fs::absolute(file).string());
  wrapper_ = std::make_unique<MemoryFile>(text);
}

void Script::open() const {
  for (const auto& [name, value] : numbers_) gmsh::onelab::setNumber(name, {value});
  gmsh::open(wrapper_ ? wrapper_->name() : file_);
  check_log(file_, "reading");
}

}  // namespace voile::formats
