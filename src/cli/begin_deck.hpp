// A case from an Abaqus or Nastran deck: what `voile init --from` does.
#pragma once

#include <filesystem>

namespace voile::cli {

/// Writes case.toml and its mesh, a copy of an Abaqus deck or what a Nastran deck is in that language, into a folder, which is
/// made if it is not there, and prints what was taken, what was left out and what to type next. Replaces nothing. Throws
/// UserError for a deck that cannot be read and for files that exist or cannot be written. Not collective.
void begin_from_deck(const std::filesystem::path& folder, const std::filesystem::path& deck);

}  // namespace voile::cli
