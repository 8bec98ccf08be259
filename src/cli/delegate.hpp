// Commands that a program beside this one does.
#pragma once

#include <array>

namespace voile::cli {

struct DelegatedCommand {
  const char *name, *what, *program;
  bool on_all_ranks = false;
};
inline constexpr std::array delegated_commands{
    DelegatedCommand{"render", "Draw results: PNG, WebP, GIF, MP4", "voile-picture", true},
    DelegatedCommand{"export", "Write results in other formats: OBJ, STL, PLY, PC2, MDD, GLB, USDA, MSH, CSV",
                     "voile-picture"},
    DelegatedCommand{"plot", "Draw curves of the history: SVG, PNG", "voile-picture"},
    DelegatedCommand{"sheet", "Put pictures beside each other: PNG", "voile-picture"},
    DelegatedCommand{"view", "Write one HTML file that shows results in a browser", "voile-picture"},
    DelegatedCommand{"manikin", "Make a dress form or a walking figure from measurements: OBJ, PC2", "voile-manikin"}};

/// If the command is one of these, this process becomes that program; where that cannot use several ranks, the first
/// does, and the others end. Returns if it is none. Throws UserError if that program is not beside this one. Before MPI starts.
void delegate_command(int argc, char** argv);

}  // namespace voile::cli
