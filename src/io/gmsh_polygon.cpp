#include "voile/io/gmsh_polygon.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "voile/base/bytes.hpp"
#include "voile/base/child_process.hpp"
#include "voile/base/error.hpp"

namespace voile::io {

namespace {

namespace fs = std::filesystem;

/// A file that another program reads; removed on destruction.
class Message {
 public:
  explicit Message(const std::string& bytes) {
    std::string name = (fs::temp_directory_path() / "voile_XXXXXX").string();
    const int descriptor = mkstemp(name.data());
    if (descriptor >= 0) close(descriptor);
    path_ = name;
    std::ofstream out(path_, std::ios::binary);
    out << bytes << std::flush;
    if (descriptor < 0 || !out) throw UserError(fmt::format("{}: cannot be written; is there room on the disk?", name));
  }
  ~Message() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  Message(const Message&) = delete;
  Message& operator=(const Message&) = delete;
  [[nodiscard]] std::string path() const { return path_.string(); }

 private:
  fs::path path_;
};

}  // namespace

std::vector<Triangulation> mesh_polygons(const std::string& file, const std::vector<Polygon>& polygons) {
  ByteWriter out;
  out.put(file);
  out.put(polygons.size());
  for (const Polygon& p : polygons) {
    out.put(p.name);
    out.put(p.points);
    out.put(p.size);
  }
  const Message message(out.take());
  ByteReader in(run_beside(file, "voile-gmsh", {message.path(), "polygons"}));
  std::vector<Triangulation> all(polygons.size());
  for (Triangulation& t : all) {
    in.get(t.points);
    in.get(t.triangles);
  }
  return all;
}

}  // namespace voile::io
