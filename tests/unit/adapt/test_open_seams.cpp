// Open seams across remeshings: both sides keep node by node, so that a weld gives one surface.
#include <functional>
#include <numeric>
#include <optional>
#include <random>

#include "adapt/transfer.hpp"
#include "mesh/weld.hpp"
#include "test_adapt_kit.hpp"
#include "test_relative.hpp"

namespace test_open_seams {

using namespace voile;
using namespace voile::testing;

namespace {

/// The seam along an edge of the grid, by its ends; empty: none.
using Cut = std::function<std::string(const Vec3&, const Vec3&)>;

/// An edge that is opened: a side of either triangle.
struct Open {
  Index t, n;
  int s, sn;
  std::string name;
};

/// Adds both sides of an opened edge to its seam and to the group of that.
void add_to_seam(mesh::MeshData& m, const Open& e) {
  auto seam = std::find_if(m.seams.begin(), m.seams.end(), [&](const mesh::Seam& s) { return s.name == e.name; });
  if (seam == m.seams.end()) {
    m.groups.push_back({mesh::seam_group(e.name), 1, {}, {}, {}});
    seam = m.seams.insert(m.seams.end(), {e.name, {}, {}});
  }
  mesh::Group& group = m.groups[static_cast<std::size_t>(seam - m.seams.begin())];
  const Index a = m.triangles[e.t][(e.s + 1) % 3], b = m.triangles[e.t][(e.s + 2) % 3];
  const Index c = m.triangles[e.n][(e.sn + 2) % 3], d = m.triangles[e.n][(e.sn + 1) % 3];
  group.segments.insert(group.segments.end(), {{a, b}, {c, d}});
  group.vertices.insert(group.vertices.end(), {a, b, c, d});
  for (const auto& pair : {std::array{a, c}, std::array{b, d}}) {
    if (pair[0] == pair[1]) continue;
    const double half = 0.5 * (m.positions[b] - m.positions[a]).norm();
    const auto known = std::find(seam->pairs.begin(), seam->pairs.end(), pair);
    if (known == seam->pairs.end()) {
      seam->pairs.push_back(pair);
      seam->lengths.push_back(half);
    } else {
      seam->lengths[static_cast<std::size_t>(known - seam->pairs.begin())] += half;
    }
  }
}

/// Opens edges of a mesh: a vertex for each fan of triangles that these leave, pairs of those that were one, and groups.
mesh::MeshData opened(mesh::MeshData m, const Cut& cut) {
  const mesh::SurfaceMesh whole(m);
  std::vector<Index> root(3 * m.triangles.size());
  std::iota(root.begin(), root.end(), Index{0});
  const auto find = [&](Index c) {
    while (root[c] != c) c = root[c];
    return c;
  };
  std::vector<Open> open;
  for (Index t = 0; t < whole.triangle_count(); ++t)
    for (int s = 0; s < 3; ++s) {
      const Index n = whole.neighbour(t, s);
      if (n < t) continue;
      const int sn = whole.side_in_neighbour(t, s);
      const std::string name = cut(whole.start_corner(t, (s + 1) % 3), whole.start_corner(t, (s + 2) % 3));
      if (!name.empty()) {
        open.push_back({t, n, s, sn, name});
        continue;
      }
      root[find(3 * t + (s + 1) % 3)] = find(3 * n + (sn + 2) % 3);
      root[find(3 * t + (s + 2) % 3)] = find(3 * n + (sn + 1) % 3);
    }
  const std::vector<Vec3> places = m.positions;
  m.positions.clear();
  std::map<Index, Index> number;
  std::vector<mesh::Triangle> old = m.triangles;
  for (Index c = 0; c < static_cast<Index>(root.size()); ++c) {
    const auto [at, fresh] = number.try_emplace(find(c), static_cast<Index>(m.positions.size()));
    if (fresh) m.positions.push_back(places[old[c / 3][c % 3]]);
    m.triangles[c / 3][c % 3] = at->second;
  }
  for (const Open& e : open) add_to_seam(m, e);
  for (mesh::Group& g : m.groups) {
    std::sort(g.vertices.begin(), g.vertices.end());
    g.vertices.erase(std::unique(g.vertices.begin(), g.vertices.end()), g.vertices.end());
  }
  add_square_groups(m);
  return m;
}

bool on(const Vec3& a, const Vec3& b, int axis, double at) {
  return std::abs(a[axis] - at) + std::abs(b[axis] - at) < 1e-9;
}

/// Four panels that meet in the middle.
std::string crossing(const Vec3& a, const Vec3& b) {
  if (on(a, b, 0, 0.5)) return "upright";
  return on(a, b, 1, 0.5) ? "level" : "";
}
/// A slit from the lower edge to the middle.
std::string dart(const Vec3& a, const Vec3& b) {
  return on(a, b, 0, 0.5) && a[1] + b[1] < 1.0 ? "dart" : "";
}
/// A panel within a hole.
std::string loop(const Vec3& a, const Vec3& b) {
  const auto ring = [](const Vec3& x) { return std::max(std::abs(x[0] - 0.5), std::abs(x[1] - 0.5)); };
  const bool side = on(a, b, 0, 0.25) || on(a, b, 0, 0.75) || on(a, b, 1, 0.25) || on(a, b, 1, 0.75);
  return side && std::max(ring(a), ring(b)) < 0.25 + 1e-9 ? "loop" : "";
}

/// Each quarter of the square gets a chart of its own, if asked for.
void give_charts(mesh::MeshData& m) {
  for (const mesh::Triangle& t : m.triangles) {
    const Vec3 middle = (m.positions[t[0]] + m.positions[t[1]] + m.positions[t[2]]) / 3;
    const double angle = (middle[0] < 0.5 ? 0.3 : 1.1) + (middle[1] < 0.5 ? 0.0 : 2.5);
    const Mat3 turn = Eigen::AngleAxisd(angle, Vec3::UnitZ()).toRotationMatrix();
    m.rest.push_back({turn * m.positions[t[0]], turn * m.positions[t[1]], turn * m.positions[t[2]]});
  }
}

double length_of(const mesh::Seam& seam) {
  return std::accumulate(seam.lengths.begin(), seam.lengths.end(), 0.0);
}

/// Pairs of the same place, no node of a side without one, and a weld that gives the surface that was cut.
void check_seams(const mesh::MeshData& first, const mesh::SurfaceMesh& after, const mesh::SurfaceMesh& whole) {
  const mesh::MeshData& m = after.data();
  REQUIRE(m.seams.size() == first.seams.size());
  for (std::size_t k = 0; k < m.seams.size(); ++k) {
    CHECK(m.seams[k].name == first.seams[k].name);
    const bool is_dart = m.seams[k].name == "dart";
    // The fraction of the tip is nobody's before an edge beside it is halved.
    if (is_dart)
      CHECK(std::abs(length_of(m.seams[k]) - 0.47) < 0.04);
    else
      CHECK(length_of(m.seams[k]) == relative(length_of(first.seams[k])).epsilon(1e-9));
    std::set<Index> nodes;
    double apart = 0.0;
    for (const auto& [a, b] : m.seams[k].pairs) {
      apart = std::max(apart, (m.positions[a] - m.positions[b]).norm());
      nodes.insert({a, b});
    }
    CHECK(apart < 1e-12);
    const std::vector<Index>& on_seam = after.group(mesh::seam_group(m.seams[k].name)).vertices;
    for (const Index v : nodes) CHECK(std::binary_search(on_seam.begin(), on_seam.end(), v));
    CHECK(on_seam.size() - nodes.size() <= (is_dart ? 1U : 0U));
  }
  const std::vector<double> mass(m.positions.size(), 1.0);
  const mesh::SurfaceMesh welded(mesh::weld(m, mesh::open_seams(m, {"all"}), m.positions, mass).data);
  CHECK(welded.component_count() == 1);
  CHECK(euler(welded) == euler(whole));
  double outline = 0.0;
  for (Index t = 0; t < welded.triangle_count(); ++t)
    for (int s = 0; s < 3; ++s)
      if (welded.neighbour(t, s) == no_index)
        outline += (welded.start_corner(t, (s + 1) % 3) - welded.start_corner(t, (s + 2) % 3)).norm();
  CHECK(outline == relative(4.0).epsilon(1e-9));
}

/// Sizes that ask for splits in some places and collapses in others.
std::vector<double> patchy(const mesh::SurfaceMesh& m, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const double y = uniform(random), x = uniform(random);  // in one order with every compiler
  const Vec3 centre(x, y, 0);
  const double finest = 0.01 + 0.03 * uniform(random);
  return sizes(m, [&](const Vec3& p) { return finest + 0.3 * (p - centre).norm(); });
}

}  // namespace

TEST_CASE("open seams keep their sides node by node through remeshings") {
  const std::vector<std::pair<const char*, Cut>> cuts{{"crossing", crossing}, {"dart", dart}, {"loop", loop}};
  for (const auto& panels : cuts)
    for (const bool charts : {false, true}) {
      const std::string name = panels.first;
      if (charts && name != "crossing") continue;
      std::size_t more = 0;
      for (unsigned seed = 1; seed <= 5; ++seed) {
        INFO(name, std::string(charts ? ", with charts" : ""), ", seed ", seed);
        const mesh::MeshData grid_data = grid(8, 8, seed % 2 == 0, 0.0, seed);
        mesh::MeshData first = opened(grid_data, panels.second);
        if (charts) give_charts(first);
        mesh::SurfaceMesh m(first);
        const RestSurface rest(m);
        check_seams(first, m, mesh::SurfaceMesh(grid_data));
        Index splits = 0;
        for (unsigned round = 0; round < 3; ++round) {
          const Remeshed r = remeshed(m, rest, patchy(m, 10 * seed + round));
          const mesh::SurfaceMesh after(r.mesh);
          check_result(m, r, after);
          check_seams(first, after, mesh::SurfaceMesh(grid_data));
          splits += r.counts.splits;
          m = after;
        }
        CHECK(splits > 50);
        more += m.data().seams[0].pairs.size() - first.seams[0].pairs.size();
      }
      CHECK(more > 10);
    }
}

TEST_CASE("new pairs of an open seam know how far along it they are") {
  for (const bool is_dart : {false, true}) {
    mesh::MeshData first = opened(grid(8, 8, false, 0.0, 1), is_dart ? Cut(dart) : Cut(crossing));
    const auto station = [](const mesh::MeshData& m, const mesh::Seam& s, std::size_t k) {
      return m.positions[s.pairs[k][0]][s.name == "level" ? 0 : 1];
    };
    for (mesh::Seam& s : first.seams)
      for (std::size_t k = 0; k < s.pairs.size(); ++k) s.stations.push_back(station(first, s, k));
    mesh::SurfaceMesh m(first);
    const RestSurface rest(m);
    for (unsigned round = 0; round < 2; ++round) m = mesh::SurfaceMesh(remeshed(m, rest, patchy(m, 10 + round)).mesh);
    CHECK(m.data().seams[0].pairs.size() > first.seams[0].pairs.size());
    for (const mesh::Seam& s : m.data().seams) {
      REQUIRE(s.stations.size() == s.pairs.size());
      for (std::size_t k = 0; k < s.pairs.size(); ++k)
        CHECK(s.stations[k] == doctest::Approx(station(m.data(), s, k)).epsilon(1e-9));
    }
  }
}

/// Two squares of opposite diagonals, sewn all round: no corner is cut off in both.
mesh::MeshData pillow(int n) {
  mesh::MeshData m = grid(n, n, false, 0.0);
  const auto half = static_cast<Index>(m.positions.size());
  const std::size_t triangles = m.triangles.size();
  for (Index v = 0; v < half; ++v) m.positions.emplace_back(1.0 - m.positions[v][0], m.positions[v][1], 0.0);
  for (std::size_t t = 0; t < triangles; ++t) {
    const mesh::Triangle v = m.triangles[t];
    m.triangles.push_back({v[0] + half, v[1] + half, v[2] + half});
  }
  mesh::Seam seam{"all round", {}, {}};
  for (Index v = 0; v < half; ++v) {
    const Vec3& x = m.positions[v];
    const auto at_end = [](double y) { return std::abs(y - 0.5) > 0.5 - 1e-9; };
    const Index i = v % (n + 1), other = half + v - i + (n - i);
    if (!at_end(x[0]) && !at_end(x[1])) continue;
    seam.pairs.push_back({v, other});
    seam.lengths.push_back(1.0 / n);
  }
  m.groups.push_back({mesh::seam_group(seam.name), 1, {}, {}, {}});
  const mesh::SurfaceMesh open(m);
  mesh::Group& group = m.groups.back();
  for (Index t = 0; t < open.triangle_count(); ++t)
    for (int s = 0; s < 3; ++s) {
      if (open.neighbour(t, s) != no_index) continue;
      const Index a = m.triangles[t][(s + 1) % 3], b = m.triangles[t][(s + 2) % 3];
      group.segments.push_back({a, b});
      group.vertices.insert(group.vertices.end(), {a, b});
    }
  std::sort(group.vertices.begin(), group.vertices.end());
  group.vertices.erase(std::unique(group.vertices.begin(), group.vertices.end()), group.vertices.end());
  m.seams.push_back(std::move(seam));
  return m;
}

TEST_CASE("no edges are made that open seams would put on top of each other") {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    mesh::SurfaceMesh m(pillow(seed % 2 == 0 ? 3 : 6));
    const RestSurface rest(m);
    for (unsigned round = 0; round < 3; ++round) {
      m = mesh::SurfaceMesh(remeshed(m, rest, patchy(m, 100 * seed + round)).mesh);
      const std::vector<double> mass(m.positions().size(), 1.0);
      const mesh::SurfaceMesh welded(mesh::weld(m.data(), {"all round"}, m.positions(), mass).data);
      CHECK(euler(welded) == 2);
      CHECK(boundary_sides(welded) == 0);
    }
  }
}

TEST_CASE("nodes of open seams stay where all else gets coarser, and are numbered anew") {
  const mesh::MeshData first = opened(grid(16, 16, true, 0.0), crossing);
  const mesh::SurfaceMesh m(first);
  const Remeshed r = remeshed(m, RestSurface(m), sizes(m, [](const Vec3&) { return 0.5; }));
  const mesh::SurfaceMesh after(r.mesh);
  CHECK(2 * after.vertex_count() < m.vertex_count());
  CHECK(r.mesh.seams[0].pairs != first.seams[0].pairs);
  for (std::size_t k = 0; k < first.seams.size(); ++k) {
    REQUIRE(r.mesh.seams[k].pairs.size() == first.seams[k].pairs.size());
    for (std::size_t i = 0; i < first.seams[k].pairs.size(); ++i) {
      const auto& now = r.mesh.seams[k].pairs[i];
      CHECK(std::array{r.kept[now[0]], r.kept[now[1]]} == first.seams[k].pairs[i]);
    }
    CHECK(r.mesh.seams[k].lengths == first.seams[k].lengths);
  }
}

TEST_CASE("frozen triangles on one side of an open seam keep both from being split") {
  const mesh::MeshData first = opened(grid(8, 8, false, 0.0), crossing);
  const mesh::SurfaceMesh m(first);
  Limits limits;
  limits.frozen.assign(static_cast<std::size_t>(m.triangle_count()), 0);
  for (Index t = 0; t < m.triangle_count(); ++t)
    limits.frozen[t] = m.start_corner(t, 0)[0] + m.start_corner(t, 1)[0] + m.start_corner(t, 2)[0] < 1.5;
  const Remeshed r = remeshed(m, RestSurface(m), sizes(m, [](const Vec3&) { return 0.03; }), limits);
  const mesh::SurfaceMesh after(r.mesh);
  check_seams(first, after, mesh::SurfaceMesh(grid(8, 8, false, 0.0)));
  REQUIRE(r.mesh.seams[0].name == "upright");
  CHECK(r.mesh.seams[0].pairs.size() == first.seams[0].pairs.size());
  CHECK(r.mesh.seams[1].pairs.size() > first.seams[1].pairs.size());
}

TEST_CASE("what is new on an open seam is as far from the other side as what is beside it") {
  const mesh::SurfaceMesh m(opened(grid(8, 8, true, 0.0), crossing));
  const Remeshed r = remeshed(m, RestSurface(m), patchy(m, 3));
  std::vector<Vec3> field;
  for (const Vec3& x : m.positions()) field.emplace_back(std::sin(3 * x[0]), x[0] * x[1] * x[1], std::cos(x[1]));
  const Vec3 apart(0.1, -0.2, 0.3);
  for (const auto& [a, b] : m.data().seams[0].pairs) field[b] = field[a] + apart;
  for (const adapt::Interpolation kind : {adapt::Interpolation::smooth, adapt::Interpolation::smoother}) {
    const std::vector<Vec3> now = adapt::transfer(m, r, field, kind);
    double worst = 0.0;
    for (const auto& [a, b] : r.mesh.seams[0].pairs) worst = std::max(worst, (now[b] - now[a] - apart).norm());
    CHECK(worst < 1e-12);
  }
}

}  // namespace test_open_seams
