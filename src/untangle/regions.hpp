// Regions of a sheet and the side of a line of intersection on which they lie; private to src/untangle.
//
// A region is what hangs together across edges that are not cut; its lowest point stands for it. Where something
// pierces a sheet, the pierced edges are cut and join regions on opposite sides: waves through a layer make many
// regions, but only two sides. The side of less area is the wrong one. Source: Baraff, Witkin, Kass, Untangling Cloth,
// ACM TOG 22 (2003).
#pragma once

#include <array>
#include <map>
#include <set>
#include <vector>

#include "contact/surface.hpp"

namespace voile::untangle {

using namespace contact;

using mesh::ascending;
using mesh::Segment;

/// Per sheet point, the region into which cuts divide the sheet; the connected parts of the sheet if nothing is cut.
[[nodiscard]] std::vector<Index> regions_without(const Surface& surface, const std::set<Segment>& cut);

/// Regions of a sheet on the two sides of what pierces it.
struct Sides {
  std::vector<Index> region;         ///< per sheet point
  std::map<Index, double> areas;     ///< of each region [m^2]
  std::map<Index, int> side;         ///< 0 or 1, of the regions at pierced edges
  std::array<double, 2> side_areas;  ///< [m^2]
};

/// `pierced`: edges of one piece that one other thing pierces; `cut`: further edges across which nothing belongs
/// together.
[[nodiscard]] Sides sides_of(const Surface& surface, const std::set<Segment>& pierced, std::set<Segment> cut);

/// The end of a pierced edge that lies on the side of less area; no_index: both are in the same region.
[[nodiscard]] Index wrong_end(const Segment& edge, const Sides& sides);

}  // namespace voile::untangle
