// Reading meshes: all formats give the same mesh, groups, .geo parameters, and a message for everything that can be
// wrong.
#include <doctest/doctest.h>
#include <fmt/format.h>
#include <gmsh.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "base/child_process.hpp"
#include "extent.hpp"
#include "formats/gmsh.hpp"
#include "test_case_kit.hpp"
#include "test_relative.hpp"
#include "voile/errors.hpp"

namespace test_gmsh {

using namespace voile;
using namespace voile::testing;
namespace fs = std::filesystem;

namespace {

/// A folder of this process, removed at the end.
class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / fmt::format("voile_gmsh_{}", ::getpid())) {
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return (path_ / name).string();
  }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  fs::path path_;
};

std::string mesh_error(const std::string& file, const formats::MeshOptions& options = {}) {
  return error_of([&] { (void)formats::read_gmsh(file, options); });
}

/// A plate of two surfaces with groups of all kinds, a circle arc (whose centre carries no triangle) and parameters.
const std::string plate = R"(
// n = comment
DefineConstant[ n = {3, Min 1, Max 9, Name "Parameters/n"}, L = 2, /* x = 1, */ w = 1 ];
h = L / n;
Point(1) = {0, 0, 0, h}; Point(2) = {L, 0, 0, h}; Point(3) = {L, w, 0, h}; Point(4) = {0, w, 0, h};
Point(5) = {L, w / 2, 0, h};
Point(6) = {L / 2, 0, 0, h}; Point(7) = {L / 2, w, 0, h};
Line(1) = {1, 6}; Line(2) = {6, 2}; Circle(3) = {2, 5, 3}; Line(4) = {3, 7}; Line(5) = {7, 4}; Line(6) = {4, 1};
Line(7) = {6, 7};
Curve Loop(1) = {1, 7, 5, 6}; Curve Loop(2) = {2, 3, 4, -7};
Plane Surface(1) = {1}; Plane Surface(2) = {2};
Physical Surface("left half") = {1};
Physical Surface("everything") = {1, 2};
Physical Curve("edge") = {6};
Physical Curve("boundary") = {1, 2, 3, 4, 5, 6};
Physical Point("corner") = {4};
Physical Curve(17) = {7};
)";

void write_variants(const std::string& geo, const Folder& folder) {
  gmsh::initialize(0, nullptr, false);
  gmsh::option::setNumber("General.Terminal", 0);
  gmsh::open(geo);
  gmsh::model::mesh::generate(2);
  for (const double version : {2.2, 4.1})
    for (const int binary : {0, 1}) {
      gmsh::option::setNumber("Mesh.MshFileVersion", version);
      gmsh::option::setNumber("Mesh.Binary", binary);
      gmsh::write(folder / fmt::format("plate_{}_{}.msh", version, binary));
    }
  gmsh::finalize();
}

const mesh::Group& group(const mesh::MeshData& data, const std::string& name, int dimension) {
  for (const mesh::Group& g : data.groups)
    if (g.name == name && g.dimension == dimension) return g;
  FAIL("no group " << name);
  return data.groups.front();
}

std::set<std::array<double, 3>> points_of(const mesh::MeshData& data, const std::vector<Index>& vertices) {
  std::set<std::array<double, 3>> points;
  for (const Index v : vertices) {
    const Vec3& x = data.positions[static_cast<std::size_t>(v)];
    points.insert({x[0], x[1], x[2]});
  }
  return points;
}

std::string two_triangles(const std::string& elements) {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n1 5 \"edge\"\n2 6 \"a\"\n2 7 "
         "\"b\"\n$EndPhysicalNames\n"
         "$Nodes\n5\n10 0 0 0\n20 1 0 0\n30 1 1 0\n40 0 1 0\n50 9 9 9\n$EndNodes\n$Elements\n" +
         elements + "$EndElements\n";
}

}  // namespace

TEST_CASE("a geometry is meshed with its groups, the circle's centre is dropped") {
  const Folder folder;
  const mesh::MeshData data = formats::read_gmsh(folder.write("plate.geo", plate), {});
  CHECK(data.triangles.size() > 10);
  CHECK(data.groups.size() == 6);
  CHECK(group(data, "everything", 2).triangles.size() == data.triangles.size());
  CHECK(group(data, "left half", 2).triangles.size() < data.triangles.size());
  CHECK(group(data, "curve-17", 1).segments.size() >= 1);
  CHECK(points_of(data, group(data, "corner", 0).vertices) == std::set<std::array<double, 3>>{{0, 1, 0}});
  for (const auto& p : points_of(data, group(data, "edge", 1).vertices)) CHECK(p[0] == 0.0);
  CHECK(std::is_sorted(data.vertex_tags.begin(), data.vertex_tags.end()));
  CHECK(std::is_sorted(data.triangle_tags.begin(), data.triangle_tags.end()));
  for (const Vec3& x : data.positions) CHECK((x - Vec3(2, 0.5, 0)).norm() > 0.01);  // the centre
  const mesh::SurfaceMesh mesh(data);
  CHECK(mesh.component_count() == 1);
}

TEST_CASE("the last line of a geometry counts without a line feed, too") {
  const Folder folder;
  const std::string text =
      "Point(1) = {0, 0, 0, 1}; Point(2) = {1, 0, 0, 1}; Point(3) = {0, 1, 0, 1};\n"
      "Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 1}; Curve Loop(1) = {1, 2, 3};\n"
      "Plane Surface(1) = {1};\n"
      "Physical Surface(\"all\") = {1}; Physical Curve(\"edge\") = {2}; Physical Point(\"p\") = {3};";
  const std::string whole = folder.write("whole.geo", text + "\n"), cut = folder.write("cut.geo", text);
  const mesh::MeshData a = formats::read_gmsh(whole, {}), b = formats::read_gmsh(cut, {});
  CHECK(a.triangles == b.triangles);
  CHECK(a.groups.size() == 3);
  CHECK(b.groups.size() == 3);
}

TEST_CASE("versions 2.2 and 4.1, ASCII and binary, give the same mesh") {
  const Folder folder;
  const std::string geo = folder.write("plate.geo", plate);
  write_variants(geo, folder);
  const mesh::MeshData reference = formats::read_gmsh(geo, {});
  for (const char* name : {"plate_2.2_0.msh", "plate_2.2_1.msh", "plate_4.1_0.msh", "plate_4.1_1.msh"}) {
    CAPTURE(name);
    const mesh::MeshData data = formats::read_gmsh(folder / name, {});
    CHECK(data.positions.size() == reference.positions.size());
    CHECK(data.triangles.size() == reference.triangles.size());
    REQUIRE(data.groups.size() == reference.groups.size());
    const bool ascii = has(name, "_0");
    for (const mesh::Group& g : reference.groups) {
      const mesh::Group& other = group(data, g.name, g.dimension);
      CHECK(other.vertices.size() == g.vertices.size());
      CHECK(other.segments.size() == g.segments.size());
      CHECK(other.triangles.size() == g.triangles.size());
      if (!ascii) CHECK(points_of(data, other.vertices) == points_of(reference, g.vertices));
    }
    CHECK_NOTHROW(mesh::SurfaceMesh{data});
  }
}

TEST_CASE("meshing is deterministic and nothing is left over from an earlier file") {
  const Folder folder;
  const std::string geo = folder.write("plate.geo", plate);
  const mesh::MeshData first = formats::read_gmsh(geo, {});
  const mesh::MeshData finer = formats::read_gmsh(geo, {.parameters = {{"n", 9.0}}});
  CHECK(finer.triangles.size() > 3 * first.triangles.size());
  CHECK(mesh_error(folder.write("bad.geo", "a = ;\n")) != "no error");
  const mesh::MeshData again = formats::read_gmsh(geo, {});
  CHECK(again.positions == first.positions);
  CHECK(again.triangles == first.triangles);
}

TEST_CASE("parameters, size, algorithm and scale") {
  const Folder folder;
  const std::string geo = folder.write("plate.geo", plate);
  const auto width = [](const mesh::MeshData& data) {
    double most = 0;
    for (const Vec3& x : data.positions) most = std::max(most, x[1]);
    return most;
  };
  CHECK(width(formats::read_gmsh(geo, {.parameters = {{"w", 0.5}, {"L", 1.0}}})) == relative(0.5));
  CHECK(width(formats::read_gmsh(geo, {.parameters = {}, .scale = 0.001})) == relative(0.001));
  const std::size_t coarse = formats::read_gmsh(geo, {.parameters = {}, .size = 0.5}).triangles.size();
  const std::size_t fine = formats::read_gmsh(geo, {.parameters = {}, .size = 0.1}).triangles.size();
  CHECK(fine > 15 * coarse);
  CHECK(formats::read_gmsh(geo, {.parameters = {}, .size = 0.1, .algorithm = 5}).triangles.size() > 15 * coarse);
  const std::string said = error_of([&] { (void)formats::read_gmsh(geo, {.parameters = {}, .algorithm = 8}); });
  CHECK(has(said, "algorithm 8 of Gmsh is for quadrangles alone"));
  const std::string other = folder.write("other.geo",
                                         "Include \"plate.geo\";\nm = DefineNumber[1, Name \"Parameters/m\"];\n"
                                         "If (Exists(extra)) Transfinite Curve{6} = 1 + m * extra; EndIf\n");
  const mesh::MeshData many = formats::read_gmsh(other, {.parameters = {{"m", 4.0}, {"extra", 5.0}, {"n", 2.0}}});
  CHECK(group(many, "edge", 1).segments.size() == 20);
}

TEST_CASE("unknown parameters are named with those there are") {
  const Folder folder;
  const std::string geo = folder.write("plate.geo", plate);
  CHECK(has(mesh_error(geo, {.parameters = {{"m", 1.0}}}), "there is no parameter 'm'; the file declares: L, n, w"));
  CHECK(has(mesh_error(geo, {.parameters = {{"x", 1.0}}}), "there is no parameter 'x'"));  // in a comment
  CHECK(has(mesh_error(folder.write("p.msh", two_triangles("0\n")), {.parameters = {{"m", 1.0}}}),
            "only be set for a .geo"));
  CHECK(has(mesh_error(folder.write("none.geo", "a = 1;\n"), {.parameters = {{"a", 1.0}}}), "declares none"));
}

TEST_CASE("a 2.2 file with tagged elements only, repeated elements dropped, loose nodes dropped") {
  const Folder folder;
  const mesh::MeshData data = formats::read_gmsh(
      folder.write("two.msh", two_triangles("3\n7 1 2 5 1 10 40\n3 2 2 6 1 10 20 30\n2 2 2 7 2 10 30 40\n")), {});
  CHECK(data.vertex_tags == std::vector<std::size_t>{10, 20, 30, 40});
  CHECK(data.triangle_tags == std::vector<std::size_t>{2, 3});
  CHECK(data.triangles == std::vector<mesh::Triangle>{{0, 2, 3}, {0, 1, 2}});
  CHECK(group(data, "a", 2).triangles == std::vector<Index>{1});
  CHECK(group(data, "b", 2).vertices == std::vector<Index>{0, 2, 3});
  CHECK(group(data, "edge", 1).segments == std::vector<mesh::Segment>{{0, 3}});
  const mesh::MeshData twice = formats::read_gmsh(
      folder.write(
          "twice.msh",
          two_triangles("4\n1 2 2 6 1 10 20 30\n2 2 2 7 1 10 20 30\n3 2 2 6 1 10 30 40\n4 2 2 7 1 10 30 40\n")),
      {});
  CHECK(twice.triangles.size() == 2);
  CHECK(group(twice, "a", 2).triangles == std::vector<Index>{0, 1});
  const mesh::MeshData untagged = formats::read_gmsh(
      folder.write("untagged.msh", two_triangles("2\n1 2 2 6 1 10 20 30\n2 2 2 0 2 10 30 40\n")), {});
  CHECK(untagged.triangles.size() == 2);
  CHECK(group(untagged, "a", 2).triangles.size() == 1);
}

TEST_CASE("groups that format 2.2 cannot tell apart are refused, not mixed up") {
  const Folder folder;
  const std::string error =
      mesh_error(folder.write("mixed.msh", two_triangles("2\n1 2 2 6 1 10 20 30\n2 2 2 7 1 10 30 40\n")));
  CHECK(has(error, "the elements of elementary surface 1 belong to different physical groups ('a', 'b')"));
}

TEST_CASE("quadrangles and elements of second order are split, with a note") {
  const Folder folder;
  const auto area_of = [](const mesh::MeshData& data) {
    const mesh::SurfaceMesh mesh(data);
    double sum = 0.0;
    for (Index t = 0; t < mesh.triangle_count(); ++t) sum += mesh.area(t);
    return sum;
  };
  const mesh::MeshData quad =
      formats::read_gmsh(folder.write("quad.msh", two_triangles("1\n8 3 2 6 1 10 20 30 40\n")), {});
  CHECK(quad.triangles.size() == 2);
  CHECK(group(quad, "a", 2).triangles.size() == 2);
  REQUIRE(quad.notes.size() == 1);
  CHECK(has(quad.notes[0], "1 quadrangles were split"));
  // Round-off does not choose the diagonal.
  std::string longer = two_triangles("1\n8 3 2 6 1 10 20 30 40\n");
  longer.replace(longer.find("30 1 1 0"), 8, "30 1.000000001 1.000000001 0");
  CHECK(formats::read_gmsh(folder.write("longer.msh", longer), {}).triangles == quad.triangles);
  const mesh::MeshData three = formats::read_gmsh(folder.write("first.geo", plate), {});
  for (const char* more : {"Mesh.ElementOrder = 2;\n", "Mesh.ElementOrder = 2; Recombine Surface{1};\n",
                           "Mesh.ElementOrder = 2; Mesh.SecondOrderIncomplete = 1; Recombine Surface{1};\n"}) {
    const mesh::MeshData second = formats::read_gmsh(folder.write("second.geo", plate + more), {});
    REQUIRE(second.notes.size() == 1);
    CHECK(has(second.notes[0], "of second order were split"));
    CHECK(area_of(second) == doctest::Approx(area_of(three)).epsilon(0.02));
    for (const mesh::Group& g : three.groups)
      CHECK(group(second, g.name, g.dimension).vertices.size() >= g.vertices.size());
  }
  const mesh::MeshData recombined =
      formats::read_gmsh(folder.write("recombined.geo", plate + "Recombine Surface{1};\n"), {});
  CHECK(has(recombined.notes.at(0), "quadrangles were split"));
}

TEST_CASE("a byte-order mark before a mesh, and ghosts of partitions, do not matter") {
  const Folder folder;
  const std::string text = two_triangles("2\n1 2 2 6 1 10 20 30\n2 2 2 6 1 10 30 40\n");
  CHECK(formats::read_gmsh(folder.write("marked.msh", "\xef\xbb\xbf" + text), {}).triangles.size() == 2);
  const mesh::SurfaceMesh parts(formats::read_gmsh(VOILE_SOURCE_FOLDER "/tests/unit/formats/ghosts.msh", {}));
  CHECK(parts.triangle_count() == 128);
  CHECK(parts.group("left", 1).segments.size() == 5);
}

TEST_CASE("elements that are no sheet are refused by name") {
  const Folder folder;
  const std::string third = mesh_error(folder.write("third.geo", plate + "Mesh.ElementOrder = 3;\n"));
  CHECK(has(third, "'Triangle 10' (10 nodes), the first is element"));
  CHECK(has(third, "Mesh.ElementOrder = 1"));
  const std::string solid =
      mesh_error(folder.write("solid.msh", two_triangles("2\n1 2 2 6 1 10 20 30\n9 4 2 8 1 10 20 30 50\n")));
  CHECK(has(solid, "1 element(s) of type 'Tetrahedron 4' (4 nodes), the first is element 9; delete the volume mesh"));
}

TEST_CASE("points and lines of a group must lie on the surface") {
  const Folder folder;
  CHECK(has(mesh_error(folder.write("centre.geo", plate + "Physical Point(\"centre\") = {5};\n")),
            "physical point 'centre': node 5 belongs to no triangle"));
  CHECK(has(mesh_error(folder.write("line.msh", two_triangles("2\n1 1 2 5 1 10 50\n2 2 2 6 1 10 20 30\n"))),
            "physical curve 'edge': node 50 belongs to no triangle"));
}

TEST_CASE("bad files give a message and do not end the program") {
  const Folder folder;
  fs::create_directories(folder / "folder.msh");
  CHECK(has(mesh_error(folder / "missing.msh"), "missing.msh: there is no such mesh file"));
  CHECK(has(mesh_error(folder / "folder.msh"), "this is not a file"));
  CHECK(has(mesh_error(folder.write("empty.msh", "")), "the file is empty"));
  CHECK(has(mesh_error(folder.write("mesh.stl", "solid")), "unknown kind of mesh file '.stl'"));
  std::string noise;
  for (int i = 0; i < 3000; ++i) noise += static_cast<char>((i * 7919 + i * i * 31) % 251);
  CHECK(has(mesh_error(folder.write("noise.msh", noise)), "this is no Gmsh mesh"));
  CHECK(mesh_error(folder.write("noise2.msh", "$MeshFormat\n" + noise)) != "no error");
  CHECK(mesh_error(folder.write("noise.geo", noise)) != "no error");
  CHECK(has(mesh_error(folder.write("syntax.geo", "a = 1;\nPoint(1) = {0, 0;\n")), "Gmsh failed while reading it: "));
  CHECK(has(mesh_error(folder.write("syntax.geo", "a = 1;\nPoint(1) = {0, 0;\n")), "line 2: syntax error"));
  CHECK(has(mesh_error(folder.write("exit.geo", "Exit;\n")), "the command 'Exit' would end the program"));
  CHECK(has(mesh_error(folder.write("curve.geo", "Point(1) = {0,0,0}; Point(2) = {1,0,0}; Line(1) = {1,2};\n")),
            "there are no triangles"));
  const std::string good = two_triangles("2\n1 2 2 6 1 10 20 30\n2 2 2 7 2 10 30 40\n");
  for (std::size_t length = 1; length + 14 < good.size(); length += 7) {
    CAPTURE(length);
    CHECK(mesh_error(folder.write("cut.msh", good.substr(0, length))) != "no error");
  }
  CHECK(mesh_error(folder.write("good.msh", good)) == "no error");
}

TEST_CASE("cut binary files give a message and do not end the program") {
  const Folder folder;
  write_variants(folder.write("plate.geo", plate), folder);
  for (const char* name : {"plate_2.2_1.msh", "plate_4.1_1.msh", "plate_4.1_0.msh"}) {
    std::ifstream in(folder / name, std::ios::binary);
    const std::string whole((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    for (int part = 1; part < 20; part += extent(1, 4)) {
      CAPTURE(name);
      CAPTURE(part);
      const std::size_t length = whole.size() * static_cast<std::size_t>(part) / 20;
      CHECK(mesh_error(folder.write("cut.msh", whole.substr(0, length))) != "no error");
    }
  }
}

TEST_CASE("a reader that is not there is named, with the remedy") {
  const std::string said = error_of([] { (void)run_beside("sheet.msh", "voile-nothing", {}); });
  CHECK(said.find("voile-nothing: the program cannot be started") != std::string::npos);
  CHECK(said.find("install it beside voile") != std::string::npos);
}

TEST_CASE("the version of Gmsh is known") {
  CHECK(formats::gmsh_version().find('.') != std::string::npos);
}

}  // namespace test_gmsh
