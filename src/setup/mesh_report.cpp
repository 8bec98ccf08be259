#include "mesh_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "base/petsc.hpp"
#include "energy/angle_bending.hpp"
#include "energy/chord_correction.hpp"
#include "energy/curvature.hpp"
#include "energy/sheet.hpp"
#include "geometry/hanging_vertices.hpp"
#include "geometry/tie_crossing.hpp"
#include "mesh/border.hpp"
#include "mesh/coincident.hpp"
#include "mesh/panels.hpp"
#include "mesh/quality.hpp"

namespace voile::setup {

namespace {

/// Below this smallest angle [degree] a triangle can keep Newton from converging.
constexpr double sliver_angle = 2.0;
/// Cells as long as this lock if their neighbours are as uneven as this, and cells as long as the last even if all are
/// equal: a strip bent into three quarters of a circle of 20 x 16 cells of aspect 8, vertices moved by a quarter of a
/// cell, deflects by 5.6 % too little, with equal cells 0.9 %, with equal cells of aspect 20 5.7 %.
constexpr double long_cell = 5.0, uneven_cell = 0.15, very_long_cell = 14.0;
/// Fraction of the area in such cells that makes a warning.
constexpr double locking_fraction = 0.1;
/// Fraction of patches that are too ill-conditioned for their quadratic that makes a warning, if half of them are by far.
constexpr double fitted_fraction = 0.5;

/// Mean of MeshQuality::fold that makes a warning. L profiles of legs of 1 and length 3: cells three times as long as wide, 8, 16, 32,
/// 64 to a leg, have 28, 14, 7, 3.5 % and a first frequency 14, 7.6, 3.8, 1.8 % too high; 8 square ones 3.1 and 1.9 %.
constexpr double folded_limit = 0.02;

double quantile(std::vector<double> values, double q) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// "triangle 12 at (x, y, z)"
std::string triangle_text(const mesh::SurfaceMesh& mesh, std::size_t t) {
  return fmt::format("triangle {} at {}", mesh.data().triangle_tags[t],
                     place_text(mesh::centroid(mesh, static_cast<Index>(t))));
}

std::size_t place_of_smallest(const std::vector<double>& values) {
  return static_cast<std::size_t>(std::min_element(values.begin(), values.end()) - values.begin());
}

std::size_t place_of_largest(const std::vector<double>& values) {
  return static_cast<std::size_t>(std::max_element(values.begin(), values.end()) - values.begin());
}

double fraction_above(const std::vector<double>& values, double limit) {
  const auto count = std::count_if(values.begin(), values.end(), [&](double x) { return !(x <= limit); });
  return static_cast<double>(count) / static_cast<double>(values.size());
}

/// Fraction of the area in cells whose nonlinear membrane locks.
double fraction_of_locking(const MeshQuality& q) {
  double locking = 0.0, all = 0.0;
  for (std::size_t t = 0; t < q.area.size(); ++t) {
    all += q.area[t];
    if (q.aspect[t] > very_long_cell || (q.aspect[t] > long_cell && q.unevenness[t] > uneven_cell))
      locking += q.area[t];
  }
  return locking / all;
}

/// Interior vertices of valence 4 and 8 in large numbers mark a union-jack pattern, on which `six_node` is wrong.
double union_jack_fraction(const mesh::SurfaceMesh& mesh) {
  Index suspicious = 0, interior = 0;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    const std::vector<Index> around = mesh.triangles_of_vertex(v);
    const bool inside = std::all_of(around.begin(), around.end(), [&](Index t) {
      for (int s = 0; s < 3; ++s)
        if (mesh.neighbour(t, s) == no_index && mesh.triangles()[t][s] != v) return false;
      return true;
    });
    if (!inside) continue;
    ++interior;
    suspicious += around.size() == 4 || around.size() == 8 ? 1 : 0;
  }
  return interior ? static_cast<double>(suspicious) / interior : 0.0;
}

/// What long cells do to large rotations; the numbers are of runs/element_study/membranes.md, cells of aspect 8 to 19.
const char* long_cell_error(energy::MembraneOperator membrane) {
  return membrane == energy::MembraneOperator::six_node_corrected
             ? "the corrected membrane does not lock there, but in large rotations bending is too stiff, and "
               "deflections can be too small by 4 to 10 %; element.type = \"angles\" errs less"
             : "the membrane can lock there in large rotations, and deflections then are too small by several percent "
               "without any other sign, the more the thinner the sheet is; element.type = \"corrected\", the default, "
               "errs less on uneven cells";
}

energy::Material unit_material() {
  energy::Material unit;
  unit.membrane = energy::isotropic_membrane(1.0, 0.3, 1.0);
  unit.bending = energy::bending_from_membrane(unit.membrane, 1.0);
  return unit;
}

}  // namespace

std::string place_text(const Vec3& x) {
  const double scale = 1e-12 * x.cwiseAbs().maxCoeff();
  const auto tidy = [&](double c) { return std::abs(c) <= scale ? 0.0 : c; };
  return fmt::format("({:.4g}, {:.4g}, {:.4g})", tidy(x[0]), tidy(x[1]), tidy(x[2]));
}

bool is_nonlinear(const input::Case& c) {
  const auto one = [](const input::Case& stage) {
    return stage.analysis != input::Analysis::linear && !stage.finds_modes();
  };
  return c.stages.empty() ? one(c) : std::any_of(c.stages.begin(), c.stages.end(), one);
}

MeshQuality measure_quality(MPI_Comm comm, const mesh::SurfaceMesh& mesh, const energy::ElementOptions& element) {
  const auto n = static_cast<std::size_t>(mesh.triangle_count());
  MeshQuality q;
  const auto lists = {&q.angle, &q.aspect, &q.unevenness, &q.condition, &q.area, &q.fold};
  for (std::vector<double>* values : lists) values->assign(n, 0.0);
  mpi::on_all(comm, [&] {
    const std::vector<energy::Material> materials{unit_material()};
    const mesh::PatchMesh patches(mesh, {});
    const energy::Sheet sheet(patches, materials, energy::assign_materials(mesh, materials), element);
    energy::CurvatureBuilder builder(sheet);
    const auto rank = static_cast<std::size_t>(mpi::rank(comm)), ranks = static_cast<std::size_t>(mpi::size(comm));
    for (std::size_t t = n * rank / ranks; t < n * (rank + 1) / ranks; ++t) {
      const mesh::TriangleShape shape = mesh::shape_of(mesh, static_cast<Index>(t));
      q.angle[t] = shape.smallest_angle * (180.0 / std::numbers::pi);
      q.aspect[t] = shape.aspect;
      q.unevenness[t] = shape.unevenness;
      q.condition[t] = builder.patch_condition(static_cast<Index>(t));
      q.area[t] = mesh.area(static_cast<Index>(t));
      for (int s = 0; s < 3 && !energy::bends_by_angles(sheet, static_cast<Index>(t)); ++s) {
        if (!sheet.is_crease(static_cast<Index>(t), s)) continue;
        const double side = (mesh.rest_corner(static_cast<Index>(t), (s + 1) % 3) -
                             mesh.rest_corner(static_cast<Index>(t), (s + 2) % 3))
                                .norm(),
                     half = 0.5 * patches.rest_dihedral(static_cast<Index>(t), s);
        q.fold[t] += std::pow(std::sin(half) * side * side / (2.0 * q.area[t]), 2);
      }
    }
  });
  for (std::vector<double>* values : lists) mpi::sum_to_root(comm, *values);
  return q;
}

std::string quality_text(const mesh::SurfaceMesh& mesh, const MeshQuality& q, const energy::ElementOptions& element) {
  const std::size_t angle = place_of_smallest(q.angle), aspect = place_of_largest(q.aspect),
                    condition = place_of_largest(q.condition);
  const double least = q.angle[angle], longest = quantile(q.aspect, 0.5), locking = fraction_of_locking(q);
  const char* verdict = !quality_warnings(mesh, q, element).empty()             ? "poor"
                        : least < 10.0 || longest > long_cell || locking > 0.01 ? "fair"
                                                                                : "good";
  std::string text = fmt::format("mesh quality: {}\n", verdict);
  text += fmt::format("  smallest angle of a triangle: {:.2f} deg at worst ({}), {:.1f} deg median\n", least,
                      triangle_text(mesh, angle), quantile(q.angle, 0.5));
  text += fmt::format("  aspect (longest side over height): {:.3g} at worst ({}), {:.3g} median\n", q.aspect[aspect],
                      triangle_text(mesh, aspect), longest);
  text += fmt::format(
      "  patch condition: {:.3g} median, {:.3g} at 99 %, {:.3g} at worst ({}); {:.3g} % of the patches above {:g}\n",
      quantile(q.condition, 0.5), quantile(q.condition, 0.99), q.condition[condition], triangle_text(mesh, condition),
      100.0 * fraction_above(q.condition, element.max_patch_condition), element.max_patch_condition);
  return text;
}

std::vector<std::string> quality_warnings(const mesh::SurfaceMesh& mesh, const MeshQuality& q,
                                          const energy::ElementOptions& element) {
  std::vector<std::string> warnings;
  const auto slivers = std::count_if(q.angle.begin(), q.angle.end(), [](double a) { return a < sliver_angle; });
  const std::size_t worst = place_of_smallest(q.angle);
  if (slivers > 0)
    warnings.push_back(fmt::format(
        "{} triangle(s) have an angle below {:g} degrees, the smallest is {:.2g} degrees in {}: Newton's method "
        "may stall there; move its vertices or remesh",
        slivers, sliver_angle, q.angle[worst], triangle_text(mesh, worst)));
  if (const double fraction = fraction_of_locking(q); q.large_rotations && fraction > locking_fraction)
    warnings.push_back(
        fmt::format("{:.0f} % of the area lies in long cells (median aspect {:.3g}, median smallest angle {:.1f} "
                    "degrees) that are uneven or longer than {:g} times their width: {}; make cells about as long as "
                    "wide, or refine along their long side",
                    100.0 * fraction, quantile(q.aspect, 0.5), quantile(q.angle, 0.5), very_long_cell,
                    long_cell_error(element.membrane)));
  if (const double fraction = fraction_above(q.condition, element.max_patch_condition);
      fraction > fitted_fraction && quantile(q.condition, 0.5) > 2.0 * element.max_patch_condition)
    warnings.push_back(fmt::format(
        "{:.0f} % of the patches have a condition above {:g} and are replaced by fits over more neighbours, which "
        "cost time and accuracy, the worst ({:.3g}) is that of {}; make neighbouring triangles more alike",
        100.0 * fraction, element.max_patch_condition, q.condition[place_of_largest(q.condition)],
        triangle_text(mesh, place_of_largest(q.condition))));
  if (element.bending == energy::BendingOperator::six_node)
    if (const double fraction = union_jack_fraction(mesh); fraction > 0.5)
      warnings.push_back(
          fmt::format("{:.0f} % of the interior vertices have valence 4 or 8 (alternating diagonals): the published "
                      "elements do not converge on such a mesh; use element.type = \"corrected\"",
                      100.0 * fraction));
  return warnings;
}

std::string unit_warning(const input::Case& c, const mesh::SurfaceMesh& mesh) {
  // No cloth has cells of a thousand thicknesses and measures tens of metres.
  constexpr double large = 20.0, thin = 1500.0;
  if (!input::UnitSystem(c.units).is_si() || c.mesh.options.scale != 1.0 || !c.panels.empty()) return "";
  Vec3 low = mesh.positions()[0], high = low;
  for (Index i = 0; i < mesh.vertex_count(); ++i) {
    low = low.cwiseMin(mesh.positions()[i]);
    high = high.cwiseMax(mesh.positions()[i]);
  }
  double area = 0.0, thickness = 0.0;
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    area +=
        0.5 *
        (mesh.rest_corner(t, 1) - mesh.rest_corner(t, 0)).cross(mesh.rest_corner(t, 2) - mesh.rest_corner(t, 0)).norm();
  const double cell = std::sqrt(2.0 * area / mesh.triangle_count()), size = (high - low).norm();
  for (const energy::Material& m : c.materials)
    if (m.membrane(0, 0) > 0.0) thickness = std::max(thickness, std::sqrt(12.0 * m.bending(0, 0) / m.membrane(0, 0)));
  if (size < large || cell < thin * thickness) return "";
  return fmt::format(
      "the sheet measures {:.3g} m and is {:.2g} m thick, with cells of {:.2g} m: if the mesh is in millimetres, give "
      "[mesh] scale = 0.001, or [units] length = \"mm\" for a case in millimetres throughout",
      size, thickness, cell);
}

std::string fold_warning(const mesh::SurfaceMesh& mesh, const MeshQuality& q, const energy::ElementOptions& element) {
  double all = 0.0, stiffer = 0.0;
  for (std::size_t t = 0; t < q.area.size(); ++t) {
    all += q.area[t];
    stiffer += q.fold[t] * q.area[t];
  }
  const double fraction = stiffer / all;
  if (fraction <= folded_limit) return "";
  return fmt::format(
      "the sheet is folded at rest, most in {}: beside such edges what one side moves in its plane counts as bending. "
      "Deflections can be too small by about {:.0f} % and frequencies too high by about {:.0f} %; use {}"
      "cells along these edges that are smaller, and as wide as long",
      triangle_text(mesh, place_of_largest(q.fold)), 100.0 * fraction / (1.0 + fraction),
      100.0 * (std::sqrt(1.0 + fraction) - 1.0),
      element.membrane == energy::MembraneOperator::six_node_corrected ? "" : "element.type = \"corrected\", or ");
}

namespace {

/// What the joints of sheets are; empty if there are none.
std::string joint_note(const mesh::SurfaceMesh& mesh) {
  if (mesh.joints().empty()) return "";
  std::map<Index, int> sides;
  std::ptrdiff_t hinges = 0, others = 0;
  for (const mesh::Joint& j : mesh.joints()) {
    if (mesh::is_clamped_border(mesh, j)) continue;
    const bool is_hinge = std::binary_search(mesh.data().hinges.begin(), mesh.data().hinges.end(), j.edge);
    ++(is_hinge ? hinges : others);
    for (const mesh::TriangleSide& s : j.sides) ++sides[s.triangle];
  }
  const auto between = std::count_if(sides.begin(), sides.end(), [](const auto& entry) { return entry.second > 1; });
  const auto edges = [](auto n) { return fmt::format("{} {}", n, n == 1 ? "edge" : "edges"); };
  std::string text = hinges > 0 ? fmt::format("[[hinge]] parts the sheet at {}", edges(hinges)) : "";
  if (others > 0)
    text += fmt::format("{}sheets are joined at {} of three or more triangles, or of two that cannot be oriented alike",
                        text.empty() ? "" : "; ", edges(others));
  if (between > 0)
    text += fmt::format("; {} triangles have two sides there, where two cells between joints bend better", between);
  return text;
}

}  // namespace

std::vector<std::string> mesh_notes(const mesh::SurfaceMesh& mesh, Crossings crossings) {
  std::vector<std::string> notes = mesh.data().notes;
  if (const std::string text = joint_note(mesh); !text.empty()) notes.push_back(text);
  for (std::string& text : mesh::seam_notes(mesh)) notes.push_back(std::move(text));
  const double tolerance = mesh::default_merge_tolerance(mesh.data());
  const mesh::Coincidence c = mesh::find_coincident(mesh.data(), tolerance);
  if (c.joints > 0 && mesh.data().seams.empty())
    notes.push_back(fmt::format(
        "{} vertices on the rim of a part lie at inner vertices of another (within {:.2g} m), as near {}: a T "
        "joint, or a smaller layer; they are not joined; if they should be, set mesh.merge = true",
        c.joints, tolerance, place_text(c.joint)));
  else if (c.places > 0 && mesh.data().seams.empty())
    notes.push_back(fmt::format(
        "{} vertices lie at {} places where others lie too (within {:.2g} m), from {} to {}: the surface is "
        "slit there; if that is not meant, {}",
        c.vertices, c.places, tolerance, place_text(c.low), place_text(c.high),
        mesh.has_charts() ? "place the panels apart, or sew them" : "set mesh.merge = true"));
  if (mesh.data().seams.empty() && !mesh.has_charts())
    if (const geometry::HangingVertices h = geometry::find_hanging(mesh.data(), tolerance); h.count > 0)
      notes.push_back(fmt::format(
          "{} vertices lie on edges or triangles of another part of the sheet, as near {}: it is not joined "
          "there; if it should be, set mesh.merge = true",
          h.count, place_text(h.place)));
  if (crossings == Crossings::noted && mesh.data().seams.empty() && !mesh.has_charts())
    if (const auto pairs = geometry::crossing_triangles(mesh.data(), tolerance); !pairs.empty())
      notes.push_back(
          fmt::format("{} pairs of triangles pass through each other, as near {}: nothing joins or stops them there; "
                      "if parts should be "
                      "joined, set mesh.merge = true, or give them [contact]",
                      pairs.size(), place_text(mesh.positions()[mesh.triangles()[pairs.front().first][0]])));
  return notes;
}

std::string uncorrected_text(long triangles) {
  if (triangles == 0) return "";
  return fmt::format(
      "{} triangle(s) stay as six_node has them, since the points around them determine no quadratic and more than {} "
      "would "
      "be needed instead: fans of many triangles; mesh them anew",
      triangles, energy::ChordCorrection::most);
}

long angle_triangles(const energy::Sheet& sheet) {
  long count = 0;
  for (Index t = 0; t < sheet.mesh().triangle_count(); ++t) count += energy::bends_by_angles(sheet, t) ? 1 : 0;
  return count;
}

std::vector<std::string> sheet_notes(const energy::Sheet& sheet) {
  std::vector<std::string> notes;
  if (sheet.continued_axes() > 0)
    notes.push_back(fmt::format(
        "{} triangle(s) that the direction of their material is (nearly) normal to, or that have no texture "
        "coordinates, take their material axis from their neighbours",
        sheet.continued_axes()));
  const long folded = sheet.options().bending == energy::BendingOperator::edge_slope ? angle_triangles(sheet) : 0;
  if (folded > 0)
    notes.push_back(fmt::format(
        "{} triangle(s) bend by angles at edges: the sheet is folded there at rest, or they lie beside a notch "
        "that is small for its thickness",
        folded));
  return notes;
}

}  // namespace voile::setup
