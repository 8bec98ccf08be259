// Pictures by rays: against a stored picture, as the eye sees the difference; with a flipped normal or another colour map they
// must not pass.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "picture/lettering.hpp"
#include "picture/pieces.hpp"
#include "picture/ray_tracer.hpp"

namespace test_rendering {

using namespace voile;
using namespace voile::picture;

namespace {

constexpr int width = 144, height = 108;
constexpr double tolerance = 0.004;  // of the difference below; what is another picture exceeds it fourfold

/// A wavy sheet over a ball: half of it in colours of a field, half plain.
Scene waves(bool flipped = false) {
  Scene scene;
  scene.ground = -0.6;
  scene.scale = make_scale(-0.3, 0.3);
  for (int part = 0; part < 2; ++part) {
    Surface& s = scene.surfaces.emplace_back();
    constexpr int n = 24;
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        const double x = -1.0 + part + static_cast<double>(i) / n, y = -0.7 + 1.4 * j / n;
        s.positions.emplace_back(x, y, 0.3 * std::sin(5.0 * x) * std::cos(3.0 * y));
      }
    for (Index j = 0; j < n; ++j)
      for (Index i = 0; i < n; ++i) {
        const Index a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
        s.triangles.push_back(flipped ? mesh::Triangle{a, d, b} : mesh::Triangle{a, b, d});
        s.triangles.push_back(flipped ? mesh::Triangle{a, c, d} : mesh::Triangle{a, d, c});
      }
    s.normals = corner_normals(s.positions, s.triangles, 1.2);
    s.front = from_bytes({66, 119, 178});
    s.back = from_bytes({226, 170, 112});
    if (part == 1)
      for (const Vec3f& x : s.positions) s.values.push_back(x.z());
  }
  return scene;
}

Image drawn(const Scene& scene, const Quality& quality = Quality::draft(), int threads = 1) {
  std::vector<Vec3> points;
  for (const Surface& s : scene.surfaces)
    for (const Vec3f& x : s.positions) points.push_back(x.cast<double>());
  const Camera c = fit_camera(named_view("three-quarter", scene.up), scene.up, points,
                              static_cast<double>(width) / height, {0.05, 0.95, 0.05, 0.95});
  return render(scene, c, width, height, quality, threads);
}

/// Mean over blocks of 4 x 4 pixels of the distance of their mean colours in OKLab: noise of single pixels does not count.
double difference(const Image& a, const Image& b) {
  REQUIRE(a.width() == b.width());
  REQUIRE(a.height() == b.height());
  double sum = 0.0;
  int blocks = 0;
  for (int y = 0; y + 4 <= a.height(); y += 4)
    for (int x = 0; x + 4 <= a.width(); x += 4, ++blocks) {
      Rgb of_a = Rgb::Zero(), of_b = Rgb::Zero();
      for (int k = 0; k < 16; ++k) {
        const std::uint8_t *p = a.at(x + k % 4, y + k / 4), *q = b.at(x + k % 4, y + k / 4);
        of_a += from_bytes({p[0], p[1], p[2]}) / 16.0F;
        of_b += from_bytes({q[0], q[1], q[2]}) / 16.0F;
      }
      sum += (to_oklab(of_a) - to_oklab(of_b)).norm();
    }
  return sum / blocks;
}

const std::filesystem::path stored = std::filesystem::path(VOILE_SOURCE_FOLDER) / "tests/unit/picture/waves.png";

}  // namespace

TEST_CASE("values of triangles are theirs, also of a surface with as many vertices") {
  // A ring of cells one high, closed: 2 n vertices, 2 n triangles.
  constexpr Index n = 12;
  Scene scene;
  scene.scale = make_scale(0.0, 1.0);
  Surface& s = scene.surfaces.emplace_back();
  for (Index i = 0; i < n; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / n;
    for (const double z : {0.0, 0.5}) s.positions.emplace_back(std::cos(angle), std::sin(angle), z);
    const Index a = 2 * i, b = 2 * ((i + 1) % n);
    s.triangles.push_back({a, b, b + 1});
    s.triangles.push_back({a, b + 1, a + 1});
  }
  s.normals = corner_normals(s.positions, s.triangles, 1.2);
  REQUIRE(s.positions.size() == s.triangles.size());
  s.values_on_triangles = true;
  for (std::size_t t = 0; t < s.triangles.size(); ++t) s.values.push_back(t % 2 == 0 ? 1.0F : 0.0F);
  const Image by_values = drawn(scene);
  for (const float x : s.values) s.triangle_colours.push_back(scene.scale.map(scene.scale.place(x)));
  const Image expected = drawn(scene);
  CHECK(difference(by_values, expected) < 1e-6);
}

TEST_CASE("a picture is the stored one; VOILE_STORE_PICTURES=1 stores it anew") {
  if (std::getenv("VOILE_STORE_PICTURES")) write_png(stored, drawn(waves(), Quality::final()));
  const Image expected = read_png(stored);
  CHECK(difference(drawn(waves()), expected) < tolerance);
  CHECK(difference(drawn(waves(), Quality::final()), expected) < 0.5 * tolerance);
  SUBCASE("a flipped sheet is another picture") {
    CHECK(difference(drawn(waves(true)), expected) > 4.0 * tolerance);
  }
  SUBCASE("so is another colour map") {
    Scene scene = waves();
    scene.scale.map = ColourMap::sequential();
    CHECK(difference(drawn(scene), expected) > 4.0 * tolerance);
  }
  SUBCASE("and one of normals that do not belong to the triangles") {
    Scene scene = waves();
    for (Surface& s : scene.surfaces)
      for (Vec3f& n : s.normals) n = Vec3f(0.8F, 0, 0.6F);
    CHECK(difference(drawn(scene), expected) > 4.0 * tolerance);
  }
  SUBCASE("and one without the ground and its shadow") {
    Scene scene = waves();
    scene.ground.reset();
    CHECK(difference(drawn(scene), expected) > 4.0 * tolerance);
  }
}

TEST_CASE("the number of threads does not change a picture") {
  const Scene scene = waves();
  const Image one = drawn(scene), three = drawn(scene, Quality::draft(), 3);
  CHECK(std::equal(one.at(0, 0), one.at(0, 0) + 3 * width * height, three.at(0, 0)));
}

TEST_CASE("each side of a sheet has its colour, whichever way the viewer looks") {
  const auto middle = [](const char* view) {
    Scene scene;
    Surface& s = scene.surfaces.emplace_back();
    s.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    s.triangles = {{0, 1, 2}, {0, 2, 3}};
    s.normals = corner_normals(s.positions, s.triangles, 1.0);
    s.front = Rgb(1, 0, 0);
    s.back = Rgb(0, 0, 1);
    std::vector<Vec3> points;
    for (const Vec3f& x : s.positions) points.push_back(x.cast<double>());
    const Camera c = fit_camera(named_view(view, Vec3::UnitZ()), Vec3::UnitZ(), points, 1.0, {});
    const Image image = render(scene, c, 32, 32, Quality::draft(), 1);
    const std::uint8_t* p = image.at(16, 16);
    return Bytes3{p[0], p[1], p[2]};
  };
  CHECK(middle("top")[0] > 200);
  CHECK(middle("top")[2] < 30);
  CHECK(middle("bottom")[2] > 120);
  CHECK(middle("bottom")[0] < 30);
}

TEST_CASE("edges are red where the sheet is folded by more than asked for") {
  // Upwards at x = 1 by 90 degrees, on by 45 degrees at x = 2.
  mesh::MeshData mesh;
  mesh.triangles = {{0, 1, 3}, {0, 3, 2}, {2, 3, 5}, {2, 5, 4}, {4, 5, 7}, {4, 7, 6}};
  const double c = std::sqrt(0.5);
  const std::vector<Vec3> x{{0, 1, 0}, {0, 0, 0}, {1, 1, 0},         {1, 0, 0},
                            {1, 1, 1}, {1, 0, 1}, {1 + c, 1, 1 + c}, {1 + c, 0, 1 + c}};
  const auto marked = [&](double degrees) {
    std::vector<int> sides;
    for (const std::uint8_t m : folded_sides(mesh, x, degrees * std::numbers::pi / 180.0)) sides.push_back(m);
    return sides;
  };
  CHECK(marked(91) == std::vector{0, 0, 0, 0, 0, 0});
  CHECK(marked(89) == std::vector{0, 1, 4, 0, 0, 0});
  CHECK(marked(44) == std::vector{0, 1, 4, 1, 4, 0});

  Scene scene;
  Surface& s = scene.surfaces.emplace_back();
  for (const Vec3& p : x) s.positions.push_back(p.cast<float>());
  s.triangles = mesh.triangles;
  s.normals = corner_normals(s.positions, s.triangles, 1.0);
  s.front = s.back = Rgb(0.1F, 0.1F, 0.9F);
  const Camera camera = fit_camera(named_view("left", Vec3::UnitZ()), Vec3::UnitZ(), x, 1.0, {});
  const auto red = [&] {
    const Image image = render(scene, camera, 64, 64, Quality::draft(), 1);
    int count = 0;
    for (int j = 0; j < 64; ++j)
      for (int i = 0; i < 64; ++i) count += image.at(i, j)[0] > image.at(i, j)[2] + 40;
    return count;
  };
  CHECK(red() == 0);
  s.red_sides = folded_sides(mesh, x, 0.7);
  CHECK(red() > 20);
}

TEST_CASE("normals are smooth over a round surface and break at a crease") {
  // A roof: two quads at a right angle.
  const std::vector<Vec3f> x{{0, 0, 1}, {1, 0, 1}, {0, 1, 0}, {1, 1, 0}, {0, -1, 0}, {1, -1, 0}};
  const std::vector<mesh::Triangle> t{{0, 1, 3}, {0, 3, 2}, {1, 0, 4}, {1, 4, 5}};
  const std::vector<Vec3f> sharp = corner_normals(x, t, 1.0), smooth = corner_normals(x, t, 2.0);
  CHECK((sharp[0] - Vec3f(0, std::sqrt(0.5F), std::sqrt(0.5F)) * (sharp[0].z() > 0 ? 1.0F : -1.0F)).norm() < 1e-5F);
  CHECK(std::abs(smooth[0].y()) < 0.3F);
  CHECK(smooth.size() == 12);
  for (const Vec3f& n : smooth) CHECK(n.norm() == doctest::Approx(1.0));
}

TEST_CASE("letters are drawn where they are asked for") {
  Image image(200, 40);
  draw_text(image, 10, 30, "Mode 3: 12.5 Hz \u00d7", 20.0, {0, 0, 0});
  int dark = 0, left = 200, right = 0;
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 200; ++x)
      if (image.at(x, y)[0] < 128) {
        ++dark;
        left = std::min(left, x);
        right = std::max(right, x);
      }
  CHECK(dark > 200);
  CHECK(left >= 9);
  CHECK(right <= 11 + text_width("Mode 3: 12.5 Hz \u00d7", 20.0));
  CHECK(right > 0.9 * text_width("Mode 3: 12.5 Hz \u00d7", 20.0));
}

}  // namespace test_rendering
