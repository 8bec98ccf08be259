// Candidates of contact against brute force: grids, lists kept over moves, long ways.
#include <doctest/doctest.h>

#include <random>

#include "contact/contact_set.hpp"
#include "test_meshes.hpp"
#include "test_relative.hpp"

namespace test_candidates {

using namespace voile;
using namespace voile::contact;
using namespace voile::testing;

TEST_CASE("candidates: the grid finds what brute force finds, on any division over ranks") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  mesh::MeshData d = grid(9, 7, true, 0.2);
  for (Vec3& x : d.positions) x[2] = 0.3 * std::sin(9.0 * x[0]);
  const mesh::SurfaceMesh mesh(d);
  Surface s = make_surface(mesh, {{"sheet", 0.01}, {"ball", 0.5}, {"rod", 0.1}, {"floor", 0.02}}, {});
  append(s, 1, {Vec3(0.5, 0.5, 0.6)}, {}, {});
  append(s, 2, {Vec3(-0.2, 0.2, 0.2), Vec3(1.2, 0.9, 0.3)}, {}, {{0, 1}});
  append(s, 3, {Vec3(-5, -5, -0.3), Vec3(7, -5, -0.3), Vec3(0, 9, -0.3), Vec3(0.3, 0.3, -0.2)}, {{0, 1, 2}, {1, 2, 3}},
         {});
  std::vector<Box> boxes(static_cast<std::size_t>(s.points()));
  for (Index i = 0; i < s.points(); ++i) {
    boxes[i].include(s.rest[i]);
    boxes[i].include(s.rest[i] + 0.2 * Vec3(u(random), u(random), u(random)));
  }
  std::vector<Pair> together;
  for (int part = 0; part < 3; ++part) {
    std::vector<char> owned(static_cast<std::size_t>(s.sheet_points));
    for (std::size_t i = 0; i < owned.size(); ++i) owned[i] = static_cast<int>(i) % 3 == part;
    const std::vector<Pair> fast = find_pairs(s, all_figures(s), boxes, owned, 0.05),
                            slow = find_pairs_by_force(s, boxes, owned, 0.05);
    REQUIRE(fast.size() == slow.size());
    REQUIRE(fast.size() > 100);
    for (std::size_t i = 0; i < fast.size(); ++i) {
      CHECK(fast[i].points == slow[i].points);
      CHECK(fast[i].kind == slow[i].kind);
    }
    together.insert(together.end(), fast.begin(), fast.end());
  }
  std::sort(together.begin(), together.end());
  together.erase(std::unique(together.begin(), together.end(),
                             [](const Pair& a, const Pair& b) { return a.points == b.points && a.kind == b.kind; }),
                 together.end());
  const std::vector<char> all(static_cast<std::size_t>(s.sheet_points), 1);
  const std::vector<Pair> one = find_pairs(s, all_figures(s), boxes, all, 0.05);
  REQUIRE(one.size() == together.size());
  for (std::size_t i = 0; i < one.size(); ++i) CHECK(one[i].points == together[i].points);
  // Only those of some points: of the sheet, of an obstacle, of all kinds.
  for (const double fraction : {0.0, 0.02, 0.3, 0.9}) {
    CAPTURE(fraction);
    std::vector<char> asked(boxes.size());
    for (char& a : asked) a = u(random) < fraction;
    std::vector<Pair> wanted = one;
    std::erase_if(wanted, [&](const Pair& p) {
      return std::none_of(p.points.begin(), p.points.end(), [&](Index i) { return i != no_index && asked[i]; });
    });
    const std::vector<Pair> some = find_pairs(s, all_figures(s), boxes, all, 0.05, asked);
    REQUIRE(some.size() == wanted.size());
    for (std::size_t i = 0; i < some.size(); ++i) CHECK(some[i].points == wanted[i].points);
  }
}

TEST_CASE("a flat sheet that rests has few candidates, however small its cells are") {
  const mesh::SurfaceMesh mesh(grid(20, 20, false, 0.0));
  const Surface s = make_surface(mesh, {{"sheet", 0.0}}, {});
  const double cell = std::sqrt(s.area[static_cast<std::size_t>(s.sheet_points / 2)]);
  for (const double cells : {0.01, 0.2, 0.45}) {  // activation distance
    CAPTURE(cells);
    Candidates candidates(s, cells * cell, std::vector<char>(static_cast<std::size_t>(s.sheet_points), 1));
    candidates.cover(s.rest, s.rest, nullptr);
    CHECK(static_cast<double>(candidates.pairs().size()) < 12.0 * s.sheet_points);
  }
}

TEST_CASE("candidates kept over many small moves are those found at once") {
  std::mt19937 random(23);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  mesh::MeshData d = grid(9, 7, true, 0.2);
  const mesh::SurfaceMesh mesh(d);
  const auto make = [&] {
    Surface s = make_surface(mesh, {{"sheet", 0.0}, {"ball", 0.2}, {"plate", 0.0}}, {});
    append(s, 1, {Vec3(0.5, 0.5, 0.3)}, {}, {});
    append(s, 2, {Vec3(-1, -1, -0.1), Vec3(3, -1, -0.1), Vec3(0, 3, -0.1)}, {{0, 1, 2}}, {});
    const std::vector<char> owned(static_cast<std::size_t>(s.sheet_points), 1);
    return ContactSet(std::move(s), {}, {0.02, 1e3, 1e-3}, owned);
  };
  ContactSet kept = make();
  std::vector<Vec3> x = kept.surface().rest;
  int found = 0;
  long contacts = 0;
  for (int k = 0; k < 60; ++k) {
    CAPTURE(k);
    std::vector<Vec3> to = x;
    // In turns a few points go far, all go a little, and all go far: into boxes and out of them.
    for (Vec3& p : to)
      p += (k % 3 == 0   ? (u(random) > 0.9 ? 0.1 : 0.0)
            : k % 3 == 1 ? 0.005
                         : 0.06) *
           Vec3(u(random), u(random), u(random));
    found += kept.cover(x, to);
    ContactSet fresh = make();
    (void)fresh.cover(to, to);
    const ContactState a = kept.state(to), b = fresh.state(to);
    CHECK(a.pairs == b.pairs);
    CHECK(a.gap == b.gap);
    contacts += b.pairs;
    x = std::move(to);
  }
  CHECK(found > 30);
  CHECK(contacts > 1000);
}

TEST_CASE("on long ways only what comes near at the same time is a candidate, and all of that") {
  // Two sheets that fly along together by twenty cells and meet on the way.
  mesh::MeshData d = grid(9, 7, true, 0.2);
  const auto half = static_cast<Index>(d.positions.size());
  const std::size_t count = d.triangles.size();
  for (Index v = 0; v < half; ++v) d.positions.push_back(d.positions[v] + Vec3(0.02, 0.03, 0.4));
  for (std::size_t t = 0; t < count; ++t) {
    const auto [a, b, c] = d.triangles[t];
    d.triangles.push_back({a + half, b + half, c + half});
  }
  const mesh::SurfaceMesh mesh(d);
  Surface s = make_surface(mesh, {{"sheet", 0.01}, {"plate", 0.0}}, {});
  append(s, 1, {Vec3(-9, -9, -0.3), Vec3(30, -9, -0.3), Vec3(0, 30, -0.3)}, {{0, 1, 2}}, {});
  const std::vector<char> all(static_cast<std::size_t>(s.sheet_points), 1);
  const std::vector<Vec3> x = s.rest;
  for (const double meet : {0.35, 0.45}) {  // near misses, and through each other
    CAPTURE(meet);
    std::vector<Vec3> to = x;
    for (Index v = 0; v < s.sheet_points; ++v) to[v] += Vec3(3.0, 0.5, v < half ? 0.1 : 0.1 - meet);
    std::vector<Box> boxes(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      boxes[i].include(x[i]);
      boxes[i].include(to[i]);
    }
    double wanted = 1.0;
    const std::vector<Pair> slow = find_pairs_by_force(s, boxes, all, 0.02);
    for (const Pair& pair : slow) {
      std::array<Vec3, 4> at, way;
      for (int i = 0; i < 4; ++i) {
        at[i] = pair.points[i] == no_index ? Vec3(Vec3::Zero()) : x[pair.points[i]];
        way[i] = pair.points[i] == no_index ? Vec3(Vec3::Zero()) : Vec3(to[pair.points[i]] - at[i]);
      }
      wanted = contact::step_fraction(pair.kind, at, way, s.offset(pair.body_a, pair.body_b), wanted);
    }
    ContactSet set(s, {}, {0.02, 1e3, 1e-3}, all);
    CHECK(set.cover(x, to));
    CHECK(set.step_fraction(x, to) == relative(wanted).epsilon(1e-12));
    CHECK((wanted < 1.0) == (meet > 0.4));
    CHECK(set.candidates().pairs().size() < slow.size() / 4);
    // Afterwards they hold around a place again.
    CHECK(set.cover(to, to));
    CHECK_FALSE(set.cover(to, to));
    ContactSet fresh(s, {}, {0.02, 1e3, 1e-3}, all);
    (void)fresh.cover(to, to);
    CHECK(set.state(to).pairs == fresh.state(to).pairs);
  }
}

TEST_CASE("the list of near pairs misses none, wherever points go within its reach") {
  std::mt19937 random(29);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  mesh::MeshData d = grid(9, 7, true, 0.2);
  for (Vec3& x : d.positions) x[2] = 0.2 * std::sin(9.0 * x[0]);
  const mesh::SurfaceMesh mesh(d);
  Surface s = make_surface(mesh, {{"sheet", 0.01}, {"rod", 0.1}}, {});
  append(s, 1, {Vec3(-0.2, 0.2, 0.2), Vec3(1.2, 0.9, 0.3)}, {}, {{0, 1}});
  std::vector<Box> boxes(static_cast<std::size_t>(s.points()));
  for (Index i = 0; i < s.points(); ++i) boxes[i].include(s.rest[i]);
  for (Box& b : boxes) b.include(Box{b.low.array() - 0.2, b.high.array() + 0.2});
  const std::vector<char> all(static_cast<std::size_t>(s.sheet_points), 1);
  const std::vector<Pair> pairs = find_pairs(s, all_figures(s), boxes, all, 0.05);
  const auto offset = [&](const Pair& p) { return p.fraction * s.offset(p.body_a, p.body_b); };
  const auto gap = [&](const Pair& p, const std::vector<Vec3>& x) {
    std::array<Vec3, 4> at;
    for (int i = 0; i < 4; ++i) at[i] = p.points[i] == no_index ? Vec3(Vec3::Zero()) : x[p.points[i]];
    return closest(p.kind, at).distance - offset(p);
  };
  const double limit = 0.05;
  const std::vector<Index> points = all_figures(s).points;
  NearList list(limit, 0.02);
  CHECK_FALSE(list.made());
  std::vector<Vec3> x = s.rest;
  long near = 0, listed = 0, renewed = 0;
  std::vector<Vec3> towards(x.size(), Vec3(Vec3::Zero()));  // what is not quite near comes nearer step by step
  for (const Pair& p : pairs) {
    if (gap(p, x) < limit || gap(p, x) > 2.0 * limit || p.points[3] == no_index) continue;
    const int first = p.kind == PairKind::edge_edge ? 2 : 1;
    const Vec3 n = (x[p.points[3]] - x[p.points[0]]).normalized();
    for (int i = 0; i < 4; ++i) towards[p.points[i]] = i < first ? n : -n;
  }
  for (int k = 0; k < 60; ++k) {
    CAPTURE(k);
    // In turns all go a little, a few go farther than the rest, and all go back; pairs of some are said to be others.
    std::vector<Vec3> from = k % 10 == 9 ? s.rest : x, to = from;
    std::vector<char> changed(from.size(), 0);
    for (std::size_t i = 0; i < to.size(); ++i) {
      const double size = k % 10 == 7 && u(random) > 0.9 ? 0.03 : 0.0045;
      to[i] += size * towards[i];
      changed[i] = k % 7 == 0 && u(random) > 0.9;
    }
    NearList::Moves moved;
    if (list.made()) {
      list.measure(points, from, to, moved);
      renewed += !list.holds(moved, limit);
    }
    list.renew(pairs, points, from, to, k == 0 ? nullptr : &changed, offset);
    list.measure(points, from, to, moved);
    REQUIRE(list.holds(moved, limit));
    CHECK_FALSE(list.holds(moved, 1.01 * limit));
    std::vector<Pair> given;
    list.for_each(moved, limit, [&](const Pair& p) { given.push_back(p); });
    CHECK(std::is_sorted(given.begin(), given.end()));
    for (const double fraction : {0.0, 0.5, 1.0}) {
      for (std::size_t i = 0; i < x.size(); ++i) x[i] = from[i] + fraction * (to[i] - from[i]);
      for (const Pair& p : pairs)
        if (gap(p, x) < limit) {
          CHECK(std::binary_search(given.begin(), given.end(), p));
          ++near;
        }
    }
    listed += static_cast<long>(given.size());
  }
  CHECK(near > 1000);
  CHECK(renewed > 10);
  CHECK(listed < static_cast<long>(60 * pairs.size()) / 2);  // and leaves out most
  // Points that go very far are no matter for a list; nor are those whose pairs are others then.
  std::vector<Vec3> far = x;
  for (Vec3& p : far) p[0] += 1.0;
  const std::vector<char> none(x.size(), 0), some(x.size(), 1);
  NearList::Moves moved;
  list.renew(pairs, points, x, far, &none, offset);
  list.measure(points, x, far, moved);
  CHECK_FALSE(list.holds(moved, limit));
  CHECK(list.made());
  list.renew(pairs, points, x, far, &some, offset);
  CHECK_FALSE(list.made());
  list.forget();
  CHECK_FALSE(list.made());
}

TEST_CASE("what is no candidate comes near nowhere in the boxes") {
  std::mt19937 random(31);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  mesh::MeshData d = grid(7, 5, true, 0.3);
  for (Vec3& x : d.positions) x[2] = 0.2 * std::sin(9.0 * x[0]);
  const mesh::SurfaceMesh mesh(d);
  const Surface s = make_surface(mesh, {{"sheet", 0.01}}, {});
  const std::vector<char> all(static_cast<std::size_t>(s.sheet_points), 1);
  const double reach = 0.1;
  std::vector<Box> everywhere(static_cast<std::size_t>(s.points()));
  for (Box& b : everywhere) b = {Vec3::Constant(-9.0), Vec3::Constant(9.0)};
  const std::vector<Pair> pairs = find_pairs(s, all_figures(s), everywhere, all, reach);
  long near = 0, found = 0;
  for (int k = 0; k < 30; ++k) {
    std::vector<Box> boxes(everywhere.size());
    std::vector<Vec3> x(boxes.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      boxes[i].include(s.rest[i] - 0.03 * Vec3(u(random), u(random), u(random)));
      boxes[i].include(s.rest[i] + 0.03 * Vec3(u(random), u(random), u(random)));
      // Corners of the boxes are where they reach farthest.
      for (int c = 0; c < 3; ++c) x[i][c] = u(random) < 0.5 ? boxes[i].low[c] : boxes[i].high[c];
    }
    const std::vector<Pair> candidates = find_pairs(s, all_figures(s), boxes, all, reach);
    for (const Pair& p : pairs) {
      std::array<Vec3, 4> at;
      for (int i = 0; i < 4; ++i) at[i] = x[p.points[i]];
      const bool is_near = closest(p.kind, at).distance - s.offset(p.body_a, p.body_b) < reach;
      if (is_near) CHECK(std::binary_search(candidates.begin(), candidates.end(), p));
      near += is_near;
    }
    found += static_cast<long>(candidates.size());
  }
  CHECK(near > 300);
  CHECK(found < static_cast<long>(30 * pairs.size()) / 2);
}

}  // namespace test_candidates
