#include "case_rubber.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "keys_common.hpp"
#include "voile/errors.hpp"

namespace voile::input {

namespace {

constexpr double poisson = 0.5, young_over_shear = 3.0;
/// Up to which stretch laws are looked at before a run.
constexpr double largest_stretch = 8.0, stretch_ratio = 1.02;

void read_neo_hookean(const SectionPlace& place, const MaterialInput& in, energy::Hyperelastic& law) {
  const bool by_young = !std::isnan(in.young);
  if (by_young != std::isnan(in.shear_modulus))
    place.fail("shear_modulus", by_young ? "there is 'young' too; keep one of them, young = 3 shear_modulus"
                                         : "the key is missing; give shear_modulus, or young = 3 shear_modulus");
  law.c10 = 0.5 * (by_young ? in.young / young_over_shear : in.shear_modulus);
}

void read_mooney_rivlin(const SectionPlace& place, const MaterialInput& in, energy::Hyperelastic& law) {
  if (!(in.c10 + in.c01 > 0.0))
    place.fail("c01", fmt::format("c10 + c01 = {:g}, half of the shear modulus at zero strain, must be above 0; check "
                                  "both moduli",
                                  in.c10 + in.c01));
  law.c10 = in.c10;
  law.c01 = in.c01;
}

void read_ogden(const SectionPlace& place, const MaterialInput& in, energy::Hyperelastic& law) {
  if (in.mu.size() != in.alpha.size() || in.mu.empty())
    place.fail("alpha",
               fmt::format("{} exponent(s) for {} moduli in 'mu'; give one for each", in.alpha.size(), in.mu.size()));
  for (std::size_t k = 0; k < in.mu.size(); ++k) {
    if (in.alpha[k] == 0.0) place.fail("alpha", "an exponent of 0 has no energy; remove the term");
    // These two need no powers.
    if (in.alpha[k] == 2.0)
      law.c10 += 0.5 * in.mu[k];
    else if (in.alpha[k] == -2.0)
      law.c01 -= 0.5 * in.mu[k];
    else
      law.terms.push_back({in.mu[k], in.alpha[k]});
  }
  if (!(law.shear_modulus() > 0.0))
    place.fail("mu", fmt::format("the sum of mu * alpha is {:g}, twice the shear modulus at zero strain; it must be "
                                 "above 0; check signs",
                                 2.0 * law.shear_modulus()));
}

}  // namespace

std::vector<Key> rubber_keys(MaterialInput& s) {
  const std::vector<std::string> neo_hookean{"neo_hookean"}, mooney_rivlin{"mooney_rivlin"}, ogden{"ogden"};
  return {{.name = "shear_modulus",
           .slot = &s.shear_modulus,
           .meaning = "Shear modulus at zero strain; `young` / 3.",
           .unit = "Pa",
           .range = positive,
           .types = neo_hookean,
           .absent = "from `young`"},
          {.name = "c10",
           .slot = &s.c10,
           .meaning = "Modulus of l1^2 + l2^2 + l3^2 - 3 in the energy per volume, l the principal stretches.",
           .unit = "Pa",
           .types = mooney_rivlin,
           .required = true},
          {.name = "c01",
           .slot = &s.c01,
           .meaning = "Modulus of 1/l1^2 + 1/l2^2 + 1/l3^2 - 3.",
           .unit = "Pa",
           .types = mooney_rivlin,
           .required = true},
          {.name = "mu",
           .slot = &s.mu,
           .meaning = "Moduli of the energy per volume, the sum of mu/alpha (l1^alpha + l2^alpha + l3^alpha - 3). The "
                      "sum of mu alpha is twice the shear modulus.",
           .unit = "Pa",
           .types = ogden,
           .required = true},
          {.name = "alpha",
           .slot = &s.alpha,
           .meaning = "Their exponents, one for each.",
           .types = ogden,
           .required = true}};
}

bool is_rubber(MaterialInput::Type type) {
  using Type = MaterialInput::Type;
  return type == Type::neo_hookean || type == Type::mooney_rivlin || type == Type::ogden;
}

void fill_rubber(const SectionPlace& place, const MaterialInput& in, energy::Material& m) {
  if (!in.prestress.empty())
    place.fail("prestress", "a hyperelastic material has no strain in proportion to it; give initial_strain instead");
  switch (in.type) {
    case MaterialInput::Type::neo_hookean:
      read_neo_hookean(place, in, m.rubber);
      break;
    case MaterialInput::Type::mooney_rivlin:
      read_mooney_rivlin(place, in, m.rubber);
      break;
    default:
      read_ogden(place, in, m.rubber);
  }
  m.rubber.scale(in.thickness);
  m.membrane = energy::isotropic_membrane(young_over_shear * m.rubber.shear_modulus(), poisson, 1.0);
}

std::string ellipticity_note(const energy::Hyperelastic& law) {
  struct Kind {
    const char* name;
    double power;  ///< of the second stretch, as a power of the first
  };
  for (const Kind kind :
       {Kind{"pulled in one direction", -0.5}, Kind{"pulled in one direction and held across it", 0.0},
        Kind{"pulled alike in both directions", 1.0}})
    for (double l = stretch_ratio; l < largest_stretch; l *= stretch_ratio) {
      const double across = std::pow(l, kind.power);
      if (energy::ellipticity(law, {0.5 * (l * l - 1.0), 0.5 * (across * across - 1.0), 0.0}) > 0.0) continue;
      return fmt::format("{}, it loses ellipticity at a stretch of {:.2f}", kind.name, l);
    }
  return "";
}

}  // namespace voile::input
