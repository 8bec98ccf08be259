// Commands that a program beside this one does.
#pragma once

#include <array>
#include <utility>

namespace voile::app {

/// The commands of voile-picture, and what they do.
inline constexpr std::array picture_commands{
    std::pair{"render", "Draw results: PNG, WebP, GIF, MP4"},
    std::pair{"export", "Write results in other formats: OBJ, STL, PLY, PC2, MDD, GLB, USDA, MSH, CSV"},
    std::pair{"plot", "Draw curves of the history: SVG, PNG"},
    std::pair{"view", "Write one HTML file that shows results in a browser"}};

/// If the command is one of these, this process becomes voile-picture; of several ranks only the first does, the others
/// end. Returns if it is none. Throws UserError if that program is not beside this one. Before MPI starts.
void delegate_pictures(int argc, char** argv);

}  // namespace voile::app
