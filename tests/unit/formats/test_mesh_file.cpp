// Sheets from files that are not Gmsh's: OBJ, Abaqus, VTK, STL, PLY, OFF.
#include <doctest/doctest.h>

#include <Eigen/LU>
#include <bit>
#include <cmath>
#include <fstream>

#include "formats/mesh_file.hpp"
#include "test_meshes.hpp"
#include "test_relative.hpp"
#include "test_text.hpp"
#include "voile/errors.hpp"

namespace test_mesh_file {

using namespace voile;
using namespace voile::testing;

namespace {

const std::string seeds = VOILE_SOURCE_FOLDER "/tests/fuzz/seeds/";

mesh::MeshData read(const std::string& suffix, const std::string& text, const formats::MeshOptions& options = {}) {
  const TemporaryFile file(suffix, text);
  return formats::read_mesh(file.path().string(), options);
}

std::string message(const std::string& suffix, const std::string& text, const formats::MeshOptions& options = {}) {
  try {
    (void)read(suffix, text, options);
  } catch (const UserError& e) {
    return e.what();
  }
  return "nothing is wrong";
}

template <class Number>
std::string big_endian(Number x) {
  std::array<char, sizeof(Number)> bytes = std::bit_cast<std::array<char, sizeof(Number)>>(x);
  std::reverse(bytes.begin(), bytes.end());
  return {bytes.begin(), bytes.end()};
}

}  // namespace

TEST_CASE("the same square from OBJ, Abaqus, VTK and Gmsh") {
  const mesh::SurfaceMesh gmsh(formats::read_mesh(seeds + "square.msh", {}));
  for (const char* name : {"square.obj", "square.inp", "square.vtk"}) {
    INFO(name);
    formats::MeshOptions options;
    options.scale = 2.0;
    const mesh::SurfaceMesh mesh(formats::read_mesh(seeds + name, options));
    REQUIRE(mesh.vertex_count() == 16);
    REQUIRE(mesh.triangle_count() == 18);
    double difference = 0.0;
    for (Index v = 0; v < 16; ++v) difference += (mesh.positions()[v] - 2.0 * gmsh.positions()[v]).norm();
    CHECK(difference < 1e-4);  // the texts have six digits
    CHECK(mesh.group("boundary", 1).segments.size() == 12);
    CHECK(!mesh.has_group("boundary-1"));
  }
}

TEST_CASE("a mesh is scaled, set upright, turned about x, y, z in turn, and moved") {
  const std::string text = "v 0 0 0\nv 1 0 0\nv 0 2 3\nf 1 2 3\n";
  formats::MeshOptions options;
  options.scale = 2.0;
  options.placement.up_axis = formats::Placement::UpAxis::y;
  CHECK(read(".obj", text, options).positions[2] == Vec3(0.0, -6.0, 4.0));  // exactly
  options.placement.rotate = {90.0, 0.0, 90.0};
  options.placement.translate = {10.0, 20.0, 30.0};
  // about x: (0, -4, -6); about z: (4, 0, -6)
  CHECK(read(".obj", text, options).positions[2] == Vec3(14.0, 20.0, 24.0));
  options.placement = {formats::Placement::UpAxis::z, {0.0, 0.0, 30.0}, {0.0, 0.0, 0.0}};
  CHECK((read(".obj", text, options).positions[1] - Vec3(std::sqrt(3.0), 1.0, 0.0)).norm() < 1e-15);
  CHECK((options.placement.rotation() * options.placement.rotation().transpose()).isIdentity(1e-15));
  CHECK(options.placement.rotation().determinant() == relative(1.0));
  options.placement.translate = {0.0, 1e200, 0.0};
  CHECK(message(".obj", text, options).find("put in place by rotate and translate") != std::string::npos);
}

TEST_CASE("groups of OBJ, Abaqus and VTK") {
  const mesh::SurfaceMesh obj(formats::read_mesh(seeds + "square.obj", {}));
  CHECK(obj.group("front", 2).triangles.size() == 9);
  CHECK(obj.group("back", 2).triangles.size() == 9);
  CHECK(obj.group("cloth", 2).triangles.size() == 18);
  CHECK(obj.group("red", 2).triangles.size() == 18);
  CHECK(obj.group("rim", 1).segments.size() == 3);
  REQUIRE(obj.data().texture.size() == 18);
  for (Index t = 0; t < 18; ++t)
    for (int i = 0; i < 3; ++i) CHECK((obj.data().texture[t][i] - obj.rest_corner(t, i).head<2>()).norm() < 1e-12);

  const mesh::SurfaceMesh inp(formats::read_mesh(seeds + "square.inp", {}));
  CHECK(inp.group("FRONT", 2).triangles.size() == 9);
  CHECK(inp.group("BOTH", 2).triangles.size() == 18);
  CHECK(inp.group("LEFT", 1).segments.size() == 3);
  CHECK(inp.group("CORNERS", 0).vertices == std::vector<Index>{0, 3, 12, 15});
  CHECK(inp.group("ALL", 2).vertices.size() == 16);

  const mesh::SurfaceMesh vtk(formats::read_mesh(seeds + "square.vtk", {}));
  CHECK(vtk.group("group-1", 2).triangles.size() == 9);
  CHECK(vtk.group("group-2", 2).triangles.size() == 9);
  CHECK(vtk.group("group-3", 1).segments.size() == 3);
}

TEST_CASE("OBJ: lines that sew are counted and said") {
  const mesh::MeshData obj = read(".obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\nstitch 0 1 1 0\nstitch 1 2 2 0\n");
  REQUIRE(obj.notes.size() == 1);
  CHECK(obj.notes[0].find("2 lines 'stitch' are passed over") != std::string::npos);
}

TEST_CASE("quadrangles are split along their shorter diagonal, and this is said") {
  const char* points = "v 0 0 0\nv 1 0 0\nv 1.2 1 0\nv 0 1 0\n";  // 2-4 is shorter than 1-3
  const mesh::MeshData obj = read(".obj", std::string(points) + "g all\nf 1 2 3 4\n");
  REQUIRE(obj.triangles.size() == 2);
  CHECK(obj.triangles[0] == mesh::Triangle{1, 2, 3});
  CHECK(obj.triangles[1] == mesh::Triangle{1, 3, 0});
  CHECK(obj.notes.at(0).find("1 polygons were split") != std::string::npos);
  CHECK(mesh::SurfaceMesh(obj).group("all").triangles.size() == 2);
  const mesh::MeshData inp =
      read(".inp", "*Node\n1,0,0\n2,1,0\n3,1.2,1\n4,0,1\n*Element, type=S4R, elset=q\n1,1,2,3,4\n");
  CHECK(inp.triangles == obj.triangles);
  CHECK(mesh::SurfaceMesh(inp).group("q").triangles.size() == 2);
  // Round-off does not choose: both diagonals of a square that was turned are as long.
  for (const char* square :
       {"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n", "v 0 0 0\nv 1 0 0\nv 1.000000001 1.000000001 0\nv 0 1 0\n"})
    CHECK(read(".obj", std::string(square) + "f 1 2 3 4\n").triangles[0] == mesh::Triangle{0, 1, 2});
}

/// Of all triangles.
double area(const mesh::MeshData& m) {
  double sum = 0.0;
  for (const auto& [a, b, c] : m.triangles) sum += mesh::triangle_area(m.positions[a], m.positions[b], m.positions[c]);
  return sum;
}

TEST_CASE("a polygon of a mesh that is not convex is split without covering its bay") {
  // an arrow head, whose shorter diagonal lies outside, from every corner and in both directions; then an L
  const char* arrow = "v 0 0 0\nv 0.1 1 0\nv 0 0.8 0\nv -0.1 1 0\n";
  for (const char* face : {"f 1 2 3 4\n", "f 2 3 4 1\n", "f 3 4 1 2\n", "f 4 3 2 1\n"}) {
    const mesh::MeshData obj = read(".obj", std::string(arrow) + face);
    CHECK(area(obj) == relative(0.08));
  }
  const mesh::MeshData bent =
      read(".obj", "v 1 2 0\nv 0 2 0\nv 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nf 1 2 3 4 5 6\nf 6 5 4 3 2 1\n");
  CHECK(area(bent) == relative(6.0));
}

TEST_CASE("Abaqus: lines are curves, second order is split, what is no sheet is left out with a note") {
  const std::string nodes = "*NODE\n1,0,0\n2,0.1D+1,0\n3,1d0,1\n4,0,1\n5,.5,0\n6,1,.5\n7,.5,1\n8,0,.5\n9,.5,.5\n";
  const mesh::MeshData gmsh = read(
      ".inp",
      nodes +
          "*ELEMENT, type=T3D2, ELSET=Line1\n1,1,5\n2,5,2\n*ELEMENT, type=CPS3, ELSET=S\n3,1,5,4\n4,5,2,3\n5,5,3,4\n"
          "*ELSET, ELSET=front\n1,2\n*ELSET, ELSET=sheet\n3,4,5\n");
  const auto group = [](const mesh::MeshData& data, const std::string& name) {
    for (const mesh::Group& g : data.groups)
      if (g.name == name) return g;
    FAIL("there is no group ", name);
    return mesh::Group{};
  };
  CHECK(group(gmsh, "front").dimension == 1);
  CHECK(group(gmsh, "front").segments.size() == 2);
  CHECK(group(gmsh, "sheet").triangles.size() == 3);
  const mesh::MeshData second =
      read(".inp", nodes +
                       "*ELEMENT, TYPE=S6, ELSET=a\n1,1,2,3,5,6,9\n2,1,3,4,9,7,8\n*ELEMENT, TYPE=B31\n3,1,2\n"
                       "*ELEMENT, TYPE=MASS, ELSET=m\n4,1\n");
  CHECK(second.triangles.size() == 8);
  CHECK(group(second, "a").triangles.size() == 8);
  REQUIRE(second.notes.size() == 3);
  CHECK(has(second.notes[0], "2 elements of second order were split"));
  CHECK(has(second.notes[1], "1 elements of type B31 were left out"));
  CHECK(has(second.notes[2], "MASS"));
  for (const auto& [type, list] : {std::pair{"S8R", "1,1,2,3,4,5,6,7,8"}, {"M3D9", "1,1,2,3,4,5,6,7,8,9"}}) {
    const mesh::MeshData eight = read(".inp", nodes + "*ELEMENT, TYPE=" + type + "\n" + list + "\n");
    CHECK(eight.triangles.size() == (std::string(type) == "S8R" ? 6 : 8));
    CHECK(has(eight.notes.at(0), "1 elements of second order"));
  }
}

TEST_CASE("Abaqus: files are included beside each other, not without end") {
  const TemporaryFile elements(".inp", "*ELEMENT, TYPE=S3, ELSET=a\n1,1,2,3\n");
  const std::string name = elements.path().filename().string();
  const std::string nodes = "*NODE\n1,0,0\n2,1,0\n3,1,1\n4,0,1\n*INCLUDE, INPUT=";
  const mesh::MeshData both = read(".inp", nodes + name + "\n*ELEMENT, TYPE=S3\n2,1,3,4\n");
  CHECK(both.triangles.size() == 2);
  const TemporaryFile loop(".inp", "");
  std::ofstream(loop.path()) << "*INCLUDE, INPUT=" << loop.path().filename().string() << "\n";
  CHECK(has(message(".inp", "*INCLUDE, INPUT=" + loop.path().filename().string() + "\n"), "include each other"));
}

TEST_CASE("a byte-order mark before a file does not matter") {
  const std::string mark = "\xef\xbb\xbf", nodes = "*NODE\n1,0,0\n2,1,0\n3,1,1\n";
  for (const auto& [suffix, text] :
       {std::pair{".inp", nodes + "*ELEMENT, TYPE=S3\n1,1,2,3\n"},
        {".obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n"},
        {".off", "OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n"},
        {".vtk",
         "# vtk DataFile Version 2.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 1 1 0\nPOLYGONS 1 4\n3 0 "
         "1 2\n"},
        {".ply",
         "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
         "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n"},
        {".stl",
         "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nendloop\nendfacet\n"
         "endsolid s\n"}}) {
    const std::string kind = suffix;
    INFO(kind);
    CHECK(read(suffix, mark + text).triangles == read(suffix, text).triangles);
    CHECK(read(suffix, text).triangles.size() == 1);
  }
}

TEST_CASE("loops of the boundary are numbered from the longest; vertices without a triangle go") {
  // A square with a square hole, and a point beside it.
  std::string text = "v 9 9 9\n";
  for (const double half : {2.0, 1.0})
    for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
      text += "v " + std::to_string(half * x) + " " + std::to_string(half * y) + " 0\n";
  for (int k = 0; k < 4; ++k) {
    const int a = 2 + k, b = 2 + (k + 1) % 4;
    text += "f " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(b + 4) + " " +
            std::to_string(a + 4) + "\n";
  }
  const mesh::SurfaceMesh mesh(read(".obj", text));
  CHECK(mesh.vertex_count() == 8);
  CHECK(mesh.group("boundary").segments.size() == 8);
  CHECK(mesh.group("boundary-1").vertices == std::vector<Index>{0, 1, 2, 3});
  CHECK(mesh.group("boundary-2").vertices == std::vector<Index>{4, 5, 6, 7});
}

TEST_CASE("VTK of version 5, binary, and STL, PLY and OFF as sheets") {
  std::string vtk = "# vtk DataFile Version 5.1\nt\nBINARY\nDATASET POLYDATA\nPOINTS 4 float\n";
  for (const float x : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 1.F, 1.F, 0.F, 0.F, 1.F, 0.F}) vtk += big_endian(x);
  vtk += "\nMETADATA\nINFORMATION 0\n\nPOLYGONS 3 6\nOFFSETS vtktypeint64\n";
  for (const std::int64_t k : {0, 3, 6}) vtk += big_endian(k);
  vtk += "\nCONNECTIVITY vtktypeint64\n";
  for (const std::int64_t k : {0, 1, 2, 0, 2, 3}) vtk += big_endian(k);
  vtk += "\nCELL_DATA 2\nFIELD FieldData 1\nphysical 1 2 int\n" + big_endian(std::int32_t{7}) +
         big_endian(std::int32_t{8}) + "\n";
  const mesh::SurfaceMesh mesh(read(".vtk", vtk));
  CHECK(mesh.triangle_count() == 2);
  CHECK(mesh.group("physical-8", 2).triangles == std::vector<Index>{1});
  for (const char* name : {"text.stl", "text.ply", "text.off", "body.obj"}) {
    const mesh::SurfaceMesh body(formats::read_mesh(seeds + name, {}));
    CHECK(body.vertex_count() == 4);
    CHECK(body.triangle_count() == 4);
    CHECK(!body.has_group("boundary"));  // it is closed
  }
}

TEST_CASE("what is wrong with a mesh names the file, the line and the remedy") {
  CHECK(has(message(".obj", "v 0 0 0\nv 1 0\n"), ".obj:2: finite numbers"));
  CHECK(has(message(".obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n"), ".obj:4: '7' is no number of one of 3 vertices"));
  CHECK(has(message(".obj", "v 0 0 0\n"), "no triangles"));
  CHECK(has(message(".inp", "*ELEMENT, TYPE=C3D8\n"), ".inp: elements of type 'C3D8'"));
  CHECK(has(message(".inp", "*INCLUDE, INPUT=/etc/hostname\n"), ".inp:1: *INCLUDE needs"));
  CHECK(has(message(".inp", "*INCLUDE, INPUT=not_there.inp\n"), "there is no file"));
  CHECK(has(message(".inp", "*NODE\n1,0,0\n*ELEMENT, TYPE=S3\n1,1,2,3\n"), ".inp:4: there is no node 2"));
  CHECK(has(message(".inp", "*PART, NAME=A\n*PART, NAME=B\n"), ".inp:2: *PART is not read"));
  CHECK(has(message(".vtk", "no vtk\n"), "no legacy VTK"));
  CHECK(has(message(".vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_GRID\n"), "STRUCTURED_GRID"));
  CHECK(
      has(message(".vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 99999999 float\n"), "count"));
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  formats::MeshOptions options;
  options.scale = 1e300;
  CHECK(has(message(".obj", triangle, options), "check the file and its scale"));
  options.scale = 1e-300;
  CHECK(has(message(".obj", triangle, options), "check the file and its scale"));
  CHECK(has(message(".obj", "v 1e200 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), "vertex 1"));
  options = {};
  options.parameters["n"] = 3;
  CHECK(has(message(".obj", triangle, options), "parameters can only be set for a .geo"));
}

}  // namespace test_mesh_file
