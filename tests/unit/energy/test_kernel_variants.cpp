// The element kernels of every instruction set that this machine has, against the scalar variant, which other tests compare with differences.
#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <string>

#include "../test_meshes.hpp"
#include "../test_model_kit.hpp"
#include "energy/angle_bending.hpp"
#include "energy/chord_forms.hpp"
#include "energy/curvature.hpp"
#include "energy/element_kernels.hpp"
#include "energy/membrane.hpp"
#include "energy/yarn_friction.hpp"

namespace test_kernel_variants {

using namespace voile;
using namespace voile::testing;

namespace {

/// A curved sheet of uneven cells with a free rim: stencils of several sizes, and batches that are not full.
mesh::MeshData shell(double aspect) {
  return mapped(square(Pattern::jittered, 7),
                [&](const Vec3& x) { return Vec3(x[0], aspect * x[1], 0.3 * x[0] * x[0] - 0.2 * x[1] * x[1]); });
}

/// Both kernels of a sheet, with points numbered as the mesh is; every triangle has blocks of its own.
struct Kernels {
  mesh::SurfaceMesh mesh;
  std::vector<energy::Material> materials;
  mesh::PatchMesh patches{mesh, {}};
  energy::Sheet sheet;
  energy::MembraneTerm membrane;
  energy::AngleBendingTerm angles;
  energy::CurvedBendingTerm curved;
  energy::YarnFrictionTerm yarns;
  std::size_t blocks = 1;

  Kernels(const mesh::MeshData& data, energy::MembraneOperator kind, bool stiffens)
      : mesh(data),
        materials{rubbing(stiffens), rubbing(false)},
        sheet(patches, materials, turns(stiffens), options(kind)),
        membrane(sheet),
        yarns(sheet) {
    energy::CurvatureBuilder builder(sheet);
    const energy::ChordForms forms(sheet);
    for (Index t = 0; t < mesh.triangle_count(); ++t) {
      const energy::CurvatureOperator op = builder.build(t);
      const energy::BendingElement bending = energy::make_bending_element(sheet, t, op);
      membrane.add(sheet, t, energy::MembraneTerm::stencil_of(sheet, t), t % 3 != 0);
      if (membrane.corrects()) membrane.correct(sheet, forms.trace(t), t, bending, bending.points);
      if (bending.coupling.size() > 0) curved.add(bending, bending.points, t % 3 != 0);
      yarns.add(sheet, t, bending, bending.points, t % 3 != 0);
      if (const auto by_angles = energy::make_edge_angles(sheet, t, op, bending))
        angles.add(bending, *by_angles, bending.points, mesh.area(t) * materials[0].bending, t % 3 != 0);
    }
    angles.end_adding();
    const auto own = [&](const Index*, int count, const auto&) {
      std::vector<Index> places;
      for (int k = 0; k < count * (count + 1) / 2; ++k) places.push_back(static_cast<Index>(blocks++));
      return places;
    };
    membrane.locate(own, 0);
    angles.locate(own, 0);
    curved.locate(own, 0);
    yarns.locate(own, 0);
  }
  /// With yarns every third triangle is of rubber.
  [[nodiscard]] std::vector<int> turns(bool stiffens) {
    if (stiffens) materials[1].rubber = {2.0, 1.0, {{3.0, 1.3}, {-1.0, -1.0}}};
    std::vector<int> of;
    for (Index t = 0; t < mesh.triangle_count(); ++t) of.push_back(stiffens && t % 3 == 1 ? 1 : 0);
    return of;
  }
  static energy::Material rubbing(bool stiffens) {
    energy::Material m = isotropic(100.0, 0.3, 0.1);
    m.friction = {0.3, energy::sliders_of(Vec3(0.1, 0.2, 0.05), 2.0, 3)};
    if (!stiffens) return m;
    m.yarns.warp_angle = 0.3;
    m.yarns.knots = {{{{0.0, 300.0}, {0.01, -200.0}}, {{0.002, 100.0}}, {{0.0, 50.0}, {0.01, -30.0}}}};
    m.yarns.stiffness = 8.0;
    m.yarns.limit = 0.02;
    m.yarns.rise = 0.5;
    return m;
  }
  static energy::ElementOptions options(energy::MembraneOperator kind) {
    energy::ElementOptions o;
    o.membrane = kind;
    return o;
  }
};

/// What a kernel gives.
struct Values {
  double energy;
  Eigen::VectorXd force, blocks;
};

template <class Term>
Values values_of(Term& term, const energy::ElementKernels& variant, const Kernels& k, const energy::Configuration& c) {
  term.use(variant);
  std::vector<Vec3> force(static_cast<std::size_t>(k.mesh.vertex_count()), Vec3::Zero());
  Eigen::VectorXd blocks = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(9 * k.blocks));
  const double energy = term.add_gradients(c, force.data());
  term.add_tangents(c, blocks.data());
  blocks.head<9>().setZero();  // takes what goes nowhere
  return {energy, Eigen::Map<Eigen::VectorXd>(force[0].data(), 3 * k.mesh.vertex_count()), blocks};
}

template <class Term>
void compare(Term& term, const Kernels& k, const energy::Configuration& c) {
  const energy::KernelVariants variants = energy::kernel_variants();
  const Values scalar = values_of(term, energy::scalar_kernels(), k, c);
  CHECK(scalar.force.norm() > 1e-6);
  for (int v = 1; v < variants.count; ++v) {
    if (!variants.variants[v]->usable()) continue;
    const std::string name = variants.variants[v]->name;
    CAPTURE(name);
    const Values found = values_of(term, *variants.variants[v], k, c);
    CHECK(std::abs(found.energy - scalar.energy) < 1e-14 * k.mesh.triangle_count() * std::abs(scalar.energy));
    CHECK((found.force - scalar.force).norm() < 1e-13 * scalar.force.norm());
    CHECK((found.blocks - scalar.blocks).norm() < 1e-13 * scalar.blocks.norm());
    const Values again = values_of(term, *variants.variants[v], k, c);
    CHECK((again.blocks - found.blocks).norm() == 0.0);
  }
}

}  // namespace

TEST_CASE("the kernels of every instruction set agree with the scalar ones") {
  using energy::MembraneOperator;
  for (const double aspect : {1.0, 0.2})
    for (const MembraneOperator kind :
         {MembraneOperator::cst, MembraneOperator::six_node, MembraneOperator::six_node_corrected}) {
      Kernels k(shell(aspect), kind, aspect == 1.0);
      std::vector<Vec3> u, x = k.mesh.positions(), previous = x;
      for (Index v = 0; v < k.mesh.vertex_count(); ++v) {
        u.push_back(noise(0.02 * aspect, 3)(v));
        x[v] += u.back();
        previous[v] += noise(0.01 * aspect, 4)(v);
      }
      for (const energy::Tangent tangent :
           {energy::Tangent::exact, energy::Tangent::linearised_stress, energy::Tangent::positive})
        for (const bool viscous : {false, true}) {
          CAPTURE(aspect);
          CAPTURE(static_cast<int>(kind));
          const energy::Configuration c{x.data(), u.data(), previous.data(), tangent};
          k.membrane.set_viscosity({});
          if (viscous) k.membrane.start_step({previous.data(), u.data()}, 0.5);
          compare(k.membrane, k, c);
          if (viscous) continue;
          compare(k.angles, k, c);
          compare(k.curved, k, c);
          compare(k.yarns, k, c);
        }
    }
}

}  // namespace test_kernel_variants
