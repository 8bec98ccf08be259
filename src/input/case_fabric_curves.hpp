// Curves of a fabric file: tension as LT, WT, EMT of KES or as points, shear as points.
//
// Symbols   x, F    extension and force per width of a tensile test [-, N/m];  E = x + x^2/2,  S = F/(1 + x)
//           f, F    shear angle and force per width [rad, N/m];  2 E12 = sin f,  S = F/cos f, with yarns that keep their length
// S dE = F dx, so that energies, and WT, are the same in both.
#pragma once

#include <toml++/toml.h>

#include <string>
#include <vector>

#include "case_read.hpp"
#include "fabric.hpp"

namespace voile::input {

/// A key with a curve.
struct CurveKey {
  const SectionPlace& place;
  const char* key;
  bool shear;
};
/// As a file has it, in strains and forces of the solver.
struct CurveFigures {
  std::vector<energy::YarnPoint> points{};  ///< empty: the end and the area below
  energy::YarnPoint end{};
  double work = 0.0;  ///< WT [J/m^2]
};
/// A point x, F of a test as E, S.
[[nodiscard]] energy::YarnPoint solver_point(bool shear, double x, double force);
/// Throws UserError for what is not a measured curve: no unit, not monotone, figures that contradict each other.
[[nodiscard]] CurveFigures read_curve(const CurveKey& key, const toml::node& node);
/// `tangent`: at zero [N/m]; 0: not measured. Throws UserError if no smooth curve has it.
[[nodiscard]] energy::YarnCurve curve_of(const CurveKey& key, const CurveFigures& figures, double tangent);
/// Of shear beside its friction, which pulls the middle of the loop down by h/G_s of half its width.
[[nodiscard]] energy::YarnCurve middle_of_loop(const Fabric& fabric, std::vector<energy::YarnPoint> points);
/// Throws UserError for loops of shear that no slider has.
void check_shear_friction(const SectionPlace& place, const Fabric& fabric);

}  // namespace voile::input
