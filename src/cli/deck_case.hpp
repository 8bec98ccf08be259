// The case file that does what a deck of another program does.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "formats/deck.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::cli {

struct DeckCase {
  std::string text;               ///< case.toml, of the mesh "mesh.inp"
  std::string sets;               ///< of single nodes and elements that the case names, to be added to the mesh
  std::vector<std::string> left;  ///< what was left out
  bool has_material = false;
  std::size_t materials = 0;
};

/// `mesh`: of the deck. Not collective.
[[nodiscard]] DeckCase deck_case(const formats::Deck& deck, const mesh::MeshData& mesh);

}  // namespace voile::cli
