// Keys of rigid groups.
#include "keys_common.hpp"

namespace voile::input {

std::vector<Key> keys_of(RigidSection& s) {
  using Turn = system::RigidGroup::Turn;
  system::RigidGroup& g = s.group;
  return {
      {.name = "group",
       .slot = &g.group,
       .meaning = "Physical point, curve or surface of at least three vertices, which move as one rigid body.",
       .required = true},
      {.name = "name",
       .slot = &s.name,
       .meaning = "Begins the names of its columns in history.csv.",
       .absent = "group"},
      {.name = "point",
       .slot = &g.point,
       .meaning = "Reference point at the start. It moves with the body.",
       .unit = "m",
       .absent = "the centre of its length or area"},
      {.name = "slope",
       .slot = choice(g.slope, {{"held", true}, {"free", false}}),
       .meaning = "Whether the slope across boundary edges of a curve turns with the body, as at a clamped edge."},
      {.name = "translation",
       .slot = &s.translation,
       .meaning =
           "Displacement of the reference point along x, y and z: each `\"free\"` or an expression of the time t, e.g. "
           "`[\"free\", 0, \"0.1*t\"]`. 0 holds it. In `static` with `control = \"load\"` t is the load factor; "
           "elsewhere but in `dynamic` only 0 is possible.",
       .unit = "m",
       .absent = "free"},
      {.name = "turn",
       .slot = choice(g.turn, {{"free", Turn::free}, {"held", Turn::held}, {"about", Turn::about}}),
       .meaning = "`free`: about any axis. `held`: it does not turn. `about`: about `turn_axis` only."},
      {.name = "turn_axis",
       .slot = &g.axis,
       .meaning = "Axis through the reference point, for `turn = \"about\"`.",
       .absent = "none"},
      {.name = "turn_angle",
       .slot = &s.angle,
       .meaning = "Angle about it, an expression likewise.",
       .unit = "degree",
       .absent = "free"},
      {.name = "force",
       .slot = &g.force,
       .meaning = "Force at the reference point at load factor 1, of a fixed direction.",
       .unit = "N"},
      {.name = "moment",
       .slot = &g.moment,
       .meaning = "Moment about the reference point at load factor 1, of a fixed direction.",
       .unit = "N m"},
      {.name = "mass",
       .slot = &g.mass,
       .meaning = "Mass at the reference point, besides that of the sheet. It has no weight.",
       .unit = "kg",
       .range = not_negative}};
}

}  // namespace voile::input
