// Loads and supports of decks that take another form in a case.
#pragma once

#include <string>
#include <vector>

#include "formats/deck.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::cli {

/// 1 where a vertex is of a set of nodes, or the node of that number.
[[nodiscard]] std::vector<char> vertices_of(const mesh::MeshData& mesh, const std::string& where);

/// Takes away supports and forces along axes of nodes (*TRANSFORM); `left` names them.
void drop_turned(formats::Deck& deck, const mesh::MeshData& mesh, std::vector<std::string>& left);

/// The axis, 0 to 2, normal to the plane that a support on the vertices `at` mirrors in: its displacement along that and both turns
/// about the others are held. -1: there is none.
[[nodiscard]] int mirror_of(const formats::Deck::Support& s, const mesh::MeshData& mesh, const std::vector<char>& at);

/// Whether the sheet at the vertices `at` lies in that plane: an edge that does not turn, not one that the sheet goes on beyond.
[[nodiscard]] bool lies_in_mirror(int mirror, const mesh::MeshData& mesh, const std::vector<char>& at);
/// Whether a group is an area: held across the sheet, it cannot turn either.
[[nodiscard]] bool is_area(const mesh::MeshData& mesh, const std::string& group);
/// Whether two of the vertices have an edge.
[[nodiscard]] bool has_edge(const mesh::MeshData& mesh, const std::vector<char>& at);

/// Gravity on a set that is the elements of some sections becomes loads per area there. Others act on the whole sheet, and a
/// line in `left` says so.
void divide_gravity(formats::Deck& deck, const mesh::MeshData& mesh, std::vector<std::string>& left);

/// The table [[temperature]] of a change of temperature of all nodes; others are in `left`.
[[nodiscard]] std::string temperature_of(const formats::Deck& deck, const mesh::MeshData& mesh,
                                         std::vector<std::string>& left);

}  // namespace voile::cli
