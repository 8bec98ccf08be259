// Keys of periodic edges.
#include "keys_common.hpp"

namespace voile::input {

std::vector<Key> keys_of(PeriodicSection& s) {
  system::PeriodicPair& p = s.pair;
  return {
      {.name = "from", .slot = &p.from, .meaning = "Physical curve on the boundary.", .required = true},
      {.name = "to",
       .slot = &p.to,
       .meaning = "Physical curve on the boundary that repeats it: moved by one translation, with the same mesh.",
       .required = true},
      {.name = "name", .slot = &s.name, .meaning = "Begins the names of its columns in history.csv.", .absent = "to"},
      {.name = "difference",
       .slot = &s.difference,
       .meaning = "Displacement of `to` less that of `from`, along x, y and z: each a number, which grows with the "
                  "load factor, an expression of the time t, or `\"free\"`. In `static` with `control = \"load\"` "
                  "t is the load factor; elsewhere no expressions are possible, in `dynamic` only 0 and `\"free\"`.",
       .unit = "m",
       .absent = "0"},
      {.name = "force",
       .slot = &p.force,
       .meaning = "Total force of a fixed direction across the edges at load factor 1, where the difference is free: "
                  "on `to`, and the opposite on `from`.",
       .unit = "N"}};
}

}  // namespace voile::input
