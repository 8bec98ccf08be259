// Files of others: read in a process of their own, scripts that would run programs.
#include <doctest/doctest.h>

#include <csignal>
#include <new>
#include <stdexcept>

#include "base/bytes.hpp"
#include "base/child_process.hpp"
#include "formats/geo_safety.hpp"
#include "formats/triangle_file.hpp"
#include "test_meshes.hpp"
#include "voile/errors.hpp"

namespace test_foreign_files {

using namespace voile;
using namespace voile::testing;

TEST_CASE("a child process: its bytes, its errors, its death") {
  std::string large(3000000, 'x');
  large[1234567] = '\0';
  CHECK(run_in_child("f", [&] { return large; }) == large);
  CHECK(run_in_child("f", [] { return std::string(); }).empty());
  const auto fails = [](auto work) {
    return [work] {
      (void)run_in_child("some.file", [&]() -> std::string {
        work();
        return "";
      });
    };
  };
  CHECK_THROWS_WITH_AS(fails([] { throw UserError("mistake"); })(), "mistake", UserError);
  CHECK_THROWS_WITH_AS(fails([] { throw std::bad_alloc(); })(),
                       doctest::Contains("some.file: reading or meshing it needs"), UserError);
  CHECK_THROWS_WITH_AS(fails([] { throw std::length_error("x"); })(), doctest::Contains("memory"), UserError);
  CHECK_THROWS_WITH_AS(fails([] { throw std::runtime_error("odd"); })(), doctest::Contains("(odd)"), UserError);
  CHECK_THROWS_WITH_AS(fails([] { throw 3; })(), doctest::Contains("unknown exception"), UserError);
  CHECK_THROWS_WITH_AS(fails([] { (void)std::raise(SIGSEGV); })(), doctest::Contains("some.file: reading it failed"),
                       UserError);
  CHECK_THROWS_WITH_AS(fails([] { std::_Exit(0); })(), doctest::Contains("without an answer"), UserError);
  // Signals to the whole group are for the run.
  const auto signalled = [] {
    for (const int number : {SIGTERM, SIGINT, SIGUSR1, SIGUSR2}) (void)std::raise(number);
    return std::string("done");
  };
  CHECK(run_in_child("f", signalled) == "done");
  // What the child changes is not changed here.
  int here = 1;
  try_in_child("f", [&] { here = 2; });
  CHECK(here == 1);
}

TEST_CASE("bytes: what is written is read, and too few are an error") {
  ByteWriter out;
  out.put(std::vector<Vec3>{{1, 2, 3}, {4, 5, 6}});
  out.put(std::vector<std::string>{"a", "", "bcd"});
  out.put(7);
  const std::string bytes = out.take();
  ByteReader in(bytes);
  std::vector<Vec3> x;
  std::vector<std::string> texts;
  int number = 0;
  in.get(x);
  in.get(texts);
  in.get(number);
  CHECK(x.at(1) == Vec3(4, 5, 6));
  CHECK(texts == std::vector<std::string>{"a", "", "bcd"});
  CHECK(number == 7);
  CHECK_THROWS_AS(in.get(number), InternalError);
  ByteReader cut(bytes.substr(0, 20));
  CHECK_THROWS_AS(cut.get(x), InternalError);
}

TEST_CASE("scripts that run programs or write files are refused, however they say it") {
  const TemporaryFile inner(".geo", "Point(1) = {0, 0, 0};\nSystemCall \"true\";\n");
  const TemporaryFile mesh(".msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Comments\nSystemCall\n$EndComments\n");
  for (const std::string& text : std::vector<std::string>{"SystemCall \"true\";",
                                                          "NonBlockingSystemCall \"true\";",
                                                          "System \"true\";",
                                                          "System'true';",
                                                          "System Str(\"true\");",
                                                          "System /* now */ StrCat(\"tr\", \"ue\");",
                                                          "s = \"true\"; System s;",
                                                          "OnelabRun(\"x\", \"true\");",
                                                          "Field[1] = ExternalProcess;",
                                                          "If(0) \" EndIf SystemCall \"true\";",
                                                          "a = '\"'; SystemCall \"true\";",
                                                          "Save \"x.msh\";",
                                                          "Save StrCat(\"x\", \".msh\");",
                                                          "Print \"x.png\";",
                                                          "CreateDir \"x\";",
                                                          "Printf(\"a; (b\") > \"x\";",
                                                          "Printf(\"%g\", Sqrt(2)) >> \"x\";",
                                                          "Error(\"x\") > Str(\"y\");",
                                                          "Plugin(BoundaryAngles).Run;",
                                                          "Merge StrCat(\"x\", \".geo\");",
                                                          "Include Str(\"x.geo\");",
                                                          "Merge \"x.py\";",
                                                          "Merge \"x.geo.gz\";",
                                                          "Include \"" + inner.path().string() + "\";",
                                                          "Merge \"" + inner.path().string() + "\";"}) {
    INFO(text);
    const TemporaryFile file(".geo", "// first line\n" + text + "\n");
    CHECK_THROWS_WITH_AS(formats::refuse_dangerous_commands(file.path().string()),
                         doctest::Contains("--allow-system-call"), UserError);
    CHECK_THROWS_WITH_AS(static_cast<void>(formats::read_gmsh(file.path().string(), {})),
                         doctest::Contains("--allow-system-call"), UserError);
  }
  const TemporaryFile numbered(".geo", "\n\nSystemCall \"true\";\n");
  CHECK_THROWS_WITH_AS(formats::refuse_dangerous_commands(numbered.path().string()),
                       doctest::Contains(".geo:3: 'SystemCall'"), UserError);
  const TemporaryFile harmless(
      ".geo",
      "// Save time: Print the coordinate System and Merge the two by Plugin; Include nothing.\n"
      "n = 3; If((n) > 2) Printf(\"n > 2: %g\", n); EndIf\nPlugin(Crack).Dimension = 1;\nMerge \"" +
          mesh.path().string() + "\";\nInclude \"missing.geo\";\nMySystem = 1; SaveAll = 2;\nMesh.SaveAll = 1;\n");
  CHECK_NOTHROW(formats::refuse_dangerous_commands(harmless.path().string()));
}

TEST_CASE("a script that is allowed to run programs does; one that is not has not run") {
  const TemporaryFile made(".txt", "");
  std::filesystem::remove(made.path());
  const TemporaryFile file(".geo", "SystemCall \"touch " + made.path().string() +
                                       "\";\nPoint(1)={0,0,0,1};Point(2)={1,0,0,1};Point(3)={0,1,0,1};Line(1)={1,2};"
                                       "Line(2)={2,3};Line(3)={3,1};Curve Loop(1)={1,2,3};Plane Surface(1)={1};\n");
  CHECK_THROWS_AS(static_cast<void>(formats::read_gmsh(file.path().string(), {})), UserError);
  CHECK(!std::filesystem::exists(made.path()));
  formats::MeshOptions options;
  options.allow_system_call = true;
  CHECK(formats::read_gmsh(file.path().string(), options).triangles.size() >= 1);
  CHECK(std::filesystem::exists(made.path()));
}

TEST_CASE("damaged foreign files are a user's error that names them") {
  // CGAL looks at the last of no elements; Gmsh indexes an array of four by the dimension.
  const TemporaryFile ply(".ply", "ply\nformat ascii 1.0\nproperty float x\nelement vertex 1\nend_header\n0\n");
  CHECK_THROWS_WITH_AS(static_cast<void>(formats::read_triangles(ply.path())), doctest::Contains(".ply"), UserError);
  const TemporaryFile msh(
      ".msh",
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n99 1 \"a\"\n$EndPhysicalNames\n$Nodes\n3\n"
      "1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n$Elements\n1\n1 2 2 1 1 1 2 3\n$EndElements\n");
  CHECK_THROWS_WITH_AS(static_cast<void>(formats::read_gmsh(msh.path().string(), {})), doctest::Contains(".msh"),
                       UserError);
  // Not a mesh after all: Gmsh would take it for a script.
  const TemporaryFile script(".msh", "$x\nSystemCall \"true\";\n");
  CHECK_THROWS_WITH_AS(static_cast<void>(formats::read_gmsh(script.path().string(), {})),
                       doctest::Contains("$MeshFormat"), UserError);
}

}  // namespace test_foreign_files
