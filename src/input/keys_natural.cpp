// Keys of temperatures, form finding, hinges and imperfections.
#include "keys_common.hpp"

namespace voile::input {

std::vector<Key> keys_of(system::Temperature& s) {
  return {
      {.name = "group",
       .slot = GroupList{&s.group},
       .meaning =
           "Physical surface. At its border `change` may jump; elsewhere a jump within a cell or two makes forces "
           "beside it oscillate.",
       .absent = "the whole surface"},
      {.name = "change",
       .slot = &s.change.text,
       .meaning = "Mean change over the thickness, an expression of x, y and z at the start and of the time t, in "
                  "quotes, e.g. `\"80\"` or `\"20 + 100*x\"`. Except in `dynamic` t is the load factor.",
       .unit = "K",
       .absent = "none"},
      {.name = "difference",
       .slot = &s.difference.text,
       .meaning = "Temperature of the top, where the normal of the triangles points to, less that of the bottom; an "
                  "expression likewise.",
       .unit = "K",
       .absent = "none"},
      {.name = "constant",
       .slot = &s.constant,
       .meaning = "Acts in full at every load factor. Otherwise it grows with the load factor, unless t occurs in its "
                  "expression."}};
}

std::vector<Key> keys_of(FormSection& s) {
  return {{.name = "pressure",
           .slot = &s.pressure,
           .meaning = "That the form carries besides, along the normals of the triangles. In the analysis a "
                      "`follower_pressure` with `constant = true` keeps it up.",
           .unit = "Pa"}};
}

std::vector<Key> keys_of(system::Hinge& s) {
  return {
      {.name = "group", .slot = GroupList{&s.group}, .meaning = "Physical curve.", .required = true},
      {.name = "stiffness",
       .slot = &s.stiffness,
       .meaning = "Moment per length of the line and radian of its angle.",
       .unit = "N",
       .range = positive,
       .required = true},
      {.name = "angle",
       .slot = &s.angle.text,
       .meaning =
           "By how much the fold that is free of moment changes: an expression of x, y and z at the start and of t, "
           "as in `[[temperature]]`. Positive folds close on the side that normals point to; `\"180\"` is flat "
           "on itself.",
       .unit = "degree",
       .absent = "none"},
      {.name = "constant",
       .slot = &s.constant,
       .meaning = "Acts in full at every load factor. Otherwise it grows with the load factor, unless t occurs in its "
                  "expression."}};
}

std::vector<Key> keys_of(ImperfectionSection& s) {
  using Type = ImperfectionSection::Type;
  return {{.name = "type",
           .slot = choice(s.type, {{"modes", Type::modes}, {"expression", Type::expression}, {"random", Type::random}}),
           .meaning =
               "`modes`: in proportion to modes of a `modal` or `buckling` run of the same mesh. `expression`: heights "
               "along the normals. `random`: smooth random heights along the normals.",
           .required = true},
          {.name = "results",
           .slot = &s.results,
           .meaning =
               "Output folder of that run (of one of its stages: the folder of the stage), relative to the folder of "
               "the case file.",
           .types = {"modes"},
           .absent = "`stage`"},
          {.name = "stage",
           .slot = &s.stage,
           .meaning =
               "Earlier `modal` or `buckling` stage of this case, instead of `results`. The stage after the last one "
               "named begins anew, without stress, with all imperfections.",
           .types = {"modes"},
           .absent = "`results`"},
          {.name = "modes",
           .slot = &s.modes,
           .meaning = "Numbers of the modes, from 1.",
           .types = {"modes"},
           .required = true},
          {.name = "amplitudes",
           .slot = &s.amplitudes,
           .meaning = "Largest displacement of each mode, of either sign; a list of one is for all.",
           .unit = "m",
           .types = {"modes"},
           .required = true},
          {.name = "height",
           .slot = &s.height,
           .meaning = "Height along the normal as an expression of x, y and z, e.g. `\"0.001*sin(pi*x)\"`.",
           .unit = "m",
           .types = {"expression"},
           .required = true},
          {.name = "amplitude",
           .slot = &s.amplitude,
           .meaning = "Largest height.",
           .unit = "m",
           .range = positive,
           .types = {"random"},
           .required = true},
          {.name = "length",
           .slot = &s.length,
           .meaning = "Correlation length: at this distance heights have a correlation of 0.61 (Gaussian).",
           .unit = "m",
           .range = positive,
           .types = {"random"},
           .required = true},
          {.name = "seed",
           .slot = &s.seed,
           .meaning = "Another number gives another field. The same number gives the same field for any numbering of "
                      "the mesh and any "
                      "number of ranks.",
           .range = not_negative,
           .types = {"random"}}};
}

}  // namespace voile::input
