// Keys of remeshing.
#include "keys_common.hpp"

namespace voile::input {

namespace {

/// What sizes the mesh is to have.
std::vector<Key> size_keys(RemeshSection& s) {
  return {
      {.name = "active",
       .slot = &s.active,
       .meaning = "Whether the mesh follows the folds. `true` if the section is there and this key is not given.",
       .absent = "`true` with the section, otherwise `false`"},
      {.name = "angle",
       .slot = Degrees{&s.angle},
       .meaning = "Angle wanted between neighbouring triangles: an edge is this over the curvature long. Smaller is "
                  "finer: 9 fine, 20 draft.",
       .unit = "degree",
       .range = positive},
      {.name = "error",
       .slot = &s.error,
       .meaning =
           "Largest `recovery_error` wanted: the fraction of the stored energy that membrane forces and moments are "
           "off by, the same in every cell. Smaller is finer: 0.02 draft, 0.005 fine; `angle` holds besides. 0: any.",
       .range = not_negative},
      {.name = "smallest",
       .slot = &s.smallest,
       .meaning = "Smallest edge that curvature and `error` can ask for. 0: a two-hundredth of the extent of the mesh, "
                  "or four times "
                  "the `thickness` of contact if that is more.",
       .unit = "m",
       .range = not_negative},
      {.name = "largest",
       .slot = &s.largest,
       .meaning = "Largest edge. 0: a twelfth of the extent of the mesh.",
       .unit = "m",
       .range = not_negative},
      {.name = "growth", .slot = &s.growth, .meaning = "Largest change of the size over distance.", .range = positive},
      {.name = "near_contact",
       .slot = &s.near_contact,
       .meaning =
           "Also ask for edges that keep the flat triangles within a quarter of the activation distance from the "
           "bent sheet, where something is in contact."},
      {.name = "near_obstacles",
       .slot = &s.near_obstacles,
       .meaning =
           "Also ask for edges that are short enough to go round spheres, capsules and convex edges of meshes that "
           "the sheet comes near, before it bends."},
      {.name = "velocity",
       .slot = &s.velocity,
       .meaning = "Largest difference of velocity between the ends of an edge. 0: any.",
       .unit = "m/s",
       .range = not_negative},
      {.name = "size",
       .slot = &s.size,
       .meaning = "Expression of x, y and z at the start: an upper bound of the edge length there [m], e.g. "
                  "`0.01 + 0.1*x`.",
       .absent = "none"},
      {.name = "background",
       .slot = &s.background,
       .meaning =
           "Field of Gmsh (`.pos`, one view of numbers): an upper bound of the edge length by place at the start. "
           "Places and lengths are those of the mesh file, whose `scale`, `translate`, `rotate` and `up_axis` "
           "hold for it too.",
       .absent = "none"}};
}

/// Where and when it is changed, and what a change may do.
std::vector<Key> course_keys(RemeshSection& s) {
  return {
      {.name = "frozen",
       .slot = Words{&s.frozen, {}},
       .meaning = "Physical surfaces that are left as they are.",
       .absent = "none"},
      {.name = "every",
       .slot = &s.every,
       .meaning = "Accepted steps between two remeshing checks. 0: 5 in `dynamic`, 1 along a path; `drape` checks when "
                  "it has come to rest.",
       .range = {0}},
      {.name = "relaxation_steps",
       .slot = &s.relaxation_steps,
       .meaning =
           "Steps of damped relaxation after a remeshing, which take the noise out of the membrane. Under load control "
           "without contact only where Newton's method does not find the equilibrium of the new mesh at once.",
       .range = {0, 10}},
      {.name = "velocity_change",
       .slot = &s.velocity_change,
       .meaning =
           "Largest fraction by which a remeshing of a motion may change velocities so that stored and kinetic energy "
           "together stay what they were. 0: what the mesh changes is lost or gained.",
       .range = {0, 0.5}},
      {.name = "energy_change",
       .slot = &s.energy_change,
       .meaning =
           "A remeshing that changes stored and kinetic energy by more than this fraction, after relaxation and change "
           "of velocities, is refused; outside `dynamic` only one that increases it.",
       .range = positive},
      {.name = "max_vertices",
       .slot = &s.max_vertices,
       .meaning = "Sizes are made larger by one factor where more vertices than this would be needed. 0: no bound.",
       .range = {0}}};
}

}  // namespace

std::vector<Key> keys_of(RemeshSection& s) {
  return joined(size_keys(s), course_keys(s));
}

}  // namespace voile::input
