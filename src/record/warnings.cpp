#include "warnings.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "dimples.hpp"
#include "discretisation_error.hpp"

namespace voile::record {

namespace {

std::string place_text(const mesh::SurfaceMesh& mesh, const Vec3& x) {
  return fmt::format("({:.4g}, {:.4g}, {:.4g}) m at {}", x[0], x[1], x[2], mesh.has_charts() ? "the start" : "rest");
}

/// Beyond the end of a curve by less than this part is at its end.
constexpr double round_off = 1e-6;

/// What a strain is, in words, and a size of it.
std::string strain_text(Reach::Of of) {
  if (of == Reach::Of::principal) return "a membrane strain";
  return of == Reach::Of::shear  ? "a shear"
         : of == Reach::Of::warp ? "a strain along the warp"
                                 : "a strain along the weft";
}

/// Curves are of extensions, laws of Green's strain.
std::string size_text(Reach::Of of, double strain, bool measured) {
  const double size = measured ? std::sqrt(std::max(0.0, 1.0 + 2.0 * strain)) - 1.0 : strain;
  if (of != Reach::Of::shear) return fmt::format("{:.2g} %", 100.0 * size);
  return fmt::format("{:.2g} degrees", std::asin(std::clamp(strain, -1.0, 1.0)) * 180.0 / std::numbers::pi);
}

}  // namespace

// Results beyond go on, but the law no longer holds.
void Warnings::say_strain(const mesh::SurfaceMesh& mesh, const Reach& reach, Index triangle) {
  if (!(reach.ratio() > 1.0 + round_off) || std::exchange(said_strain_, true)) return;
  const Vec3 x =
      (mesh.start_corner(triangle, 0) + mesh.start_corner(triangle, 1) + mesh.start_corner(triangle, 2)) / 3.0;
  const std::string why =
      reach.measured
          ? "there its measured curve has ended, at {}, and goes on straight; measure it further, or check loads"
          : "the law is linear in the strain and meant for less than {}";
  fmt::print(stderr, "voile: warning: {} of {} at {}: {} (history: largest_strain)\n", strain_text(reach.of),
             size_text(reach.of, reach.strain, reach.measured), place_text(mesh, x),
             fmt::format(fmt::runtime(why), size_text(reach.of, reach.limit, reach.measured)));
}

void Warnings::say_dimples(const input::Case& c, const energy::Sheet& sheet, const std::vector<double>& displacement,
                           double load_factor) {
  if (said_dimples_) return;
  const std::string text = dimple_warning(c, sheet, displacement, load_factor);
  said_dimples_ = !text.empty();
  if (said_dimples_) fmt::print(stderr, "voile: warning: {}\n", text);
}

void Warnings::say_linear_range(const energy::Sheet& sheet, const std::vector<double>& strain) {
  Reach most;
  Index at = no_index;
  for (Index t = 0; t < sheet.mesh().triangle_count(); ++t) {
    const Vec3 e = Eigen::Map<const Vec3>(&strain[3 * static_cast<std::size_t>(t)]);
    const Reach reach = reach_of(sheet.material(t), e);
    if (reach.ratio() <= most.ratio()) continue;
    most = reach;
    at = t;
  }
  if (at != no_index) say_strain(sheet.mesh(), most, at);
}

void Warnings::say_range(const mesh::SurfaceMesh& mesh, const Validity& v) {
  if (linear_) return;
  if (v.triangle != no_index) say_strain(mesh, v.reach, v.triangle);
  if (v.turn > turn_limit && !std::exchange(said_turn_, true))
    fmt::print(stderr,
               "voile: warning: the surface turns by {:.0f} degrees across one edge at {}: bending is too soft beyond "
               "{:.0f} degrees; a finer mesh there is needed (history: largest_turn)\n",
               v.turn * 180.0 / std::numbers::pi,
               place_text(mesh, 0.5 * (mesh.positions()[v.vertex_a] + mesh.positions()[v.vertex_b])),
               turn_limit * 180.0 / std::numbers::pi);
}

Warnings::MembraneError Warnings::membrane_error(const energy::Sheet& sheet, const system::TriangleFields& t,
                                                 double strain) {
  if (!chord_error_) {
    chord_error_.emplace(sheet);
    const std::string locks = locking_warning(sheet, t);
    if (!locks.empty() && !std::exchange(said_locking_, true)) fmt::print(stderr, "voile: warning: {}\n", locks);
  }
  std::vector<double> error = chord_error_->energies(sheet, t.curvature, t.whole_curvature, linear_);
  // Chords that are corrected leave little: what remains is bending that is none.
  const bool corrected = sheet.options().membrane == energy::MembraneOperator::six_node_corrected;
  for (std::size_t k = 0; corrected && k < error.size(); ++k) error[k] += t.in_plane[k];
  double spurious = 0.0;
  for (std::size_t k = 0; k < error.size(); ++k) spurious += sheet.mesh().area(static_cast<Index>(k)) * error[k];
  const double stored = judged_energy(sheet, t).whole;
  const double fraction = stored > round_off_energy(sheet, strain) ? spurious / stored : 0.0;
  if (search_ || fraction > largest_error_) {
    largest_error_ = fraction;
    is_corrected_ = corrected;
  }
  return {std::move(error), largest_error_};
}

std::string Warnings::membrane_text() const {
  if (!(largest_error_ > error_limit)) return "";
  // Under given loads deflections are too small by the fraction f of the energy. Straight chords stiffen a sheet that stretches where
  // it may, which then stores more: f/(1 + f).
  const double error = is_corrected_ ? largest_error_ : largest_error_ / (1.0 + largest_error_);
  return fmt::format(
      "{} {} of the stored energy: deflections may be too small by {}; use a finer mesh, or "
      "cells that are less stretched and uneven{} (summary.json: membrane_error; field membrane_error)",
      is_corrected_ ? "second derivatives within the surface, and what the correction of chords leaves, take"
                    : "spurious membrane strains of straight chords between vertices take",
      up_to_text(largest_error_), up_to_text(error),
      is_corrected_ ? "; where thick strips bend in their plane, element.type = \"angles\"" : "");
}

}  // namespace voile::record
