#include "voile/app/case_keys.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace voile::app {

namespace {

const Range positive{0.0, std::numeric_limits<double>::infinity(), true};
const Range not_negative{0.0};

/// Binds an enumeration whose enumerators are in the order of `names`.
template <class Enum>
Choice choice(Enum& value, std::vector<std::string> names) {
  return {std::move(names), [&value] { return static_cast<int>(value); },
          [&value](int i) { value = static_cast<Enum>(i); }};
}

/// Binds a string that may only take one of `names`.
Choice word(std::string& value, std::vector<std::string> names) {
  return {names,
          [&value, names] { return static_cast<int>(std::find(names.begin(), names.end(), value) - names.begin()); },
          [&value, names](int i) { value = names[static_cast<std::size_t>(i)]; }};
}

bool contains(const std::vector<std::string>& list, const std::string& item) {
  return std::find(list.begin(), list.end(), item) != list.end();
}

}  // namespace

std::string Range::text() const {
  std::string lower =
      low > -std::numeric_limits<double>::infinity() ? fmt::format("{} {}", low_open ? ">" : ">=", low) : "";
  std::string upper = high < std::numeric_limits<double>::infinity() ? fmt::format("<= {}", high) : "";
  return lower + (lower.empty() || upper.empty() ? "" : " and ") + upper;
}

bool applies(const Key& key, const std::string& type) {
  return key.types.empty() || contains(key.types, type);
}

bool is_required(const Key& key, const std::string& type) {
  return applies(key, type) && (key.required || contains(key.required_types, type));
}

std::vector<Key> top_keys(Case& c) {
  return {{.name = "title", .slot = &c.title, .meaning = "Free text, shown at the start of a run."},
          {.name = "analysis",
           .slot = word(c.analysis, {"static", "linear", "modal", "buckling", "dynamic", "drape"}),
           .meaning = "`static`: the load path of `steps`. `linear`: one solution for small deflections at "
                      "`final_load_factor`. `modal`: natural vibrations. `buckling`: critical loads; both about the "
                      "state that `eigen` names. `dynamic`: motion in time. `drape`: a stable equilibrium at load "
                      "factor 1 from any start."}};
}

namespace {

/// Keys that put the points of a file in place; `types`: of the section that has files.
std::vector<Key> placement_keys(io::Placement& p, const std::vector<std::string>& types) {
  return {
      {.name = "up_axis",
       .slot = choice(p.up_axis, {"y", "z"}),
       .meaning = "Axis that points up in files. From `y` it is turned to z: (x, y, z) becomes (x, -z, y).",
       .types = types},
      {.name = "rotate",
       .slot = &p.rotate,
       .meaning = "Then files are turned about the axes x, y and z of the scene, in this order, through its origin.",
       .unit = "degree",
       .types = types},
      {.name = "translate",
       .slot = &p.translate,
       .meaning = "Then they are moved by this. Everything else in the case (points, directions, loads, motions) "
                  "refers to the scene.",
       .unit = "m",
       .types = types}};
}

std::vector<Key> joined(std::vector<Key> first, const std::vector<Key>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

/// `first` with `second` after the key `name`.
std::vector<Key> with_keys_after(const std::string& name, std::vector<Key> first, const std::vector<Key>& second) {
  const auto at = std::find_if(first.begin(), first.end(), [&](const Key& k) { return k.name == name; });
  first.insert(at + 1, second.begin(), second.end());
  return first;
}

}  // namespace

std::vector<Key> keys_of(MeshSection& s) {
  io::MeshOptions& o = s.options;
  std::vector<Key> keys{
      {.name = "file",
       .slot = &s.file,
       .meaning =
           "Gmsh mesh (`.msh`) or geometry (`.geo`), or a mesh as `.obj`, `.inp` (Abaqus), `.vtk` (legacy), `.stl`, "
           "`.ply` or `.off` (see [meshes.md](meshes.md)), relative to the folder of the case file.",
       .required = true},
      {.name = "scale",
       .slot = &o.scale,
       .meaning = "The file's coordinates are multiplied by this to become metres.",
       .range = positive},
      {.name = "size",
       .slot = &o.size,
       .meaning = "Target edge length everywhere, for a `.geo`, in its own unit of length. 0: as the `.geo` says.",
       .unit = "file unit",
       .range = not_negative},
      {.name = "algorithm",
       .slot = &o.algorithm,
       .meaning = "Gmsh's number of the 2-D meshing algorithm, for a `.geo` (5 Delaunay, 6 Frontal-Delaunay, ...). "
                  "0: as the `.geo` says.",
       .range = {0, 9}},
      {.name = "merge",
       .slot = &o.merge,
       .meaning =
           "Whether vertices on the boundary that lie at the same place become one. Without it they are a slit, as "
           "they are in a mesh that was exported part by part."},
      {.name = "merge_tolerance",
       .slot = &o.merge_tolerance,
       .meaning =
           "How close such vertices lie, after `scale`. 0: a millionth of the mesh's extent, but at most a tenth of "
           "its shortest edge.",
       .unit = "m",
       .range = not_negative},
      {.name = "parameters",
       .slot = &o.parameters,
       .meaning = "Numbers that a `.geo` declares with `DefineConstant` (or `DefineNumber`), by name of the variable.",
       .absent = "as the `.geo` says"}};
  return with_keys_after("scale", std::move(keys), placement_keys(o.placement, {}));
}

std::vector<Key> keys_of(energy::ElementOptions& s) {
  return {{.name = "bending",
           .slot = choice(s.bending, {"edge_slope", "six_node"}),
           .meaning = "Curvature of a triangle: from one normal slope per edge, or from the quadratic through the "
                      "triangle and its three neighbours (accurate on regular meshes only)."},
          {.name = "membrane",
           .slot = choice(s.membrane, {"cst", "six_node", "six_node_three_point"}),
           .meaning = "Membrane strain: constant-strain triangle, mid-side strains of the six-node patch averaged, or "
                      "the energies of the three mid-side strains averaged."},
          {.name = "cst_share",
           .slot = &s.cst_share,
           .meaning = "Share of constant-strain energy in `six_node`. Without it free edges can crumple; much of it "
                      "makes the element stiff in folding.",
           .range = {0, 1}},
          {.name = "max_patch_condition",
           .slot = &s.max_patch_condition,
           .meaning = "A patch quadratic with a larger condition number is replaced by a fit over more neighbours.",
           .range = {1, std::numeric_limits<double>::infinity(), true}},
          {.name = "crease_angle",
           .slot = Degrees{&s.crease_angle},
           .meaning = "Dihedral angle at rest above which an edge is a crease that membrane strains are not averaged "
                      "across.",
           .unit = "degree",
           .range = {0, 180}}};
}

std::vector<Key> keys_of(MaterialInput& s) {
  const std::vector<std::string> iso{"isotropic"}, matrices{"matrices"}, laminate{"laminate"}, fabric{"fabric"},
      ortho{"orthotropic", "laminate"}, plates{"isotropic", "orthotropic"},
      solids{"isotropic", "orthotropic", "laminate"};
  return {
      {.name = "type",
       .slot = choice(s.type, {"isotropic", "orthotropic", "matrices", "laminate", "fabric"}),
       .meaning = "How the stiffness is given. `laminate`: from plies of one orthotropic material. `fabric`: from a "
                  "file of measured figures.",
       .required = true},
      {.name = "groups",
       .slot = Words{&s.groups, {}},
       .meaning = "Physical surfaces made of this material.",
       .absent = "every triangle that no other material covers"},
      {"young", &s.young, "Young's modulus.", "Pa", positive, iso, true},
      {.name = "poisson",
       .slot = &s.poisson,
       .meaning = "Poisson's ratio.",
       .range = {-1, 0.5, true},
       .types = iso,
       .required = true},
      {"young_1", &s.young_1, "Young's modulus along the material direction.", "Pa", positive, ortho, true},
      {"young_2", &s.young_2, "Young's modulus across it, in the surface.", "Pa", positive, ortho, true},
      {.name = "poisson_12",
       .slot = &s.poisson_12,
       .meaning = "Contraction across the material direction per unit of stretch along it.",
       .types = ortho,
       .required = true},
      {"shear_12", &s.shear_12, "Shear modulus in the surface.", "Pa", positive, ortho, true},
      {"thickness", &s.thickness, "Thickness of the shell.", "m", positive, plates, true},
      {.name = "angles",
       .slot = &s.angles,
       .meaning = "Directions of the plies' fibres against material axis 1, one per ply, along the normal of the "
                  "triangles from the lowest. The stack must be free of coupling between stretching and bending, as "
                  "symmetric stacks are.",
       .unit = "degree",
       .types = laminate,
       .required = true},
      {.name = "ply_thicknesses",
       .slot = &s.ply_thicknesses,
       .meaning = "Thickness of each ply, in the order of `angles`, or one for all.",
       .unit = "m",
       .range = positive,
       .types = laminate,
       .required = true},
      {"density", &s.density, "Mass per volume; used by gravity and vibration.", "kg/m^3", not_negative, solids},
      {.name = "membrane",
       .slot = &s.membrane,
       .meaning = "Membrane stiffness A as three rows, order 11, 22, 12 with engineering shear: N = A E.",
       .unit = "N/m",
       .types = matrices,
       .required = true},
      {.name = "bending",
       .slot = &s.bending,
       .meaning = "Bending stiffness D as three rows, M = D (k11, k22, 2 k12).",
       .unit = "N m",
       .types = matrices,
       .required = true},
      {.name = "areal_density",
       .slot = &s.areal_density,
       .meaning = "Mass per area; used by gravity and vibration.",
       .unit = "kg/m^2",
       .range = not_negative,
       .types = matrices},
      {.name = "fabric",
       .slot = &s.fabric,
       .meaning = "Fabric file (see [fabrics.md](fabrics.md)), relative to the folder of the case file.",
       .types = fabric,
       .required = true},
      {.name = "warp_angle",
       .slot = Degrees{&s.warp_angle},
       .meaning = "Angle from `direction` to the warp, positive about the normal of the triangles.",
       .unit = "degree",
       .types = fabric},
      {.name = "direction",
       .slot = &s.direction,
       .meaning =
           "Direction of material axis 1 in space, projected into each triangle; the warp of a `fabric` lies at "
           "`warp_angle` to it. Triangles that are normal to it continue it from their neighbours; another direction "
           "for some `groups` is another `[[material]]`. Either this or `texture_direction` is needed, by `matrices` "
           "unless both are those of an isotropic material.",
       .types = {"orthotropic", "laminate", "matrices", "fabric"},
       .absent = "none"},
      {.name = "texture_direction",
       .slot = &s.texture_direction,
       .meaning =
           "Direction of material axis 1 in the texture coordinates (u, v) of an OBJ mesh, e.g. `[0, 1]`: the grain "
           "line of the flat piece that a part of a garment is cut from.",
       .types = {"orthotropic", "laminate", "matrices", "fabric"},
       .absent = "none"},
      {.name = "bending_damping",
       .slot = &s.bending_damping,
       .meaning = "Damping in proportion to the bending stiffness of this material, in `dynamic`, besides that of "
                  "`[damping]`. A `fabric` has its own if the key is missing, see [fabrics.md](fabrics.md).",
       .unit = "s",
       .range = not_negative},
      {.name = "membrane_damping",
       .slot = &s.membrane_damping,
       .meaning = "Relaxation time of the membrane of this material (Kelvin-Voigt), likewise besides `[damping]`.",
       .unit = "s",
       .range = not_negative}};
}

namespace {

/// Keys of a rigid motion; `types`: of the section that can move.
std::vector<Key> motion_keys(MotionInput& m, const std::vector<std::string>& types) {
  return {
      {.name = "motion",
       .slot = &m.translation,
       .meaning =
           "Displacement as three expressions of the time t, e.g. `[\"0.1*sin(2*pi*t)\", \"0\", \"table(t, 0, 0, 1, "
           "0.05)\"]`; `table` interpolates between pairs of time and value. Needs `analysis = \"dynamic\"`; supports "
           "move in `static` with `control = \"load\"` too, where t is the load factor.",
       .unit = "m",
       .types = types,
       .absent = "none"},
      {.name = "rotation_axis",
       .slot = &m.axis,
       .meaning =
           "Axis of a rotation of the whole group; goes with `rotation_angle`. The slope that a `clamped` support "
           "holds turns with it.",
       .types = types,
       .absent = "none"},
      {.name = "rotation_centre", .slot = &m.centre, .meaning = "A point on the axis.", .unit = "m", .types = types},
      {.name = "rotation_angle",
       .slot = &m.angle,
       .meaning = "Angle as an expression of the time t.",
       .unit = "degree",
       .types = types,
       .absent = "none"}};
}

}  // namespace

std::vector<Key> keys_of(system::Support& s, MotionInput& m) {
  std::vector<Key> keys{
      {.name = "type",
       .slot = choice(s.kind, {"displacement", "hinged", "clamped", "symmetry"}),
       .meaning = "`displacement`: the named components are prescribed. `hinged`: all three are, the edge may turn. "
                  "`clamped`: as hinged, and the slope across the edge is held. `symmetry`: mirror plane.",
       .required = true},
      {.name = "group",
       .slot = &s.group,
       .meaning = "Physical point, curve or surface; a curve for `symmetry`, a curve or surface for `clamped`.",
       .required = true},
      {.name = "components",
       .slot = &s.components,
       .meaning = "Which of `\"x\"`, `\"y\"`, `\"z\"` are prescribed.",
       .types = {"displacement"},
       .required = true},
      {.name = "value",
       .slot = &s.value,
       .meaning = "Displacement at load factor 1, in proportion to the load factor.",
       .unit = "m",
       .types = {"displacement", "hinged", "clamped"}},
      {.name = "x_axis",
       .slot = &s.x_axis,
       .meaning = "Direction that `\"x\"` means in `components` and `value`; `y_axis` and the normal of both follow.",
       .types = {"displacement"},
       .absent = "the global axes"},
      {.name = "y_axis",
       .slot = &s.y_axis,
       .meaning = "Direction that `\"y\"` means, made square to `x_axis`.",
       .types = {"displacement"},
       .absent = "any direction square to `x_axis`"},
      {.name = "cylinder_axis",
       .slot = &s.cylinder_axis,
       .meaning = "`\"x\"`, `\"y\"`, `\"z\"` mean radial, circumferential and axial about this axis, at each vertex's "
                  "place at rest.",
       .types = {"displacement"},
       .absent = "none"},
      {.name = "cylinder_centre",
       .slot = &s.cylinder_centre,
       .meaning = "A point on `cylinder_axis`.",
       .unit = "m",
       .types = {"displacement"}},
      {.name = "normal",
       .slot = &s.normal,
       .meaning = "Normal of the mirror plane.",
       .types = {"symmetry"},
       .absent = "found from the mesh"},
      {.name = "release",
       .slot = &s.release,
       .meaning = "Time at which the support lets go.",
       .unit = "s",
       .range = not_negative,
       .absent = "never"}};
  return joined(std::move(keys), motion_keys(m, {"displacement", "hinged", "clamped"}));
}

std::vector<Key> keys_of(ContactSection& s) {
  contact::ContactOptions& o = s.input.options;
  return {
      {.name = "distance",
       .slot = &o.distance,
       .meaning =
           "Gap below which surfaces push each other away. This and the other defaults of contact are in SI units: "
           "give them all in another set.",
       .unit = "m",
       .range = positive},
      {.name = "stiffness",
       .slot = &o.stiffness,
       .meaning = "Of the barrier: the pressure at half the distance is 1.2 times this, and grows without bound as the "
                  "gap closes.",
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

std::vector<Key> keys_of(ObstacleSection& s) {
  const std::vector<std::string> mesh{"mesh"}, plane{"plane"}, sphere{"sphere"}, axis{"capsule", "cylinder"};
  system::Obstacle& o = s.shape;
  std::vector<Key> keys{
      {.name = "name", .slot = &o.name, .meaning = "Unique; for rules and messages.", .required = true},
      {.name = "type",
       .slot = choice(s.type, {"mesh", "plane", "sphere", "capsule", "cylinder"}),
       .meaning = "`mesh`: triangles of a file, both sides of which are solid. `plane`: a half-space. `capsule`: all "
                  "points within `radius` of the line from `point` to `end`. `cylinder`: with flat ends at `point` and "
                  "`end`, as triangles.",
       .required = true},
      {.name = "file",
       .slot = &s.file,
       .meaning = "Triangles: OBJ, STL, PLY, OFF or `.msh`, relative to the folder of the case file.",
       .types = mesh,
       .required = true},
      {.name = "scale",
       .slot = &s.scale,
       .meaning = "Coordinates in files are multiplied by this to become metres.",
       .range = positive,
       .types = mesh},
      {.name = "frames",
       .slot = &s.frames,
       .meaning = "Positions of the vertices in time, linear between key frames: PC2, MDD, or OBJ files as "
                  "`walk_%04d.obj`. They are scaled and put in place as the mesh is.",
       .types = mesh,
       .absent = "none"},
      {.name = "frames_per_second",
       .slot = &s.frames_per_second,
       .meaning = "Of `frames` that do not say it themselves (PC2, OBJ).",
       .unit = "1/s",
       .range = positive,
       .types = mesh},
      {.name = "frames_start",
       .slot = &s.frames_start,
       .meaning = "Time of the first key frame, whatever the file says of it. Before it the body is held in the first "
                  "frame, after the last one in the last; below 0 the run begins within the frames.",
       .unit = "s",
       .types = mesh},
      {.name = "frames_loop",
       .slot = &s.frames_loop,
       .meaning = "Whether the frames repeat: where the last one is the first again, at once, else the body goes from "
                  "the last to the first within one more frame.",
       .types = mesh},
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
       .slot = choice(s.on_pinch, {"stop", "yield"}),
       .meaning =
           "When it closes on the sheet and leaves no room: `stop` ends the run, `yield` lets its surface give way "
           "to the vertices that are pinched until they are free again (`dynamic` only)."}};
  return joined(with_keys_after("scale", std::move(keys), placement_keys(s.placement, mesh)),
                motion_keys(s.motion, {}));
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

std::vector<Key> keys_of(system::Load& s) {
  const std::vector<std::string> vectors{"point", "line", "area", "gravity"},
      magnitudes{"pressure", "follower_pressure", "follower_moment"};
  return {
      {.name = "type",
       .slot = choice(s.kind, {"point", "line", "pressure", "follower_pressure", "area", "gravity", "follower_moment"}),
       .meaning = "`point`: force on every vertex of a group. `line`: force per rest length of a curve. `area`: force "
                  "per rest area. `gravity`: acceleration. `pressure`: along the rest normal. `follower_pressure`: "
                  "along the current normal. `follower_moment`: moment per rest length about a boundary edge.",
       .required = true},
      {.name = "group",
       .slot = &s.group,
       .meaning = "Where it acts: any group for `point`, a curve for `line` and `follower_moment`, else a surface.",
       .required_types = {"point", "line", "follower_moment"},
       .absent = "the whole surface"},
      {.name = "vector",
       .slot = &s.vector,
       .meaning = "Size and direction at load factor 1.",
       .unit = "point N, line N/m, area N/m^2, gravity m/s^2",
       .types = vectors,
       .required = true},
      {.name = "magnitude",
       .slot = &s.magnitude,
       .meaning = "Size at load factor 1; a pressure is positive along the normal of the triangles.",
       .unit = "pressures Pa, moment N",
       .types = magnitudes,
       .required = true},
      {.name = "constant", .slot = &s.constant, .meaning = "Acts in full at every load factor, as a dead weight does."},
      {.name = "history",
       .slot = &s.history_text,
       .meaning = "Factor as an expression of the time t, in place of the load factor. Needs `analysis = \"dynamic\"`.",
       .absent = "none"}};
}

std::vector<Key> keys_of(system::PointMass& s) {
  return {
      {.name = "group", .slot = &s.group, .meaning = "Any group.", .required = true},
      {.name = "mass",
       .slot = &s.mass,
       .meaning = "Of each vertex of the group, besides the sheet's. `gravity` on the whole surface, or on the same "
                  "group, acts on it.",
       .unit = "kg",
       .range = positive,
       .required = true}};
}

std::vector<Key> keys_of(system::Spring& s) {
  return {{.name = "type",
           .slot = choice(s.kind, {"point", "line", "area", "pair"}),
           .meaning = "From the place at rest: `point` on every vertex of a group, `line` per rest length of a curve, "
                      "`area` per rest area, an elastic foundation. `pair`: between every vertex of a group and the "
                      "nearest one of `to` at rest.",
           .required = true},
          {.name = "group",
           .slot = &s.group,
           .meaning = "Any group for `point` and `pair`, a curve for `line`, a surface for `area`.",
           .required_types = {"point", "line", "pair"},
           .absent = "the whole surface"},
          {.name = "stiffness",
           .slot = &s.stiffness,
           .meaning = "Force per displacement from the place at rest; of each pair, force per change of length.",
           .unit = "point, pair N/m, line N/m^2, area N/m^3",
           .range = positive,
           .required = true},
          {.name = "direction",
           .slot = &s.direction,
           .meaning = "It acts along this direction only.",
           .types = {"point", "line", "area"},
           .absent = "it acts in all directions"},
          {.name = "to",
           .slot = &s.to,
           .meaning = "The group of the other ends.",
           .types = {"pair"},
           .required_types = {"pair"}},
          {.name = "length",
           .slot = &s.length,
           .meaning = "Length without force. 0 pulls the pair together from any distance.",
           .unit = "m",
           .range = not_negative,
           .types = {"pair"},
           .absent = "the distance at rest"}};
}

std::vector<Key> keys_of(solve::StaticOptions& s) {
  return {
      {.name = "control",
       .slot = choice(s.control, {"load", "displacement", "arc_length"}),
       .meaning = "What a step prescribes: `load` the load factor, `displacement` that of `control_probe`, "
                  "`arc_length` the distance between the states, which follows limit points and snap-back."},
      {.name = "final_load_factor",
       .slot = &s.final_load_factor,
       .meaning = "Load factor at the end of the run (with `final_displacement` that ends it instead).",
       .range = positive},
      {.name = "control_probe",
       .slot = &s.control_probe,
       .meaning = "Name of a displacement probe with one component. Needed for `displacement`; with `arc_length` it "
                  "belongs to `final_displacement`.",
       .absent = "none"},
      {.name = "final_displacement",
       .slot = &s.final_displacement,
       .meaning = "Displacement of `control_probe` at the end of the run, of either sign. 0: the run ends at "
                  "`final_load_factor`.",
       .unit = "m"},
      {.name = "initial_step",
       .slot = &s.initial_step,
       .meaning = "First increment of the load factor; a share of `final_displacement` under `displacement`; under "
                  "`arc_length` the length that this increment of the load factor has at the start. `min_step` and "
                  "`max_step` are in the same unit. `max_step` if that is smaller and this key is not given.",
       .range = positive},
      {.name = "max_steps",
       .slot = &s.max_steps,
       .meaning = "A path that has not ended after so many steps ends with exit code 3.",
       .range = {1}},
      {.name = "min_step",
       .slot = &s.min_step,
       .meaning = "A step that fails at this size ends the run with exit code 3.",
       .range = positive},
      {.name = "max_step",
       .slot = &s.max_step,
       .meaning = "Largest step. Under `arc_length` 1e9, in practice none, if this key is not given.",
       .range = positive},
      {.name = "stops",
       .slot = &s.stops,
       .meaning = "Load factors that a step ends on exactly, ascending; results are recorded there. `load` only.",
       .range = positive,
       .absent = "none"},
      {.name = "target_iterations",
       .slot = &s.target_iterations,
       .meaning = "A step that converges in fewer iterations lets the next one grow. Under `displacement` and "
                  "`arc_length`, 5 if this key is not given.",
       .range = {1}},
      {.name = "fallback",
       .slot = &s.fallback,
       .meaning = "Try pseudo-transient continuation before a step is made very small. `load` only."},
      {.name = "at_critical_point",
       .slot = choice(s.at_critical_point, {"pass", "stop", "switch_branch"}),
       .meaning =
           "At a limit or bifurcation point: only report it, end the run there, or (the first bifurcation, under "
           "`arc_length`) leave along the lowest mode. `displacement` and `arc_length` only."},
      {.name = "branch_step",
       .slot = &s.branch_step,
       .meaning = "First step along the mode, in units of the step in force; its sign picks the side."}};
}

std::vector<Key> keys_of(EigenSection& s) {
  return {
      {.name = "modes", .slot = &s.modes, .meaning = "How many modes, lowest first.", .range = {1}},
      {.name = "load_factor",
       .slot = &s.load_factor,
       .meaning = "Load factor of the equilibrium about which modes are found; the path of `steps` leads to it. 0: the "
                  "unloaded state (constant loads act).",
       .range = not_negative}};
}

std::vector<Key> keys_of(TimeSection& s, system::Mass& mass) {
  solve::TimeOptions& o = s.options;
  return {
      {.name = "method",
       .slot = choice(o.method, {"alpha", "central_difference"}),
       .meaning =
           "`alpha`: implicit generalised-alpha. `central_difference`: explicit, steps below the stability limit."},
      {.name = "end", .slot = &o.end_time, .meaning = "End of the run.", .unit = "s", .range = positive},
      {.name = "step", .slot = &o.step, .meaning = "Size of the first step.", .unit = "s", .range = positive},
      {.name = "min_step",
       .slot = &o.min_step,
       .meaning = "A step that fails at this size ends the run with exit code 3. 0: a thousandth of `step`.",
       .unit = "s",
       .range = not_negative},
      {.name = "max_step",
       .slot = &o.max_step,
       .meaning = "Largest step. 0: `step`.",
       .unit = "s",
       .range = not_negative},
      {.name = "step_error",
       .slot = &o.step_error,
       .meaning = "Largest local error of any displacement in a step, which then sets the step. 0: not controlled.",
       .unit = "m",
       .range = not_negative},
      {.name = "radius",
       .slot = &o.radius,
       .meaning =
           "Spectral radius at infinite frequency: 1 no numerical dissipation, 0 the most. With contact not more than "
           "0.5: impacts can feed energy into what is hardly damped.",
       .range = {0, 1}},
      {.name = "forces_at_end",
       .slot = &o.forces_at_end,
       .meaning = "Take forces at the end of the step (Wood-Bossak-Zienkiewicz) instead of within it (Chung-Hulbert)."},
      {.name = "target_iterations",
       .slot = &o.target_iterations,
       .meaning =
           "A step that needs more iterations makes the next one smaller. With contact 25 if this key is not given.",
       .range = {1}},
      {.name = "velocity_tolerance",
       .slot = &o.velocity_tolerance,
       .meaning =
           "An increment of the iteration below this, as root mean square over the mass and per step, ends the step. "
           "0: `-snes_rtol` and `-snes_stol` alone decide.",
       .unit = "m/s",
       .range = not_negative},
      {.name = "mass",
       .slot = choice(mass, {"consistent", "lumped"}),
       .meaning = "Mass matrix: consistent with linear displacements in the triangles, or lumped at the vertices."},
      {.name = "load_history",
       .slot = &s.load_history,
       .meaning = "Load factor as an expression of the time t.",
       .absent = "1 throughout"},
      {.name = "checkpoint_steps",
       .slot = &s.checkpoint_steps,
       .meaning = "Write `checkpoint.h5` every so many steps. 0: not by steps.",
       .range = not_negative},
      {.name = "checkpoint_minutes",
       .slot = &s.checkpoint_minutes,
       .meaning = "Write `checkpoint.h5` after so many minutes. 0: not by time.",
       .unit = "min",
       .range = not_negative}};
}

std::vector<Key> keys_of(InitialVelocity& s) {
  return {{.name = "group", .slot = &s.group, .meaning = "Any group.", .absent = "the whole surface"},
          {.name = "velocity", .slot = &s.velocity, .meaning = "Velocity of every vertex of the group.", .unit = "m/s"},
          {.name = "angular_velocity",
           .slot = &s.angular_velocity,
           .meaning = "Added turning: axis times speed, right-handed.",
           .unit = "rad/s"},
          {.name = "centre", .slot = &s.centre, .meaning = "A point on that axis.", .unit = "m"}};
}

std::vector<Key> damping_keys(system::DynamicsOptions& s) {
  return {{.name = "mass",
           .slot = &s.mass_damping,
           .meaning = "Damping in proportion to the mass, as by air at rest.",
           .unit = "1/s",
           .range = not_negative},
          {.name = "bending",
           .slot = &s.bending_damping,
           .meaning = "Damping in proportion to the constant bending stiffness.",
           .unit = "s",
           .range = not_negative},
          {.name = "membrane",
           .slot = &s.viscous_time,
           .meaning = "Relaxation time of the membrane (Kelvin-Voigt).",
           .unit = "s",
           .range = not_negative},
          {.name = "materials",
           .slot = &s.material_damping,
           .meaning = "Whether the materials' own damping (`bending_damping` and `membrane_damping` of `[[material]]`, "
                      "which a `fabric` always has) acts besides."}};
}

std::vector<Key> keys_of(energy::DragOptions& s) {
  return {{.name = "density", .slot = &s.air_density, .meaning = "Of the air.", .unit = "kg/m^3", .range = positive},
          {.name = "normal_drag",
           .slot = &s.normal,
           .meaning = "Drag coefficient of the air that moves across the surface; 0: none.",
           .range = not_negative},
          {.name = "tangential_drag",
           .slot = &s.tangential,
           .meaning = "Drag coefficient of the air that moves along the surface; 0: none.",
           .range = not_negative},
          {.name = "wind", .slot = &s.wind, .meaning = "Velocity of the air.", .unit = "m/s"}};
}

std::vector<Key> keys_of(solve::DrapeOptions& s) {
  return {{.name = "max_iterations",
           .slot = &s.max_iterations,
           .meaning = "Iterations of one search for an equilibrium, falls included.",
           .range = {1}},
          {.name = "max_escapes",
           .slot = &s.max_escapes,
           .meaning = "How often an unstable equilibrium is left along its lowest mode.",
           .range = not_negative},
          {.name = "push",
           .slot = &s.push,
           .meaning = "Largest displacement of such an escape, in edge lengths.",
           .range = positive},
          {.name = "fall",
           .slot = &s.fall,
           .meaning = "With contact: the sheet first falls, damped, until it nearly rests, then the search begins. "
                      "`false`: the search begins at once."}};
}

std::vector<Key> keys_of(Probe& s) {
  return {{.name = "name", .slot = &s.name, .meaning = "Column of `history.csv`; unique.", .required = true},
          {.name = "type",
           .slot = choice(s.kind, {"displacement", "reaction", "energy"}),
           .meaning = "`displacement`: mean over a group or of the vertex nearest to a point. `reaction`: total over a "
                      "group. `energy`: of the shell.",
           .unit = "m, N, J",
           .required = true},
          {.name = "group",
           .slot = &s.group,
           .meaning = "Physical group to observe; a displacement needs this or `point`.",
           .types = {"displacement", "reaction"},
           .required_types = {"reaction"},
           .absent = "none"},
          {.name = "point",
           .slot = &s.point,
           .meaning = "Rest position near the vertex to observe.",
           .unit = "m",
           .types = {"displacement"},
           .absent = "none"},
          {.name = "components",
           .slot = &s.components,
           .meaning = "Which of `\"x\"`, `\"y\"`, `\"z\"` to record.",
           .types = {"displacement", "reaction"},
           .absent = "all three"}};
}

std::vector<Key> keys_of(OutputSection& s) {
  return {
      {.name = "fields",
       .slot = Words{&s.fields,
                     {"displacement", "reaction", "velocity", "membrane_force", "bending_moment", "curvature",
                      "membrane_strain", "contact_force", "friction_force", "contact_pressure", "gives_way"}},
       .meaning =
           "Fields in `results.h5`, any of `displacement`, `velocity`, `reaction`, `membrane_force`, `bending_moment`, "
           "`curvature`, `membrane_strain`, `contact_force`, `friction_force`, `contact_pressure`, "
           "`gives_way` (1 where an obstacle does).",
       .absent = "all of them"},
      {.name = "stresses",
       .slot = choice(s.stresses, {"none", "surface", "plies"}),
       .meaning = "Stresses besides these fields: `surface`: 11, 22, 12 in material axes, principal and von Mises at "
                  "the top (where the normal points to) and the bottom; `plies`: also at both faces of every ply. For "
                  "`isotropic`, `orthotropic` and `laminate`."},
      {.name = "every",
       .slot = &s.every,
       .meaning = "Results every so many steps; stops and the last step always.",
       .range = {1}}};
}

std::vector<Key> petsc_keys(Case& c) {
  return {{.name = "options",
           .slot = &c.petsc_options,
           .meaning = "Options of PETSc as on its command line, e.g. `\"-snes_rtol 1e-10 -ksp_type cg\"`."}};
}

const std::vector<SectionInfo>& sections() {
  static const std::vector<SectionInfo> all{
      {"mesh", false, "The surface. Required."},
      {"element", false, "Operators of the shell element."},
      {"material", true, "Stiffness and mass of the shell. At least one."},
      {"support", true, "Prescribed displacements and slopes."},
      {"load", true, "Loads; each grows with the load factor unless it is `constant`."},
      {"mass", true, "Masses at vertices."},
      {"spring", true, "Linear springs to where vertices are at rest."},
      {"contact", false,
       "Contact without interpenetration, see [contact.md](contact.md). This section, or an obstacle, switches it on."},
      {"obstacle", true, "What the sheet can touch."},
      {"contact_rule", true, "What holds between two bodies instead of the general rules."},
      {"steps", false, "How the path of equilibria is followed from the unloaded state."},
      {"eigen", false, "Modes of vibration and buckling."},
      {"time", false, "Motion in time, `analysis = \"dynamic\"`."},
      {"initial_velocity", true,
       "How a motion starts, unless `--restart` goes on from another; where groups overlap the last one counts."},
      {"damping", false, "Damping of `dynamic`."},
      {"air", false, "Drag by air and wind in `dynamic`. Speed and normal are those of the start of each step."},
      {"drape", false, "The search of `analysis = \"drape\"`."},
      {"probe", true, "Numbers recorded in `history.csv` after every step."},
      {"output", false, "What is written to `results.h5` and `results.xdmf`."},
      {"petsc", false, "The solver library."}};
  return all;
}

}  // namespace voile::app
