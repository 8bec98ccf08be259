// Holes and notches that are small for the thickness of a sheet.
//
// Symbols   R    radius of an arc of the boundary that is concave: length over turn of its edges [m]
//           h    sqrt(12 D/A), the thickness that the sheet bends with [m];  E_1 >= E_2 moduli of both axes
// Beside an arc in-plane strains change over R. Their gradient counts as curvature in the constant bending matrix, whose energy is
// (h/R)^2 of that of stretching: stresses at the arc of a round hole are 1.6 % too low at R = 10 h, 4 % at 5 h, and with
// E_1 = 14 E_2 16 and 25 %. Angles at edges (edge_angle.hpp) do not see what lies in the surface.
#pragma once

#include <vector>

#include "sheet.hpp"

namespace voile::energy {

/// Per triangle, whether it lies within R of a concave arc of R < 20 h sqrt(E_1/E_2); empty: none does. Corners are no arcs. `root`: of
/// each vertex of a periodic sheet the one that it repeats, or itself; empty: it is not periodic.
[[nodiscard]] std::vector<char> near_notches(const Sheet& sheet, const std::vector<Index>& root = {});

}  // namespace voile::energy
