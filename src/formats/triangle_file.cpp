#include "triangle_file.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/IO/OBJ.h>
#include <CGAL/IO/OFF.h>
#include <CGAL/IO/PLY.h>
#include <CGAL/IO/STL.h>
#include <fmt/format.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include "base/bytes.hpp"
#include "base/child_process.hpp"
#include "base/plain_file.hpp"
#include "gmsh.hpp"
#include "polygon_split.hpp"
#include "voile/errors.hpp"

namespace voile::formats {

namespace {

namespace fs = std::filesystem;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Polygon = std::vector<std::size_t>;

struct PolygonSoup {
  std::vector<Point> points;
  std::vector<Polygon> polygons;
};

Point point(const Vec3& x) {
  return {x[0], x[1], x[2]};
}

// ----------------------------------------------------------------------------------------------------------- formats

[[noreturn]] void fail(const fs::path& file, const std::string& what) {
  throw UserError(fmt::format("{}: {}", file.string(), what));
}

/// The lines of an OBJ file that describe vertices and faces: CGAL gives up on statements that it does not know.
/// Throws if a vertex or face is not made of numbers.
std::stringstream obj_vertices_and_faces(const fs::path& file, std::istream& in) {
  std::stringstream kept;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    line.erase(std::min(line.find('#'), line.size()));
    const std::size_t begin = std::min(line.find_first_not_of(" \t"), line.size());
    if (begin + 1 >= line.size() || (line[begin + 1] != ' ' && line[begin + 1] != '\t')) continue;
    const std::string rest = line.substr(begin + 1);
    if (line[begin] == 'v') {
      std::istringstream words(rest);
      double x = 0.0;
      if (!(words >> x >> x >> x))
        fail(file, fmt::format("line {}: 'v' must be followed by three finite numbers", number));
    } else if (line[begin] == 'f') {
      if (rest.find_first_not_of("0123456789-/ \t\r") != std::string::npos)
        fail(file, fmt::format("line {}: 'f' must be followed by vertex numbers; join a face continued on the next "
                               "line into one line",
                               number));
    } else {
      continue;
    }
    kept << line.substr(begin) << '\n';
  }
  return kept;
}

/// CGAL would take a number that is not finite for an equal of any vertex, and cannot say that a file is cut short.
void check_stl(const fs::path& file, std::ifstream& in) {
  constexpr std::size_t header = 84, record = 50;
  const std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  rewind(in);
  const auto value = [&](auto number, std::size_t at) {
    std::memcpy(&number, bytes.data() + at, sizeof number);
    return number;
  };
  const std::size_t count = bytes.size() < header ? 0 : value(std::uint32_t{}, header - sizeof(std::uint32_t));
  if (bytes.size() < header || bytes.size() != header + record * count) {
    const std::size_t begin = std::min(bytes.find_first_not_of(" \t\r\n"), bytes.size());
    if (bytes.compare(begin, 5, "solid") == 0) return;
    fail(file, fmt::format("this is no complete STL file: an ASCII file starts with 'solid', a binary one of {} "
                           "triangles has {} bytes, but it has {}; export it again",
                           count, header + record * count, bytes.size()));
  }
  for (std::size_t t = 0; t < count; ++t)
    for (std::size_t k = 3; k < 12; ++k)
      if (!std::isfinite(value(0.0F, header + record * t + k * sizeof(float))))
        fail(file, fmt::format("triangle {} (counted from 1) has coordinates that are not finite", t + 1));
}

/// CGAL reserves memory for what the header of an ASCII file claims before it looks any further.
void check_off(const fs::path& file, std::ifstream& in) {
  std::vector<double> counts;  // vertices, faces
  std::string line, word;
  while (counts.size() < 2 && std::getline(in, line)) {
    std::istringstream words(line.substr(0, line.find('#')));
    while (counts.size() < 2 && words >> word)
      if (word.find_first_not_of("0123456789") == std::string::npos)
        counts.push_back(std::strtod(word.c_str(), nullptr));
  }
  rewind(in);
  const auto length = static_cast<double>(fs::file_size(file));
  for (const double count : counts)
    if (count > length)
      fail(file, fmt::format("this is no complete OFF file: the header claims {} entries in {} bytes", count, length));
}

bool read_format(const fs::path& file, const std::string& extension, PolygonSoup& soup) {
  std::ifstream in = open_input(file);
  if (!in) fail(file, "the file cannot be read; check its permissions");
  if (in.peek() == std::char_traits<char>::eof()) fail(file, "the file is empty; export it again");
  if (extension == ".obj") {
    std::stringstream kept = obj_vertices_and_faces(file, in);
    return CGAL::IO::read_OBJ(kept, soup.points, soup.polygons);
  }
  if (extension == ".ply") return CGAL::IO::read_PLY(in, soup.points, soup.polygons, CGAL::parameters::verbose(false));
  if (extension == ".off") {
    check_off(file, in);
    return CGAL::IO::read_OFF(in, soup.points, soup.polygons);
  }
  check_stl(file, in);
  return CGAL::IO::read_STL(in, soup.points, soup.polygons);
}

/// CGAL says only whether it could read a file; numbers of vertices that do not exist are left to check_faces().
PolygonSoup read_polygons(const fs::path& file, const std::string& extension) {
  PolygonSoup soup;
  std::string detail;
  bool done = false;
  try {
    done = read_format(file, extension, soup);
  } catch (const UserError&) {
    throw;
  } catch (const std::exception& e) {
    detail = fmt::format(" ({})", e.what());
  }
  const bool bad_index = extension == ".obj" && !soup.points.empty() && !soup.polygons.empty();
  if (!done && !bad_index)
    fail(file, fmt::format("this is no complete {} file{}; export it again as triangles",
                           extension == ".obj"   ? "OBJ"
                           : extension == ".ply" ? "PLY"
                           : extension == ".off" ? "OFF"
                                                 : "STL",
                           detail));
  return soup;
}

// ------------------------------------------------------------------------------------------------------------ checks

void check_faces(const fs::path& file, const PolygonSoup& soup) {
  if (soup.points.size() > static_cast<std::size_t>(std::numeric_limits<Index>::max()) ||
      soup.polygons.size() > static_cast<std::size_t>(std::numeric_limits<Index>::max()) / 4)
    fail(file, "the file has too many vertices or faces; coarsen the surface");
  for (std::size_t f = 0; f < soup.polygons.size(); ++f) {
    if (soup.polygons[f].size() < 3)
      fail(file, fmt::format("face {} (counted from 1) has fewer than three corners; remove it", f + 1));
    for (const std::size_t v : soup.polygons[f])
      if (v >= soup.points.size())
        fail(file, fmt::format("face {} (counted from 1) names a vertex that does not exist: there are {}; export the "
                               "file again",
                               f + 1, soup.points.size()));
  }
}

/// Finite coordinates, no triangles of zero area, something left.
geometry::TriangleSoup checked(const fs::path& file, geometry::TriangleSoup soup) {
  for (std::size_t v = 0; v < soup.positions.size(); ++v)
    if (!soup.positions[v].allFinite())
      fail(file,
           fmt::format("vertex {} (counted from 1) has coordinates that are not finite; export the file again", v + 1));
  const auto corner = [&](const mesh::Triangle& t, std::size_t i) {
    return point(soup.positions[static_cast<std::size_t>(t[i])]);
  };
  soup.degenerate_count = static_cast<Index>(std::erase_if(soup.triangles, [&](const mesh::Triangle& t) {
    return CGAL::collinear(corner(t, 0), corner(t, 1), corner(t, 2));
  }));
  if (soup.triangles.empty())
    fail(file, soup.degenerate_count > 0 ? "all triangles have zero area; export the surface again with more digits"
                                         : "there are no triangles; export the surface as a triangle mesh");
  return soup;
}

geometry::TriangleSoup read_msh(const fs::path& file) {
  mesh::MeshData data = read_gmsh(file.string(), {});
  return {std::move(data.positions), std::move(data.triangles)};
}

geometry::TriangleSoup read_soup(const fs::path& file, const std::string& extension) {
  const PolygonSoup polygons = read_polygons(file, extension);
  check_faces(file, polygons);
  geometry::TriangleSoup soup;
  for (const Point& p : polygons.points) soup.positions.emplace_back(p.x(), p.y(), p.z());
  std::vector<Vec3> corners;
  for (const Polygon& p : polygons.polygons) {
    corners.clear();
    for (const std::size_t v : p) corners.push_back(soup.positions[v]);
    for (const auto& [a, b, c] : split_polygon(corners))
      soup.triangles.push_back({static_cast<Index>(p[a]), static_cast<Index>(p[b]), static_cast<Index>(p[c])});
  }
  return checked(file, std::move(soup));
}

}  // namespace

geometry::TriangleSoup read_triangles(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  std::error_code ignored;
  if (!fs::exists(file, ignored)) fail(file, "there is no such file of triangles");
  require_plain_file(file);
  if (!fs::is_regular_file(file, ignored)) fail(file, "this is not a file");
  if (file.extension() == ".msh") return checked(file, read_msh(file));  // Gmsh wants lower case
  constexpr std::array<const char*, 4> known{".obj", ".stl", ".ply", ".off"};
  if (std::find(known.begin(), known.end(), extension) == known.end())
    fail(file,
         fmt::format("unknown kind of file '{}'; give .obj, .stl, .ply, .off or .msh", file.extension().string()));
  ByteReader bytes(run_in_child(file.string(), [&] {
    const geometry::TriangleSoup soup = read_soup(file, extension);
    ByteWriter out;
    out.put(soup.positions);
    out.put(soup.triangles);
    out.put(soup.degenerate_count);
    return out.take();
  }));
  geometry::TriangleSoup soup;
  bytes.get(soup.positions);
  bytes.get(soup.triangles);
  bytes.get(soup.degenerate_count);
  return soup;
}

}  // namespace voile::formats
