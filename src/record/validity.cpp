#include "validity.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "energy/chord_error.hpp"
#include "energy/natural_state.hpp"
#include "energy/sheet.hpp"
#include "mesh/patch.hpp"

namespace voile::record {

namespace {

/// E11, E22, 2 E12 of a triangle with edges a, b that were A, B at rest, in an orthonormal frame whose axis 1 is along A.
Vec3 green_strain(const Vec3& rest_a, const Vec3& rest_b, const Vec3& a, const Vec3& b) {
  const double length = rest_a.norm(), along = rest_b.dot(rest_a) / length;
  const double height = rest_a.cross(rest_b).norm() / length;
  if (!(length > 0.0 && height > 0.0)) return Vec3::Zero();
  const Vec3 f1 = a / length, f2 = (b - along * f1) / height;
  return {0.5 * (f1.squaredNorm() - 1.0), 0.5 * (f2.squaredNorm() - 1.0), f1.dot(f2)};
}

/// Larger of |E_1|, |E_2|.
double principal_size(const Vec3& e) {
  return std::abs(0.5 * (e[0] + e[1])) + std::hypot(0.5 * (e[0] - e[1]), 0.5 * e[2]);
}

/// Angle from rest_a to material axis 1 in the plane of both edges [rad].
double axis_angle(const Vec3& rest_a, const Vec3& rest_b, const Vec3& axis) {
  const Vec3 across = rest_a.cross(rest_b).cross(rest_a);
  return std::atan2(axis.dot(across) / across.norm(), axis.dot(rest_a) / rest_a.norm());
}

/// Signed angle about the common edge from one normal to the other.
double turn_about(const Vec3& edge, const Vec3& n, const Vec3& m) {
  return std::atan2(edge.normalized().dot(n.cross(m)), n.dot(m));
}

/// The same of the rest shape across side s of t: none across a seam.
double rest_turn(const mesh::SurfaceMesh& mesh, Index t, int s) {
  if (!mesh.chart_join(t, s).same_chart) return 0.0;
  return turn_about(mesh.rest_corner(t, (s + 2) % 3) - mesh.rest_corner(t, (s + 1) % 3), mesh.rest_normal(t),
                    mesh.rest_normal(mesh.neighbour(t, s)));
}

/// Strains in axes from which material axis 1 lies at `angle` [rad], in those of the material and from its natural state.
Vec3 own_strain(const energy::Material& material, const Vec3& e, double angle) {
  const Vec3 half(0.5, 0.5, 0.0);
  return energy::turned_strain(angle) * e - (energy::natural_state(material, 0.0, 0.0).metric(half) - half);
}

}  // namespace

Reach reach_of(const energy::Material& material, const Vec3& e) {
  const auto& knots = material.yarns.knots;
  Reach most{principal_size(e)};
  if (std::all_of(knots.begin(), knots.end(), [](const auto& k) { return k.empty(); })) return most;
  const Vec3 yarns = energy::yarn_axes(material.yarns) * e;
  most = {};
  for (const auto of : {Reach::Of::warp, Reach::Of::weft, Reach::Of::shear}) {
    const auto r = static_cast<std::size_t>(of) - 1;
    const bool shear = of == Reach::Of::shear;
    Reach here{yarns[static_cast<Eigen::Index>(r)], shear ? 2.0 * strain_limit : strain_limit, of};
    here.measured = !knots[r].empty() && knots[r].back().strain > 0.0 && (shear || here.strain > 0.0);
    if (here.measured) here.limit = knots[r].back().strain;
    if (here.ratio() > most.ratio()) most = here;
  }
  return most;
}

Validity assess(const system::Model& model, const std::vector<double>& displacement, bool linear) {
  const mesh::SurfaceMesh &mesh = model.dofs().mesh(), &sheet = model.discretisation().sheet().mesh(),
                          &before = model.discretisation().patches_before().mesh();
  const energy::Sheet& materials = model.discretisation().sheet();
  Validity v;
  // So small a part of a linear displacement that its square does not count.
  constexpr double of_cell = 1e-6;
  double largest = 0.0;
  for (const double u : displacement) largest = std::max(largest, std::abs(u));
  const double part = linear && largest > 0.0 ? of_cell * std::sqrt(model.discretisation().mean_area()) / largest : 1.0;
  const double fraction = model.potential().drawn_in();
  const auto rest = [&](Index t, int i) -> Vec3 {
    return (1.0 - fraction) * before.rest_corner(t, i) + fraction * sheet.rest_corner(t, i);
  };
  const auto now = [&](Index i) -> Vec3 {
    return mesh.positions()[i] + part * Eigen::Map<const Vec3>(displacement.data() + 3 * static_cast<std::size_t>(i));
  };
  const auto normal = [](const Vec3& a, const Vec3& b, const Vec3& c) -> Vec3 { return (b - a).cross(c - a); };
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const mesh::Triangle& i = mesh.triangles()[t];
    const Vec3 x0 = now(i[0]), x1 = now(i[1]), x2 = now(i[2]);
    const Vec3 corner = rest(t, 0);
    const Vec3 rest_a = rest(t, 1) - corner, rest_b = rest(t, 2) - corner,
               e = green_strain(rest_a, rest_b, x1 - x0, x2 - x0) / part;
    v.strain = std::max(v.strain, principal_size(e));
    const energy::Material& material = materials.material(t);
    const Vec3 elastic =
        material.yarns.any() ? own_strain(material, e, axis_angle(rest_a, rest_b, materials.frame(t).e1)) : e;
    const Reach reach = material.rubber.any() ? Reach{} : reach_of(material, elastic);
    if (reach.ratio() > v.reach.ratio()) {
      v.reach = reach;
      v.triangle = t;
    }
    const Vec3 n = normal(x0, x1, x2);
    for (int s = 0; s < 3; ++s) {
      const Index other = mesh.neighbour(t, s);
      if (other == no_index || other < t) continue;
      const mesh::Triangle& j = mesh.triangles()[other];
      const Index a = i[static_cast<std::size_t>((s + 1) % 3)], b = i[static_cast<std::size_t>((s + 2) % 3)];
      const double turn = std::remainder(
          turn_about(now(b) - now(a), n, normal(now(j[0]), now(j[1]), now(j[2]))) - rest_turn(mesh, t, s),
          2.0 * std::numbers::pi);
      if (std::abs(turn) / part <= v.turn) continue;
      v.turn = std::abs(turn) / part;
      v.vertex_a = a;
      v.vertex_b = b;
    }
  }
  return v;
}

std::string percent_text(double fraction) {
  constexpr double least = 1e-4;
  if (fraction > 0.0 && fraction < least) return "less than 0.01 %";
  return fraction > 1.0 ? "more than 100 %" : fmt::format("{:.2g} %", 100.0 * fraction);
}

std::string up_to_text(double fraction) {
  return (fraction > 1.0 ? "" : "up to ") + percent_text(fraction);
}

std::string locking_warning(const energy::Sheet& sheet, const system::TriangleFields& fields) {
  std::vector<double> rest = fields.whole_curvature;
  for (std::size_t i = 0; i < rest.size(); ++i) rest[i] -= fields.curvature[i];
  const double fraction = energy::locking_estimate(sheet, rest);
  if (fraction <= error_limit) return "";
  return fmt::format(
      "the mesh is too coarse for a curved shell this thin: where it bends without stretching, deflections can be too "
      "small by about {}; use a finer mesh",
      percent_text(fraction));
}

}  // namespace voile::record
