// Hyperelastic materials of a case: neo_hookean, mooney_rivlin, ogden.
#pragma once

#include "case_keys.hpp"
#include "case_read.hpp"

namespace voile::input {

/// Keys that only such materials have.
[[nodiscard]] std::vector<Key> rubber_keys(MaterialInput& section);
[[nodiscard]] bool is_rubber(MaterialInput::Type type);
/// Its law, and the stiffness at zero strain that all else takes.
void fill_rubber(const SectionPlace& place, const MaterialInput& in, energy::Material& m);
/// Where a law loses ellipticity in tension, up to several times its length: empty if nowhere.
[[nodiscard]] std::string ellipticity_note(const energy::Hyperelastic& law);

}  // namespace voile::input
