// Lines along which three pieces and more are sewn together.
//
// Segments of the edges of pieces hang together through seams. Those that become one edge are a tree: one segment in two seams and
// more, as the edge of a skirt between the two layers of its waistband, joins the others. At rest fabric is flat across each pair, so
// the segments lie on either side of the edge in turn.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "mesh/surface_mesh.hpp"

namespace voile::pattern {

/// Two segments that a seam makes one, each ascending, and the seam's place in a list.
struct SewnPair {
  std::array<mesh::Segment, 2> segments;
  std::size_t seam = 0;
};

/// Checks that the surface with all seams welded would be one, and sets `mesh.folded`. Not collective. Throws UserError that names the
/// pieces: cells that would be folded, lines that would be joined without a seam between them, or by seams in a circle.
/// `seams`: what each is called in messages.
void take_layers(mesh::MeshData& mesh, const std::vector<SewnPair>& pairs, const std::vector<std::string>& seams);

}  // namespace voile::pattern
