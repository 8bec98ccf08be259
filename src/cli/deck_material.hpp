// A [[material]] of a case from a section of an Abaqus deck.
#pragma once

#include <string>
#include <vector>

#include "io/abaqus_deck.hpp"

namespace voile::cli {

struct DeckMaterial {
  std::string text;               ///< without `groups`; empty: nothing is known of it
  std::vector<std::string> left;  ///< what was not taken
};
[[nodiscard]] DeckMaterial deck_material(const io::AbaqusDeck& deck, const io::AbaqusDeck::Section& section);

}  // namespace voile::cli
