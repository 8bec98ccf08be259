// Lists of groups that count as one.
#include <doctest/doctest.h>

#include "setup/group_names.hpp"
#include "test_case_kit.hpp"
#include "test_meshes.hpp"

namespace test_group_unions {

using namespace voile;
using namespace voile::testing;

namespace {

input::Case with_spring(const std::string& groups) {
  return input::parse_case(
      "[mesh]\nfile = \"a.msh\"\n[[material]]\ntype = \"isotropic\"\nyoung = 1e6\npoisson = 0.3\nthickness = 0.01\n"
      "[[spring]]\ntype = \"line\"\nstiffness = 1\ngroup = " +
          groups + "\n",
      "case.toml");
}

mesh::SurfaceMesh square_mesh() {
  mesh::MeshData data = grid(4, 4, false, 0.0);
  add_square_groups(data);
  data.groups.push_back({"corner", 0, {0}, {}, {}});
  return mesh::SurfaceMesh(std::move(data));
}

}  // namespace

TEST_CASE("a list of groups becomes a group with the members of all, each once") {
  const input::Case c = with_spring("[\"left\", \"bottom\"]");
  const mesh::SurfaceMesh before = square_mesh(), mesh = setup::with_group_unions(c, before);
  const mesh::Group& both = mesh.group(c.springs[0].group, 1);
  CHECK(both.vertices.size() == 9);
  CHECK(both.segments.size() == 8);
  CHECK_NOTHROW(setup::check_group_names(c, mesh));
  CHECK(setup::with_group_unions(with_spring("\"left\""), before).groups().size() == before.groups().size());
  const std::string echo = input::echo_case(c);
  CHECK(has(echo, "group = [\"left\", \"bottom\"]"));
}

TEST_CASE("a group of the mesh that is named like a list must be that list") {
  const input::Case c = with_spring("[\"left\", \"bottom\"]");
  const mesh::SurfaceMesh once = setup::with_group_unions(c, square_mesh());
  CHECK(setup::with_group_unions(c, once).groups().size() == once.groups().size());
  mesh::MeshData data = square_mesh().data();
  data.groups.push_back(square_mesh().group("right", 1));
  data.groups.back().name = "left + bottom";
  CHECK(has(error_of([&] { (void)setup::with_group_unions(c, mesh::SurfaceMesh(std::move(data))); }),
            "the mesh has a group 'left + bottom' of its own"));
}

TEST_CASE("hinges along a list of lines are one group too") {
  const input::Case c = input::parse_case(
      "[mesh]\nfile = \"a.msh\"\n[[material]]\ntype = \"isotropic\"\nyoung = 1e6\npoisson = 0.3\nthickness = 0.01\n"
      "[[hinge]]\ngroup = [\"left\", \"right\"]\nstiffness = 1\n",
      "case.toml");
  CHECK(setup::with_group_unions(c, square_mesh()).group(c.hinges[0].group, 1).segments.size() == 8);
}

TEST_CASE("groups of a list that are unknown or of another kind are named") {
  const mesh::SurfaceMesh mesh = square_mesh();
  const auto refused = [&](const std::string& groups) {
    return error_of([&] {
      const input::Case c = with_spring(groups);
      setup::check_group_names(c, setup::with_group_unions(c, mesh));
    });
  };
  CHECK(has(refused("[\"left\", \"bottem\"]"), "[[spring]] group = \"bottem\""));
  CHECK(has(refused("[\"left\", \"corner\"]"), "[[spring]] group: 'left' is a curve and 'corner' a point"));
  CHECK(has(refused("[]"), "the list is empty"));
  CHECK(has(refused("[\"left\", \"left\"]"), "'left' is there twice"));
}

}  // namespace test_group_unions
