#include "resample.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <limits>
#include <set>

#include "adapt/remesh.hpp"
#include "voile/errors.hpp"

namespace voile::picture {

namespace {

/// Sizes asked for, over the edges of the meshes: edges up to 1.4 times the size remain.
constexpr double size_fraction = 0.72;
constexpr int most_rounds = 12;
/// Splits towards the tolerance, and vertices at which they end.
constexpr int most_refinements = 6;
/// Over the longest extent of the sheet at the start.
constexpr double default_tolerance = 5e-4;
constexpr std::size_t most_vertices = 2'000'000;
/// A vertex is looked for from this fraction of the way into one of its triangles: where two edges lie on each other, as at a
/// slit, the triangle on the right side is found.
constexpr double inwards = 1e-3;
/// Weights that are negative by less belong to a point that going inwards took across an edge.
constexpr double beside = 0.01;
/// Distance from the triangle that was found, over the longest edge there of the coarser mesh, beyond which the meshes are of
/// different sheets.
constexpr double far = 0.5;
/// Over the extent of the sheet: meshes that are closer at the start are of one surface, as those of plane pieces.
constexpr double same = 1e-9;

Vec3 centroid(const std::vector<Vec3>& x, const mesh::Triangle& t) {
  return (x[t[0]] + x[t[1]] + x[t[2]]) / 3.0;
}

Vec3 at(const std::vector<Vec3>& x, const mesh::Triangle& t, const Vec3& weights) {
  return weights[0] * x[t[0]] + weights[1] * x[t[1]] + weights[2] * x[t[2]];
}

std::array<Vec3, 3> corners(const std::vector<Vec3>& x, const mesh::Triangle& t) {
  return {x[t[0]], x[t[1]], x[t[2]]};
}

double longest_side(const std::vector<Vec3>& x, const mesh::Triangle& t) {
  return std::max({(x[t[0]] - x[t[1]]).norm(), (x[t[1]] - x[t[2]]).norm(), (x[t[2]] - x[t[0]]).norm()});
}

/// Longest side of the box around the points.
double extent(const std::vector<Vec3>& x) {
  Eigen::AlignedBox3d box;
  for (const Vec3& p : x) box.extend(p);
  return box.sizes().maxCoeff();
}

/// Longest edge at each vertex [m].
std::vector<double> edges_at(const mesh::MeshData& mesh) {
  std::vector<double> longest(mesh.positions.size(), 0.0);
  for (const mesh::Triangle& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const Index a = t[i], b = t[(i + 1) % 3];
      const double length = (mesh.positions[a] - mesh.positions[b]).norm();
      longest[a] = std::max(longest[a], length);
      longest[b] = std::max(longest[b], length);
    }
  return longest;
}

}  // namespace

/// Finds material points on a mesh.
class Resampled::Locator {
 public:
  explicit Locator(const mesh::MeshData& mesh) : mesh_(mesh), search_(mesh.positions, mesh.triangles) {}
  /// The vertices of another mesh.
  [[nodiscard]] std::vector<Place> vertices_of(const mesh::MeshData& other) const {
    return places_of(other, vertices(other));
  }
  /// Points of another mesh.
  [[nodiscard]] std::vector<Place> places_of(const mesh::MeshData& other, const std::vector<Place>& points) const {
    std::vector<Place> places;
    const std::vector<double> edges = edges_at(other);
    for (const Place& point : points) {
      const mesh::Triangle& of = other.triangles[point.triangle];
      const Vec3 p = at(other.positions, of, point.weights);
      const Index t = search_.find(p + inwards * (centroid(other.positions, of) - p));
      const mesh::Triangle& face = mesh_.triangles[t];
      places.push_back({t, geometry::nearest_weights(p, corners(mesh_.positions, face), beside)});
      const double there = std::max({edges[of[0]], edges[of[1]], edges[of[2]]});
      if ((at(mesh_.positions, face, places.back().weights) - p).norm() >
          far * std::max(there, longest_side(mesh_.positions, face)))
        throw UserError(
            fmt::format("one mesh for all frames: the sheet at ({:.4g}, {:.4g}, {:.4g}) m at the start is not in all "
                        "meshes of the run; export its stages or steps apart (--stage, --steps FIRST:LAST)",
                        p[0], p[1], p[2]));
    }
    return places;
  }
  [[nodiscard]] std::vector<Index> triangles_of(const mesh::MeshData& other) const {
    std::vector<Index> triangles;
    for (const mesh::Triangle& t : other.triangles) triangles.push_back(search_.find(centroid(other.positions, t)));
    return triangles;
  }

  /// Each vertex of a mesh, in some triangle of it.
  static std::vector<Place> vertices(const mesh::MeshData& mesh) {
    std::vector<Place> result(mesh.positions.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (int i = 0; i < 3; ++i) result[mesh.triangles[t][i]] = {static_cast<Index>(t), Vec3::Unit(i)};
    return result;
  }

 private:
  const mesh::MeshData& mesh_;
  geometry::ClosestTriangle search_;
};

/// At the vertices of `base`, from the edges of all meshes there.
std::vector<double> Resampled::wanted_sizes(const mesh::MeshData& base) const {
  std::vector<double> size(base.positions.size(), std::numeric_limits<double>::infinity());
  for (const auto& mesh : meshes_) {
    const std::vector<double> edges = edges_at(mesh->data);
    const std::vector<Place> places = Locator(mesh->data).vertices_of(base);
    for (std::size_t v = 0; v < size.size(); ++v)
      for (const Index w : mesh->data.triangles[places[v].triangle])
        size[v] = std::min(size[v], size_fraction * edges[w]);
    // What lies between two vertices of the base is asked for at both.
    const std::vector<Place> back = Locator(base).vertices_of(mesh->data);
    for (std::size_t w = 0; w < back.size(); ++w)
      for (const Index v : base.triangles[back[w].triangle]) size[v] = std::min(size[v], size_fraction * edges[w]);
  }
  return size;
}

Resampled::Resampled(const Recording& recording, const std::vector<Moment>& moments, std::optional<double> tolerance) {
  for (const Moment& moment : moments) {
    auto mesh = recording.mesh(moment);
    if (mesh->data.triangles.empty())
      throw UserError(
          fmt::format("{}: step {} has no triangles", recording.folder().string(), recording.number(moment)));
    if (std::find(meshes_.begin(), meshes_.end(), mesh) == meshes_.end()) meshes_.push_back(std::move(mesh));
  }
  mesh_ = *std::max_element(meshes_.begin(), meshes_.end(), [](const auto& a, const auto& b) {
    return a->data.positions.size() < b->data.positions.size();
  });
  tolerance_ = tolerance.value_or(default_tolerance * extent(mesh_->data.positions));
  split(wanted_sizes(mesh_->data));
  for (int k = 0; k < most_refinements && mesh_->data.positions.size() < most_vertices; ++k) {
    const std::vector<double> sizes = smaller_sizes(recording, moments);
    if (sizes.empty()) break;
    split(sizes);
  }
}

/// Halves edges that are too long, and finds all meshes of the run on the result.
void Resampled::split(const std::vector<double>& sizes) {
  const mesh::SurfaceMesh base(mesh_->data);
  adapt::Options options;
  options.only_splits = true;
  options.rounds = most_rounds;
  auto next = std::make_shared<results::StoredMesh>();
  next->data = adapt::remesh(base, adapt::RestSurface(base), base.positions(), sizes, {}, options).mesh;
  mesh_ = next;
  const Locator on_this(mesh_->data);
  same_surface_ = true;
  for (const auto& mesh : meshes_) {
    const Locator there(mesh->data);
    std::vector<Place> vertices = there.vertices_of(mesh_->data);
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      const Vec3 found = at(mesh->data.positions, mesh->data.triangles[vertices[v].triangle], vertices[v].weights);
      same_surface_ = same_surface_ && (found - mesh_->data.positions[v]).norm() < same * extent(mesh_->data.positions);
    }
    auto between = points_between(there, vertices);
    of_[mesh.get()] = {std::move(vertices), on_this.vertices_of(mesh->data), std::move(between),
                       there.triangles_of(mesh_->data)};
  }
}

std::vector<double> Resampled::smaller_sizes(const Recording& recording, const std::vector<Moment>& moments) const {
  std::vector<double> sizes = edges_at(mesh_->data);
  bool any = false;
  for (const Moment& moment : moments) {
    const State state = recording.state(moment, 1.0);
    const std::vector<Distance> away = distances(state, positions(state));
    const std::size_t count = same_surface_ ? away.size() : state.positions.size();
    for (std::size_t i = 0; i < count; ++i) {
      const Distance& d = away[i];
      if (d.length <= tolerance_) continue;
      any = true;
      const mesh::Triangle& t = mesh_->data.triangles[d.triangle];
      const double half = 0.5 * size_fraction * longest_side(mesh_->data.positions, t);
      for (const Index w : t) sizes[w] = std::min(sizes[w], half);
    }
  }
  return any ? sizes : std::vector<double>{};
}

Resampled::~Resampled() = default;

std::vector<Vec3> Resampled::positions(const State& state) const {
  std::vector<Vec3> x;
  for (const Place& p : of_.at(state.mesh.get()).vertices)
    x.push_back(at(state.positions, state.mesh->data.triangles[p.triangle], p.weights));
  return x;
}

results::Field Resampled::field(const results::StoredMesh& from, results::Field field) const {
  const Correspondence& c = of_.at(&from);
  const auto n = static_cast<std::size_t>(field.components);
  std::vector<double> values;
  if (field.centre == results::Centre::vertex)
    for (const Place& p : c.vertices)
      for (std::size_t k = 0; k < n; ++k) {
        double sum = 0.0;
        for (std::size_t i = 0; i < 3; ++i)
          sum += p.weights[i] * field.values[n * static_cast<std::size_t>(from.data.triangles[p.triangle][i]) + k];
        values.push_back(sum);
      }
  else
    for (const Index t : c.of_triangle)
      for (std::size_t k = 0; k < n; ++k) values.push_back(field.values[n * static_cast<std::size_t>(t) + k]);
  field.values = std::move(values);
  return field;
}

std::vector<Resampled::Distance> Resampled::distances(const State& state, const std::vector<Vec3>& positions) const {
  std::vector<Distance> away;
  const Correspondence& c = of_.at(state.mesh.get());
  const auto on_one = [&](const Place& p) { return at(positions, mesh_->data.triangles[p.triangle], p.weights); };
  for (std::size_t v = 0; v < c.back.size(); ++v)
    away.push_back({(on_one(c.back[v]) - state.positions[v]).norm(), c.back[v].triangle});
  for (const auto& [one, run] : c.between) {
    const Vec3 x = on_one(one);
    const std::array<Vec3, 3> face = corners(state.positions, state.mesh->data.triangles[run.triangle]);
    const Vec3 w = geometry::nearest_weights(x, face);
    away.push_back({(w[0] * face[0] + w[1] * face[1] + w[2] * face[2] - x).norm(), one.triangle});
  }
  return away;
}

/// Points of edges of the one mesh whose ends are on two triangles of another: both meshes are farthest apart where edges cross.
std::vector<std::pair<Resampled::Place, Resampled::Place>> Resampled::points_between(
    const Locator& there, const std::vector<Place>& vertices) const {
  std::vector<Place> points;
  std::set<std::pair<Index, Index>> seen;
  for (std::size_t t = 0; t < mesh_->data.triangles.size(); ++t)
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      const Index a = mesh_->data.triangles[t][i], b = mesh_->data.triangles[t][j];
      if (vertices[a].triangle == vertices[b].triangle || !seen.insert(std::minmax(a, b)).second) continue;
      for (const double part : {0.25, 0.5, 0.75})
        points.push_back({static_cast<Index>(t), (1.0 - part) * Vec3::Unit(i) + part * Vec3::Unit(j)});
    }
  const std::vector<Place> places = there.places_of(mesh_->data, points);
  std::vector<std::pair<Place, Place>> pairs;
  for (std::size_t k = 0; k < points.size(); ++k) pairs.emplace_back(points[k], places[k]);
  return pairs;
}

}  // namespace voile::picture
