#include "imperfections.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include "input/expression.hpp"
#include "mesh/periodic.hpp"
#include "results/stored_step.hpp"
#include "system/mirror_plane.hpp"
#include "voile/errors.hpp"

namespace voile::setup {

namespace {

using input::ImperfectionSection;

/// Waves that a random field is the sum of.
constexpr int waves = 400;

/// Orthonormal normals of the mirror planes on which vertices lie.
using Planes = std::map<Index, std::vector<Vec3>>;

/// Nothing where only the imperfect shape tells, as on a straight edge of a curved sheet; supports are checked on that shape.
std::optional<Vec3> normal_of(const mesh::SurfaceMesh& perfect, const system::Support& symmetry) {
  try {
    return system::mirror_normal(perfect, symmetry);
  } catch (const UserError&) {
    return std::nullopt;
  }
}

Planes planes_of(const input::Case& c, const mesh::SurfaceMesh& mesh) {
  constexpr double same = 1e-6;
  Planes planes;
  const auto add = [&](const std::vector<system::Support>& supports) {
    for (const system::Support& s : supports) {
      if (s.kind != system::Support::Kind::symmetry || !mesh.has_group(s.group)) continue;  // check_group_names() tells
      const std::optional<Vec3> normal = normal_of(mesh, s);
      if (!normal) continue;
      for (const Index v : mesh.group(s.group).vertices) {
        Vec3 rest = *normal;
        for (const Vec3& known : planes[v]) rest -= known.dot(*normal) * known;
        if (rest.norm() > same) planes[v].push_back(rest.normalized());
      }
    }
  };
  add(c.supports);
  for (const input::Case& stage : c.stages) add(stage.supports);
  return planes;
}

/// Of each vertex the one that it repeats where the sheet is periodic, or itself, and by how many periods.
struct Repeats {
  std::vector<Index> root;
  std::vector<mesh::ContinuedSurface::Shift> periods;
};

Repeats repeats_of(const input::Case& c, const mesh::SurfaceMesh& mesh) {
  Repeats r;
  for (Index v = 0; v < mesh.vertex_count(); ++v) r.root.push_back(v);
  if (c.periodics.empty()) return r;
  std::vector<mesh::PeriodicCurves> pairs;
  for (const input::PeriodicSection& s : c.periodics) pairs.push_back({s.pair.from, s.pair.to});
  mesh::ContinuedSurface sheet = mesh::continue_periodically(mesh, pairs, 1);
  r.root.assign(sheet.root.begin(), sheet.root.begin() + mesh.vertex_count());
  r.periods = std::move(sheet.shift);
  return r;
}

/// Displacement of each vertex per unit of height: its part along the normal n of each triangle there is 1, or 1 in the least squares
/// of their areas. Directions that less than `least` of the area needs are left out: small curvature, and sheets folded flat.
/// Triangles count with their images in mirror planes, so that vertices stay in these, and beyond periodic edges.
std::vector<Vec3> lifts_of(const mesh::SurfaceMesh& mesh, const Planes& planes, const Repeats& repeats) {
  constexpr double least = 0.05;
  const auto count = static_cast<std::size_t>(mesh.vertex_count());
  std::vector<Mat3> squares(count, Mat3::Zero());  // sum of A n n^T
  std::vector<Vec3> sums(count, Vec3::Zero());     // sum of A n
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    for (const Index corner : mesh.triangles()[t]) {
      const auto v = static_cast<std::size_t>(repeats.root[static_cast<std::size_t>(corner)]);
      const Vec3 n = mesh.start_normal(t);
      squares[v] += mesh.area(t) * n * n.transpose();
      sums[v] += mesh.area(t) * n;
    }
  for (std::size_t v = 0; v < count; ++v) {
    squares[v] = Mat3(squares[static_cast<std::size_t>(repeats.root[v])]);
    sums[v] = Vec3(sums[static_cast<std::size_t>(repeats.root[v])]);
  }
  for (const auto& [v, normals] : planes)
    for (const Vec3& n : normals) {
      const Mat3 mirror = Mat3::Identity() - 2.0 * n * n.transpose();
      Mat3& square = squares[static_cast<std::size_t>(v)];
      square += Mat3(mirror * square * mirror);
      sums[static_cast<std::size_t>(v)] += Vec3(mirror * sums[static_cast<std::size_t>(v)]);
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

/// Where an imperfection is applied.
struct Place {
  const input::Case& c;
  const mesh::SurfaceMesh& mesh;
  const Planes& planes;
  const Repeats& repeats;
  const StageModes& known;

  [[noreturn]] void fail(const char* key, const std::string& what) const {
    throw UserError(fmt::format("{}: [[imperfection]] {}: {}", c.file.string(), key, what));
  }
};

/// Mode `number`, from 1, of a file or of a stage of this run.
std::vector<double> shape_of(const Place& at, const ImperfectionSection& s, double number) {
  const auto known = at.known.find(s.stage);
  if (!s.stage.empty() && known != at.known.end() && number <= static_cast<double>(known->second.size()))
    return known->second[static_cast<std::size_t>(number) - 1];
  const std::filesystem::path file = modes_file(s.results);
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored))
    at.fail("results", fmt::format("there is no {}; name the output folder of a finished run with analysis = "
                                   "\"buckling\" or \"modal\"",
                                   file.string()));
  try {
    return results::read_mode(file, static_cast<int>(number), at.mesh);
  } catch (const UserError& e) {
    at.fail("modes", fmt::format("mode {:g}: {}", number, e.what()));
  }
}

/// Modes of the supports of the case leave no mirror plane; half of another mode would be no imperfection that anybody has asked for.
void require_in_planes(const Place& at, const std::vector<double>& shape, double most, double number) {
  constexpr double round_off = 1e-6;
  for (const auto& [v, normals] : at.planes)
    for (const Vec3& n : normals)
      if (const double across = n.dot(Eigen::Map<const Vec3>(&shape[3 * static_cast<std::size_t>(v)]));
          std::abs(across) > round_off * most)
        at.fail("modes", fmt::format("mode {:g} moves vertex {} across the mirror plane of a [[support]] of type "
                                     "symmetry; find modes with the supports of this case, or model the whole",
                                     number, at.mesh.data().vertex_tags[static_cast<std::size_t>(v)]));
}

void add_modes(const Place& at, const ImperfectionSection& s, std::vector<Vec3>& added) {
  for (std::size_t k = 0; k < s.modes.size(); ++k) {
    const std::vector<double> shape = shape_of(at, s, s.modes[k]);
    double most = 0.0;
    for (std::size_t v = 0; v < added.size(); ++v) most = std::max(most, Eigen::Map<const Vec3>(&shape[3 * v]).norm());
    if (!(most > 0.0) || !std::isfinite(most)) at.fail("modes", fmt::format("mode {:g} is zero", s.modes[k]));
    require_in_planes(at, shape, most, s.modes[k]);
    const double scale = s.amplitudes[s.amplitudes.size() == 1 ? 0 : k] / most;
    for (std::size_t v = 0; v < added.size(); ++v) added[v] += scale * Eigen::Map<const Vec3>(&shape[3 * v]);
  }
}

void add_heights(const Place& at, const ImperfectionSection& s, std::vector<Vec3>& added) {
  const mesh::SurfaceMesh& mesh = at.mesh;
  const std::vector<Vec3> lifts = lifts_of(mesh, at.planes, at.repeats);
  std::vector<double> h;
  if (s.type == ImperfectionSection::Type::random) {
    h = random_heights(s, mesh);
  } else {
    const auto height = input::place_expression(s.height, false).value;
    try {
      for (const Vec3& x : mesh.positions()) h.push_back(height(x, 0.0));
    } catch (const UserError& e) {
      at.fail("height", fmt::format("{}; write one that is finite at every vertex", e.what()));
    }
  }
  for (std::size_t v = 0; v < added.size(); ++v) added[v] += h[v] * lifts[v];
}

/// Vertices that repeat others may move from them by the same for all of a pair: the cell then repeats itself by another translation.
void require_repeats(const Place& at, const std::vector<Vec3>& added) {
  constexpr double round_off = 1e-6;
  double most = 0.0;
  for (const Vec3& w : added) most = std::max(most, w.norm());
  std::map<mesh::ContinuedSurface::Shift, Vec3> apart;
  for (std::size_t v = 0; v < added.size() && !at.repeats.periods.empty(); ++v) {
    const Vec3 d = added[v] - added[static_cast<std::size_t>(at.repeats.root[v])];
    const auto known = apart.emplace(at.repeats.periods[v], d).first;
    if ((d - known->second).norm() > round_off * most)
      throw UserError(
          fmt::format("{}: [[imperfection]]: the shape does not repeat itself along [[periodic]] edges: at vertex {} "
                      "it is {:.3g} m off; give "
                      "heights that are alike on both curves of a pair, e.g. a sine of the period",
                      at.c.file.string(), at.mesh.data().vertex_tags[v], (d - known->second).norm()));
  }
}

/// What is added to each vertex. Rank 0 only.
std::vector<double> added_by(const input::Case& c, const mesh::SurfaceMesh& mesh, const StageModes& known) {
  std::vector<Vec3> added(static_cast<std::size_t>(mesh.vertex_count()), Vec3::Zero());
  const Planes planes = planes_of(c, mesh);
  const Repeats repeats = repeats_of(c, mesh);
  const Place at{c, mesh, planes, repeats, known};
  for (const ImperfectionSection& s : c.imperfections)
    s.type == ImperfectionSection::Type::modes ? add_modes(at, s, added) : add_heights(at, s, added);
  require_repeats(at, added);
  std::vector<double> numbers;
  for (const Vec3& w : added) numbers.insert(numbers.end(), w.begin(), w.end());
  return numbers;
}

}  // namespace

mesh::SurfaceMesh with_imperfections(MPI_Comm comm, const input::Case& c, mesh::SurfaceMesh perfect,
                                     const StageModes& known) {
  if (c.imperfections.empty()) return perfect;
  if (perfect.has_charts())
    throw UserError(fmt::format(
        "{}: [[imperfection]]: panels are flat without stress; an imperfection needs a mesh whose own shape "
        "is without stress (no [[panel]], mesh.rest = \"positions\")",
        c.file.string()));
  std::vector<double> added;
  mpi::on_root(comm, [&] { added = added_by(c, perfect, known); });
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
