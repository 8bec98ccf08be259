#include "gas_surface.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "voile/errors.hpp"

namespace voile::system {

namespace {

/// |V| over the three halves power of the area: below it a surface counts as flat.
constexpr double flat = 1e-6;

class Builder {
 public:
  Builder(const mesh::SurfaceMesh& mesh, const Load& load) : mesh_(mesh), load_(load) {
    if (load.group.empty())
      for (Index t = 0; t < mesh.triangle_count(); ++t) triangles_.push_back(t);
    else
      triangles_ = mesh.group(load.group, 2).triangles;
  }

  GasSurface build() {
    find_edges();
    orient();
    for (const Index t : triangles_) surface_.faces.push_back({t, corners(t)});
    find_rims();
    set_origin();
    turn_outwards();
    if (load_.apex) surface_.rims.clear();
    return std::move(surface_);
  }

 private:
  using Edge = std::pair<Index, Index>;

  [[noreturn]] void refuse(const std::string& why) const {
    throw UserError(fmt::format("[[load]] type 'gas', {}: {}",
                                load_.group.empty() ? "the whole surface" : "group '" + load_.group + "'", why));
  }
  [[nodiscard]] std::string place(Index v) const {
    const Vec3& x = mesh_.positions()[v];
    return fmt::format("({:.4g}, {:.4g}, {:.4g}) m", x[0], x[1], x[2]);
  }
  /// As oriented so far.
  [[nodiscard]] std::array<Index, 3> corners(Index t) const {
    const mesh::Triangle& v = mesh_.triangles()[t];
    const auto at = turned_.find(t);
    return at != turned_.end() && at->second ? std::array{v[0], v[2], v[1]} : std::array{v[0], v[1], v[2]};
  }

  void find_edges() {
    for (const Index t : triangles_)
      for (int i = 0; i < 3; ++i) {
        const Index a = mesh_.triangles()[t][i], b = mesh_.triangles()[t][(i + 1) % 3];
        std::vector<Index>& of = triangles_of_[std::minmax(a, b)];
        of.push_back(t);
        if (of.size() > 2)
          refuse(fmt::format("at {} three of its triangles meet; name the surface of one chamber only", place(a)));
      }
  }
  [[nodiscard]] bool runs(Index t, const Edge& edge) const {
    const std::array<Index, 3> v = corners(t);
    for (std::size_t i = 0; i < 3; ++i)
      if (v[i] == edge.first && v[(i + 1) % 3] == edge.second) return true;
    return false;
  }

  void orient() {
    std::vector<Index> open{triangles_.front()};
    turned_[open.front()] = false;
    while (!open.empty()) {
      const Index t = open.back();
      open.pop_back();
      const std::array<Index, 3> v = corners(t);
      for (std::size_t i = 0; i < 3; ++i) {
        const Edge edge{v[i], v[(i + 1) % 3]};
        for (const Index other : triangles_of_.at(std::minmax(edge.first, edge.second))) {
          if (other == t) continue;
          const bool known = turned_.contains(other);
          if (known && runs(other, edge)) refuse("it has one side only (a Moebius strip), and encloses nothing");
          if (known) continue;
          turned_[other] = false;
          turned_[other] = runs(other, edge);
          open.push_back(other);
        }
      }
    }
    if (turned_.size() < triangles_.size())
      refuse("it is of several parts that have no edge in common; give each a [[load]], or join them by mesh.merge");
  }

  void find_rims() {
    std::map<Index, GasSurface::Side> next;
    for (const auto& [edge, of] : triangles_of_) {
      if (of.size() != 1) continue;
      const Edge way = runs(of[0], edge) ? Edge{edge.second, edge.first} : edge;
      if (!next.try_emplace(way.first, GasSurface::Side{of[0], {way.first, way.second}}).second)
        refuse(fmt::format("two rims of holes touch each other at {}; close one of them", place(way.first)));
    }
    while (!next.empty()) {
      GasSurface::Rim rim;
      for (auto at = next.begin(); at != next.end(); at = next.find(rim.sides.back().vertices[1])) {
        rim.sides.push_back(at->second);
        rim.vertices.push_back(at->first);
        next.erase(at);
      }
      surface_.rims.push_back(std::move(rim));
    }
  }

  [[nodiscard]] Vec3 mean(const std::vector<Index>& vertices) const {
    Vec3 sum = Vec3::Zero();
    for (const Index v : vertices) sum += mesh_.positions()[v];
    return sum / static_cast<double>(vertices.size());
  }

  void set_origin() {
    std::vector<Index> all;
    for (const GasSurface::Face& f : surface_.faces) all.insert(all.end(), f.vertices.begin(), f.vertices.end());
    surface_.origin = load_.apex ? *load_.apex : mean(all);
  }

  [[nodiscard]] double enclosed() const {
    const auto six_fold = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
      return Vec3(a - surface_.origin).dot(Vec3(b - surface_.origin).cross(Vec3(c - surface_.origin)));
    };
    const std::vector<Vec3>& x = mesh_.positions();
    double sum = 0.0;
    for (const GasSurface::Face& f : surface_.faces)
      sum += six_fold(x[f.vertices[0]], x[f.vertices[1]], x[f.vertices[2]]);
    if (load_.apex) return sum / 6.0;
    for (const GasSurface::Rim& rim : surface_.rims) {
      const Vec3 centre = mean(rim.vertices);
      for (const GasSurface::Side& s : rim.sides) sum += six_fold(centre, x[s.vertices[0]], x[s.vertices[1]]);
    }
    return sum / 6.0;
  }

  void turn_outwards() {
    double area = 0.0;
    const double volume = enclosed();
    for (const Index t : triangles_)
      area += 0.5 * Vec3(mesh_.start_corner(t, 1) - mesh_.start_corner(t, 0))
                        .cross(Vec3(mesh_.start_corner(t, 2) - mesh_.start_corner(t, 0)))
                        .norm();
    const bool is_flat = std::abs(volume) < flat * std::pow(area, 1.5);
    if (is_flat && load_.added_volume == 0.0)
      refuse(
          fmt::format("it encloses no volume at the start ({:.3g} m^3); begin from an open shape, or give "
                      "added_volume, that of the rigid space behind it",
                      volume));
    // With rigid space an open sheet may be flat, or hang into it: then its normals point away from the gas.
    const bool open = load_.added_volume > 0.0 && !surface_.rims.empty(), turn = !open && volume < 0.0;
    if (turn) {
      for (GasSurface::Face& f : surface_.faces) std::swap(f.vertices[1], f.vertices[2]);
      for (GasSurface::Rim& rim : surface_.rims)
        for (GasSurface::Side& s : rim.sides) std::swap(s.vertices[0], s.vertices[1]);
    }
    surface_.volume = (turn ? -volume : volume) + load_.added_volume;
    if (surface_.volume <= 0.0)
      refuse(
          fmt::format("the gas has a volume of {:.3g} m^3 at the start; normals must point away from the gas, and "
                      "added_volume must be more than the sheet takes from it",
                      surface_.volume));
  }

  const mesh::SurfaceMesh& mesh_;
  const Load& load_;
  std::vector<Index> triangles_;
  std::map<Edge, std::vector<Index>> triangles_of_;
  std::map<Index, bool> turned_;
  GasSurface surface_;
};

}  // namespace

GasSurface gas_surface(const mesh::SurfaceMesh& mesh, const Load& load) {
  return Builder(mesh, load).build();
}

}  // namespace voile::system
