// Keys of materials.
#include <fmt/format.h>

#include "case_rubber.hpp"
#include "keys_common.hpp"

namespace voile::input {

namespace {

/// Of what it is, by elastic constants.
std::vector<Key> elastic_keys(MaterialInput& s) {
  const std::vector<std::string> iso{"isotropic"}, laminate{"laminate"}, ortho{"orthotropic", "laminate"},
      plates{"isotropic", "orthotropic", "neo_hookean", "mooney_rivlin", "ogden"};
  return {
      {.name = "type",
       .slot = choice(s.type, {{"isotropic", MaterialInput::Type::isotropic},
                               {"orthotropic", MaterialInput::Type::orthotropic},
                               {"matrices", MaterialInput::Type::matrices},
                               {"laminate", MaterialInput::Type::laminate},
                               {"fabric", MaterialInput::Type::fabric},
                               {"neo_hookean", MaterialInput::Type::neo_hookean},
                               {"mooney_rivlin", MaterialInput::Type::mooney_rivlin},
                               {"ogden", MaterialInput::Type::ogden}}),
       .meaning = "How the stiffness is given. `laminate`: from plies of one orthotropic material. `fabric`: from a "
                  "file of measured figures. `neo_hookean`, `mooney_rivlin`, `ogden`: incompressible rubber at large "
                  "strains.",
       .required = true},
      {.name = "groups",
       .slot = Words{&s.groups, {}},
       .meaning = "Physical surfaces made of this material.",
       .absent = "every triangle that no other material covers"},
      {.name = "young",
       .slot = &s.young,
       .meaning = "Young's modulus; of `neo_hookean` three times `shear_modulus`.",
       .unit = "Pa",
       .range = positive,
       .types = {"isotropic", "neo_hookean"},
       .required_types = iso,
       .absent = "from `shear_modulus`"},
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
                  "triangles from the lowest. A stack that is not symmetric couples stretching and bending.",
       .unit = "degree",
       .types = laminate,
       .required = true},
      {.name = "ply_thicknesses",
       .slot = &s.ply_thicknesses,
       .meaning = "Thickness of each ply, in the order of `angles`, or one for all.",
       .unit = "m",
       .range = positive,
       .types = laminate,
       .required = true}};
}

/// Density, and stiffnesses by other figures.
std::vector<Key> sheet_keys(MaterialInput& s) {
  const std::vector<std::string> matrices{"matrices"}, fabric{"fabric"},
      solids{"isotropic", "orthotropic", "laminate", "neo_hookean", "mooney_rivlin", "ogden"};
  return {
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
      {.name = "coupling",
       .slot = &s.coupling,
       .meaning = "Coupling B of stretching and bending as three rows: N = A E - B k, M = D k - B E.",
       .unit = "N",
       .types = matrices},
      {.name = "areal_density",
       .slot = &s.areal_density,
       .meaning = "Mass per area; used by gravity and vibration.",
       .unit = "kg/m^2",
       .range = not_negative,
       .types = matrices},
      {.name = "fabric",
       .slot = &s.fabric,
       .meaning = "Fabric file (see [fabrics.md](fabrics.md)), relative to the folder of the case file; or the "
                  "name of a shipped fabric.",
       .types = fabric,
       .required = true},
      {.name = "warp_angle",
       .slot = Degrees{&s.warp_angle},
       .meaning = "Angle from `direction` to the warp, positive about the normal of the triangles; of `matrices` the "
                  "axes of `bending_hysteresis` alone.",
       .unit = "degree",
       .types = {"fabric", "matrices"}}};
}

/// A second fabric that is fused to the first.
std::vector<Key> interlining_keys(MaterialInput& s) {
  const std::vector<std::string> fabric{"fabric"};
  return {
      {.name = "interlining",
       .slot = &s.interlining,
       .meaning = "Fabric file of a second layer that is fused to this one, found as `fabric` is, see "
                  "[fabrics.md](fabrics.md#interlining).",
       .types = fabric,
       .absent = "none"},
      {.name = "interlining_angle",
       .slot = Degrees{&s.interlining_angle},
       .meaning = "From the warp of the fabric to that of the interlining, positive about the normal.",
       .unit = "degree",
       .types = fabric},
      {.name = "interlining_distance",
       .slot = &s.interlining_distance,
       .meaning = "Distance of the middles of both layers.",
       .unit = "m",
       .range = not_negative,
       .types = fabric,
       .absent = "half of the sum of their thicknesses"},
      {.name = "interlining_bond",
       .slot = &s.interlining_bond,
       .meaning = "Fraction of the stiffness by the distance of the layers that the glue makes: 1 where they cannot "
                  "slide on each other, 0 where they do freely.",
       .range = {0.0, 1.0},
       .types = fabric}};
}

/// Friction of yarns that bend.
std::vector<Key> hysteresis_keys(MaterialInput& s) {
  const std::vector<std::string> fabric{"fabric"}, others{"orthotropic", "matrices", "laminate"};
  return {{.name = "hysteresis",
           .slot = choice(s.hysteresis, {{"damping", MaterialInput::Hysteresis::damping},
                                         {"friction", MaterialInput::Hysteresis::friction}}),
           .meaning = "What the loop of moment over curvature becomes. `damping`: viscous damping with the same loss. "
                      "`friction`: friction inside the fabric, which needs `bending_hysteresis` in the fabric file.",
           .types = fabric},
          {.name = "bending_hysteresis",
           .slot = &s.bending_hysteresis,
           .meaning = "Width 2HB of the loop of bending moment per width over curvature, as friction inside the sheet: "
                      "one number for both material axes, or three, for axis 1, axis 2 and twist.",
           .unit = "N",
           .range = not_negative,
           .types = others,
           .absent = "no friction"},
          {.name = "bending_hysteresis_spread",
           .slot = &s.bending_hysteresis_spread,
           .meaning = "Change of curvature over which the moment goes from one side of the loop to the other.",
           .unit = "1/m",
           .range = positive,
           .types = others},
          {.name = "bending_sliders",
           .slot = &s.bending_sliders,
           .meaning = "Number of springs with sliders that make the loop. One gives a parallelogram; more round its "
                      "corners, with the same width and the same mean spread.",
           .range = {1, 8},
           .types = {"fabric", "orthotropic", "matrices", "laminate"}}};
}

/// Yarns that stiffen and rub in the plane; fabrics have them in their files.
std::vector<Key> yarn_keys(MaterialInput& s) {
  const std::vector<std::string> matrices{"matrices"};
  const auto stiffening = [&](const char* name, std::vector<double>* slot, const char* of) {
    return Key{
        .name = name,
        .slot = slot,
        .meaning = fmt::format("Pairs of a strain and a change [N/m]: {} from that strain on, the tangent stiffness "
                               "changes by so much per strain.",
                               of),
        .types = matrices,
        .absent = "none"};
  };
  return {stiffening("stiffening_warp", &s.stiffening_warp, "of tension along the warp,"),
          stiffening("stiffening_weft", &s.stiffening_weft, "of tension along the weft,"),
          stiffening("stiffening_shear", &s.stiffening_shear, "of shear to either side,"),
          {.name = "shear_hysteresis",
           .slot = &s.shear_hysteresis,
           .meaning = "Friction in shear: H0, its growth over 2 E12, stiffness of the spring before the slider.",
           .unit = "N/m",
           .range = not_negative,
           .types = matrices,
           .absent = "no friction"}};
}

/// The natural state.
std::vector<Key> natural_keys(MaterialInput& s) {
  const std::vector<std::string> isotropic{"isotropic"}, two{"orthotropic", "laminate"}, matrices{"matrices"};
  return {
      {.name = "expansion",
       .slot = &s.expansion,
       .meaning = "Thermal expansion, for `[[temperature]]`.",
       .unit = "1/K",
       .types = isotropic,
       .absent = "none"},
      {.name = "expansion_1",
       .slot = &s.expansion_1,
       .meaning = "Thermal expansion along the material direction (of a laminate: along the fibres of a ply).",
       .unit = "1/K",
       .types = two,
       .absent = "none"},
      {.name = "expansion_2",
       .slot = &s.expansion_2,
       .meaning = "The same across it, in the surface.",
       .unit = "1/K",
       .types = two,
       .absent = "none"},
      {.name = "expansion_strain",
       .slot = &s.expansion_strain,
       .meaning = "Strain per kelvin without force, 11, 22, 12 with engineering shear.",
       .unit = "1/K",
       .types = matrices,
       .absent = "none"},
      {.name = "expansion_curvature",
       .slot = &s.expansion_curvature,
       .meaning = "Curvature without moment per kelvin of difference between top and bottom, k11, k22, 2 k12: of a "
                  "plate of thickness h minus the expansion over h.",
       .unit = "1/(m K)",
       .types = matrices,
       .absent = "none"},
      {.name = "coupled_curvature",
       .slot = &s.coupled_curvature,
       .meaning = "Curvature without force per kelvin of change, with `coupling`.",
       .unit = "1/(m K)",
       .types = matrices,
       .absent = "none"},
      {.name = "coupled_strain",
       .slot = &s.coupled_strain,
       .meaning = "Strain without force per kelvin of difference, with `coupling`.",
       .unit = "1/K",
       .types = matrices,
       .absent = "none"},
      {.name = "initial_strain",
       .slot = &s.initial_strain,
       .meaning = "Strain from the rest shape to the shape without stress along material axes 1 and 2 (of a `fabric`: "
                  "warp and weft), as a fraction; a third number is the engineering shear. `[-0.02, -0.03]`: the "
                  "sheet shrinks by 2 and 3 %.",
       .absent = "none"},
      {.name = "prestress",
       .slot = &s.prestress,
       .meaning = "Membrane force that the rest shape has along the same axes, positive in tension; a third number "
                  "is the shear. Rubber takes `initial_strain` instead.",
       .unit = "N/m",
       .absent = "none"}};
}

/// What plies bear.
std::vector<Key> strength_keys(MaterialInput& s) {
  const std::vector<std::string> types{"orthotropic", "laminate"};
  using Criterion = energy::Strength::Criterion;
  std::vector<Key> keys{
      {.name = "failure",
       .slot = choice(s.strength.criterion, {{"tsai_wu", Criterion::tsai_wu},
                                             {"hashin", Criterion::hashin},
                                             {"maximum_stress", Criterion::maximum_stress},
                                             {"maximum_strain", Criterion::maximum_strain}}),
       .meaning =
           "Criterion of the field `failure_index`. `tsai_wu`: with F12 = -sqrt(F11 F22)/2. `hashin`: fibre and matrix "
           "modes in plane stress, with half of the compressive strength across the fibres as transverse shear "
           "strength. `maximum_strain`: strengths over moduli. It needs the five strengths.",
       .types = types}};
  const auto add = [&](const char* name, double* slot, const char* meaning) {
    keys.push_back({.name = name,
                    .slot = slot,
                    .meaning = meaning,
                    .unit = "Pa",
                    .range = positive,
                    .types = types,
                    .absent = "not known"});
  };
  add("tensile_strength_1", &s.strength.tensile_1,
      "Strength along the material direction (of a laminate: along fibres).");
  add("compressive_strength_1", &s.strength.compressive_1, "The same in compression, as a positive number.");
  add("tensile_strength_2", &s.strength.tensile_2, "Strength across it, in the surface.");
  add("compressive_strength_2", &s.strength.compressive_2, "The same in compression, as a positive number.");
  add("shear_strength", &s.strength.shear, "Strength in shear in the surface.");
  return keys;
}

/// Axes and damping.
std::vector<Key> axis_keys(MaterialInput& s) {
  return {
      {.name = "direction",
       .slot = &s.direction,
       .meaning =
           "Direction of material axis 1 in space (in panels and with `mesh.rest = \"texture\"`: [u, v, 0] as "
           "`texture_direction`), projected into each triangle; the warp of a `fabric` lies at "
           "`warp_angle` to it. Triangles that are normal to it continue it from their neighbours; another direction "
           "for some `groups` is another `[[material]]`. Either this or `texture_direction` is needed, by `matrices` "
           "and `isotropic` only where something depends on it.",
       .absent = "none"},
      {.name = "texture_direction",
       .slot = &s.texture_direction,
       .meaning =
           "Direction of material axis 1 in the texture coordinates (u, v) of an OBJ mesh, e.g. `[0, 1]`: the grain "
           "line of the flat piece that a part of a garment is cut from.",
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

}  // namespace

std::vector<Key> keys_of(MaterialInput& s) {
  const std::vector<Key> solid = joined(joined(elastic_keys(s), sheet_keys(s)), strength_keys(s));
  const std::vector<Key> all = joined(joined(joined(solid, rubber_keys(s)), natural_keys(s)), axis_keys(s));
  return joined(joined(joined(all, interlining_keys(s)), hysteresis_keys(s)), yarn_keys(s));
}

}  // namespace voile::input
