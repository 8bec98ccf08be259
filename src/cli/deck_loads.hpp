// Loads of decks that take another form in a case.
#pragma once

#include <string>
#include <vector>

#include "formats/deck.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::cli {

/// Gravity on a set that is the elements of some sections becomes loads per area there. Others act on the whole sheet, and a
/// line in `left` says so.
void divide_gravity(formats::Deck& deck, const mesh::MeshData& mesh, std::vector<std::string>& left);

/// The table [[temperature]] of a change of temperature of all nodes; others are in `left`.
[[nodiscard]] std::string temperature_of(const formats::Deck& deck, const mesh::MeshData& mesh,
                                         std::vector<std::string>& left);

}  // namespace voile::cli
