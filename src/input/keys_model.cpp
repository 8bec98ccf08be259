// Keys of the sheet and what acts on it: mesh, element, supports, loads, masses, springs.
#include "keys_common.hpp"

namespace voile::input {

namespace {

/// The shapes at rest and at the start.
std::vector<Key> shape_keys(MeshSection& s) {
  formats::MeshOptions& o = s.options;
  return {
      {.name = "file",
       .slot = &s.file,
       .meaning = "Gmsh mesh (`.msh`) or geometry (`.geo`), or a mesh as `.obj`, `.inp` (Abaqus), `.bdf` (Nastran), "
                  "`.vtk` (legacy), "
                  "`.stl`, `.ply` or `.off` (see [meshes.md](meshes.md)), relative to the folder of the case file.",
       .absent = "required, unless there are [[panel]]"},
      {.name = "start",
       .slot = &s.start,
       .meaning =
           "A file with the same triangles in another place or shape, from which `static`, `drape` and `dynamic` "
           "begin; `file` (or what `rest` names) remains the shape without strain, and `file` where supports hold. "
           "`scale` and the placement below "
           "are for "
           "both.",
       .absent = "the shape of `file`"},
      {.name = "rest",
       .slot = choice(o.rest, {{"positions", formats::RestShape::positions}, {"texture", formats::RestShape::texture}}),
       .meaning = "What is without strain: `positions`: the shape of `file`. `texture`: the flat panels of its texture "
                  "coordinates, one per corner (OBJ), sewn where triangles have a common edge; the vertices of `file` "
                  "are then the "
                  "start, and where supports hold (see [meshes.md](meshes.md))."},
      {.name = "texture_unit",
       .slot = &o.texture_unit,
       .meaning = "Length that a texture coordinate of 1 is in the panels, for `rest = \"texture\"`.",
       .unit = "m",
       .range = positive}};
}

/// How a file is read.
std::vector<Key> reading_keys(formats::MeshOptions& o) {
  return {
      {.name = "scale",
       .slot = &o.scale,
       .meaning = "The file's coordinates are multiplied by this to become metres, or the case's unit of length.",
       .range = positive},
      {.name = "size",
       .slot = &o.size,
       .meaning = "Target edge length everywhere, for a `.geo`, in its own unit of length. 0: as in the `.geo`.",
       .unit = "file unit",
       .range = not_negative},
      {.name = "algorithm",
       .slot = &o.algorithm,
       .meaning = "Gmsh's number of the 2-D meshing algorithm, for a `.geo` (5 Delaunay, 6 Frontal-Delaunay, ...). "
                  "0: as in the `.geo`.",
       .range = {0, 9}},
      {.name = "merge",
       .slot = &o.merge,
       .meaning =
           "Whether parts are joined where they touch: vertices at one place become one if one is on a boundary, "
           "and triangles are divided where a part ends on them or, without contact of the sheet with itself, passes "
           "through them."},
      {.name = "merge_tolerance",
       .slot = &o.merge_tolerance,
       .meaning = "How close they lie, after `scale`. 0: a millionth of the mesh's extent, but at most a tenth of "
                  "its shortest edge.",
       .unit = "m",
       .range = not_negative},
      {.name = "parameters",
       .slot = &o.parameters,
       .meaning = "Numbers that a `.geo` declares with `DefineConstant` (or `DefineNumber`), by name of the variable.",
       .absent = "as in the `.geo`"}};
}

}  // namespace

std::vector<Key> keys_of(MeshSection& s) {
  return joined(shape_keys(s),
                with_keys_after("scale", reading_keys(s.options), placement_keys(s.options.placement, {})));
}

namespace {

/// A word stands for two operators.
Choice element_choice(energy::ElementOptions& s) {
  Choice c;
  for (const energy::ElementType& type : energy::element_types) c.names.emplace_back(type.name);
  c.get = [&s] { return energy::type_of(s); };
  c.set = [&s](int i) {
    s.bending = energy::element_types[i].bending;
    s.membrane = energy::element_types[i].membrane;
    s.cst_fraction = energy::element_types[i].cst_fraction;
  };
  return c;
}

}  // namespace

std::vector<Key> keys_of(energy::ElementOptions& s) {
  return {
      {.name = "type",
       .slot = element_choice(s),
       .meaning = "The element. `corrected`: bending from one normal slope per edge, a constant matrix, and by angles "
                  "beside folds at rest and small notches; membrane from "
                  "the mid-side strains of the six-node patch, less the spurious strain of straight chords where the "
                  "surface bends. `angles`: the same, with bending from the angles at edges on every triangle, for "
                  "folds at rest and long uneven cells; up to 1.5 times the time. `six_node`: without the correction "
                  "of chords, the default of version 0.1. `sze_zhou_2016` and `zhou_sze_2012`: the published elements "
                  "for comparison, with the quadratic through a triangle and its three neighbours for bending "
                  "(accurate on regular meshes only), the second with constant membrane strain "
                  "(docs/howto/choose-an-element.md)."},
      {.name = "cst_fraction",
       .slot = &s.cst_fraction,
       .meaning = "Fraction of constant-strain energy in six-node membranes. Without it free edges can crumple; much "
                  "of it makes the element stiff in folding.",
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

std::vector<Key> motion_keys(MotionInput& m, const std::vector<std::string>& types) {
  return {
      {.name = "motion",
       .slot = &m.translation,
       .meaning =
           "Displacement along the global axes by three expressions of t, e.g. `[\"0.1*sin(2*pi*t)\", \"0\", "
           "\"table(t, 0, 0, 1, 0.05)\"]`; `table` interpolates between pairs of time and value. In `static` with "
           "`control = \"load\"` t is the load factor: of an obstacle in its first `static` stage, where none of its "
           "stages is `dynamic`. In `drape` obstacles stand still; for supports t is 1, or the run's.",
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

namespace {

/// The axes that `components` and `value` mean.
std::vector<Key> axes_keys(system::Support& s) {
  return {
      {.name = "x_axis",
       .slot = &s.x_axis,
       .meaning = "Direction that `\"x\"` means in `components` and `value`; `y_axis` and the normal of both follow.",
       .types = {"displacement", "sliding"},
       .absent = "the global axes"},
      {.name = "y_axis",
       .slot = &s.y_axis,
       .meaning = "Direction that `\"y\"` means, made square to `x_axis`.",
       .types = {"displacement", "sliding"},
       .absent = "any direction square to `x_axis`"},
      {.name = "cylinder_axis",
       .slot = &s.cylinder_axis,
       .meaning = "`\"x\"`, `\"y\"`, `\"z\"` mean radial, circumferential and axial about this axis, at each vertex's "
                  "place at the start.",
       .types = {"displacement"},
       .absent = "none"},
      {.name = "cylinder_centre",
       .slot = &s.cylinder_centre,
       .meaning = "A point on `cylinder_axis`.",
       .unit = "m",
       .types = {"displacement"}}};
}

}  // namespace

std::vector<Key> keys_of(system::Support& s, MotionInput& m) {
  std::vector<Key> keys{
      {.name = "type",
       .slot = choice(s.kind, {{"displacement", system::Support::Kind::displacement},
                               {"hinged", system::Support::Kind::hinged},
                               {"clamped", system::Support::Kind::clamped},
                               {"sliding", system::Support::Kind::sliding},
                               {"symmetry", system::Support::Kind::symmetry}}),
       .meaning = "`displacement`: the named components are prescribed. `hinged`: all three are, the edge may turn. "
                  "`clamped`: as hinged, and the slope across the edge, or round the surface, is held. `sliding`: that "
                  "slope alone, and the named components. `symmetry`: mirror plane.",
       .required = true},
      {.name = "group",
       .slot = GroupList{&s.group},
       .meaning =
           "Physical point, curve or surface; a curve for `symmetry` and `sliding`, a curve or surface for `clamped`.",
       .required = true},
      {.name = "components",
       .slot = &s.components,
       .meaning = "Which of `\"x\"`, `\"y\"`, `\"z\"` are prescribed.",
       .types = {"displacement", "sliding"},
       .required_types = {"displacement"},
       .absent = "none"},
      {.name = "value",
       .slot = &s.value,
       .meaning = "Displacement at load factor 1, in proportion to the load factor.",
       .unit = "m",
       .types = {"displacement", "hinged", "clamped", "sliding"}},
      {.name = "normal",
       .slot = &s.normal,
       .meaning = "Normal of the mirror plane.",
       .types = {"symmetry"},
       .absent = "found from the mesh"},
      {.name = "release",
       .slot = &s.release,
       .meaning = "Time at which the support releases.",
       .unit = "s",
       .range = not_negative,
       .absent = "never"}};
  return joined(with_keys_after("value", std::move(keys), axes_keys(s)),
                motion_keys(m, {"displacement", "hinged", "clamped"}));
}

std::vector<Key> keys_of(system::Load& s) {
  const std::vector<std::string> vectors{"point", "line", "area", "gravity"},
      magnitudes{"pressure", "follower_pressure", "follower_moment", "gas"}, gas{"gas"};
  return {
      {.name = "type",
       .slot = choice(s.kind, {{"point", system::Load::Kind::point},
                               {"line", system::Load::Kind::line},
                               {"pressure", system::Load::Kind::pressure},
                               {"follower_pressure", system::Load::Kind::follower_pressure},
                               {"area", system::Load::Kind::area},
                               {"gravity", system::Load::Kind::gravity},
                               {"follower_moment", system::Load::Kind::follower_moment},
                               {"gas", system::Load::Kind::gas}}),
       .meaning =
           "`point`: force on every vertex of a group. `line`: force per rest length of a curve. `area`: force "
           "per rest area. `gravity`: acceleration. `pressure`: along the normal at the start. `follower_pressure`: "
           "along the current normal. `follower_moment`: moment per rest length about a boundary edge. `gas`: pressure "
           "of "
           "a gas that the group encloses, p V^n = constant with the absolute pressure p "
           "(docs/howto/inflate-a-membrane.md).",
       .required = true},
      {.name = "group",
       .slot = GroupList{&s.group},
       .meaning =
           "Where it acts: any group for `point`, a curve for `line` and `follower_moment`, else a surface; for `gas` "
           "one in one part, whose holes are closed by a fan of triangles each.",
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
       .meaning =
           "Size at load factor 1; a pressure is positive along the normal of the triangles, that of a gas outwards: "
           "its excess over `ambient` while the volume is that of the start.",
       .unit = "pressure, follower_pressure, gas Pa, follower_moment N",
       .types = magnitudes,
       .required = true},
      {.name = "constant", .slot = &s.constant, .meaning = "Acts in full at every load factor, as a dead weight does."},
      {.name = "history",
       .slot = &s.history_text,
       .meaning = "Factor as an expression of the time t, instead of the load factor. Needs `analysis = \"dynamic\"`.",
       .absent = "none"},
      {.name = "distribution",
       .slot = &s.distribution_text,
       .meaning = "Factor as an expression of x, y and z at the start, e.g. `\"max(0, 2 - z)\"` with the weight of "
                  "water per volume as `magnitude` for a tank filled to z = 2 m. It is taken at the middle of each "
                  "triangle or edge.",
       .types = {"line", "area", "pressure", "follower_pressure"},
       .absent = "1 everywhere"},
      {.name = "ambient",
       .slot = &s.ambient,
       .meaning = "Pressure outside, absolute.",
       .unit = "Pa",
       .range = not_negative,
       .types = gas},
      {.name = "exponent",
       .slot = &s.exponent,
       .meaning =
           "n of p V^n: 1 at constant temperature, 1.4 for air without exchange of heat, 0 for a constant pressure.",
       .range = {0, 5},
       .types = gas},
      {.name = "added_volume",
       .slot = &s.added_volume,
       .meaning =
           "Rigid space that belongs to the gas besides what the group encloses, e.g. the box behind a flat membrane. "
           "Of an open surface the normals then point away from "
           "the gas; without it the gas is on the inner side.",
       .unit = "m^3",
       .range = not_negative,
       .types = gas},
      {.name = "leak_area",
       .slot = &s.leak_area,
       .meaning = "Area of an orifice times its discharge coefficient: the gas leaks in a motion. 0: it is closed.",
       .unit = "m^2",
       .range = not_negative,
       .types = gas},
      {.name = "density",
       .slot = &s.density,
       .meaning = "Of a gas that leaks, at ambient pressure.",
       .unit = "kg/m^3",
       .range = positive,
       .types = gas},
      {.name = "apex",
       .slot = &s.apex,
       .meaning = "Fixed point from which fans close the holes; with symmetry planes a point on all of them.",
       .unit = "m",
       .types = gas,
       .absent = "the mean of each rim, which moves with it"}};
}

std::vector<Key> keys_of(system::PointMass& s) {
  return {
      {.name = "group", .slot = GroupList{&s.group}, .meaning = "Any group.", .required = true},
      {.name = "mass",
       .slot = &s.mass,
       .meaning = "Of each vertex of the group, besides the sheet's. `gravity` on the whole surface, or on the same "
                  "group, acts on it.",
       .unit = "kg",
       .range = positive,
       .required = true}};
}

std::vector<Key> keys_of(system::Spring& s) {
  return {
      {.name = "type",
       .slot = choice(s.kind, {{"point", system::Spring::Kind::point},
                               {"line", system::Spring::Kind::line},
                               {"area", system::Spring::Kind::area},
                               {"pair", system::Spring::Kind::pair},
                               {"band", system::Spring::Kind::band}}),
       .meaning =
           "From the place at the start: `point` on every vertex of a group, `line` per rest length of a curve, "
           "`area` per rest area, an elastic foundation. `pair`: between every vertex of a group and the "
           "nearest one of `to` at the start. `band`: elastic along the edges of a curve, which only pulls, as in a "
           "waistband.",
       .required = true},
      {.name = "group",
       .slot = GroupList{&s.group},
       .meaning = "Any group for `point` and `pair`, a curve for `line` and `band`, a surface for `area`.",
       .required_types = {"point", "line", "pair", "band"},
       .absent = "the whole surface"},
      {.name = "stiffness",
       .slot = &s.stiffness,
       .meaning = "Force per displacement from the place at the start; of each pair, force per change of length; of a "
                  "band, force per strain.",
       .unit = "point, pair N/m, line N/m^2, area N/m^3, band N",
       .range = positive,
       .required = true},
      {.name = "direction",
       .slot = &s.direction,
       .meaning = "It acts along this direction only.",
       .types = {"point", "line", "area"},
       .absent = "it acts in all directions"},
      {.name = "to",
       .slot = GroupList{&s.to},
       .meaning = "The group of the other ends.",
       .types = {"pair"},
       .required_types = {"pair"}},
      {.name = "length",
       .slot = &s.length,
       .meaning =
           "Length without force. pair: 0 pulls it together from any distance. band: of the whole curve, above 0; "
           "shorter than the fabric it gathers it.",
       .unit = "m",
       .range = not_negative,
       .types = {"pair", "band"},
       .absent = "pair: the distance at the start; band: the length of the curve at rest"},
      {.name = "force",
       .slot = &s.force,
       .meaning = "With which it pulls where its curve has the length at rest, instead of `length`: a cable.",
       .unit = "N",
       .range = not_negative,
       .types = {"band"},
       .absent = "`length` gives it"},
      {.name = "rise",
       .slot = &s.rise,
       .meaning =
           "Time in which a band that is shorter than its curve gets so, in a stage in time, from where it first "
           "acts. 0: at once, which snaps it onto the body in a fraction of a millisecond.",
       .unit = "s",
       .range = not_negative,
       .types = {"band"},
       .absent = "0.1 where it first acts after sewing, else 0"}};
}

}  // namespace voile::input
