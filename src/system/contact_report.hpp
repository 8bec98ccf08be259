// Contacts in a state, in numbers and words.
#pragma once

#include <limits>
#include <string>

namespace voile::system {

/// What a user wants to know of the contacts in a state.
struct ContactReport {
  long pairs = 0;                                        ///< within the activation distance
  double gap = std::numeric_limits<double>::infinity();  ///< smallest [m]; infinite: nothing within the distance
  std::string nearest;                                   ///< the pair with the smallest gap, in words; on every rank
  long most_pairs = 0;                                   ///< of them on one rank
  long candidates = 0;       ///< of all ranks; those with vertices of several are counted by each of them
  long most_candidates = 0;  ///< of them on one rank
};

}  // namespace voile::system
