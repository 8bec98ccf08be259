// Loads of moments on edges of the boundary (energy/edge_moment.hpp).
#pragma once

namespace voile::energy {
class FollowerTerm;
}  // namespace voile::energy

namespace voile::system {

class Discretisation;
struct Load;

/// Adds what a `follower_moment` does on this rank to the term, under a number of its factors. Not collective. Throws UserError for
/// an unknown group, and an edge that is not on the boundary or whose slope a support holds.
void add_edge_moments(const Discretisation& on, const Load& load, int factor, energy::FollowerTerm& term);

}  // namespace voile::system
