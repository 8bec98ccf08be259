// A [[material]] of a case from a section of a deck.
#pragma once

#include <string>
#include <vector>

#include "formats/deck.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::cli {

struct DeckMaterial {
  std::string text;               ///< without `groups`; empty: nothing is known of it
  std::vector<std::string> left;  ///< what was not taken
};
/// Of triangles, how many there are, of how many x is the normal to 0.1 degrees, and their normals.
struct SquareToX {
  std::size_t triangles = 0, square = 0;
  std::vector<Vec3> normals{};
};
/// Names of sets are alike whatever their capitals.
[[nodiscard]] bool same_name(const std::string& a, const std::string& b);
/// The group of `mesh` of that name, or none: of nodes and elements those of nodes if asked for.
[[nodiscard]] const mesh::Group* group_named(const mesh::MeshData& mesh, const std::string& name, bool nodes = false);

[[nodiscard]] SquareToX square_to_x(const mesh::MeshData& mesh, const mesh::Group* group);
/// Without an orientation material axis 1 is along x, and along z where x is normal to the sheet.
[[nodiscard]] DeckMaterial deck_material(const formats::Deck& deck, const formats::Deck::Section& section,
                                         const SquareToX& place);

}  // namespace voile::cli
