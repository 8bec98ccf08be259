// Pattern files for tests.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "pattern/garment.hpp"
#include "test_text.hpp"
#include "voile/errors.hpp"

namespace voile::testing {

/// A file that lives as long as this does; one per process.
class TextFile {
 public:
  TextFile(const std::string& name, const std::string& text)
      : path_(std::filesystem::temp_directory_path() / ("voile_" + std::to_string(::getpid()) + "_" + name)) {
    std::ofstream(path_) << text;
  }
  ~TextFile() { std::filesystem::remove(path_); }
  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline pattern::Pattern read(const std::string& name, const std::string& text, const pattern::ReadOptions& o = {}) {
  const TextFile file(name, text);
  return pattern::read_pattern(file.path(), o);
}

/// What a file is refused for; empty if it is not.
inline std::string refusal(const std::string& name, const std::string& text, const pattern::ReadOptions& o = {}) {
  try {
    (void)read(name, text, o);
  } catch (const UserError& e) {
    return e.what();
  }
  return "";
}

/// A rectangle from the origin: edges 0 below, 1 right, 2 above, 3 left.
inline pattern::Panel rectangle(const std::string& name, double width, double height, double size) {
  pattern::Panel p;
  p.piece.name = name;
  p.file = "test";
  p.size = size;
  const std::array<Vec2, 4> x{Vec2(0, 0), Vec2(width, 0), Vec2(width, height), Vec2(0, height)};
  for (std::size_t k = 0; k < 4; ++k) p.piece.edges.push_back({pattern::Curve::bezier({x[k], x[(k + 1) % 4]})});
  return p;
}

/// Edges of pieces on others.
inline pattern::SeamRequest seam(std::vector<std::string> edges, std::vector<std::string> to,
                                 std::vector<std::string> meet = {}) {
  pattern::SeamRequest r;
  r.where = "test";
  r.edges = std::move(edges);
  r.to = std::move(to);
  r.meet = std::move(meet);
  return r;
}

/// What a garment is refused for; empty if it is not.
inline std::string refusal_of(const std::vector<pattern::Panel>& panels,
                              const std::vector<pattern::SeamRequest>& seams) {
  try {
    (void)pattern::make_garment(panels, seams);
  } catch (const UserError& e) {
    return e.what();
  }
  return "";
}

inline pattern::Panel moved(pattern::Panel p, const Vec3& shift) {
  p.shift = shift;
  return p;
}

}  // namespace voile::testing
