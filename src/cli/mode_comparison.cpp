#include "mode_comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "base/decompositions.hpp"
#include "base/plain_file.hpp"
#include "base/text.hpp"
#include "geometry/closest_triangle.hpp"
#include "results/stored_run.hpp"
#include "voile/errors.hpp"

namespace voile::cli {

namespace {

namespace fs = std::filesystem;

/// Largest distance of a vertex from the other mesh, over the extent, at which they still have one shape.
constexpr double other_shape = 0.02;

double extent_of(const std::vector<Vec3>& positions) {
  Vec3 low = positions.front(), high = low;
  for (const Vec3& x : positions) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  return (high - low).norm();
}

bool same_mesh(const mesh::MeshData& a, const mesh::MeshData& b) {
  constexpr double round_off = 1e-9;
  if (a.triangles != b.triangles || a.positions.size() != b.positions.size()) return false;
  const double limit = round_off * extent_of(a.positions);
  return std::equal(a.positions.begin(), a.positions.end(), b.positions.begin(),
                    [&](const Vec3& x, const Vec3& y) { return (x - y).norm() <= limit; });
}

/// Values of the second column of modes.csv, and its name.
void read_values(const fs::path& file, ModeSet& set) {
  std::ifstream in = open_input(file);
  std::string line;
  for (bool head = true; std::getline(in, line); head = false) {
    const std::vector<std::string> row = csv_cells(line);
    const std::string cell = row.size() > 1 ? row[1] : "";
    if (head) {
      set.quantity = cell;
      continue;
    }
    char* end = nullptr;
    set.values.push_back(std::strtod(cell.c_str(), &end));
    if (end == cell.c_str() || !std::isfinite(set.values.back()))
      throw UserError(fmt::format("{}: '{}' is no value of mode {}; run the analysis again", file.string(), cell,
                                  set.values.size()));
  }
  if (set.values.size() != static_cast<std::size_t>(set.shapes.cols()))
    throw UserError(fmt::format("{}: it has {} modes, and {} has {}; name the output folder of a finished run",
                                file.string(), set.values.size(), set.file.string(), set.shapes.cols()));
}

/// Modes of one mesh at points.
Eigen::MatrixXd at_points(const ModeSet& set, const std::vector<Vec3>& points, const ModeSet& other) {
  const std::vector<Vec3>& x = set.mesh.positions;
  const geometry::ClosestTriangle closest(x, set.mesh.triangles);
  const double limit = other_shape * extent_of(x);
  Eigen::MatrixXd found = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(points.size()), set.shapes.cols());
  for (std::size_t p = 0; p < points.size(); ++p) {
    const mesh::Triangle& t = set.mesh.triangles[static_cast<std::size_t>(closest.find(points[p]))];
    const std::array<Vec3, 3> corners{x[static_cast<std::size_t>(t[0])], x[static_cast<std::size_t>(t[1])],
                                      x[static_cast<std::size_t>(t[2])]};
    const Vec3 w = geometry::nearest_weights(points[p], corners);
    const Vec3 place = w[0] * corners[0] + w[1] * corners[1] + w[2] * corners[2];
    if ((place - points[p]).norm() > limit)
      throw UserError(fmt::format(
          "{}: the vertex at ({:.4g}, {:.4g}, {:.4g}) m is {:.3g} m away from the mesh of {}: the two shapes "
          "differ; compare runs of one shape",
          other.file.string(), points[p][0], points[p][1], points[p][2], (place - points[p]).norm(),
          set.file.string()));
    for (int k = 0; k < 3; ++k)
      found.middleRows(3 * static_cast<Eigen::Index>(p), 3) +=
          w[k] * set.shapes.middleRows(3 * static_cast<Eigen::Index>(t[static_cast<std::size_t>(k)]), 3);
  }
  return found;
}

/// Products of the modes.
struct Products {
  Eigen::MatrixXd cross, back;    ///< a.Mb and Ma.b
  Eigen::MatrixXd first, second;  ///< a.Ma, b.Mb
};

Partner partner_of(Eigen::Index i, const Products& p, const Eigen::MatrixXd& mac, const ModeSet& second, double near) {
  Partner found;
  Eigen::Index best = 0;
  (void)mac.row(i).maxCoeff(&best);
  found.best = static_cast<std::size_t>(best);
  const double value = second.values[found.best];
  for (std::size_t j = 0; j < second.values.size(); ++j)
    if (std::abs(second.values[j] - value) <= near * std::abs(value)) found.around.push_back(j);
  const auto count = static_cast<Eigen::Index>(found.around.size());
  Eigen::VectorXd c(count);
  Eigen::MatrixXd g(count, count);
  for (Eigen::Index j = 0; j < count; ++j) {
    const auto at = static_cast<Eigen::Index>(found.around[static_cast<std::size_t>(j)]);
    c[j] = 0.5 * (p.cross(i, at) + p.back(i, at));
    for (Eigen::Index k = 0; k < count; ++k)
      g(j, k) = p.second(at, static_cast<Eigen::Index>(found.around[static_cast<std::size_t>(k)]));
  }
  found.span = c.dot(Eigen::VectorXd(LeastSquares(g).solve(c))) / p.first(i, i);
  return found;
}

}  // namespace

ModeSet read_modes(const fs::path& folder) {
  std::error_code ignored;
  const fs::path modes = folder / "modes";
  if (!fs::exists(modes / "results.vtkhdf", ignored))
    throw UserError(
        fmt::format("{}: there are no modes; name the output folder of a run with analysis = \"modal\" or "
                    "\"buckling\", or of its stage",
                    folder.string()));
  const results::StoredRun run(modes);
  if (run.steps().empty()) throw UserError(fmt::format("{}: it has no modes", run.file().string()));
  results::StoredMesh mesh = run.mesh(run.steps().front().epoch);
  ModeSet set{run.file(), std::move(mesh.data), std::move(mesh.unit), {}, {}, {}, {}};
  const auto rows = 3 * static_cast<Eigen::Index>(set.mesh.positions.size()),
             count = static_cast<Eigen::Index>(run.steps().size());
  const auto read = [&](const char* name) {
    Eigen::MatrixXd all(rows, count);
    for (Eigen::Index k = 0; k < count; ++k) {
      const results::Field f = run.field(static_cast<std::size_t>(k), name, set.mesh);
      all.col(k) = Eigen::Map<const Eigen::VectorXd>(f.values.data(), rows);
    }
    return all;
  };
  set.shapes = read("mode");
  if (run.has_field(0, "mode_times_mass")) set.mass_shapes = read("mode_times_mass");
  read_values(folder / "modes.csv", set);
  return set;
}

ModeComparison compare(const ModeSet& first, const ModeSet& second, double near) {
  if (first.length != second.length)
    throw UserError(fmt::format("{} has lengths in {}, {} in {}; compare runs of one system of units",
                                first.file.string(), first.length, second.file.string(), second.length));
  ModeComparison c;
  c.same_mesh = same_mesh(first.mesh, second.mesh);
  c.by_mass = c.same_mesh && first.mass_shapes.size() > 0 && second.mass_shapes.size() > 0;
  Eigen::MatrixXd a = first.shapes, b = second.shapes;
  if (!c.same_mesh) {  // each must lie on the other: a part of a shape is another shape
    Eigen::MatrixXd at_first = at_points(second, first.mesh.positions, first),
                    at_second = at_points(first, second.mesh.positions, second);
    const bool few = first.mesh.positions.size() <= second.mesh.positions.size();
    (few ? b : a) = std::move(few ? at_first : at_second);
  }
  const Eigen::MatrixXd &ma = c.by_mass ? first.mass_shapes : a, &mb = c.by_mass ? second.mass_shapes : b;
  const Products p{a.transpose() * mb, ma.transpose() * b, a.transpose() * ma, b.transpose() * mb};
  c.mac = p.cross.cwiseProduct(p.back);
  for (Eigen::Index i = 0; i < c.mac.rows(); ++i)
    for (Eigen::Index j = 0; j < c.mac.cols(); ++j) c.mac(i, j) /= p.first(i, i) * p.second(j, j);
  for (Eigen::Index i = 0; i < c.mac.rows(); ++i) c.partners.push_back(partner_of(i, p, c.mac, second, near));
  return c;
}

}  // namespace voile::cli
