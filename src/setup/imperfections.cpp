#include "imperfections.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "input/expression.hpp"
#include "results/stored_step.hpp"
#include "voile/errors.hpp"

namespace voile::setup {

namespace {

using input::ImperfectionSection;

/// Waves that a random field is the sum of.
constexpr int waves = 400;

/// Displacement of each vertex per unit of height: its part along the normal n of each triangle there is 1, or 1 in the least squares
/// of their areas. Directions that less than `least` of the area needs are left out: small curvature, and sheets folded flat.
std::vector<Vec3> lifts_of(const mesh::SurfaceMesh& mesh) {
  constexpr double least = 0.05;
  const auto count = static_cast<std::size_t>(mesh.vertex_count());
  std::vector<Mat3> squares(count, Mat3::Zero());  // sum of A n n^T
  std::vector<Vec3> sums(count, Vec3::Zero());     // sum of A n
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    for (const Index v : mesh.triangles()[t]) {
      const Vec3 n = mesh.start_normal(t);
      squares[static_cast<std::size_t>(v)] += mesh.area(t) * n * n.transpose();
      sums[static_cast<std::size_t>(v)] += mesh.area(t) * n;
    }
  std::vector<Vec3> lifts(count, Vec3::Zero());
  for (std::size_t v = 0; v < count; ++v) {
    const Eigen::SelfAdjointEigenSolver<Mat3> parts(squares[v]);
    for (int k = 0; k < 3; ++k) {
      const Vec3 e = parts.eigenvectors().col(k);
      if (parts.eigenvalues()[k] > least * squares[v].trace())
        lifts[v] += e * (e.dot(sums[v]) / parts.eigenvalues()[k]);
    }
  }
  return lifts;
}

/// Numbers that are the same with every compiler: uniform from the engine's bits, normal by Box and Muller.
class Numbers {
 public:
  explicit Numbers(int seed) : engine_(static_cast<std::uint64_t>(seed)) {}
  double uniform() { return (static_cast<double>(engine_() >> 11) + 0.5) * 0x1p-53; }
  double normal() { return std::sqrt(-2.0 * std::log(uniform())) * std::cos(2.0 * std::numbers::pi * uniform()); }

 private:
  std::mt19937_64 engine_;
};

std::vector<double> random_heights(const ImperfectionSection& s, const mesh::SurfaceMesh& mesh) {
  std::vector<double> h(static_cast<std::size_t>(mesh.vertex_count()), 0.0);
  Numbers numbers(s.seed);
  for (int j = 0; j < waves; ++j) {
    Vec3 k;
    for (int i = 0; i < 3; ++i) k[i] = numbers.normal() / s.length;
    const double phase = 2.0 * std::numbers::pi * numbers.uniform();
    for (std::size_t v = 0; v < h.size(); ++v) h[v] += std::cos(k.dot(mesh.positions()[v]) + phase);
  }
  double most = 0.0;
  for (const double x : h) most = std::max(most, std::abs(x));
  for (double& x : h) x *= s.amplitude / most;
  return h;
}

/// Results of modes in the folder of a run; a file is taken as it is.
std::filesystem::path modes_file(const std::filesystem::path& given) {
  std::error_code ignored;
  if (std::filesystem::is_regular_file(given, ignored)) return given;
  return given / "modes" / "results.vtkhdf";
}

void add_modes(const input::Case& c, const ImperfectionSection& s, const mesh::SurfaceMesh& mesh,
               std::vector<Vec3>& added) {
  const std::filesystem::path file = modes_file(s.results);
  std::error_code ignored;
  const auto fail = [&](const char* key, const std::string& what) {
    throw UserError(fmt::format("{}: [[imperfection]] {}: {}", c.file.string(), key, what));
  };
  if (!std::filesystem::exists(file, ignored))
    fail("results", fmt::format("there is no {}; name the output folder of a finished run with analysis = \"buckling\" "
                                "or \"modal\"",
                                file.string()));
  for (std::size_t k = 0; k < s.modes.size(); ++k) {
    std::vector<double> shape;
    try {
      shape = results::read_mode(file, static_cast<int>(s.modes[k]), mesh);
    } catch (const UserError& e) {
      fail("modes", fmt::format("mode {:g}: {}", s.modes[k], e.what()));
    }
    double most = 0.0;
    for (std::size_t v = 0; v < added.size(); ++v) most = std::max(most, Eigen::Map<const Vec3>(&shape[3 * v]).norm());
    if (!(most > 0.0) || !std::isfinite(most))
      fail("modes", fmt::format("mode {:g} of {} is zero", s.modes[k], file.string()));
    const double scale = s.amplitudes[s.amplitudes.size() == 1 ? 0 : k] / most;
    for (std::size_t v = 0; v < added.size(); ++v) added[v] += scale * Eigen::Map<const Vec3>(&shape[3 * v]);
  }
}

void add_heights(const input::Case& c, const ImperfectionSection& s, const mesh::SurfaceMesh& mesh,
                 std::vector<Vec3>& added) {
  const std::vector<Vec3> lifts = lifts_of(mesh);
  std::vector<double> h;
  if (s.type == ImperfectionSection::Type::random) {
    h = random_heights(s, mesh);
  } else {
    const auto height = input::place_expression(s.height, false).value;
    try {
      for (const Vec3& x : mesh.positions()) h.push_back(height(x, 0.0));
    } catch (const UserError& e) {
      throw UserError(fmt::format("{}: [[imperfection]] height: {}; write one that is finite at every vertex",
                                  c.file.string(), e.what()));
    }
  }
  for (std::size_t v = 0; v < added.size(); ++v) added[v] += h[v] * lifts[v];
}

/// What is added to each vertex. Rank 0 only.
std::vector<double> added_by(const input::Case& c, const mesh::SurfaceMesh& mesh) {
  std::vector<Vec3> added(static_cast<std::size_t>(mesh.vertex_count()), Vec3::Zero());
  for (const ImperfectionSection& s : c.imperfections)
    if (s.type == ImperfectionSection::Type::modes)
      add_modes(c, s, mesh, added);
    else
      add_heights(c, s, mesh, added);
  std::vector<double> numbers;
  for (const Vec3& w : added) numbers.insert(numbers.end(), w.begin(), w.end());
  return numbers;
}

}  // namespace

mesh::SurfaceMesh with_imperfections(MPI_Comm comm, const input::Case& c, mesh::SurfaceMesh perfect) {
  if (c.imperfections.empty()) return perfect;
  if (perfect.has_charts())
    throw UserError(fmt::format(
        "{}: [[imperfection]]: panels are flat without stress; an imperfection needs a mesh whose own shape "
        "is without stress (no [[panel]], mesh.rest = \"positions\")",
        c.file.string()));
  std::vector<double> added;
  mpi::on_root(comm, [&] { added = added_by(c, perfect); });
  mpi::broadcast(comm, added);
  mesh::MeshData data = perfect.data();
  double most = 0.0;
  for (std::size_t v = 0; v < data.positions.size(); ++v) {
    const Vec3 w = Eigen::Map<const Vec3>(&added[3 * v]);
    most = std::max(most, w.norm());
    data.positions[v] += w;
  }
  data.notes.push_back(fmt::format("the shape without stress differs from the mesh by up to {:.4g} m", most));
  return mesh::SurfaceMesh(std::move(data));
}

}  // namespace voile::setup
