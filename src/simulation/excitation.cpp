#include "excitation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "system/rigid_motions.hpp"
#include "voile/errors.hpp"

namespace voile::simulation {

namespace {

using Section = input::HarmonicSection;

/// Whether a symmetry support holds what moves along a direction: half of a body cannot shake through its mirror plane.
bool mirror_is_crossed(const input::Case& c, const system::Model& model,
                       const std::function<bool(const Vec3&)>& along) {
  const auto& held = model.discretisation().constraints().vertices;
  for (const system::Support& support : c.supports) {
    if (support.kind != system::Support::Kind::symmetry) continue;
    for (const Index v : model.dofs().mesh().group(support.group).vertices) {
      const system::VertexSupport& s = held.at(v);
      if (std::count(s.fixed.begin(), s.fixed.end(), true) != 1) continue;  // others hold it too
      for (int k = 0; k < 3; ++k)
        if (s.fixed[static_cast<std::size_t>(k)] && along(s.axes.col(k))) return true;
    }
  }
  return false;
}

}  // namespace

/// Of a base that moves, displacements are relative to it: inertia loads them, and air at rest damps its motion too.
Excitation excitation_of(const input::Case& c, system::Model& model, Vec a, const system::RigidInertia& inertia) {
  Excitation e;
  e.force = model.dofs().create_vector();
  if (c.harmonic.excitation == Section::Excitation::base) {
    e.base = c.harmonic.acceleration * c.harmonic.direction->normalized();
    e.mass_damping = c.dynamics.mass_damping;
    for (std::size_t k = 0; k < 3; ++k)
      VOILE_PETSC(VecAXPY(e.force, -e.base[static_cast<Eigen::Index>(k)], inertia.force[k]));
    return e;
  }
  model.assemble_tangent(a, {.kind = energy::Tangent::exact});
  model.load_direction(a, e.force);
  model.dofs().clear_fixed(e.force);
  double size = 0.0;
  VOILE_PETSC(VecNorm(e.force, NORM_2, &size));
  if (size == 0.0)
    throw UserError(c.file.string() +
                    ": harmonic.excitation: no load acts on what can move (those of earlier stages are constant); give "
                    "a [[load]], or excitation = \"base\"");
  return e;
}

namespace {

/// Whether an expression of t is a straight line from a little before `at` to `at` + 1 at a place, and changes at all.
struct Course {
  bool straight = true, changes = false;
};
Course course_of(const system::Field& f, const Vec3& x, double at) {
  constexpr double step = 1e-3, alike = 1e-6;
  const double here = f.value(x, at), before = (here - f.value(x, at - step)) / step,
               after = (f.value(x, at + step) - here) / step, far = f.value(x, at + 1.0) - here,
               scale = std::max({std::abs(before), std::abs(after), std::abs(far)});
  const double round_off = alike * (scale + std::abs(here));
  return {std::abs(before - after) <= round_off && std::abs(far - after) <= round_off, scale > round_off};
}

}  // namespace

void require_straight(const input::Case& c, const mesh::SurfaceMesh& mesh) {
  const bool harmonic = c.analysis == input::Analysis::harmonic && c.harmonic.excitation == Section::Excitation::loads;
  if (!harmonic && c.analysis != input::Analysis::buckling) return;
  const auto check = [&](const system::Field& f, const char* key) {
    if (!f.in_time || !f.value) return;
    Course all;
    for (const Vec3& x : mesh.positions()) {
      const Course one = course_of(f, x, c.eigen.load_factor);
      all = {all.straight && one.straight, all.changes || one.changes};
    }
    if (all.straight && all.changes) return;
    throw UserError(
        fmt::format("{}: {} = \"{}\": analysis = \"{}\" takes by how much it grows with the load factor at "
                    "eigen.load_factor = {:g}, where it "
                    "{}; give a number, or a multiple of t",
                    c.file.string(), key, f.text, input::word_of(c.analysis), c.eigen.load_factor,
                    all.straight ? "does not change with t" : "is no straight line of t"));
  };
  for (const system::Temperature& t : c.temperatures) {
    check(t.change, "temperature.change");
    check(t.difference, "temperature.difference");
  }
  for (const system::Hinge& h : c.hinges) check(h.angle, "hinge.angle");
}

void require_excitation(const input::Case& c, const system::Model& model) {
  require_straight(c, model.dofs().mesh());
  if (c.analysis != input::Analysis::harmonic) return;
  const std::string file = c.file.string();
  if (c.harmonic.excitation == Section::Excitation::loads) {
    if (!model.conditions().has_prescribed()) return;
    throw UserError(file +
                    ": [[support]]: with analysis = \"harmonic\" supports do not move by `value`; set it to 0, or move "
                    "all of them with harmonic.excitation = \"base\"");
  }
  constexpr double across = 1e-6;  // cosine of what counts as square to the direction
  const Vec3 along = c.harmonic.direction->normalized();
  const auto leaves = [&](const Vec3& d) { return std::abs(d.dot(along)) > across; };
  for (const system::FreePiece& piece :
       system::free_pieces(model.dofs().mesh(), model.discretisation().constraints(), c.springs))
    if (std::any_of(piece.directions.begin(), piece.directions.end(), leaves))
      throw UserError(fmt::format(
          "{}: harmonic.direction: nothing holds the sheet along ({:g}, {:g}, {:g}), so that a moving base leaves it "
          "behind; add a [[support]] that holds it there, or choose another direction",
          file, along[0], along[1], along[2]));
  if (mirror_is_crossed(c, model, leaves))
    throw UserError(
        fmt::format("{}: harmonic.direction: the base cannot move through the plane of a [[support]] of type "
                    "\"symmetry\"; model the whole, or choose a direction in the plane",
                    file));
}

}  // namespace voile::simulation
