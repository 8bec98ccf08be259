// Blocks of a DXF as AAMA/ASTM D6673 has them; private to src/pattern.
#pragma once

#include <string>
#include <vector>

#include "dxf_entities.hpp"
#include "pattern.hpp"

namespace voile::pattern {

/// What the entities of a layer draw. `slits`: where outlines go out and back on the same way, see curves_of(); may be null.
[[nodiscard]] std::vector<Curve> curves_on(const std::vector<DxfEntity>& entities, const std::string& layer,
                                           std::vector<Vec2>* slits = nullptr);

/// Whether a block has an outline on the layers of the standard.
[[nodiscard]] bool is_piece(const DxfBlock& block);

/// The piece that a block draws, in the file's units, without a name; a half is unfolded across its mirror line. `where`:
/// for messages. Throws UserError.
[[nodiscard]] Piece read_block(const std::string& where, const DxfBlock& block, std::vector<std::string>& notes);

}  // namespace voile::pattern
