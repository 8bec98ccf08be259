#include "tangle.hpp"

#include <algorithm>

#include "lettering.hpp"
#include "ray_tracer.hpp"

namespace voile::picture {

namespace {

constexpr double crease = 40.0 / 57.29578;  // [rad]
constexpr double near_fraction = 0.15;      // of the size of what intersects: the view from near
constexpr double near_edges = 4.0;          // and no less in edges of a triangle there
const Bytes3 red{214, 32, 32}, grey{196, 192, 186};

/// The triangles that `wanted` chooses, each part in its colour.
template <class Wanted>
Scene scene_of(const Tangle& tangle, const Wanted& wanted) {
  Scene scene;
  Surface& s = scene.surfaces.emplace_back();
  for (const Vec3& x : tangle.positions) s.positions.push_back(x.cast<float>());
  for (std::size_t t = 0; t < tangle.triangles.size(); ++t) {
    if (!wanted(t)) continue;
    s.triangles.push_back(tangle.triangles[t]);
    s.triangle_colours.push_back(tangle.hit[t]         ? from_bytes(red)
                                 : tangle.piece[t] < 0 ? from_bytes(grey)
                                                       : category_colour(static_cast<std::size_t>(tangle.piece[t])));
  }
  s.normals = corner_normals(s.positions, s.triangles, crease);
  s.mesh_lines = true;
  return scene;
}

template <class Wanted>
std::vector<Vec3> corners_of(const Tangle& tangle, const Wanted& wanted) {
  std::vector<Vec3> points;
  for (std::size_t t = 0; t < tangle.triangles.size(); ++t)
    if (wanted(t))
      for (const Index v : tangle.triangles[t]) points.push_back(tangle.positions[static_cast<std::size_t>(v)]);
  return points;
}

/// Corners of a box about the triangle that is nearest to the middle of all of them; three points each.
std::vector<Vec3> round_one(const std::vector<Vec3>& corners) {
  Vec3 low = corners.front(), high = low;
  for (const Vec3& x : corners) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  const Vec3 middle = 0.5 * (low + high);
  std::size_t nearest = 0;
  for (std::size_t k = 0; k < corners.size(); k += 3)
    if ((corners[k] - middle).norm() < (corners[nearest] - middle).norm()) nearest = k;
  const Vec3& at = corners[nearest];
  const double half =
      std::max(near_fraction * (high - low).norm(), near_edges * (corners[nearest + 1] - corners[nearest]).norm());
  return {at - Vec3::Constant(half), at + Vec3::Constant(half)};
}

}  // namespace

Image picture_of(const Tangle& tangle, int width, int height) {
  const auto of_sheet = [&](std::size_t t) { return tangle.piece[t] >= 0; };
  const auto hit = [&](std::size_t t) { return tangle.hit[t] != 0; };
  const Scene whole = scene_of(tangle, [](std::size_t) { return true; }),
              open = scene_of(tangle, [&](std::size_t t) { return of_sheet(t) || hit(t); });
  const std::vector<Vec3> sheet = corners_of(tangle, of_sheet), near = round_one(corners_of(tangle, hit));
  struct Part {
    const char* view;
    const char* text;
    const Scene& scene;
    const std::vector<Vec3>& points;
  };
  const Part parts[] = {{"three-quarter", "what intersects is red", whole, sheet},
                        {"three-quarter", "from behind", whole, sheet},
                        {"three-quarter", "obstacles left out, but for what intersects", open, sheet},
                        {"three-quarter", "from near", whole, near}};
  Image image(width, height);
  const int w = width / 2, h = height / 2;
  const double line = std::max(9.0, height / 60.0);
  for (int i = 0; i < 4; ++i) {
    const Part& p = parts[i];
    View view = named_view(p.view, Vec3::UnitZ());
    if (i == 1) view.back = Vec3(-1, 2, 1);
    const Camera camera =
        fit_camera(view, Vec3::UnitZ(), p.points, static_cast<double>(w) / h, {0.05, 0.95, 0.1, 0.95});
    const int x = i % 2 * w, y = i / 2 * h;
    image.paste(render(p.scene, camera, w, h, Quality::draft()), x, y);
    draw_text(image, x + 0.8 * line, y + 1.4 * line, p.text, line, ink);
  }
  return image;
}

}  // namespace voile::picture
