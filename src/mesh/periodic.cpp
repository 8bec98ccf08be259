#include "periodic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "voile/errors.hpp"

namespace voile::mesh {

namespace {

/// Vertices closer than this, relative to the extent of the mesh, are images of each other.
constexpr double same_place = 1e-6;

using Shift = ContinuedSurface::Shift;

std::string place_of(const SurfaceMesh& mesh, Index v) {
  const Vec3& x = mesh.positions()[v];
  return fmt::format("vertex {} ({:.6g}, {:.6g}, {:.6g})", mesh.data().vertex_tags[v], x.x(), x.y(), x.z());
}

/// One pair of curves: which vertex of `to` repeats which of `from`.
class Matcher {
 public:
  Matcher(const SurfaceMesh& mesh, const PeriodicCurves& names)
      : mesh_(mesh), names_(names), from_(curve("from", names.from)), to_(curve("to", names.to)) {
    if (from_.vertices.size() != to_.vertices.size())
      fail(fmt::format("'{}' has {} vertices and '{}' has {}; mesh both curves alike (Periodic Curve in Gmsh)",
                       names.from, from_.vertices.size(), names.to, to_.vertices.size()));
    for (const Index v : from_.vertices)
      if (std::binary_search(to_.vertices.begin(), to_.vertices.end(), v))
        fail(place_of(mesh, v) + " is on both curves; a period leads from one to another one");
  }

  [[nodiscard]] Vec3 translation() const {
    Vec3 sum = Vec3::Zero();
    for (const Index v : to_.vertices) sum += mesh_.positions()[v];
    for (const Index v : from_.vertices) sum -= mesh_.positions()[v];
    return sum / static_cast<double>(to_.vertices.size());
  }

  /// Vertex of `from` that each one of `to` repeats.
  [[nodiscard]] std::map<Index, Index> partners() const {
    const Vec3 t = translation();
    std::map<Index, Index> partner, image;
    for (const Index v : from_.vertices) {
      const Vec3 x = mesh_.positions()[v] + t;
      const auto away = [&](Index w) { return (mesh_.positions()[w] - x).norm(); };
      const Index nearest = *std::min_element(to_.vertices.begin(), to_.vertices.end(),
                                              [&](Index a, Index b) { return away(a) < away(b); });
      if (away(nearest) > same_place * mesh_.extent() || partner.count(nearest) > 0)
        fail(
            fmt::format("{} of '{}', moved by ({:.6g}, {:.6g}, {:.6g}) m, lies {:.3g} m from the nearest vertex of "
                        "'{}'; the curves must differ by a translation and be meshed alike (Periodic Curve in Gmsh)",
                        place_of(mesh_, v), names_.from, t.x(), t.y(), t.z(), away(nearest), names_.to));
      partner[nearest] = v;
      image[v] = nearest;
    }
    require_edges(image);
    return partner;
  }

  /// Edges of both curves, each ascending.
  [[nodiscard]] std::vector<Segment> edges() const {
    std::vector<Segment> all;
    for (const Group* g : {&from_, &to_})
      for (const Segment& s : g->segments) all.push_back({std::min(s[0], s[1]), std::max(s[0], s[1])});
    return all;
  }

  [[noreturn]] void fail(const std::string& why) const {
    throw UserError(
        fmt::format("{}: [[periodic]] from = '{}', to = '{}': {}", mesh_.source(), names_.from, names_.to, why));
  }

 private:
  [[nodiscard]] const Group& curve(const char* key, const std::string& name) const {
    const Group* group = nullptr;
    try {
      group = &mesh_.group(name, 1);
    } catch (const UserError& e) {
      throw UserError(fmt::format("[[periodic]] {}: {}", key, e.what()));
    }
    for (const Segment& s : group->segments)
      for (const Index t : mesh_.triangles_of_vertex(s[0])) {
        const int side = mesh_.side_of(t, s[0], s[1]);
        if (side >= 0 && (mesh_.neighbour(t, side) != no_index || mesh_.is_joint(t, side)))
          fail(fmt::format("the edge {}-{} of '{}' lies inside the surface; name curves of its boundary",
                           mesh_.data().vertex_tags[s[0]], mesh_.data().vertex_tags[s[1]], name));
      }
    return *group;
  }

  void require_edges(const std::map<Index, Index>& image) const {
    std::set<Segment> there;
    for (const Segment& s : to_.segments) there.insert({std::min(s[0], s[1]), std::max(s[0], s[1])});
    for (const Segment& s : from_.segments) {
      const Index a = image.at(s[0]), b = image.at(s[1]);
      if (there.count({std::min(a, b), std::max(a, b)}) == 0)
        fail(fmt::format("the edge {}-{} of '{}' has no image in '{}'; mesh both curves alike",
                         mesh_.data().vertex_tags[s[0]], mesh_.data().vertex_tags[s[1]], names_.from, names_.to));
    }
  }

  const SurfaceMesh& mesh_;
  PeriodicCurves names_;
  const Group &from_, &to_;
};

class Builder {
 public:
  Builder(const SurfaceMesh& mesh, const std::vector<PeriodicCurves>& pairs) : mesh_(mesh) {
    std::map<Segment, std::size_t> taken;
    for (const PeriodicCurves& names : pairs) {
      const Matcher matcher(mesh, names);
      for (const Segment& edge : matcher.edges())
        if (const auto [at, is_new] = taken.emplace(edge, partners_.size()); !is_new)
          matcher.fail(fmt::format("the edge {}-{} belongs to the pair '{}', '{}' too; leave it out of one of them",
                                   mesh.data().vertex_tags[edge[0]], mesh.data().vertex_tags[edge[1]],
                                   pairs[at->second].from, pairs[at->second].to));
      partners_.push_back(matcher.partners());
      result_.translations.push_back(matcher.translation());
    }
    find_roots();
  }

  ContinuedSurface build(int rings) {
    data_ = mesh_.data();
    data_.seams.clear();
    data_.notes.clear();
    for (Index t = 0; t < mesh_.triangle_count(); ++t) result_.original.push_back(t);
    add_images(rings);
    for (Group& g : data_.groups) extend(g);
    result_.surface = std::make_unique<const SurfaceMesh>(std::move(data_));
    require_orientation();
    return std::move(result_);
  }

 private:
  struct Place {
    Index root;
    Shift shift;
    auto operator<=>(const Place&) const = default;
  };

  [[nodiscard]] Place resolve(Index v, int depth) const {
    std::vector<Place> ways;
    for (std::size_t i = 0; i < partners_.size(); ++i) {
      const auto found = partners_[i].find(v);
      if (found == partners_[i].end()) continue;
      if (depth == 0) fail(v);
      ways.push_back(resolve(found->second, depth - 1));
      ++ways.back().shift[i];
    }
    if (ways.empty()) return {v, {}};
    if (std::adjacent_find(ways.begin(), ways.end(), std::not_equal_to<>()) != ways.end()) fail(v);
    return ways.front();
  }

  [[noreturn]] void fail(Index v) const {
    throw UserError(fmt::format(
        "{}: [[periodic]]: {} repeats different vertices along different pairs; use a cell whose pairs meet as the "
        "sides of a parallelogram do",
        mesh_.source(), place_of(mesh_, v)));
  }

  void find_roots() {
    constexpr auto deepest = static_cast<int>(ContinuedSurface::most);
    for (Index v = 0; v < mesh_.vertex_count(); ++v) {
      const Place place = resolve(v, deepest);
      result_.root.push_back(place.root);
      result_.shift.push_back(place.shift);
      vertex_at_[place] = v;
      alike_[place.root].push_back(v);
    }
  }

  /// Vertex of an image of v, `by` so many periods away.
  Index image_of(Index v, const Shift& by) {
    Place place{result_.root[v], result_.shift[v]};
    Vec3 x = mesh_.positions()[v];
    for (std::size_t i = 0; i < partners_.size(); ++i) {
      place.shift[i] += by[i];
      x += by[i] * result_.translations[i];
    }
    const auto [at, is_new] = vertex_at_.emplace(place, static_cast<Index>(data_.positions.size()));
    if (is_new) {
      data_.positions.push_back(x);
      data_.vertex_tags.push_back(mesh_.data().vertex_tags[v]);
      result_.root.push_back(place.root);
      result_.shift.push_back(place.shift);
    }
    return at->second;
  }

  void add_image(Index t, const Shift& by) {
    Triangle corners = mesh_.triangles()[t];
    for (Index& v : corners) v = image_of(v, by);
    data_.triangles.push_back(corners);
    data_.triangle_tags.push_back(mesh_.data().triangle_tags[t]);
    if (!data_.texture.empty()) data_.texture.push_back(std::array(data_.texture[t]));
    result_.original.push_back(t);
  }

  void add_images(int rings) {
    std::set<std::pair<Index, Shift>> done;
    std::set<Place> reached;
    for (const auto& [root, vertices] : alike_)
      for (const Index v : vertices)
        if (vertices.size() > 1) reached.insert({root, result_.shift[v]});
    std::vector<Place> front(reached.begin(), reached.end());
    for (int ring = 0; ring < rings; ++ring) {
      std::vector<Place> next;
      for (const Place& place : front)
        for (const Index v : alike_.at(place.root)) {
          Shift by = place.shift;
          for (std::size_t i = 0; i < by.size(); ++i) by[i] -= result_.shift[v][i];
          if (by == Shift{}) continue;
          for (const Index t : mesh_.triangles_of_vertex(v)) {
            if (!done.emplace(t, by).second) continue;
            add_image(t, by);
            for (const Index w : data_.triangles.back())
              if (const Place there{result_.root[w], result_.shift[w]}; reached.insert(there).second)
                next.push_back(there);
          }
        }
      front.swap(next);
    }
  }

  /// Images are in the surfaces that their originals are in.
  void extend(Group& g) const {
    if (g.dimension != 2) return;
    std::vector<char> inside(static_cast<std::size_t>(mesh_.triangle_count()), 0);
    for (const Index t : g.triangles) inside[t] = 1;
    for (std::size_t t = inside.size(); t < result_.original.size(); ++t)
      if (inside[result_.original[t]]) g.triangles.push_back(static_cast<Index>(t));
  }

  void require_orientation() const {
    const SurfaceMesh& whole = *result_.surface;
    bool alike = whole.joints().empty();
    for (Index t = 0; t < mesh_.triangle_count(); ++t) alike = alike && whole.triangles()[t] == mesh_.triangles()[t];
    if (!alike)
      throw UserError(fmt::format(
          "{}: [[periodic]]: the normals of the sheet at `from` and at `to` do not point to the same side, or more "
          "than two triangles meet at an edge there; correct the orientation, or the groups",
          mesh_.source()));
  }

  const SurfaceMesh& mesh_;
  std::vector<std::map<Index, Index>> partners_;
  std::map<Place, Index> vertex_at_;
  std::map<Index, std::vector<Index>> alike_;  ///< vertices of each root
  ContinuedSurface result_;
  MeshData data_;
};

}  // namespace

ContinuedSurface continue_periodically(const SurfaceMesh& mesh, const std::vector<PeriodicCurves>& pairs, int rings) {
  return Builder(mesh, pairs).build(rings);
}

}  // namespace voile::mesh
