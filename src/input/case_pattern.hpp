// The patterns of a case; private to src/input.
#pragma once

#include "case.hpp"
#include "case_read.hpp"

namespace voile::input {

/// Reads every [[panel]] and [[seam]], and [sewing]. Throws UserError for what contradicts itself.
void read_pattern(const CaseReader& reader, Case& c);

/// The mesh is made from panels. Throws UserError for keys of [mesh] that then mean nothing.
void check_panel_mesh(const SectionPlace& place, const Case& c);

}  // namespace voile::input
