// A [[material]] of a case from a section of a deck.
#pragma once

#include <string>
#include <vector>

#include "formats/deck.hpp"

namespace voile::cli {

struct DeckMaterial {
  std::string text;               ///< without `groups`; empty: nothing is known of it
  std::vector<std::string> left;  ///< what was not taken
};
[[nodiscard]] DeckMaterial deck_material(const formats::Deck& deck, const formats::Deck::Section& section);

}  // namespace voile::cli
