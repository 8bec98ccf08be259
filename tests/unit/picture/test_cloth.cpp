// Cloth in pictures: means over pixels, threads and prints in the material's direction, thickness, textures for other programs.
#include "picture/cloth.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "../test_meshes.hpp"
#include "../test_text.hpp"
#include "picture/cloth_images.hpp"
#include "picture/flat_sheet.hpp"
#include "picture/ray_tracer.hpp"
#include "voile/errors.hpp"

namespace test_cloth {

using namespace voile;
using namespace voile::testing;
using namespace voile::picture;

namespace {

const Vec2f none(0.0F, 0.0F);

std::string refusal(const std::function<void()>& work) {
  try {
    work();
  } catch (const UserError& e) {
    return e.what();
  }
  return "";
}

Surface sheet_of(const mesh::MeshData& mesh, const std::vector<SheetMaterial>& materials) {
  Surface s;
  s.positions = single(mesh.positions);
  s.triangles = mesh.triangles;
  s.normals = corner_normals(s.positions, s.triangles, 1.0);
  s.front = s.back = Rgb(0.05F, 0.1F, 0.4F);
  s.flat = flat_coordinates(mesh, materials);
  return s;
}

/// The unit square from above, `size` pixels wide, without a margin.
Image from_above(const Surface& s, int size) {
  Scene scene;
  scene.surfaces.push_back(s);
  const std::vector<Vec3> corners{{0, 0, 0}, {1, 1, 0}};
  const Camera c = fit_camera(named_view("top", scene.up), scene.up, corners, 1.0, {});
  return render(scene, c, size, size, Quality::draft(), 1);
}

/// How often the brightness crosses its middle along a row, or a column.
int changes(const Image& image, bool along_row, int at) {
  int count = 0;
  for (int i = 3; i + 2 < image.width(); ++i) {
    const auto bright = [&](int k) { return (along_row ? image.at(k, at) : image.at(at, k))[0] > 145; };
    if (bright(i) != bright(i - 1)) ++count;
  }
  return count;
}

double roughness(const Image& image) {
  double sum = 0.0, squares = 0.0;
  int n = 0;
  for (int y = image.height() / 4; y < 3 * image.height() / 4; ++y)
    for (int x = image.width() / 4; x < 3 * image.width() / 4; ++x, ++n) {
      const double b = image.at(x, y)[2];
      sum += b;
      squares += b * b;
    }
  return std::sqrt(std::max(0.0, squares / n - sum * sum / n / n)) / (sum / n);
}

std::shared_ptr<const Cloth> cloth(const std::string& weave, const std::string& print) {
  return std::make_shared<const Cloth>(parse_cloth(weave, print));
}

}  // namespace

TEST_CASE("a pixel that is larger than a repeat sees the mean of the weave, whose light is 1 and whose slopes are 0") {
  for (const Weave weave : {Weave::plain, Weave::twill, Weave::knit})
    for (const bool back : {false, true}) {
      const WeaveTile tile(weave, back);
      const Relief far = tile.mean({0.3F, 0.7F}, {40.0F, 3.0F}, {-2.0F, 35.0F});
      CHECK(far.shade == doctest::Approx(1.0).epsilon(1e-4));
      CHECK(std::abs(far.across) < 1e-4);
      CHECK(std::abs(far.along) < 1e-4);
      double shade = 0.0, warp = 0.0, deviation = 0.0;
      constexpr int n = 40;
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const Vec2f at((static_cast<float>(i) + 0.5F) / n, (static_cast<float>(j) + 0.5F) / n);
          const Relief near = tile.mean(at, {0.02F, 0.0F}, {0.0F, 0.02F});
          shade += near.shade / (n * n);
          warp += near.warp / (n * n);
          deviation += std::abs(near.shade - 1.0) / (n * n);
          // A long pixel across is averaged along its length alone.
          CHECK(std::abs(tile.mean(at, {8.0F, 0.0F}, {0.0F, 1.0F}).shade - 1.0) < 0.02);
        }
      CHECK(shade == doctest::Approx(1.0).epsilon(0.01));
      CHECK(warp == doctest::Approx(far.warp).epsilon(0.03));
      CHECK(deviation > 0.03);
    }
}

TEST_CASE("a print is sharp at a point, half covered on its edges, and half of it covers a large pixel") {
  for (const Print print : {Print::stripes, Print::checks}) {
    CHECK(second_colour(print, 0.01, {0.005F, 0.005F}, none, none) == (print == Print::stripes ? 1.0F : 0.0F));
    CHECK(second_colour(print, 0.01, {0.015F, 0.005F}, none, none) == (print == Print::stripes ? 0.0F : 1.0F));
    CHECK(second_colour(print, 0.01, {-0.005F, 0.025F}, none, none) == (print == Print::stripes ? 0.0F : 1.0F));
    CHECK(second_colour(print, 0.01, {0.02F, 0.005F}, {0.002F, 0.0F}, {0.0F, 0.002F}) == doctest::Approx(0.5));
    for (const float x : {0.0F, 0.013F, 0.4F})
      CHECK(second_colour(print, 0.01, {x, 0.3F * x}, {0.15F, 0.0F}, {0.0F, 0.15F}) ==
            doctest::Approx(0.5).epsilon(0.02));
    double sum = 0.0;
    for (int i = 0; i < 1000; ++i)
      sum += second_colour(print, 0.01, {2e-5F * static_cast<float>(i), 0.004F}, {0.007F, 0.001F}, {0.0F, 0.003F});
    CHECK(sum == doctest::Approx(500.0).epsilon(1e-3));
  }
  // Along its own stripes a long pixel stays sharp.
  CHECK(second_colour(Print::stripes, 0.01, {0.005F, 0.0F}, {0.001F, 0.0F}, {0.0F, 3.0F}) == doctest::Approx(1.0));
}

TEST_CASE("flat coordinates follow the material's direction, in space or in texture coordinates of any unit") {
  const mesh::MeshData plane = grid(4, 3, false, 0.2);
  const double c = std::cos(0.4), s = std::sin(0.4);
  const auto along = [](const std::vector<std::array<Vec2f, 3>>& flat, const mesh::MeshData& mesh, const Vec3& warp) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 e = mesh.positions[static_cast<std::size_t>(mesh.triangles[t][i])] -
                       mesh.positions[static_cast<std::size_t>(mesh.triangles[t][(i + 1) % 3])];
        const Vec2f d = flat[t][i] - flat[t][(i + 1) % 3];
        CHECK(d[0] == doctest::Approx(e.dot(warp.cross(Vec3::UnitZ()))).epsilon(1e-4));
        CHECK(d[1] == doctest::Approx(e.dot(warp)).epsilon(1e-4));
      }
  };
  along(flat_coordinates(plane, {{.direction = Vec3(c, s, 3.0)}}), plane, {c, s, 0.0});
  along(flat_coordinates(plane, {}), plane, Vec3::UnitX());
  mesh::MeshData textured = plane;
  for (const mesh::Triangle& t : plane.triangles) {
    auto& corners = textured.texture.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& x = plane.positions[static_cast<std::size_t>(t[i])];
      corners[i] = 100.0 * Vec2(-x[1], x[0]);  // u is -y, v is x; in cm
    }
  }
  along(flat_coordinates(textured, {{.texture_direction = Vec2(-s, c)}}), plane, {c, s, 0.0});
  along(flat_coordinates(textured, {{.direction = Vec3(c, s, 0.0)}}), plane, {c, s, 0.0});
  along(flat_coordinates(textured, {}), plane, Vec3::UnitX());
  // The warp of a fabric lies at an angle to the axis of its material, also in a mirrored drawing.
  along(flat_coordinates(plane, {{.direction = Vec3::UnitX(), .warp_angle = 0.4}}), plane, {c, s, 0.0});
  along(flat_coordinates(textured, {{.direction = Vec3::UnitX(), .warp_angle = 0.4}}), plane, {c, s, 0.0});
  along(flat_coordinates(textured, {{.texture_direction = Vec2(0.0, 1.0), .warp_angle = 0.4}}), plane, {c, s, 0.0});
  mesh::MeshData mirrored = textured;
  for (auto& corners : mirrored.texture)
    for (Vec2& at : corners) at[0] = -at[0];
  for (const double angle : {0.4, -0.4}) {
    const auto flat = flat_coordinates(mirrored, {{.direction = Vec3::UnitX(), .warp_angle = angle}});
    const Vec3 warp(std::cos(angle), std::sin(angle), 0.0);
    for (std::size_t i = 0; i < 2; ++i) {
      const Vec3 e = plane.positions[static_cast<std::size_t>(plane.triangles[0][i])] -
                     plane.positions[static_cast<std::size_t>(plane.triangles[0][i + 1])];
      CHECK(flat[0][i][1] - flat[0][i + 1][1] == doctest::Approx(e.dot(warp)).epsilon(1e-4));
    }
  }
  // A texture that is stretched over a plane sheet is that of a picture, not of cloth.
  mesh::MeshData stretched = textured;
  for (auto& corners : stretched.texture)
    for (Vec2& at : corners) at[0] *= 1.3;
  along(flat_coordinates(stretched, {{.direction = Vec3(c, s, 0.0)}}), plane, {c, s, 0.0});
  CHECK(uneven_texture(stretched) == 0.0);
  stretched.positions[0] += 0.2 * Vec3::UnitZ();
  CHECK(uneven_texture(stretched) > 0.1);
  const mesh::MeshData curved = mapped(plane, [](const Vec3& x) { return Vec3(x[0], x[1], 0.3 * x[0] * x[0]); });
  CHECK(has(refusal([&] { (void)flat_coordinates(curved, {}); }), "curved at the start"));
}

TEST_CASE("stripes of a known width are counted in the picture, and turn with the material") {
  const mesh::MeshData mesh = grid(5, 5, false, 0.1);
  // 20 stripes of 5 cm on 1 m, the threads of the second picture run along y.
  Surface s = sheet_of(mesh, {{.direction = Vec3::UnitX()}});
  s.cloth = cloth("", "stripes:5cm");
  const Image lying = from_above(s, 200);
  CHECK(changes(lying, true, 95) <= 1);
  CHECK(changes(lying, false, 95) == doctest::Approx(19).epsilon(0.06));
  s.flat = flat_coordinates(mesh, {{.direction = Vec3::UnitY()}});
  const Image upright = from_above(s, 200);
  CHECK(changes(upright, true, 95) == doctest::Approx(19).epsilon(0.06));
  CHECK(changes(upright, false, 95) <= 1);
}

TEST_CASE("the weave is seen from near and gone from afar, without moire, and its colour stays") {
  const mesh::MeshData mesh = grid(2, 2, false, 0.0);
  Surface s = sheet_of(mesh, {{.direction = Vec3(1.0, 0.3, 0.0)}});
  const double smooth = roughness(from_above(s, 100));
  for (const char* weave : {"plain", "twill", "knit"}) {
    s.cloth = cloth(std::string(weave) + ":5cm", "");
    CHECK(roughness(from_above(s, 100)) > smooth + 0.03);
    // A thread of a third of a pixel, on which sampling at points would show moire.
    s.cloth = cloth(std::string(weave) + ":3.3mm", "");
    CHECK(roughness(from_above(s, 100)) < smooth + 0.01);
    double colour[2] = {0.0, 0.0};
    for (const int k : {0, 1}) {
      s.cloth = cloth(std::string(weave) + (k == 0 ? ":5cm" : ":0.1mm"), "");
      const Image image = from_above(s, 100);
      for (int y = 20; y < 80; ++y)
        for (int x = 20; x < 80; ++x)
          colour[k] += from_bytes({image.at(x, y)[0], image.at(x, y)[1], image.at(x, y)[2]})[2];
    }
    CHECK(colour[0] == doctest::Approx(colour[1]).epsilon(0.03));
  }
}

TEST_CASE("a thick sheet is closed and twice its half thickness thick") {
  const mesh::MeshData mesh = grid(3, 2, false, 0.1);
  Surface s = sheet_of(mesh, {});
  thicken(s, 0.02);
  std::map<mesh::Segment, int> turns;  // each edge is passed once in both directions
  for (const mesh::Triangle& t : s.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const Index a = t[i], b = t[(i + 1) % 3];
      const bool back_layer = a >= 12 && b >= 12 && t[0] >= 12 && t[1] >= 12 && t[2] >= 12;
      turns[mesh::ascending(a, b)] += (a < b) != back_layer ? 1 : -1;  // the back layer turns as the front does
    }
  for (const auto& [edge, sum] : turns) CHECK(sum == 0);
  for (std::size_t v = 0; v < 12; ++v) CHECK(s.positions[v][2] - s.positions[v + 12][2] == doctest::Approx(0.02));
  CHECK(s.flat.size() == s.triangles.size());
  CHECK(s.normals.size() == 3 * s.triangles.size());
}

TEST_CASE(
    "textures for other programs: a vertex for each flat place, normals of unit length, prints as they are drawn") {
  const std::vector<mesh::Triangle> triangles{{0, 1, 2}, {1, 3, 2}};
  const SplitSheet whole =
      split_at_seams(triangles, {{Vec2f(0, 0), Vec2f(1, 0), Vec2f(0, 1)}, {Vec2f(1, 0), Vec2f(1, 1), Vec2f(0, 1)}});
  CHECK(whole.triangles == triangles);
  const SplitSheet apart =
      split_at_seams(triangles, {{Vec2f(0, 0), Vec2f(1, 0), Vec2f(0, 1)}, {Vec2f(3, 0), Vec2f(3, 1), Vec2f(2, 1)}});
  CHECK(apart.origin == std::vector<Index>{0, 1, 2, 1, 3, 2});
  const std::vector<Vec3f> x{{0, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {-1, 1, 0}};  // turned: across is y
  for (const Vec3f& t : tangents_of(whole, x, std::vector<Vec3f>(4, Vec3f(0, 0, 1))))
    CHECK((t - Vec3f(0, 1, 0)).norm() < 1e-6F);
  const Image normals = normal_image(Weave::twill);
  for (int i = 0; i < normals.width(); i += 7) {
    Vec3f n;
    for (int k = 0; k < 3; ++k) n[k] = static_cast<float>(normals.at(i, i)[k]) / 127.5F - 1.0F;
    CHECK(n.norm() == doctest::Approx(1.0).epsilon(0.01));
  }
  const Image stripes = print_image(Print::stripes, Rgb::Zero());
  CHECK(stripes.at(3, 3)[0] == 238);
  CHECK(stripes.at(40, 3)[0] == 0);
  const std::vector<char> png = png_bytes(stripes);
  CHECK(std::string(png.data() + 1, 3) == "PNG");
  CHECK(png.size() < 2000);
}

TEST_CASE("what cloth is asked for is read with units, and mistakes are told") {
  CHECK(parse_cloth("twill:0.5mm", "checks:2cm").spacing == doctest::Approx(5e-4));
  CHECK(parse_cloth("knit", "checks:2cm").width == doctest::Approx(0.02));
  CHECK_FALSE(parse_cloth("", "").any());
  for (const auto& [cloth, print, part] : {std::array<const char*, 3>{"satin", "", "plain, twill or knit"},
                                           {"twill:", "", "no length"},
                                           {"twill:3", "", "unit"},
                                           {"", "dots:1mm", "stripes:WIDTH"},
                                           {"", "stripes", "no length"},
                                           {"", "stripes:-1mm", "range"},
                                           {"", "stripes:nanmm", "range"}})
    CHECK(has(refusal([&, a = cloth, b = print] { (void)parse_cloth(a, b); }), part));
}

}  // namespace test_cloth
