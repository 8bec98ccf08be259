#include "stall.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/mpi.hpp"
#include "base/text.hpp"
#include "mesh/quality.hpp"

namespace voile::solve {

namespace {

constexpr std::size_t shown = 3;

/// Sum of |r| over the corners of each triangle.
std::vector<double> by_triangle(const mesh::SurfaceMesh& mesh, const std::vector<double>& r) {
  std::vector<double> sums;
  for (const mesh::Triangle& t : mesh.triangles()) {
    double sum = 0.0;
    for (const Index v : t) {
      const double size = Vec3(r[3 * v], r[3 * v + 1], r[3 * v + 2]).norm();
      sum += std::isfinite(size) ? size : std::numeric_limits<double>::infinity();
    }
    sums.push_back(sum);
  }
  return sums;
}

bool share_a_vertex(const mesh::Triangle& s, const mesh::Triangle& t) {
  return std::any_of(s.begin(), s.end(), [&](Index v) { return std::find(t.begin(), t.end(), v) != t.end(); });
}

std::string describe(const mesh::SurfaceMesh& mesh, const std::vector<double>& r) {
  std::vector<double> sums = by_triangle(mesh, r);
  std::vector<Index> worst;
  std::vector<std::string> texts;
  while (worst.size() < shown) {
    const auto t = static_cast<Index>(std::max_element(sums.begin(), sums.end()) - sums.begin());
    if (!(sums[t] > 0.0)) break;
    sums[t] = 0.0;
    // Triangles around one vertex would all say the same.
    if (std::any_of(worst.begin(), worst.end(),
                    [&](Index w) { return share_a_vertex(mesh.triangles()[w], mesh.triangles()[t]); }))
      continue;
    worst.push_back(t);
    const Vec3 x = mesh::centroid(mesh, t);
    texts.push_back(fmt::format("triangle {} at ({:.4g}, {:.4g}, {:.4g}), smallest angle {:.2g} degrees",
                                mesh.data().triangle_tags[t], x[0], x[1], x[2],
                                mesh::shape_of(mesh, t).smallest_angle * (180.0 / std::numbers::pi)));
  }
  return texts.empty() ? "" : "the residual is largest at " + voile::join(texts, "; ");
}

}  // namespace

std::string largest_residuals(const system::Model& model, Vec r) {
  const std::vector<double> values = model.dofs().gather_forces(r);
  std::string text;
  mpi::on_root(model.dofs().comm(), [&] { text = describe(model.dofs().mesh(), values); });
  mpi::broadcast(model.dofs().comm(), text);
  return text;
}

namespace {

/// Of hyperelastic triangles the largest stretch, and the loss of ellipticity of one in tension.
std::string describe_stretch(const energy::Sheet& sheet, const std::vector<double>& strains) {
  Index most = no_index, lost = no_index;
  double stretch = 0.0, least = 0.0;
  for (Index t = 0; t < sheet.mesh().triangle_count(); ++t) {
    const energy::Hyperelastic& law = sheet.material(t).rubber;
    if (!law.any()) continue;
    const Vec3 strain = Eigen::Map<const Vec3>(&strains[3 * static_cast<std::size_t>(t)]);
    const energy::Stretches s = energy::stretches_of(law.natural * strain);
    if (s.most > stretch) {
      stretch = s.most;
      most = t;
    }
    const double left = s.most * s.least > 1.0 ? energy::ellipticity(law, strain) : 1.0;
    if (left > least) continue;
    least = left;
    lost = t;
  }
  if (most == no_index) return "";
  const auto place = [&](Index t) {
    const Vec3 x = mesh::centroid(sheet.mesh(), t);
    return fmt::format("triangle {} at ({:.4g}, {:.4g}, {:.4g})", sheet.mesh().data().triangle_tags[t], x[0], x[1],
                       x[2]);
  };
  std::string text = fmt::format("; the largest stretch is {:.4g}, of {}", stretch, place(most));
  if (lost != no_index) text += fmt::format("; the law has lost ellipticity in {}", place(lost));
  return text;
}

}  // namespace

std::string largest_stretch(system::Model& model, Vec a) {
  const std::vector<energy::Material>& materials = model.discretisation().materials();
  if (std::none_of(materials.begin(), materials.end(), [](const auto& m) { return m.rubber.any(); })) return "";
  const system::TriangleFields fields = model.triangle_fields(a);
  std::string text;
  mpi::on_root(model.dofs().comm(),
               [&] { text = describe_stretch(model.discretisation().sheet(), fields.membrane_strain); });
  mpi::broadcast(model.dofs().comm(), text);
  return text;
}

std::string largest_residuals_at(system::Model& model, Vec a) {
  const petsc::VecHandle r = model.dofs().create_vector();
  model.residual(a, r);
  model.dofs().clear_fixed(r);
  return largest_residuals(model, r) + largest_stretch(model, a);
}

}  // namespace voile::solve
