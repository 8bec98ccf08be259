// Keys of sewing patterns: pieces, seams, sewing.
#include "keys_common.hpp"

namespace voile::input {

namespace {

/// Length beyond which nothing of a garment is [m].
constexpr double farthest = 1e6;
/// Where a spring of a seam turns from stiff to a constant force it is l0 = T / k long. T is a tenth of the membrane
/// stiffness, 1 N/m for the softest fabric, and k doubles seven times: with 1e10 N/m^2 l0 is 1e-12 m, of which positions
/// of a metre (2e-16 m) leave three digits. Sewing a tube takes 2 CPU s up to here, 12 with 1e12.
constexpr double stiffest_seam = 1e10;
/// Largest force per length of a seam [N/m]: what stretches a plate of steel, 5 mm thick, to twice its length.
constexpr double strongest_seam = 1e9;
constexpr double most_sewing_strain = 10.0;
/// Faster than anything is sewn [m/s]: the springs have no length from the first step on.
constexpr double fastest_seam = 1e6;

/// Clothes over each other, at most.
constexpr double most_layers = 100;

/// Beyond these nothing is sewn: a factor of the bending stiffness, and the width of an allowance [m].
constexpr double stiffest_bend = 1e4;
constexpr double widest_allowance = 1.0;

std::vector<Key> wrapping_keys(PanelSection& s) {
  return {{.name = "wrap_axis",
           .slot = &s.wrap_axis,
           .meaning = "Direction of the axis of a cylinder or cone onto which each piece is bent after it has been "
                      "placed, without stretch: the plane of the piece must be parallel to the axis.",
           .absent = "the pieces stay flat, unless there is `wrap_end`"},
          {.name = "wrap_point", .slot = &s.wrap_point, .meaning = "A point on that axis.", .unit = "m"},
          {.name = "wrap_end",
           .slot = &s.wrap_end,
           .meaning = "Another point on it, which gives its direction instead of `wrap_axis`.",
           .unit = "m",
           .absent = "`wrap_axis` has the direction"},
          {.name = "wrap_along",
           .slot = choice(s.wrap_along, {{"as_placed", PanelSection::Along::as_placed},
                                         {"x", PanelSection::Along::x},
                                         {"y", PanelSection::Along::y},
                                         {"-x", PanelSection::Along::minus_x},
                                         {"-y", PanelSection::Along::minus_y}}),
           .meaning = "Direction in the piece as it is drawn that shall be the direction of the axis: each piece is "
                      "turned about its origin, after `rotate`, by the least angle that makes it so."},
          {.name = "wrap_shift",
           .slot = &s.wrap_shift,
           .meaning = "By how much pieces are moved along the axis.",
           .unit = "m",
           .range = {-farthest, farthest}},
          {.name = "wrap_radius",
           .slot = &s.wrap_radius,
           .meaning = "Radius of that cylinder, or of the cone where `wrap_point` is. 0: the distance of the plane of "
                      "the piece from the axis, which the cylinder then touches. Of a piece whose plane contains the "
                      "axis the right side is outside.",
           .unit = "m",
           .range = {0.0, farthest}},
          {.name = "wrap_angle",
           .slot = Degrees{&s.wrap_angle},
           .meaning = "Between the axis of a cone and its surface, positive if it widens along the axis. A piece keeps "
                      "its line nearest to the axis, which leans by this angle about the point at the height of "
                      "`wrap_point`. 0: a cylinder.",
           .unit = "degree",
           .range = {-89.0, 89.0}},
          {.name = "wrap_radii",
           .slot = &s.wrap_radii,
           .meaning = "Radii of a cone at `wrap_point` and at `wrap_end`, instead of `wrap_radius` and `wrap_angle`.",
           .unit = "m",
           .range = {0.0, farthest},
           .absent = "as `wrap_radius` and `wrap_angle` give"}};
}

/// How pieces come out of what the file draws.
std::vector<Key> cutting_keys(PanelSection& s) {
  return {
      {.name = "mirror",
       .slot = &s.mirror,
       .meaning = "Whether the pieces are cut from the mirror image of their outlines (x becomes -x)."},
      {.name = "unfold",
       .slot = &s.unfold,
       .meaning =
           "Edge of each piece, by number or label, which is a fold line: what is drawn is half of the piece, and its "
           "mirror image is added. The mirror line of a DXF block does so without this key.",
       .absent = "pieces are whole"},
      {.name = "grain",
       .slot = &s.grain,
       .meaning = "Direction `[x, y]` of the grain line as the file draws the pieces. Their texture coordinates are "
                  "turned until "
                  "it is along v, which `texture_direction = [0, 1]` of `[[material]]` means.",
       .absent = "the grain line of a DXF block (layer 7), else `[0, 1]`"},
      {.name = "stitches",
       .slot = &s.stitches,
       .meaning = "Whether the stitches of a `.json`, or of an `.obj`, become seams."},
      {.name = "euler",
       .slot = choice(s.euler, {{"zyx", PanelSection::Euler::zyx}, {"xyz", PanelSection::Euler::xyz}}),
       .meaning =
           "Order of the angles of a `.json`: `zyx`: R = Rz Ry Rx, as its simulator reads them; `xyz`: R = Rx Ry "
           "Rz, as its writer stores them. The two differ where more than one angle is not zero."}};
}

}  // namespace

std::vector<Key> keys_of(PanelSection& s) {
  std::vector<Key> keys{
      {.name = "file",
       .slot = &s.file,
       .meaning =
           "Pattern: GarmentCode (`.json`), outlines (`.svg`, `.dxf`, `.geo`) or a mesh whose texture coordinates are "
           "those of the pieces (`.obj`), relative to the folder of the case file.",
       .required = true},
      {.name = "parameters",
       .slot = &s.parameters,
       .meaning = "Numbers that a `.geo` declares by DefineConstant, e.g. `{ waist = 0.7 }`.",
       .absent = "as the file has them"},
      {.name = "pieces",
       .slot = Words{&s.pieces, {}},
       .meaning = "Names of the pieces that are taken from it.",
       .absent = "all of them"},
      {.name = "nest_size",
       .slot = &s.nest_size,
       .meaning =
           "Of a DXF whose blocks are pieces in several sizes: only those whose text `Size:` is this one. They are "
           "called by their `Piece Name:`.",
       .absent = "all sizes"},
      {.name = "name",
       .slot = &s.name,
       .meaning = "What its only piece is called, e.g. where a file is used twice.",
       .absent = "the piece's own name"},
      {.name = "unit",
       .slot = &s.unit,
       .meaning = "Length of one unit of the file's coordinates. 0: what the file states: an SVG by a width "
                  "with a unit and a viewBox, a DXF by $INSUNITS, a text 'Units:' or $MEASUREMENT; "
                  "an OBJ and a Gmsh script are in metres.",
       .unit = "m",
       .range = not_negative},
      {.name = "texture_unit",
       .slot = &s.texture_unit,
       .meaning = "Length of 1 in the texture coordinates of an `.obj`. 0: what edges of its mesh are long in space, "
                  "where they are so alike.",
       .unit = "m",
       .range = not_negative},
      {.name = "size", .slot = &s.size, .meaning = "Length of the edges of cells.", .unit = "m", .range = positive}};
  std::vector<Key> places = placement_keys(s.placement, {});
  places.push_back({.name = "origin",
                    .slot = &s.origin,
                    .meaning = "Where the origin of the file comes before `translate` moves it on, both within 1e6 m.",
                    .unit = "m"});
  places.push_back({.name = "anchor",
                    .slot = &s.anchor,
                    .meaning = "Point `PIECE@POINT` of a piece of this section that comes there instead of the origin "
                               "of the file, turned by `rotate`, before pieces are bent.",
                    .absent = "the origin of the file"});
  places.push_back(
      {.name = "layer",
       .slot = &s.layer,
       .meaning = "Of the clothes, from the body outwards: each begins outside the one before, by `contact.distance`, "
                  "`thickness` and what the cells of a bent piece cut off. Flat pieces move to their right side.",
       .range = {0, most_layers}});
  return joined(joined(joined(std::move(keys), cutting_keys(s)), places), wrapping_keys(s));
}

std::vector<Key> keys_of(SeamSection& s) {
  return {
      {.name = "name", .slot = &s.name, .meaning = "Of the seam.", .absent = "made of its edges"},
      {.name = "edges",
       .slot = Words{&s.edges, {}},
       .meaning =
           "One side: edges `PIECE/EDGE` in the order in which they follow each other, EDGE being the number "
           "from 0 in the file or a label that only one edge of the piece has, or `PIECE/FROM..TO` for all edges "
           "from one point to another, round the outline or a hole in the order of the file. A `*` in names of pieces "
           "makes a seam for each text that it stands for in `edges`, `to`, `meet` and `name` alike.",
       .required = true},
      {.name = "to", .slot = Words{&s.to, {}}, .meaning = "The other side.", .required = true},
      {.name = "meet",
       .slot = &s.meet,
       .meaning = "Two points `PIECE@POINT` that come together, an end of each side; POINT counts from 0, edge k "
                  "begins at point k; corners and notches of DXF blocks have names too, c0, c1, ... and n0, n1, ....",
       .absent = "the ends whose choice makes the way shorter at the start"},
      {.name = "gather",
       .slot = choice(s.gather, {{"auto", SeamSection::Gather::automatic},
                                 {"always", SeamSection::Gather::always},
                                 {"never", SeamSection::Gather::never}}),
       .meaning =
           "Whether the longer side is gathered: drawn in along the seam to the length of the other, in folds that "
           "are finer than its cells. auto: from 1.25 times that length on; always: whatever ease there is; "
           "never: the cells beside the seam are strained, as where the shorter side is to be stretched."},
      {.name = "bending",
       .slot = &s.bending,
       .meaning = "As `[sewing] bending`, of this seam.",
       .range = {0.0, stiffest_bend},
       .absent = "`[sewing] bending`"},
      {.name = "zip_speed",
       .slot = &s.zip_speed,
       .meaning =
           "At which the seam closes along itself from the points of `meet` on, as by the slider of a zipper. 0: "
           "all of it at once.",
       .unit = "m/s",
       .range = {0.0, fastest_seam}},
      {.name = "allowance",
       .slot = &s.allowance,
       .meaning = "As `[sewing] allowance`, of this seam.",
       .unit = "m",
       .range = {0.0, widest_allowance},
       .absent = "`[sewing] allowance`"}};
}

std::vector<Key> keys_of(MarkSection& s) {
  return {
      {.name = "name", .slot = &s.name, .meaning = "Of the mark and its group.", .required = true},
      {.name = "point",
       .slot = &s.point,
       .meaning = "A point of an outline as `PIECE@POINT`, as in `[[seam]] meet`.",
       .absent = "`panel` and `at` give its place"},
      {.name = "panel", .slot = &s.panel, .meaning = "The piece that it is in.", .absent = "there is `point`"},
      {.name = "at",
       .slot = &s.at,
       .meaning = "Its place [x, y] inside of that piece as its file draws it: x to the right, y up, from the origin "
                  "of the file.",
       .unit = "m",
       .absent = "there is `point`"}};
}

std::vector<Key> keys_of(SewingSection& s) {
  return {
      {.name = "stiffness",
       .slot = &s.stiffness,
       .meaning = "Of the springs that pull a seam together, per rest length of the seam. When none has a "
                  "length left it doubles every 0.03 s, up to 128 times. Double precision resolves no more beside "
                  "a membrane.",
       .unit = "N/m^2",
       .range = {0.0, stiffest_seam, true}},
      {.name = "force",
       .slot = &s.force,
       .meaning = "With which they pull at most until none has a length left, per rest length of the seam. 0: what "
                  "stretches the softest material of the case by a tenth.",
       .unit = "N/m",
       .range = {0.0, strongest_seam}},
      {.name = "strain",
       .slot = &s.strain,
       .meaning = "From then on the force doubles every 0.1 s for seams that are open yet, up to what stretches the "
                  "softest material of the case by this strain.",
       .range = {0.0, most_sewing_strain, true},
       .absent = "0.3; no rise where `force` is given"},
      {.name = "speed",
       .slot = &s.speed,
       .meaning = "At which they get shorter, down to no length.",
       .unit = "m/s",
       .range = {0.0, fastest_seam, true}},
      {.name = "gap",
       .slot = &s.gap,
       .meaning = "Largest distance of points that are made one at the end of the stage; if one is larger then, the "
                  "run ends there.",
       .unit = "m",
       .range = {0.0, farthest, true}},
      {.name = "bending",
       .slot = &s.bending,
       .meaning = "Factor of the fabric's bending energy across a welded seam, over the cells beside it: 0 is a hinge, "
                  "1 the fabric as it is elsewhere. Others count over one row of cells, whose size then matters.",
       .range = {0.0, stiffest_bend}},
      {.name = "allowance",
       .slot = &s.allowance,
       .meaning = "Width of the strip of the same fabric that lies on each side of a seam, inside of it: it adds its "
                  "mass, and its stiffness against stretch and bending as that of another layer.",
       .unit = "m",
       .range = {0.0, widest_allowance}},
      {.name = "friction",
       .slot = &s.friction,
       .meaning = "Largest coefficient of friction in stages that sew. Fabric that slides along the body goes to where "
                  "it fits "
                  "before its seams are closed; it stays where it is as long as the coefficient exceeds the slope of "
                  "the body.",
       .range = not_negative,
       .absent = "that of `[contact]`, `[[obstacle]]` and `[[contact_rule]]`"}};
}

}  // namespace voile::input
