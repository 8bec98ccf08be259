// Keys of contact, obstacles and rules.
#include "keys_common.hpp"

namespace voile::input {

std::vector<Key> keys_of(ContactSection& s) {
  contact::ContactOptions& o = s.input.options;
  return {
      {.name = "distance",
       .slot = &o.distance,
       .meaning = "Activation distance: the gap below which surfaces repel each other.",
       .unit = "m",
       .range = positive},
      {.name = "stiffness",
       .slot = &o.stiffness,
       .meaning = "Of the barrier: the pressure at half the distance is 1.2 times this on planes, about twice that on "
                  "meshes; it grows without bound as the gap closes.",
       .unit = "Pa",
       .range = positive},
      {.name = "thickness",
       .slot = &s.input.thickness,
       .meaning = "Of the sheet: mid-surfaces of its layers stay further apart than this.",
       .unit = "m",
       .range = not_negative},
      {.name = "self", .slot = &s.input.self, .meaning = "Whether the sheet, all pieces of it, touches itself."},
      {.name = "friction",
       .slot = &s.input.friction,
       .meaning = "Coefficient of friction of the sheet against itself.",
       .range = not_negative},
      {.name = "slip_speed",
       .slot = &o.slip_speed,
       .meaning = "Below this speed friction falls smoothly to zero, so that what sticks creeps slower than this.",
       .unit = "m/s",
       .range = positive},
      {.name = "slip_distance",
       .slot = &o.slip_distance,
       .meaning = "The same for a slip within one load step of `static`, or from the end of the fall of `drape`. 0: a "
                  "thousandth of "
                  "a cell.",
       .unit = "m",
       .range = not_negative},
      {.name = "settle_time",
       .slot = &o.settle_time,
       .meaning = "In `dynamic`, a start nearer than `distance` is let out to it within this time. 0: the barrier acts "
                  "in full at once, and throws the sheet away.",
       .unit = "s",
       .range = not_negative},
      {.name = "check",
       .slot = &s.check,
       .meaning = "Count intersecting triangles after every step with exact predicates, independently of the solver."},
      {.name = "untangle",
       .slot = &s.untangle,
       .meaning =
           "Repair shallow intersections of the start, and gaps below `distance`: vertices move, by at most five "
           "cells, until nothing intersects. Not with `--restart`."}};
}

namespace {

/// Beyond this nothing is left of a motion [s].
constexpr double longest_smoothing = 10.0;

const std::vector<std::string> of_mesh{"mesh"};

/// Which obstacle, and those from files.
std::vector<Key> mesh_keys(ObstacleSection& s) {
  return {
      {.name = "name", .slot = &s.shape.name, .meaning = "Unique; for rules and messages.", .required = true},
      {.name = "type",
       .slot = choice(s.type, {{"mesh", ObstacleSection::Type::mesh},
                               {"plane", ObstacleSection::Type::plane},
                               {"sphere", ObstacleSection::Type::sphere},
                               {"capsule", ObstacleSection::Type::capsule},
                               {"cylinder", ObstacleSection::Type::cylinder}}),
       .meaning = "`mesh`: triangles of a file, both sides of which are solid. `plane`: a half-space. `capsule`: all "
                  "points within `radius` of the line from `point` to `end`. `cylinder`: with flat ends at `point` and "
                  "`end`, as triangles.",
       .required = true},
      {.name = "file",
       .slot = &s.file,
       .meaning = "Triangles: OBJ, STL, PLY, OFF or `.msh`, relative to the folder of the case file.",
       .types = of_mesh,
       .required = true},
      {.name = "scale",
       .slot = &s.scale,
       .meaning = "Coordinates in files are multiplied by this to become metres.",
       .range = positive,
       .types = of_mesh},
      {.name = "landmarks",
       .slot = &s.landmarks,
       .meaning = "Named points, for the places of pieces: lines `NAME,X,Y,Z`, in the coordinates of `file`, as `voile "
                  "manikin` writes them. More by `[[landmark]]`.",
       .types = of_mesh,
       .absent = "none"},
      {.name = "frames",
       .slot = &s.frames,
       .meaning =
           "Positions of the vertices in time, for `dynamic`, linear between key frames: PC2, MDD, or OBJ files as "
           "`walk_%04d.obj`. They are scaled and put in place as the mesh is.",
       .types = of_mesh,
       .absent = "none"},
      {.name = "frames_per_second",
       .slot = &s.frames_per_second,
       .meaning = "Of `frames` that do not have it themselves (PC2, OBJ).",
       .unit = "1/s",
       .range = positive,
       .types = of_mesh},
      {.name = "frames_start",
       .slot = &s.frames_start,
       .meaning = "Time of the first key frame, whatever the file states. Before it the body is held in the first "
                  "frame, after the last one in the last; below 0 the run begins within the frames.",
       .unit = "s",
       .types = of_mesh},
      {.name = "frames_loop",
       .slot = &s.frames_loop,
       .meaning = "Whether the frames repeat: where the last one is the first again, at once, else the body goes from "
                  "the last to the first within one more frame.",
       .types = of_mesh},
      {.name = "frames_smoothing",
       .slot = &s.frames_smoothing,
       .meaning = "The body is at the mean of where frames have it during this time before each instant, so that its "
                  "velocity does not jump from frame to frame and what shakes is smoothed; it follows half of this "
                  "time later. 0: linear between frames.",
       .unit = "s",
       .range = {0.0, longest_smoothing},
       .types = of_mesh}};
}

/// Those given by figures, and what all have.
std::vector<Key> shape_keys(ObstacleSection& s) {
  const std::vector<std::string> plane{"plane"}, axis{"capsule", "cylinder"};
  contact::Obstacle& o = s.shape;
  return {
      {.name = "point",
       .slot = &s.point,
       .meaning = "A point of the plane, the centre of the sphere, one end of the axis of capsule or cylinder.",
       .unit = "m",
       .types = {"plane", "sphere", "capsule", "cylinder"},
       .required = true},
      {.name = "normal", .slot = &o.normal, .meaning = "Points to the free side.", .types = plane, .required = true},
      {.name = "end",
       .slot = &s.end,
       .meaning = "The other end of the axis.",
       .unit = "m",
       .types = axis,
       .required = true},
      {.name = "radius",
       .slot = &o.radius,
       .meaning = "Of sphere, capsule and cylinder.",
       .unit = "m",
       .range = positive,
       .types = {"sphere", "capsule", "cylinder"},
       .required = true},
      {.name = "thickness",
       .slot = &o.thickness,
       .meaning = "The surface lies half of this further out.",
       .unit = "m",
       .range = not_negative},
      {.name = "friction",
       .slot = &o.friction,
       .meaning = "Coefficient of friction against the sheet.",
       .range = not_negative},
      {.name = "on_pinch",
       .slot = choice(s.on_pinch, {{"stop", ObstacleSection::OnPinch::stop}, {"pass", ObstacleSection::OnPinch::pass}}),
       .meaning = "When it closes on the sheet and leaves no room: `stop` ends the run, `pass` makes the "
                  "pinched vertices ignore it until they are free again (`dynamic` only)."}};
}

}  // namespace

std::vector<Key> keys_of(ObstacleSection& s) {
  const std::vector<Key> files = with_keys_after("scale", mesh_keys(s), placement_keys(s.placement, of_mesh));
  return joined(joined(files, shape_keys(s)), motion_keys(s.motion, {}));
}

std::vector<Key> keys_of(system::Attachment& s) {
  return {{.name = "groups",
           .slot = Words{&s.groups, {}},
           .meaning = "Physical points, curves or surfaces whose vertices are held.",
           .required = true},
          {.name = "obstacle",
           .slot = &s.obstacle,
           .meaning = "Name of the obstacle that holds them, of type `mesh` or `cylinder`.",
           .required = true},
          {.name = "stiffness",
           .slot = &s.stiffness,
           .meaning = "Force per displacement: of each vertex of points, per rest length of curves, per rest area of "
                      "surfaces, so that it does not depend on the mesh.",
           .unit = "points N/m, curves N/m^2, surfaces N/m^3",
           .range = positive,
           .absent = "1e4 in SI units"},
          {.name = "hard",
           .slot = &s.hard,
           .meaning = "Whether they are exactly where the surface takes them, instead of springs: `stiffness` means "
                      "nothing then. "
                      "What presses them into something else ends the run."},
          {.name = "gap",
           .slot = &s.gap,
           .meaning = "Distance from the surface at which springs hold them, along its normal. Less than the contact "
                      "distance presses them onto it.",
           .unit = "m",
           .range = not_negative,
           .absent = "where they are to the surface as it takes hold"},
          {.name = "release",
           .slot = &s.release,
           .meaning = "Time at which it releases, in `dynamic`.",
           .unit = "s",
           .range = not_negative,
           .absent = "never"}};
}

std::vector<Key> keys_of(LandmarkSection& s) {
  return {{.name = "obstacle", .slot = &s.obstacle, .meaning = "Whose point it is.", .required = true},
          {.name = "name", .slot = &s.name, .meaning = "Of the point; unique for the obstacle.", .required = true},
          {.name = "point", .slot = &s.point, .meaning = "Where it is in the scene.", .unit = "m", .absent = "-"},
          {.name = "near",
           .slot = &s.near,
           .meaning = "It is the vertex of the obstacle's mesh that is nearest to this point of the scene.",
           .unit = "m",
           .absent = "-"},
          {.name = "vertices",
           .slot = &s.vertices,
           .meaning = "It is the mean of these vertices of the obstacle's mesh, counted from 1 in the order of its "
                      "file, where the body is at the start. Two on either side of a limb give a point within it.",
           .range = {1.0},
           .absent = "-"}};
}

std::vector<Key> keys_of(RuleSection& s) {
  return {{.name = "first",
           .slot = &s.first,
           .meaning = "An obstacle, a physical surface, or a physical curve: its vertices with all edges and triangles "
                      "that touch them.",
           .required = true},
          {.name = "second", .slot = &s.second, .meaning = "Another, or the same.", .required = true},
          {.name = "friction",
           .slot = &s.friction,
           .meaning = "Coefficient of friction between the two.",
           .range = not_negative,
           .absent = "as for other pairs"},
          {.name = "ignore", .slot = &s.ignore, .meaning = "The two do not see each other."}};
}

}  // namespace voile::input
