// Criteria of failure: by hand, and that an index is in proportion to the stress.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "energy/layer_stress.hpp"
#include "test_relative.hpp"

namespace test_failure {

using namespace voile;
using Criterion = energy::Strength::Criterion;

namespace {

/// E-glass/epoxy of Jones, Mechanics of Composite Materials, 2nd ed. (1999), table 2-3.
energy::Strength glass(Criterion criterion) {
  return {criterion, 1062e6, 610e6, 31e6, 118e6, 72e6, 38.6e9, 8.27e9, 0.26, 4.14e9};
}

}  // namespace

TEST_CASE("every criterion gives 1 at each strength, and is in proportion to the stress") {
  for (const Criterion c :
       {Criterion::tsai_wu, Criterion::hashin, Criterion::maximum_stress, Criterion::maximum_strain}) {
    const energy::Strength s = glass(c);
    for (const Vec3& at : {Vec3(1062e6, 0.0, 0.0), Vec3(-610e6, 0.0, 0.0), Vec3(0.0, 31e6, 0.0), Vec3(0.0, -118e6, 0.0),
                           Vec3(0.0, 0.0, 72e6), Vec3(0.0, 0.0, -72e6)}) {
      if (c == Criterion::maximum_strain && at[0] < 0.0) continue;  // it expands across the fibres, and fails by that
      CHECK(energy::failure_index(s, at) == relative(1.0));
    }
    const Vec3 stress(120e6, -20e6, 33e6);
    CHECK(energy::failure_index(s, 2.5 * stress) == relative(2.5 * energy::failure_index(s, stress)));
    CHECK(energy::failure_index(s, Vec3::Zero()) == 0.0);
  }
}

TEST_CASE("criteria under combined stress by hand") {
  const Vec3 stress(100e6, 20e6, 30e6);
  CHECK(energy::failure_index(glass(Criterion::hashin), stress) == relative(std::hypot(20.0 / 31.0, 30.0 / 72.0)));
  CHECK(energy::failure_index(glass(Criterion::hashin), {-100e6, -20e6, 70e6}) ==
        relative(std::hypot(20.0 / 118.0, 70.0 / 72.0)));
  CHECK(energy::failure_index(glass(Criterion::maximum_stress), stress) == relative(20.0 / 31.0));
  const double across = 20.0 - 0.26 * 8.27 / 38.6 * 100.0;
  CHECK(energy::failure_index(glass(Criterion::maximum_strain), stress) ==
        relative(std::max(across / 31.0, 30.0 / 72.0)));
  const double index = energy::failure_index(glass(Criterion::tsai_wu), stress), r = 1.0 / index;
  const double f1 = 1.0 / 1062.0 - 1.0 / 610.0, f2 = 1.0 / 31.0 - 1.0 / 118.0, f11 = 1.0 / (1062.0 * 610.0),
               f22 = 1.0 / (31.0 * 118.0);
  const double quadratic = f11 * 1e4 + f22 * 400.0 + 900.0 / 5184.0 - std::sqrt(f11 * f22) * 2000.0;
  CHECK(quadratic * r * r + (100.0 * f1 + 20.0 * f2) * r == relative(1.0));
}

TEST_CASE("the ply and face that fail first") {
  energy::Material m;
  const energy::LaminateStiffness l =
      energy::laminate(energy::orthotropic_membrane(38.6e9, 8.27e9, 0.26, 4.14e9, 1.0),
                       {{0.0, 1e-3}, {0.5 * std::numbers::pi, 1e-3}, {0.25 * std::numbers::pi, 1e-3}});
  m.layers = l.layers;
  m.strength = glass(Criterion::maximum_stress);
  // Stretched along axis 1, the second ply is pulled across its fibres.
  const energy::LayerFailure pulled = energy::worst_layer(m, {Vec3(1e-3, 0.0, 0.0), Vec3::Zero()});
  CHECK(pulled.layer == 2);
  const double q22 = 8.27e9 / (1.0 - 0.26 * 0.26 * 8.27 / 38.6);
  CHECK(pulled.index == relative(1e-3 * q22 / 31e6));
  // Bent so that the top, at 45 degrees, is stretched: strain is -z k.
  const energy::LayerFailure bent = energy::worst_layer(m, {Vec3::Zero(), Vec3(-1.0, 0.0, 0.0)});
  CHECK(bent.layer == 3);
  CHECK(bent.top);
  CHECK(energy::turned_stress({5.0, 1.0, 2.0}, 0.5 * std::numbers::pi).isApprox(Vec3(1.0, 5.0, -2.0)));
}

}  // namespace test_failure
