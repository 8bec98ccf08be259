// Names of the columns of history.csv that are not those of probes. voile-picture reads histories by
// them, too: nothing here may need the code of a solver (and with it PETSc, MUMPS and X).
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "system/energy_balance.hpp"

namespace voile::record {

/// Which of the columns a history has.
struct HistoryColumns {
  bool in_time = false, energy_balance = false, fabric = false, sewing = false, remeshing = false, contact = false,
       passing = false;
  std::vector<char> gases{};  ///< of each, whether it leaks
};

/// In the order of the file.
[[nodiscard]] std::vector<std::string> names_of(const HistoryColumns& columns);

/// Those of the balance of energy, besides `kinetic_energy` [J].
[[nodiscard]] std::array<std::pair<const char*, double>, 10> named_parts(const system::EnergyBalance& balance);

/// Of a rigid group of this name.
[[nodiscard]] std::vector<std::string> names_of_rigid(const std::string& name);

/// Of a pair of periodic edges of this name.
[[nodiscard]] std::vector<std::string> names_of_periodic(const std::string& name);

/// Whether a column of a history is that of a probe.
[[nodiscard]] bool is_of_probe(const std::string& column);

}  // namespace voile::record
