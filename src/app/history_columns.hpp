// Names of the columns of history.csv that are not those of probes; private to src/app.
#pragma once

#include <string>
#include <vector>

namespace voile::app {

/// Which of the columns a history has.
struct HistoryColumns {
  bool in_time = false, energy_balance = false, sewing = false, remeshing = false, contact = false, yielding = false;
};

/// In the order of the file.
[[nodiscard]] std::vector<std::string> names_of(const HistoryColumns& columns);

/// Whether a column of a history is that of a probe.
[[nodiscard]] bool is_of_probe(const std::string& column);

}  // namespace voile::app
