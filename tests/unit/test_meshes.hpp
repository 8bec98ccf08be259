// Meshes for tests: structured grids with all the patterns that the element must survive, and unstructured ones.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <string>

#include "base/mpi.hpp"
#include "base/petsc.hpp"
#include "formats/gmsh.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::testing {

enum class Pattern { diagonal, union_jack, jittered, gmsh, split };

inline std::string name_of(Pattern p) {
  static const std::array<const char*, 5> names{"diagonal", "union_jack", "jittered", "gmsh", "valence-3"};
  return names[static_cast<std::size_t>(p)];
}

/// Edge groups of the unit square from coordinates: left x=0, right x=1, bottom y=0, top y=1.
inline void add_square_groups(mesh::MeshData& d) {
  struct Side {
    const char* name;
    int axis;
    double at;
  };
  for (const Side side : {Side{"left", 0, 0.0}, Side{"right", 0, 1.0}, Side{"bottom", 1, 0.0}, Side{"top", 1, 1.0}}) {
    const auto on = [&](Index v) { return std::abs(d.positions[v][side.axis] - side.at) < 1e-9; };
    mesh::Group g{side.name, 1, {}, {}, {}};
    for (Index v = 0; v < static_cast<Index>(d.positions.size()); ++v)
      if (on(v)) g.vertices.push_back(v);
    for (const mesh::Triangle& t : d.triangles)
      for (int s = 0; s < 3; ++s) {
        const Index a = t[(s + 1) % 3], b = t[(s + 2) % 3];
        if (on(a) && on(b)) g.segments.push_back({a, b});
      }
    d.groups.push_back(g);
  }
}

/// nx x ny cells on the unit square.
inline mesh::MeshData grid(int nx, int ny, bool alternate, double jitter, unsigned seed = 1) {
  mesh::MeshData d;
  d.source = "grid";
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> noise(-jitter, jitter);
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i) {
      const bool inside = i > 0 && i < nx && j > 0 && j < ny;
      const double dx = noise(random), dy = noise(random);
      d.positions.push_back({(i + (inside ? dx : 0.0)) / nx, (j + (inside ? dy : 0.0)) / ny, 0.0});
    }
  const auto at = [&](int i, int j) { return static_cast<Index>(j * (nx + 1) + i); };
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      const Index a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), e = at(i, j + 1);
      if (alternate && (i + j) % 2 == 1) {
        d.triangles.push_back({a, b, e});
        d.triangles.push_back({b, c, e});
      } else {
        d.triangles.push_back({a, b, c});
        d.triangles.push_back({a, c, e});
      }
    }
  return d;
}

/// Splits every `every`-th triangle at its barycentre: interior vertices of valence three.
inline void split_some(mesh::MeshData& d, int every) {
  std::vector<mesh::Triangle> result;
  for (std::size_t t = 0; t < d.triangles.size(); ++t) {
    const mesh::Triangle v = d.triangles[t];
    if (static_cast<int>(t) % every != every / 2) {
      result.push_back(v);
      continue;
    }
    const auto c = static_cast<Index>(d.positions.size());
    d.positions.push_back((d.positions[v[0]] + d.positions[v[1]] + d.positions[v[2]]) / 3.0);
    for (int i = 0; i < 3; ++i) result.push_back({v[i], v[(i + 1) % 3], c});
  }
  d.triangles.swap(result);
}

/// A unique file in the temporary folder, removed at the end of the scope.
class TemporaryFile {
 public:
  TemporaryFile(const std::string& suffix, const std::string& content) {
    static int count = 0;
    path_ = std::filesystem::temp_directory_path() /
            ("voile_test_" + std::to_string(getpid()) + "_" + std::to_string(count++) + suffix);
    std::ofstream(path_) << content;
  }
  ~TemporaryFile() { std::filesystem::remove(path_); }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Unstructured mesh of the unit square with edges of about 1/n. The same on all ranks: Gmsh is deterministic.
inline mesh::MeshData gmsh_square(int n) {
  const std::string size = std::to_string(1.0 / n);
  const TemporaryFile file(".geo",
                           "h = " + size +
                               ";\nPoint(1)={0,0,0,h};Point(2)={1,0,0,h};Point(3)={1,1,0,h};Point(4)={0,1,0,h};\n"
                               "Line(1)={1,2};Line(2)={2,3};Line(3)={3,4};Line(4)={4,1};\n"
                               "Curve Loop(1)={1,2,3,4};Plane Surface(1)={1};Physical Surface(\"all\")={1};\n"
                               "Point(5)={0.5,0.5,0,h};Point{5} In Surface{1};Mesh.Algorithm=5;\n");
  mesh::MeshData d = formats::read_gmsh(file.path().string(), {});
  d.groups.clear();
  return d;
}

/// The unit square with n cells per side, with edge groups.
inline mesh::MeshData square(Pattern p, int n) {
  mesh::MeshData d =
      p == Pattern::gmsh ? gmsh_square(n) : grid(n, n, p == Pattern::union_jack, p == Pattern::jittered ? 0.25 : 0.0);
  if (p == Pattern::split) split_some(d, 20);
  add_square_groups(d);
  return d;
}

/// Moves every vertex of a mesh of the unit square.
inline mesh::MeshData mapped(mesh::MeshData d, const std::function<Vec3(const Vec3&)>& f) {
  for (Vec3& x : d.positions) x = f(x);
  return d;
}

inline double total_area(const mesh::SurfaceMesh& m) {
  double sum = 0.0;
  for (Index t = 0; t < m.triangle_count(); ++t) sum += m.area(t);
  return sum;
}

}  // namespace voile::testing
