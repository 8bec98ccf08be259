// Equilibria of a specimen of a drape test, as the fabric has them without friction.
//
// A sinusoidal load, -w cos(n a) in the direction a with the weight w per area, folds the specimen into n folds while it hangs.
// Without that load it goes to the equilibrium next to these folds, which may have another number, or be unstable. One more search
// begins with the shape that the test came to.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "drape_test.hpp"

namespace voile::cli {

struct DrapeEquilibrium {
  int start = 0;                   ///< folds; 0: the shape of the test
  DrapeRepeat specimen;            ///< `converged`: an equilibrium was found, stable or not
  double energy = 0.0;             ///< of the fabric and its weight; 0: flat [J]
  double eigenvalue = 0.0;         ///< of the tangent in the mass, nearest to zero [1/s^2]
  long negative_eigenvalues = -1;  ///< 0: stable; -1: not known
  int rank = 0;                    ///< by energy, 1: the lowest; one for all that are the same
};

/// From the numbers of folds of the test, and from the end of this repeat if it has rested. Throws StoppedBySignal, UserError.
[[nodiscard]] std::vector<DrapeEquilibrium> find_drape_equilibria(const DrapeSetting& s, const DrapeRepeat& tested);
/// Whether one was found.
[[nodiscard]] bool has_equilibrium(const std::vector<DrapeEquilibrium>& all);
/// Numbers them by energy.
void rank_equilibria(std::vector<DrapeEquilibrium>& all);
/// As CSV, and for summary.json. Throws UserError.
[[nodiscard]] nlohmann::ordered_json write_equilibria(const std::filesystem::path& file,
                                                      const std::vector<DrapeEquilibrium>& all);

}  // namespace voile::cli
