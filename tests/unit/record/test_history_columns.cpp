// Columns of histories that are known by name, and those of probes.
#include <doctest/doctest.h>

#include <algorithm>

#include "record/history_columns.hpp"

namespace test_history_columns {

using voile::record::is_of_probe;
using voile::record::names_of;

TEST_CASE("columns of a history that are not probes' are known, whichever a run has") {
  for (const bool in_time : {false, true})
    for (const auto& name : names_of({.in_time = in_time,
                            .energy_balance = true,
                            .sewing = true,
                            .remeshing = true,
                            .contact = true,
                            .passing = true})) {
      CAPTURE(name);
      CHECK_FALSE(is_of_probe(name));
    }
  CHECK(is_of_probe("tip_uz"));
  CHECK(is_of_probe("vertices_uz"));
}

TEST_CASE("a history has the columns of what takes part in its run") {
  const auto has = [](const voile::record::HistoryColumns& which, const char* name) {
    const auto names = names_of(which);
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  CHECK_FALSE(has({}, "time"));
  CHECK(has({.in_time = true}, "time"));
  CHECK(has({.remeshing = true}, "vertices"));
  CHECK_FALSE(has({.contact = true}, "vertices"));
  CHECK(has({.contact = true}, "smallest_gap"));
  CHECK(has({.sewing = true}, "seam_gap"));
  CHECK(has({.passing = true}, "passing"));
}

}  // namespace test_history_columns
