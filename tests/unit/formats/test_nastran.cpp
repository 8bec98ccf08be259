// Sheets from Nastran bulk data: fields, continuations, coordinate systems, groups, mistakes.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "formats/mesh_file.hpp"
#include "test_meshes.hpp"
#include "test_text.hpp"
#include "voile/errors.hpp"

namespace test_nastran {

using namespace voile;
using namespace voile::testing;

namespace {

mesh::MeshData read(const std::string& text, const std::string& suffix = ".bdf") {
  const TemporaryFile file(suffix, text);
  return formats::read_mesh(file.path().string(), {});
}

std::string message(const std::string& text) {
  try {
    (void)read(text);
  } catch (const UserError& e) {
    return e.what();
  }
  return "nothing is wrong";
}

/// Three grid points in every form of fields.
const std::string points =
    "GRID           1              0.      0.    1.-3\n"
    "grid,2,,2.5D+0,0.,1.0-3  $ free\n"
    "GRID*                  3                             1.5            1.25+A\n"
    "*A      1.000000000E-3\n";

}  // namespace

TEST_CASE("Nastran: small, large and free fields are the same numbers; control cards and comments are passed over") {
  for (const std::string head : {"", "SOL 101\nCEND\nTITLE = GRID, 1\nSPC = 2\nBEGIN BULK\n"}) {
    const mesh::MeshData data =
        read(head + "$ three points\n" + points + "CTRIA3\t7\t4\t1\t2\t3\nENDDATA\nGRID nonsense\n", ".DAT");
    REQUIRE(data.positions.size() == 3);
    CHECK(data.positions[0] == Vec3(0.0, 0.0, 1e-3));
    CHECK(data.positions[1] == Vec3(2.5, 0.0, 1e-3));
    CHECK(data.positions[2] == Vec3(1.5, 1.25, 1e-3));
    CHECK(mesh::SurfaceMesh(data).group("property-4", 2).triangles.size() == 1);
  }
}

TEST_CASE("Nastran: places in rectangular, cylindrical and spherical systems that build on each other") {
  // System 5: origin (1, 2, 3), its axes x, y, z are y, z, x of the basic one. 6 and 7: curved, the same axes.
  const std::string systems =
      "CORD2R,5,,1.,2.,3.,2.,2.,3.\n,1.,3.,3.\n"
      "CORD2C,6,5,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n"
      "CORD1S,7,10,11,12\n"
      "GRID,10,5\nGRID,11,5,,,1.\nGRID,12,5,1.\n";
  const std::string body = "GRDSET,,6\nGRID,1,5,1.,2.,4.\nGRID,2,,2.,90.,.5\nGRID,3,7,2.,90.,30.\nCTRIA3,1,,1,2,3\n";
  const mesh::MeshData data = read(systems + body);
  REQUIRE(data.positions.size() == 3);
  CHECK((data.positions[0] - Vec3(5.0, 3.0, 5.0)).norm() < 1e-14);
  CHECK((data.positions[1] - Vec3(1.5, 2.0, 5.0)).norm() < 1e-14);
  CHECK((data.positions[2] - Vec3(1.0, 2.0 + std::sqrt(3.0), 4.0)).norm() < 1e-14);
  CHECK(mesh::SurfaceMesh(data).group("property-1", 2).triangles.size() == 1);  // PID is EID where it is blank
  CHECK(has(message(body), "GRID: there is no coordinate system 5"));
  CHECK(has(message("CORD2R,5,6\n,0.,0.,1.,1.,0.,0.\nCORD2R,6,5\n" + body), "refers to itself"));
  CHECK(has(message("CORD2R,5,,0.,0.,0.,0.,0.,1.\n,0.,0.,2.\n" + body), ":1: CORD2R: its three points lie on a line"));
  CHECK(has(message(systems + systems.substr(0, 44) + body), "is there twice"));
}

TEST_CASE("Nastran: quadrangles and second order are split, held points are a group, others are noted") {
  std::string text;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i)
      text += "GRID," + std::to_string(3 * j + i + 1) + ",," + std::to_string(i) + ".," + std::to_string(j) + ".\n";
  const std::string held = "SPC1,4,123456,1,THRU,7,BY,3\nSPC,4,9,3\nCBAR,99,3,1,2,0.,0.,1.\n";
  const mesh::MeshData four =
      read(text + held + "CQUAD4,1,8,1,2,5,4\nCQUAD4,2,8,2,3,6,5\nCQUADR,3,9,4,5,8,7\nCQUAD4,4,9,5,6,9,8\n");
  CHECK(four.triangles.size() == 8);
  const mesh::SurfaceMesh mesh(four);
  CHECK(mesh.group("property-8", 2).triangles.size() == 4);
  CHECK(mesh.group("spc-4", 1).vertices == std::vector<Index>{0, 3, 6, 8});
  CHECK(has(four.notes.back(), "type CBAR"));
  // Of a range only what exists: the numbers between are never made.
  const mesh::MeshData wide = read(text +
                                   "SPC1,4,123456,1,THRU,99999997,BY,3\nCQUAD4,1,8,1,2,5,4\nCQUAD4,2,8,4,5,8,7\n"
                                   "CQUAD4,3,8,2,3,6,5\nCQUAD4,4,8,5,6,9,8\n");
  CHECK(mesh::SurfaceMesh(wide).group("spc-4").vertices == std::vector<Index>{0, 3, 6});
  const mesh::MeshData eight = read(text + "CQUAD8,1,8,1,3,9,7,2,6\n,8,4\n");
  CHECK(eight.triangles.size() == 6);
  CHECK(has(message(text + "CQUAD8,1,8,1,3,9,7,2,6\n,8\n"), "CQUAD8: 7 of 8 nodes are given"));
  CHECK(read(text + "CQUAD8,1,8,1,3,9,7\n").triangles.size() == 2);
}

TEST_CASE("Nastran: what is wrong names the file, the line and the card") {
  const std::string triangle = "CTRIA3,7,4,1,2,3\n";
  CHECK(has(message(points + "CTRIA3,7,4,1,2,8\n"), ":5: CTRIA3: there is no grid point 8"));
  CHECK(has(message(points + "CTRIA3,7,4,1,2\n"), ":5: CTRIA3: corner 3 is missing"));
  CHECK(has(message(points + triangle + triangle), ":6: CTRIA3: element 7 is there twice, first in line 5"));
  CHECK(has(message("GRID,1,,0.,1.x\n" + triangle), ":1: GRID: field 5 is '1.X'"));
  CHECK(has(message(points + "GRID,1,,5.\n" + triangle), ":5: GRID: grid point 1 is there twice"));
  CHECK(has(message(points + "+B      1.\n" + triangle), ":5: the continuation 'B' does not follow its card"));
  CHECK(has(message(points + "=,*1,=,*(1.),==\n" + triangle), ":5: replicated cards"));
  CHECK(has(message("BEGIN SUPER=2\n" + points + triangle), ":1: superelements"));
  CHECK(has(message("INCLUDE '/etc/hostname'\n"), ":1: INCLUDE: there is no file '/etc/hostname' beside"));
  CHECK(has(message("CHEXA,1,1,1,2,3,4,5,6\n,7,8\n"), "type 'CHEXA' are no triangles"));
  const TemporaryFile inner(".bdf", points);
  CHECK(read("INCLUDE '" + inner.path().filename().string().substr(0, 3) + "\n" +
             inner.path().filename().string().substr(3) + "'\n" + triangle)
            .triangles.size() == 1);
}

}  // namespace test_nastran
