// Parameters of draping.
#pragma once

namespace voile::solve {

struct DrapeOptions {
  int max_iterations = 2000;  ///< of each search
  int max_escapes = 10;       ///< from unstable equilibria
  double push = 0.1;          ///< largest displacement of an escape, in edge lengths
  bool fall = true;           ///< with contact: a damped fall first, then the search
};

}  // namespace voile::solve
