#include "start_supports.hpp"

#include <fmt/format.h>

#include <cmath>

#include "base/mpi.hpp"
#include "voile/errors.hpp"

namespace voile::setup {

namespace {

/// Fraction of a cell below which a distance is round-off of the file.
constexpr double same_cell = 1e-6;

}  // namespace

void check_start_supports(const input::Case& c, system::Model& model, Vec start) {
  if (c.mesh.start.empty()) return;
  const petsc::VecHandle moved = model.dofs().create_vector();
  VOILE_PETSC(VecCopy(start, moved));
  model.conditions().enforce(moved);
  VOILE_PETSC(VecAXPY(moved, -1.0, start));
  const std::vector<double> by = model.dofs().gather(moved);
  const double cell = std::sqrt(model.discretisation().mean_area());
  mpi::on_root(model.dofs().comm(), [&] {
    double farthest = 0.0;
    std::size_t worst = 0;
    for (std::size_t v = 0; 3 * v < by.size(); ++v) {
      const double distance = std::hypot(by[3 * v], by[3 * v + 1], by[3 * v + 2]);
      if (distance <= farthest) continue;
      farthest = distance;
      worst = v;
    }
    if (farthest <= same_cell * cell) return;
    const mesh::SurfaceMesh& mesh = model.dofs().mesh();
    const Vec3& at = mesh.positions()[worst];
    const std::string what = fmt::format(
        "[mesh] start: supports hold vertex {} at ({:.4g}, {:.4g}, {:.4g}) of [mesh] file, {:.3g} m from where {} has "
        "it",
        mesh.data().vertex_tags[worst], at.x(), at.y(), at.z(), farthest, c.mesh.start.filename().string());
    if (farthest > cell)
      throw UserError(
          fmt::format("{}; let both meshes agree there, or hold the sheet from a second stage on (`stages` of "
                      "[[support]]), which takes hold of it where it is",
                      what));
    fmt::print("note: {}; the run begins by pulling it there\n", what);
  });
}

}  // namespace voile::setup
