// Stress resultants of a state against smooth ones.
#include "energy/recovery_error.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "../test_meshes.hpp"
#include "../test_model_kit.hpp"
#include "../test_relative.hpp"
#include "base/mpi.hpp"
#include "record/discretisation_error.hpp"
#include "record/validity.hpp"

namespace test_recovery_error {

using namespace voile;
using namespace voile::testing;
using energy::RecoveryError;

namespace {

/// A tensor in the plane of the unit square at x.
using TensorField = std::function<Mat2(const Vec2&)>;

struct Stressed {
  std::vector<double> membrane, bending;  ///< e_N, e_M of each triangle
  [[nodiscard]] double largest() const {
    return std::max(*std::max_element(membrane.begin(), membrane.end()),
                    *std::max_element(bending.begin(), bending.end()));
  }
};

/// A piece of the mesh in a chart of its own.
struct Cut {
  double from = 2.0;  ///< triangles whose centroid lies beyond this x are in it
  Mat3 turn = Mat3::Identity();
  Vec3 shift = Vec3::Zero();
};

/// N = M = the field at the centroids, in the axes of each triangle.
Stressed stress(const mesh::MeshData& flat, const std::vector<energy::Material>& materials, const TensorField& field,
                energy::MembraneOperator membrane = energy::MembraneOperator::six_node, const Cut& cut = {}) {
  mesh::MeshData data = flat;
  const auto centre = [&](Index t) -> Vec3 {
    const mesh::Triangle& v = flat.triangles[static_cast<std::size_t>(t)];
    return (flat.positions[v[0]] + flat.positions[v[1]] + flat.positions[v[2]]) / 3.0;
  };
  const auto is_cut = [&](Index t) { return centre(t).x() > cut.from; };
  if (cut.from < 1.0)
    for (Index t = 0; t < static_cast<Index>(flat.triangles.size()); ++t) {
      data.rest.emplace_back();
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 x = flat.positions[flat.triangles[static_cast<std::size_t>(t)][i]];
        data.rest.back()[i] = is_cut(t) ? Vec3(cut.turn * x + cut.shift) : x;
      }
    }
  const mesh::SurfaceMesh mesh(data);
  const mesh::PatchMesh patches(mesh, {});
  energy::ElementOptions options;
  options.membrane = membrane;
  const energy::Sheet sheet(patches, materials, energy::assign_materials(mesh, materials), options);
  std::vector<double> values;
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const mesh::Frame frame = sheet.frame(t);
    const Mat3 back = is_cut(t) ? Mat3(cut.turn.transpose()) : Mat3(Mat3::Identity());
    const Vec2 e1 = (back * frame.e1).head<2>(), e2 = (back * frame.e2).head<2>();
    const Mat2 s = field(centre(t).head<2>());
    values.insert(values.end(), {e1.dot(s * e1), e2.dot(s * e2), e1.dot(s * e2)});
  }
  const RecoveryError error(sheet);
  Stressed result;
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const RecoveryError::Density d = error.of(t, values, values);
    result.membrane.push_back(d.membrane);
    result.bending.push_back(d.bending);
  }
  return result;
}

Mat2 tensor(double s11, double s22, double s12) {
  Mat2 s;
  s << s11, s12, s12, s22;
  return s;
}

Mat2 linear_field(const Vec2& x) {
  return tensor(1.0 + 2.0 * x[0] - x[1], 0.5 - x[0] + 3.0 * x[1], -0.7 + x[0] + x[1]);
}

Mat2 curved_field(const Vec2& x) {
  return tensor(std::sin(3.0 * x[0]), x[0] * x[1], std::cos(2.0 * x[1]));
}

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double d = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) d = std::max(d, std::abs(a[i] - b[i]));
  return d;
}

}  // namespace

TEST_CASE("constant resultants have no error, linear ones that of a constant moment in each triangle") {
  const std::vector<energy::Material> materials{isotropic(1e3, 0.3, 0.1)};
  const Mat3 compliance = materials[0].bending.inverse();
  for (const Pattern p : {Pattern::diagonal, Pattern::union_jack, Pattern::jittered, Pattern::split}) {
    CAPTURE(name_of(p));
    const mesh::MeshData data = square(p, 6);
    const Mat2 constant = tensor(1.0, -2.0, 0.5);
    CHECK(stress(data, materials, [&](const Vec2&) { return constant; }).largest() < 1e-9);
    const Stressed s = stress(data, materials, linear_field);
    CHECK(*std::max_element(s.membrane.begin(), s.membrane.end()) < 1e-9);
    // Differences along x and y, whatever the axes: N_,x = (2, -1, 1), N_,y = (-1, 3, 1).
    const Vec3 along_x(2, -1, 1), along_y(-1, 3, 1);
    for (std::size_t t = 0; t < s.bending.size(); ++t) {
      Mat2 spread = Mat2::Zero();
      const mesh::Triangle& v = data.triangles[t];
      const Vec3 c = (data.positions[v[0]] + data.positions[v[1]] + data.positions[v[2]]) / 3.0;
      for (const Index i : v) {
        const Vec2 d = (data.positions[i] - c).head<2>();
        spread += d * d.transpose() / 12.0;
      }
      const double expected = 0.5 * (spread(0, 0) * along_x.dot(compliance * along_x) +
                                     2.0 * spread(0, 1) * along_x.dot(compliance * along_y) +
                                     spread(1, 1) * along_y.dot(compliance * along_y));
      CHECK(s.bending[t] == relative(expected).epsilon(1e-4));
    }
    // The plain triangle's strain is constant as well.
    const Stressed plain = stress(data, materials, linear_field, energy::MembraneOperator::cst);
    const double ratio = materials[0].bending(0, 0) / materials[0].membrane(0, 0);
    for (std::size_t t = 0; t < s.bending.size(); ++t)
      CHECK(plain.membrane[t] == relative(ratio * plain.bending[t]).epsilon(1e-6));
  }
}

TEST_CASE("charts turned at random have the errors of the whole sheet") {
  const std::vector<energy::Material> materials{isotropic(1e3, 0.3, 0.1)};
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const mesh::MeshData data = square(Pattern::jittered, 7);
  const Stressed whole = stress(data, materials, curved_field);
  CHECK(whole.largest() > 1e-6);
  for (int i = 0; i < 4; ++i) {
    const Vec3 axis = Vec3(any(random), any(random), any(random)).normalized();
    const Cut cut{0.5, Eigen::AngleAxisd(3.0 * any(random), axis).toRotationMatrix(), Vec3(4.0, any(random), 1.0)};
    const Stressed charts = stress(data, materials, curved_field, energy::MembraneOperator::six_node, cut);
    CHECK(difference(whole.membrane, charts.membrane) < 1e-9 * whole.largest());
    CHECK(difference(whole.bending, charts.bending) < 1e-9 * whole.largest());
  }
  // A material with a direction turns with its panel: stresses jump at the seam, and are not fitted across it.
  std::vector<energy::Material> woven = materials;
  woven[0].direction = Vec3::UnitX();
  const Mat3 quarter = Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitZ()).toRotationMatrix();
  const auto jump = [](const Vec2& x) { return tensor(x[0] > 0.5 ? 1.0 : 3.0, 0.0, 0.0); };
  const mesh::MeshData even = square(Pattern::diagonal, 8);
  const Cut cut{0.5, quarter, Vec3(4, 0, 0)};
  CHECK(stress(even, woven, jump, energy::MembraneOperator::six_node, cut).largest() < 1e-9);
  CHECK(stress(even, materials, jump, energy::MembraneOperator::six_node, cut).largest() > 1e-3);
}

TEST_CASE("resultants may jump where another material begins and at creases") {
  const auto jump = [](const Vec2& x) { return tensor(x[0] > 0.5 ? 1.0 : 3.0, 1.0, 0.0); };
  mesh::MeshData data = square(Pattern::diagonal, 8);
  std::vector<energy::Material> materials{isotropic(1e3, 0.3, 0.1)};
  CHECK(stress(data, materials, jump).largest() > 1e-3);
  mesh::Group left{"left half", 2, {}, {}, {}}, right{"right half", 2, {}, {}, {}};
  for (Index t = 0; t < static_cast<Index>(data.triangles.size()); ++t) {
    const mesh::Triangle& v = data.triangles[static_cast<std::size_t>(t)];
    const double x = (data.positions[v[0]] + data.positions[v[1]] + data.positions[v[2]]).x() / 3.0;
    (x > 0.5 ? right : left).triangles.push_back(t);
  }
  mesh::MeshData halves = data;
  halves.groups.push_back(left);
  halves.groups.push_back(right);
  materials.push_back(isotropic(1e3, 0.3, 0.1));
  materials[0].groups = {"left half"};
  materials[1].groups = {"right half"};
  CHECK(stress(halves, materials, jump).largest() < 1e-9);
  // A roof with a ridge, flat on both sides: axis 1 goes down the slopes.
  mesh::MeshData roof = mapped(data, [](const Vec3& x) { return Vec3(x[0], x[1], -2.0 * std::abs(x[0] - 0.5)); });
  const mesh::SurfaceMesh mesh(roof);
  const mesh::PatchMesh patches(mesh, {});
  for (const double angle : {1.0, 3.0}) {
    energy::ElementOptions options;
    options.crease_angle = angle;  // the ridge folds by 127 degrees
    const std::vector<energy::Material> one{isotropic(1e3, 0.3, 0.1)};
    const energy::Sheet sheet(patches, one, energy::assign_materials(mesh, one), options);
    std::vector<double> values;
    for (Index t = 0; t < mesh.triangle_count(); ++t) {
      const double x = (mesh.start_corner(t, 0) + mesh.start_corner(t, 1) + mesh.start_corner(t, 2)).x() / 3.0;
      values.insert(values.end(), {x > 0.5 ? 1.0 : 3.0, 1.0, 0.0});
    }
    const RecoveryError error(sheet);
    double largest = 0.0;
    for (Index t = 0; t < mesh.triangle_count(); ++t) largest = std::max(largest, error.of(t, values, values).bending);
    CAPTURE(angle);
    CHECK((angle < 2.0 ? largest < 1e-9 : largest > 1e-3));
  }
}

TEST_CASE("stresses may jump where the temperature may") {
  const mesh::SurfaceMesh mesh(square(Pattern::diagonal, 6));
  const mesh::PatchMesh patches(mesh, {});
  const std::vector<energy::Material> one{isotropic(1e3, 0.3, 0.1)};
  std::vector<int> zones;
  std::vector<double> values;
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const double x = (mesh.start_corner(t, 0) + mesh.start_corner(t, 1) + mesh.start_corner(t, 2)).x() / 3.0;
    zones.push_back(x > 0.5 ? 1 : 0);
    values.insert(values.end(), {x > 0.5 ? 1.0 : 3.0, 1.0, 0.0});
  }
  for (const bool heated : {true, false}) {
    CAPTURE(heated);
    const energy::Sheet sheet(patches, one, energy::assign_materials(mesh, one), {}, {},
                              heated ? zones : std::vector<int>{});
    const RecoveryError error(sheet);
    double largest = 0.0;
    for (Index t = 0; t < mesh.triangle_count(); ++t) largest = std::max(largest, error.of(t, values, values).bending);
    CHECK((heated ? largest < 1e-9 : largest > 1e-3));
  }
}

TEST_CASE("a constant state of a cylinder has no error") {
  const mesh::SurfaceMesh mesh(mapped(square(Pattern::diagonal, 6), [](const Vec3& x) {
    return Vec3(std::sin(1.5 * x[0]), x[1], std::cos(1.5 * x[0]));
  }));
  const mesh::PatchMesh patches(mesh, {});
  std::vector<energy::Material> materials{isotropic(1e3, 0.3, 0.1)};
  materials[0].direction = Vec3::UnitY();
  const energy::Sheet sheet(patches, materials, energy::assign_materials(mesh, materials), {});
  std::vector<double> values;
  for (Index t = 0; t < mesh.triangle_count(); ++t) values.insert(values.end(), {1.0, 2.0, 3.0});
  const RecoveryError error(sheet);
  for (Index t = 0; t < mesh.triangle_count(); ++t) CHECK(error.of(t, values, values).bending < 1e-9);
}

namespace {

struct Estimate {
  double fraction = 0.0;
  std::string warning;
  double apart = 0.0;    ///< largest difference between what all ranks and one have found
  std::size_t size = 0;  ///< of the fields
};

/// Of a sheet that is displaced by u.
Estimate estimate(Pattern pattern, int n, const std::function<Vec3(const Vec3&)>& u, bool linear) {
  const mesh::SurfaceMesh mesh(square(pattern, n));
  system::ModelInput input;
  input.materials = {isotropic(1e6, 0.3, 1e-2, 1.0)};
  for (const char* side : {"left", "right", "bottom", "top"})
    input.supports.push_back(support(side, system::Support::Kind::hinged));
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  petsc::VecHandle a = model.dofs().create_vector();
  set_displacement(model, a, [&](Index v) { return u(mesh.positions()[v]); });
  const system::TriangleFields fields = model.triangle_fields(a);
  record::DiscretisationError error;
  const record::DiscretisationError::Densities d = error.judged(model, fields, {"", linear ? 0.0 : record::no_strain});
  Estimate e{error.last().whole, error.warning(), 0.0, d.bending.size()};
  if (mpi::rank(PETSC_COMM_WORLD) != 0) return e;
  const RecoveryError alone(model.discretisation().sheet());
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const RecoveryError::Density one = alone.of(t, fields.membrane_force, fields.bending_moment);
    const auto at = static_cast<std::size_t>(t);
    e.apart = std::max({e.apart, std::abs(one.membrane - d.membrane[at]), std::abs(one.bending - d.bending[at])});
  }
  return e;
}

/// Small against the thickness: bending alone.
Vec3 wave(const Vec3& x) {
  return {0, 0, 1e-7 * std::sin(std::numbers::pi * x[0]) * std::sin(std::numbers::pi * x[1])};
}

}  // namespace

TEST_CASE(
    "the estimate of a smooth bent state goes with the square of the cells and is the same on any number of ranks") {
  for (const Pattern p : {Pattern::diagonal, Pattern::union_jack, Pattern::jittered}) {
    CAPTURE(name_of(p));
    const Estimate coarse = estimate(p, 8, wave, true), fine = estimate(p, 16, wave, true);
    if (mpi::rank(PETSC_COMM_WORLD) != 0) continue;
    CHECK(coarse.size == 128);
    CHECK(coarse.apart == 0.0);
    CHECK(coarse.fraction / fine.fraction > 3.2);
    CHECK(coarse.fraction / fine.fraction < 4.8);
    // A constant curvature in each triangle leaves this fraction of the energy of the wave, right angles of 1/8: sum of k_,a J k_,b.
    const double exact = 2.0 * std::pow(std::numbers::pi / 8.0, 2) / 18.0;
    CHECK(coarse.fraction > 0.5 * exact);
    CHECK(coarse.fraction < 5.0 * exact);
  }
}

TEST_CASE("what cells do not resolve is told with its cause, place and remedy, and nothing is said of round-off") {
  const auto bump = [](const Vec3& x) {
    const double r = (x - Vec3(0.75, 0.25, 0.0)).norm();
    return Vec3(0, 0, 1e-4 * std::exp(-40.0 * r * r));
  };
  const Estimate coarse = estimate(Pattern::diagonal, 8, bump, false),
                 fine = estimate(Pattern::diagonal, 40, bump, false),
                 still = estimate(
                     Pattern::jittered, 8, [](const Vec3&x) { return 1e-13 * x.norm() * Vec3::Ones(); }, false);
  if (mpi::rank(PETSC_COMM_WORLD) != 0) return;
  CHECK(coarse.fraction > record::error_limit);
  CHECK(coarse.warning.find("bending moments") != std::string::npos);
  const auto open = coarse.warning.find("near (");
  REQUIRE(open != std::string::npos);
  const double x = std::stod(coarse.warning.substr(open + 6)),
               y = std::stod(coarse.warning.substr(coarse.warning.find(", ", open) + 2));
  CHECK(std::hypot(x - 0.75, y - 0.25) < 0.25);
  CHECK(fine.fraction < record::error_limit);
  CHECK(fine.warning.empty());
  CHECK(still.fraction == 0.0);
}

}  // namespace test_recovery_error
