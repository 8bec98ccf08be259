// The same box from every format; what is wrong with a file is said; tessellations are closed and inscribed.
#include <doctest/doctest.h>
#include <fmt/format.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "base/text.hpp"
#include "extent.hpp"
#include "formats/triangle_file.hpp"
#include "test_meshes.hpp"
#include "test_relative.hpp"
#include "voile/errors.hpp"

namespace test_triangle_file {

using namespace voile;
using voile::testing::TemporaryFile;

namespace {

// The box 1 x 2 x 3, vertex v at (v & 1, v & 2, 3 (v & 4) / 4), with quadrangles.
constexpr std::array<std::array<int, 4>, 6> quads{
    {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};

std::array<double, 3> box_vertex(int v) {
  return {static_cast<double>(v & 1), static_cast<double>(v & 2), 0.75 * (v & 4)};
}

/// Bytes of a number of four bytes or one.
template <class Number>
std::string bytes(Number number, std::endian order) {
  const auto raw = std::bit_cast<std::array<char, sizeof(Number)>>(number);
  std::string text(raw.begin(), raw.end());
  if (order != std::endian::native) std::reverse(text.begin(), text.end());
  return text;
}

std::string obj_box(const char* face = "f {} {} {} {}\n") {
  std::string text = "# a box\nmtllib box.mtl\no box\n";
  for (int v = 0; v < 8; ++v) {
    const auto [x, y, z] = box_vertex(v);
    text += fmt::format("v {} {} {}\n", x, y, z);
  }
  text += "vn 0 0 1\nvt 0 0\nusemtl none\ns off\nl 1 2\n";
  for (const auto& [a, b, c, d] : quads) text += fmt::format(fmt::runtime(face), a + 1, b + 1, c + 1, d + 1);
  return text;
}

std::string off_box() {
  std::string text = "OFF\n# a box\n8 6 0\n";
  for (int v = 0; v < 8; ++v) text += fmt::format("{}\n", join(box_vertex(v), " "));
  for (const auto& q : quads) text += fmt::format("4 {} {} {} {}\n", q[0], q[1], q[2], q[3]);
  return text;
}

std::string ply_box(const std::string& format, bool cut = false) {
  std::string text = "ply\nformat " + format +
                     " 1.0\ncomment a box\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
                     "element face 6\nproperty list uchar int vertex_indices\nend_header\n";
  const bool is_ascii = format == "ascii";
  const std::endian order = format == "binary_big_endian" ? std::endian::big : std::endian::little;
  for (int v = 0; v < 8; ++v)
    for (const double x : box_vertex(v)) text += is_ascii ? fmt::format("{} ", x) : bytes(static_cast<float>(x), order);
  for (const auto& q : quads) {
    text += is_ascii ? "\n4" : "\4";
    for (const int v : q) text += is_ascii ? fmt::format(" {}", v) : bytes(std::int32_t{v}, order);
  }
  return cut ? text.substr(0, text.size() - 6) : text;
}

/// Each quadrangle as two triangles with its own corners.
std::vector<std::array<std::array<double, 3>, 3>> facets() {
  std::vector<std::array<std::array<double, 3>, 3>> result;
  for (const auto& [a, b, c, d] : quads) {
    result.push_back({box_vertex(a), box_vertex(b), box_vertex(c)});
    result.push_back({box_vertex(a), box_vertex(c), box_vertex(d)});
  }
  return result;
}

std::string stl_ascii_box() {
  std::string text = "solid box\n";
  for (const auto& facet : facets()) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const auto& x : facet) text += fmt::format("vertex {} {} {}\n", x[0], x[1], x[2]);
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid\n";
}

std::string stl_binary_box(const std::string& title, float last = 3.0F) {
  std::string text = title + std::string(80 - title.size(), ' ') + bytes(std::uint32_t{12}, std::endian::little);
  for (const auto& facet : facets()) {
    text += std::string(12, '\0');
    for (const auto& x : facet)
      for (const double value : x) text += bytes(value == 3.0 ? last : static_cast<float>(value), std::endian::little);
    text += std::string(2, '\0');
  }
  return text;
}

geometry::TriangleSoup read(const std::string& extension, const std::string& content) {
  const TemporaryFile file(extension, content);
  return formats::read_triangles(file.path());
}

double area(const geometry::TriangleSoup& s) {
  double sum = 0.0;
  for (const auto& [a, b, c] : s.triangles)
    sum += 0.5 * (s.positions[b] - s.positions[a]).cross(s.positions[c] - s.positions[a]).norm();
  return sum;
}

double volume(const geometry::TriangleSoup& s) {
  double sum = 0.0;
  for (const auto& [a, b, c] : s.triangles) sum += s.positions[a].dot(s.positions[b].cross(s.positions[c])) / 6.0;
  return sum;
}

void check_box(const geometry::TriangleSoup& s) {
  CHECK(s.positions.size() == 8);
  CHECK(s.triangles.size() == 12);
  CHECK(s.degenerate_count == 0);
  CHECK(area(s) == relative(22.0));
  CHECK(volume(s) == relative(6.0));  // oriented outwards, as the file is
}

/// What read_triangles says about a file.
std::string complaint(const std::string& extension, const std::string& content) {
  const TemporaryFile file(extension, content);
  try {
    (void)formats::read_triangles(file.path());
  } catch (const UserError& e) {
    const std::string text = e.what();
    CHECK(text.starts_with(file.path().string() + ": "));
    return text.substr(file.path().string().size() + 2);
  }
  return "nothing";
}

bool has(const std::string& text, const std::string& part) {
  CAPTURE(text);
  const bool found = text.find(part) != std::string::npos;
  CHECK(found);
  return found;
}

/// Closed and consistently oriented: SurfaceMesh needs to repair nothing. Returns its longest edge.
double check_closed(const geometry::TriangleSoup& s) {
  mesh::MeshData data;
  data.source = "primitive";
  data.positions = s.positions;
  data.triangles = s.triangles;
  const mesh::SurfaceMesh mesh(data);
  CHECK(mesh.reoriented_count() == 0);
  CHECK(mesh.component_count() == 1);
  CHECK(2 * mesh.vertex_count() == mesh.triangle_count() + 4);  // Euler, closed without holes
  double longest = 0.0;
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) {
      CHECK(mesh.neighbour(t, k) != no_index);
      longest = std::max(longest, (mesh.rest_corner(t, k) - mesh.rest_corner(t, (k + 1) % 3)).norm());
    }
  return longest;
}

double distance_to_segment(const Vec3& x, const Vec3& a, const Vec3& b) {
  const double t = a == b ? 0.0 : std::clamp((x - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (x - a - t * (b - a)).norm();
}

}  // namespace

TEST_CASE("a box is read from every format") {
  for (const char* face : {"f {} {} {} {}\n", "f {}/1 {}/1 {}/1 {}/1\r\n", "f {}//1 {}//1 {}//1 {}//1\n",
                           "  f\t{}/1/1 {}/1/1 {}/1/1 {}/1/1 # note\n"})
    check_box(read(".obj", obj_box(face)));
  check_box(read(".OBJ", obj_box()));
  check_box(read(".off", off_box()));
  check_box(read(".off", "OFF 8 6 0\n" + off_box().substr(off_box().find("0\n") + 2)));
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"})
    check_box(read(".ply", ply_box(format)));
  check_box(read(".stl", stl_ascii_box()));
  check_box(read(".stl", stl_binary_box("box")));
  check_box(read(".stl", stl_binary_box("solid box")));  // many programs write that
  const geometry::TriangleSoup s = read(".obj", obj_box());
  for (int v = 0; v < 8; ++v) CHECK(s.positions[v] == Vec3(box_vertex(v).data()));
}

TEST_CASE("a Gmsh mesh is read as triangles") {
  const geometry::TriangleSoup s =
      read(".msh",
           "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n"
           "4 0 1 0\n$EndNodes\n$Elements\n2\n1 2 2 1 1 1 2 3\n2 2 2 1 1 1 3 4\n$EndElements\n");
  CHECK(s.positions.size() == 4);
  CHECK(s.triangles.size() == 2);
  CHECK(area(s) == relative(1.0));
}

TEST_CASE("a polygon that is not convex is split without covering its bay") {
  // an L in the plane x + y + z = const, then a comb with a corner in the middle of an edge, in both directions
  const geometry::TriangleSoup bent =
      read(".obj", "v 0 0 0\nv 2 0 -2\nv 2 1 -3\nv 1 1 -2\nv 1 2 -3\nv 0 2 -2\nf 1 2 3 4 5 6\n");
  CHECK(bent.triangles.size() == 4);
  CHECK(area(bent) == relative(3.0 * std::numbers::sqrt3));
  for (const char* face : {"f 1 2 3 4 5 6 7 8 9\n", "f 9 8 7 6 5 4 3 2 1\n", "f -9 -8 -7 -6 -5 -4 -3 -2 -1\n"}) {
    const geometry::TriangleSoup comb =
        read(".obj",
             std::string("v 0 0 0\nv 2 0 0\nv 4 0 0\nv 4 3 0\nv 3 1 0\nv 2 3 0\nv 1 1 0\nv 0 3 0\nv 0 1 0\n") + face);
    CHECK(comb.triangles.size() == 7);
    CHECK(comb.degenerate_count == 0);
    CHECK(area(comb) == relative(8.0));
  }
}

TEST_CASE("a quadrangle of an obstacle is split along its shorter diagonal") {
  const geometry::TriangleSoup soup = read(".obj", "v 0 0 0\nv 1 0 0\nv 1.2 1 0\nv 0 1 0\nf 1 2 3 4\n");
  CHECK(soup.triangles == std::vector<mesh::Triangle>{{1, 2, 3}, {1, 3, 0}});
}

TEST_CASE("vertex numbers stay, triangles of zero area go, nothing needs to be a manifold") {
  // a vertex without a face, coinciding vertices, an edge of three triangles, one bent back, two of zero area
  const geometry::TriangleSoup s = read(".obj",
                                        "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nv 0 1 0\nv 2 0 0\n"
                                        "f 2 3 4\nf 2 3 5\nf 3 2 6\nf 2 3 7\nf 2 3 8\nf 2 2 4\n");
  CHECK(s.positions.size() == 8);
  CHECK(s.triangles.size() == 4);
  CHECK(s.degenerate_count == 2);
  CHECK(s.triangles[3] == mesh::Triangle{1, 2, 6});
  CHECK(area(s) == relative(2.0));
}

TEST_CASE("what is wrong with a file of triangles is said") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  CHECK_THROWS_AS((void)formats::read_triangles("no_such_file.obj"), UserError);
  CHECK_THROWS_AS((void)formats::read_triangles("."), UserError);
  has(complaint(".igs", "x"), "unknown kind of file '.igs'; give .obj, .stl, .ply, .off or .msh");
  for (const char* extension : {".obj", ".stl", ".ply", ".off", ".msh"}) {
    CAPTURE(extension);
    has(complaint(extension, ""), "the file is empty");
    CHECK(complaint(extension, "This is not a mesh.\nAt all.\n") != "nothing");
    CHECK(complaint(extension, std::string(500, '\377')) != "nothing");
  }
  has(complaint(".obj", triangle + "f 1 2 4\n"), "face 1 (counted from 1) names a vertex that does not exist");
  has(complaint(".obj", triangle + "f 1 2 99\n"), "face 1 (counted from 1) names a vertex that does not exist");
  has(complaint(".obj", triangle + "f 0 1 2\n"), "names a vertex that does not exist");
  has(complaint(".obj", triangle + "f -1 -2 -9\n"), "names a vertex that does not exist");
  has(complaint(".obj", triangle + "f 1 2 3\nf 1 2\n"), "face 2 (counted from 1) has fewer than three corners");
  has(complaint(".obj", triangle + "f 1 2 x\n"), "line 4: 'f' must be");
  has(complaint(".obj", triangle + "v 1 nan 0\nf 1 2 3\n"), "line 4: 'v' must be");
  has(complaint(".obj", triangle + "v 1 1e999 0\nf 1 2 3\n"), "line 4: 'v' must be");
  has(complaint(".obj", triangle), "OBJ");
  has(complaint(".obj", triangle + "f 1 2 2\n"), "all triangles have zero area");
  has(complaint(".off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"), "OFF");
  has(complaint(".off", "OFF\n3 1 0\n0 0 0\n1 0 0\n"), "OFF");
  has(complaint(".off", "OFF # a\n# b\n3000000000 1 0\n0 0 0\n1 0 0\n"), "claims 3000000000 entries in 39 bytes");
  has(complaint(".off", "OFF\n3 1 0\n0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n"), "OFF");
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"})
    has(complaint(".ply", ply_box(format, true)), "PLY");
  has(complaint(".ply",
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n"),
      "names a vertex that does not exist");
  has(complaint(".stl", stl_binary_box("box").substr(0, 300)), "STL");
  has(complaint(".stl", stl_binary_box("box") + "x"), "it has 685");
  has(complaint(".stl", stl_binary_box("box", nan)), "coordinates that are not finite");
  has(complaint(".stl", stl_ascii_box().substr(0, 500)), "STL");
  has(complaint(".stl", "solid box\nendsolid box\n"), "there are no triangles");
  has(complaint(".stl",
                "solid b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 nan 0\nvertex 0 1 0\nendloop\n"
                "endfacet\nendsolid b\n"),
      "STL");
}

TEST_CASE("a file that is cut short anywhere is refused") {
  const std::vector<std::pair<std::string, std::string>> files{
      {".off", off_box()},       {".ply", ply_box("ascii")},      {".ply", ply_box("binary_little_endian")},
      {".stl", stl_ascii_box()}, {".stl", stl_binary_box("box")}, {".stl", stl_binary_box("solid box")}};
  for (const auto& file : files) {
    const std::string &extension = file.first, &content = file.second;
    CAPTURE(extension);
    int accepted = 0;
    const std::size_t size = content.back() == '\n' ? content.size() - 1 : content.size();
    for (std::size_t length = 0; length < size; length += extent(1U, 5U) + length / 16)
      if (complaint(extension, content.substr(0, length)) == "nothing") ++accepted;
    if (complaint(extension, content.substr(0, size - 1)) == "nothing") ++accepted;
    CHECK(accepted == 0);
  }
  for (std::size_t length = 0; length < obj_box().size(); length += extent(3U, 20U))
    (void)complaint(".obj", obj_box().substr(0, length));
}

TEST_CASE("a sphere is closed, inscribed and as fine as promised") {
  const Vec3 centre(3.0, -1.0, 2.0);
  const double r = 0.7;
  for (int refinement = 0; refinement <= 4; ++refinement) {
    CAPTURE(refinement);
    const geometry::TriangleSoup s = geometry::sphere_surface(centre, r, refinement);
    CHECK(s.triangles.size() == 20U << (2 * refinement));
    const double h = check_closed(s);
    CHECK(h < 1.33 * r / (1 << refinement));
    for (const Vec3& x : s.positions) CHECK((x - centre).norm() == relative(r).epsilon(1e-14));
    double deepest = 0.0;
    for (const auto& [a, b, c] : s.triangles)
      deepest = std::max(deepest, r - ((s.positions[a] + s.positions[b] + s.positions[c]) / 3.0 - centre).norm());
    CHECK(deepest < 1.2 * h * h / (6.0 * r));
    CHECK(deepest > 0.8 * h * h / (6.0 * r));
    const double exact = 4.0 / 3.0 * std::numbers::pi * r * r * r;
    CHECK(volume(s) < exact);
    CHECK(volume(s) > exact * (1.0 - 0.6 * h * h / (r * r)));
  }
  for (const double radius : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()})
    CHECK_THROWS_AS((void)geometry::sphere_surface(centre, radius, 1), InternalError);
  CHECK_THROWS_AS((void)geometry::sphere_surface(centre, 1.0, 9), InternalError);
  CHECK_THROWS_AS((void)geometry::sphere_surface(centre, 1.0, -1), InternalError);
}

TEST_CASE("a capsule is closed and inscribed") {
  const Vec3 a(1.0, 2.0, 3.0);
  const double r = 0.5;
  for (const Vec3& b : {Vec3(3.0, 1.0, 2.5), Vec3(1.0, 2.0, 3.1), Vec3(1.0, 2.0, 3.0)})
    for (int refinement = 0; refinement <= 3; ++refinement) {
      CAPTURE(refinement);
      const geometry::TriangleSoup s = geometry::capsule_surface(a, b, r, refinement);
      (void)check_closed(s);
      for (const Vec3& x : s.positions) CHECK(distance_to_segment(x, a, b) == relative(r).epsilon(1e-14));
      const double exact = std::numbers::pi * r * r * ((b - a).norm() + 4.0 / 3.0 * r);
      const double loss = 1.0 - volume(s) / exact;
      CHECK(loss > 0.0);
      CHECK(loss < 0.26 / (1 << (2 * refinement)));
    }
  CHECK_THROWS_AS((void)geometry::capsule_surface(a, a, 0.0, 1), InternalError);
  CHECK_THROWS_AS((void)geometry::capsule_surface(a, a, 1.0, 8), InternalError);
}

TEST_CASE("a cylinder is closed, straddles the true one and has no long triangles") {
  const Vec3 a(1.0, 2.0, 3.0);
  struct Size {
    double length, radius, sagitta;
  };
  for (const Size& size : {Size{1.0, 0.25, 1e-4}, {0.01, 0.5, 1e-3}, {5.0, 0.1, 1e-3}, {0.3, 0.2, 0.1}}) {
    CAPTURE(size.length);
    const Vec3 axis = Vec3(2.0, -1.0, 0.5).normalized(), b = a + size.length * axis;
    const geometry::TriangleSoup s = geometry::cylinder_surface(a, b, size.radius, size.sagitta);
    (void)check_closed(s);
    double widest = 0.0, narrowest = size.radius, slender = 0.0;
    for (const mesh::Triangle& t : s.triangles) {
      const std::array<Vec3, 3> x{s.positions[t[0]], s.positions[t[1]], s.positions[t[2]]};
      const double h = std::max({(x[1] - x[0]).norm(), (x[2] - x[1]).norm(), (x[0] - x[2]).norm()});
      const Vec3 n = (x[1] - x[0]).cross(x[2] - x[0]);
      slender = std::max(slender, h * h / n.norm());
      if (std::abs(n.normalized().dot(axis)) > 0.5) continue;
      for (int k = 0; k < 3; ++k) {
        const Vec3 middle = 0.5 * (x[k] + x[(k + 1) % 3]) - a, corner = x[k] - a;
        narrowest = std::min(narrowest, (middle - middle.dot(axis) * axis).norm());
        widest = std::max(widest, (corner - corner.dot(axis) * axis).norm());
      }
    }
    CHECK(widest - narrowest <= size.sagitta * (1.0 + 1e-9));
    CHECK(0.5 * (widest + narrowest) == relative(size.radius).epsilon(1e-12));
    CHECK(slender < 20.0);
    const double exact = std::numbers::pi * size.radius * size.radius * size.length;
    CHECK(volume(s) == relative(exact).epsilon(2.0 * (widest - narrowest) / size.radius));
    CHECK(s.triangles.size() < 20000);
  }
  CHECK(geometry::cylinder_surface(a, a + Vec3(0, 0, 1e5), 0.1, 1e-9).triangles.size() < 250000);
  CHECK_THROWS_AS((void)geometry::cylinder_surface(a, a, 1.0, 0.1), InternalError);
  CHECK_THROWS_AS((void)geometry::cylinder_surface(a, Vec3::Zero(), 0.0, 0.1), InternalError);
  CHECK_THROWS_AS((void)geometry::cylinder_surface(a, Vec3::Zero(), 1.0, 0.0), InternalError);
}

}  // namespace test_triangle_file
