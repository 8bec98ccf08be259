#include "tracing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <numbers>

#include "voile/errors.hpp"

namespace voile::picture {

namespace {

constexpr float eye_light = 0.09F;                        // from the viewer, without shadows
constexpr float field_evenness = 0.45F;                   // how much less a field is shaded
constexpr float returned = 0.22F;                         // light of the sky that comes back from what is in its way
constexpr float sky_reach = 0.35F;                        // what is farther away does not darken [sizes of the scene]
constexpr float line_pixels = 0.55F, mark_pixels = 1.3F;  // half widths
constexpr float line_strength = 0.55F;
constexpr float brightest_ground = 1.2F;  // of one sample: a cut at 1 would make their mean darker than the background

/// Two unit vectors that make a right angle with n and each other.
std::pair<Vec3f, Vec3f> around(const Vec3f& n) {
  const Vec3f u = n.unitOrthogonal();
  return {u, n.cross(u)};
}

RTCRay ray_of(const Vec3f& from, const Vec3f& direction, float far) {
  RTCRay ray{};
  ray.org_x = from[0], ray.org_y = from[1], ray.org_z = from[2];
  ray.dir_x = direction[0], ray.dir_y = direction[1], ray.dir_z = direction[2];
  ray.tfar = far;
  ray.mask = 0xFFFFFFFFU;
  return ray;
}

/// Copies an array into a new buffer of a geometry.
template <class Value>
void fill_buffer(RTCGeometry g, RTCBufferType type, RTCFormat format, const std::vector<Value>& values) {
  auto* to = static_cast<Value*>(rtcSetNewGeometryBuffer(g, type, 0, format, sizeof(Value), values.size()));
  if (!to) throw std::bad_alloc();
  std::copy(values.begin(), values.end(), to);
}

Rgb mix(const Rgb& a, const Rgb& b, float t) {
  return a + t * (b - a);
}

}  // namespace

Tracer::Tracer(const Scene& scene, const Camera& camera, int height, int threads)
    : scene_(scene), camera_(camera), up_(scene.up.cast<float>()), middle_(Vec3f::Zero()) {
  device_ = rtcNewDevice(fmt::format("threads={}", threads).c_str());
  check_device("start");
  rays_ = rtcNewScene(device_);
  rtcSetSceneFlags(rays_, RTC_SCENE_FLAG_ROBUST);
  Vec3f low = Vec3f::Constant(std::numeric_limits<float>::max()), high = -low;
  for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
    const Surface& s = scene.surfaces[i];
    if (s.triangles.empty()) continue;
    const RTCGeometry g = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    fill_buffer(g, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, s.positions);
    fill_buffer(g, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, s.triangles);
    rtcCommitGeometry(g);
    rtcAttachGeometryByID(rays_, g, static_cast<unsigned>(i));
    rtcReleaseGeometry(g);
    for (const Vec3f& x : s.positions) {
      low = low.cwiseMin(x);
      high = high.cwiseMax(x);
    }
  }
  rtcCommitScene(rays_);
  check_device("take the scene");
  if (low[0] <= high[0]) {
    middle_ = 0.5F * (low + high);
    size_ = std::max((high - low).norm(), std::numeric_limits<float>::min());
  }
  pixel_ = static_cast<float>(2.0 * camera.tan_y) / static_cast<float>(height);
  // Over the viewer's left shoulder, but always from above.
  const Vec3f right = camera.right.cast<float>(), back = camera.back.cast<float>();
  const Vec3f level = back - back.dot(up_) * up_;
  lamp_ = (up_ - right * 0.95F + level * 0.6F).normalized();
  rim_ = (0.5F * up_ + right * 0.95F - level * 0.6F).normalized();
}

void Tracer::check_device(const char* what) const {
  const RTCError error = rtcGetDeviceError(device_);
  if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  if (!device_ || error != RTC_ERROR_NONE)
    throw InternalError(fmt::format("Embree does not {} (error {})", what, static_cast<int>(error)));
}

Tracer::~Tracer() {
  if (rays_) rtcReleaseScene(rays_);
  if (device_) rtcReleaseDevice(device_);
}

bool Tracer::blocked(const Vec3f& from, const Vec3f& direction, float far) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray = ray_of(from, direction, far);
  rtcOccluded1(rays_, &context, &ray);
  return ray.tfar < 0.0F;
}

Rgb Tracer::colour_at(const Surface& s, std::size_t t, const Eigen::Vector3f& bary, bool is_front) const {
  const mesh::Triangle& corners = s.triangles[t];
  Rgb colour = is_front ? s.front : s.back;
  if (!s.triangle_colours.empty()) {
    colour = s.triangle_colours[t];
  } else if (s.values_on_triangles) {
    colour = scene_.scale.map(scene_.scale.place(s.values[t]));
  } else if (!s.values.empty()) {
    float value = 0.0F;
    for (int i = 0; i < 3; ++i)
      value += bary[i] * s.values[static_cast<std::size_t>(corners[static_cast<std::size_t>(i)])];
    colour = scene_.scale.map(scene_.scale.place(value));
  }
  return colour;
}

/// `width`: of a pixel there [m].
void Tracer::draw_lines(const Surface& s, std::size_t t, const Eigen::Vector3f& bary, float width, Rgb& colour) const {
  const mesh::Triangle& corners = s.triangles[t];
  const unsigned marks = s.marked_sides.empty() ? 0U : s.marked_sides[t];
  const unsigned reds = s.red_sides.empty() ? 0U : s.red_sides[t];
  if (!s.mesh_lines && marks == 0U && reds == 0U) return;
  const auto x = [&](std::size_t i) -> const Vec3f& { return s.positions[static_cast<std::size_t>(corners[i % 3])]; };
  const float twice_area = (x(1) - x(0)).cross(x(2) - x(0)).norm();
  for (std::size_t i = 0; i < 3; ++i) {
    const float side = (x(i + 2) - x(i + 1)).norm(), height = twice_area / std::max(side, 1e-30F);
    const float pixels = bary[static_cast<int>(i)] * height / width;
    const bool red = (reds >> i & 1U) != 0U, marked = red || (marks >> i & 1U) != 0U;
    if (s.mesh_lines && !marked) {
      // Lines closer than a few pixels would make the surface dark.
      const float fade = std::clamp((height / width - 3.0F) / 5.0F, 0.0F, 1.0F);
      colour = mix(colour, Rgb(0.03F, 0.03F, 0.04F),
                   fade * line_strength * std::clamp(line_pixels + 0.5F - pixels, 0.0F, 1.0F));
    }
    if (marked)
      colour = mix(colour, red ? Rgb(0.55F, 0.02F, 0.01F) : Rgb(0.015F, 0.015F, 0.02F),
                   0.9F * std::clamp((red ? 2.0F : 1.0F) * mark_pixels + 0.5F - pixels, 0.0F, 1.0F));
  }
}

/// `flat`: normal of the triangle on the viewer's side.
Rgb Tracer::cloth_at(const RTCRayHit& hit, const Vec3f& direction, const Sample& sample, const Vec3f& flat) const {
  const Surface& s = scene_.surfaces[hit.hit.geomID];
  const std::size_t t = hit.hit.primID;
  const mesh::Triangle& v = s.triangles[t];
  const std::array<Vec2f, 3>& at = s.flat[t];
  const Vec3f& corner = s.positions[static_cast<std::size_t>(v[0])];
  const Vec3f e = s.positions[static_cast<std::size_t>(v[1])] - corner,
              f = s.positions[static_cast<std::size_t>(v[2])] - corner;
  const Vec2f a = at[1] - at[0], b = at[2] - at[0];
  const float ee = e.squaredNorm(), ef = e.dot(f), ff = f.squaredNorm(), area2 = std::max(ee * ff - ef * ef, 1e-37F);
  // A side of the pixel, put on the triangle along the ray, in flat coordinates.
  const float towards = std::min(direction.dot(flat), -0.02F);
  const auto flattened = [&](const Vec3f& side) {
    const Vec3f d = side - direction * (side.dot(flat) / towards);
    const float de = d.dot(e), df = d.dot(f);
    return Vec2f(((de * ff - df * ef) * a + (df * ee - de * ef) * b) / area2);
  };
  ClothHit at_hit;
  at_hit.is_front = Vec3f(hit.hit.Ng_x, hit.hit.Ng_y, hit.hit.Ng_z).dot(direction) < 0.0F;
  at_hit.place = at[0] + hit.hit.u * a + hit.hit.v * b;
  at_hit.u = flattened(sample.width * camera_.right.cast<float>());
  at_hit.v = flattened(sample.width * camera_.up.cast<float>());
  at_hit.normal = sample.normal;
  at_hit.to_eye = -direction;
  at_hit.to_lamp = lamp_;
  const float det = a[0] * b[1] - a[1] * b[0];
  if (std::abs(det) > 1e-6F * std::sqrt(area2)) {
    at_hit.across = ((b[1] * e - a[1] * f) / det).normalized();
    at_hit.along = ((a[0] * f - b[0] * e) / det).normalized();
  }
  const bool coloured = !s.values.empty() || !s.triangle_colours.empty();
  return coloured ? s.cloth->colour(at_hit, sample.colour, sample.colour) : s.cloth->colour(at_hit, s.front, s.back);
}

/// `origin`: where rays to the light begin, `flat`: the normal of the triangle, both on the viewer's side.
void Tracer::meet(const RTCRayHit& hit, const Vec3f& direction, Sample& sample, Vec3f& origin, Vec3f& flat) const {
  const Surface& s = scene_.surfaces[hit.hit.geomID];
  const std::size_t t = hit.hit.primID;
  flat = Vec3f(hit.hit.Ng_x, hit.hit.Ng_y, hit.hit.Ng_z).normalized();
  const bool is_front = flat.dot(direction) < 0.0F;
  const float turn = is_front ? 1.0F : -1.0F;
  flat *= turn;
  const Eigen::Vector3f bary(1.0F - hit.hit.u - hit.hit.v, hit.hit.u, hit.hit.v);
  Vec3f normal = Vec3f::Zero(), point = Vec3f::Zero(), lift = Vec3f::Zero();
  for (std::size_t i = 0; i < 3; ++i) {
    normal += bary[static_cast<int>(i)] * turn * s.normals[3 * t + i];
    point += bary[static_cast<int>(i)] * s.positions[static_cast<std::size_t>(s.triangles[t][i])];
  }
  // Onto the smooth surface that the normals pretend, lest the triangles shadow themselves (J. Hanika, Ray Tracing Gems II).
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3f n = turn * s.normals[3 * t + i];
    const float below = std::min(0.0F, (point - s.positions[static_cast<std::size_t>(s.triangles[t][i])]).dot(n));
    lift -= bary[static_cast<int>(i)] * below * n;
  }
  normal.normalize();
  // A smooth normal may turn away from the viewer where the surface does so.
  const float towards = -normal.dot(direction);
  if (towards < 0.02F) normal = (normal + (0.02F - towards) * -direction).normalized();
  sample.surface = static_cast<int>(hit.hit.geomID);
  sample.normal = normal;
  sample.point = point;
  const float depth = (point - camera_.eye.cast<float>()).dot(-camera_.back.cast<float>());
  sample.width = std::max(depth * pixel_, 1e-30F);
  sample.colour = colour_at(s, t, bary, is_front);
  if (s.cloth) sample.colour = cloth_at(hit, direction, sample, flat);
  draw_lines(s, t, bary, sample.width, sample.colour);
  const float grazing = 1.0F - std::clamp(-normal.dot(direction), 0.0F, 1.0F);
  sample.shine = s.sheen * 0.25F * grazing * grazing * grazing * grazing * (0.5F * Rgb::Ones() + 0.5F * sample.colour);
  origin = point + lift + flat * (2e-5F * size_);
}

void Tracer::take_ground(const Vec3f& direction, Sample& sample) const {
  const Vec3f eye = camera_.eye.cast<float>();
  const float fall = direction.dot(up_), height = eye.dot(up_) - static_cast<float>(*scene_.ground);
  if (fall >= -1e-6F || height <= 0.0F) return;
  sample.point = eye + direction * (height / -fall);
  sample.surface = static_cast<int>(scene_.surfaces.size());
  sample.normal = up_;
  sample.width = std::max((sample.point - eye).dot(-camera_.back.cast<float>()) * pixel_, 1e-30F);
}

Rgb Tracer::lamp(const Vec3f& at, const Rgb& colour, const Vec3f& origin, const Vec3f& flat, const Vec3f& normal,
                 Noise& noise) const {
  const auto [u, v] = around(at);
  const float r = scene_.lighting.lamp_radius * std::sqrt(noise()), a = 2.0F * std::numbers::pi_v<float> * noise();
  const Vec3f to_lamp = (at + r * (std::cos(a) * u + std::sin(a) * v)).normalized();
  const float facing = normal.dot(to_lamp);
  if (facing <= 0.0F || flat.dot(to_lamp) <= -0.3F) return Rgb::Zero();
  return blocked(origin, to_lamp, 10.0F * size_) ? Rgb(Rgb::Zero()) : Rgb(facing * colour);
}

Rgb Tracer::sky(const Vec3f& origin, const Vec3f& flat, const Vec3f& normal, int rays, Noise& noise) const {
  const auto [u, v] = around(normal);
  Rgb sum = Rgb::Zero();
  const float shift = noise();
  for (int i = 0; i < rays; ++i) {
    // Spread evenly around, with the cosine that the surface asks for.
    const float r2 = (static_cast<float>(i) + noise()) / static_cast<float>(rays), r = std::sqrt(r2);
    const float a = 2.0F * std::numbers::pi_v<float> * (shift + 0.618034F * static_cast<float>(i));
    const Vec3f d = r * std::cos(a) * u + r * std::sin(a) * v + std::sqrt(1.0F - r2) * normal;
    const Rgb light = mix(scene_.lighting.floor, scene_.lighting.sky, 0.5F + 0.5F * d.dot(up_));
    const bool dark = d.dot(flat) <= 0.0F || blocked(origin, d, sky_reach * size_);
    sum += (dark ? returned : 1.0F) * light;
  }
  return sum / static_cast<float>(std::max(rays, 1));
}

Rgb Tracer::background(float row) const {
  return mix(scene_.background_top, scene_.background_bottom, row);
}

Sample Tracer::look(float column, float row, int sky_rays, Noise& noise) const {
  const Vec3f direction = camera_.ray(column, row).cast<float>().normalized(), eye = camera_.eye.cast<float>();
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit hit{};
  hit.ray = ray_of(eye, direction, std::numeric_limits<float>::infinity());
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(rays_, &context, &hit);
  Sample sample;
  sample.colour = background(row);
  Vec3f origin, flat;
  const bool ground = hit.hit.geomID == RTC_INVALID_GEOMETRY_ID;
  if (!ground) {
    meet(hit, direction, sample, origin, flat);
  } else if (scene_.ground) {
    take_ground(direction, sample);
    flat = up_;
    origin = sample.point + flat * (2e-5F * size_);
    // Far away nothing reaches it.
    if ((sample.point - middle_).norm() > 3.0F * size_) sample.surface = -1;
  }
  if (sample.surface < 0) return sample;
  const Lighting& lighting = scene_.lighting;
  sample.light = lamp(lamp_, lighting.lamp, origin, flat, sample.normal, noise) +
                 sky(origin, flat, sample.normal, sky_rays, noise);
  if (!ground && !lighting.rim.isZero(0.0F))
    sample.light += lamp(rim_, lighting.rim, origin, flat, sample.normal, noise);
  if (ground) {
    // It is the background, darker where light is kept from it. An open sky shines as it does 2/3 of the way up.
    // Mean cosine over the lamp's disc against that of its middle: 2 (sqrt(1 + r^2) - 1)/r^2.
    const float spread = 2.0F / (std::sqrt(1.0F + lighting.lamp_radius * lighting.lamp_radius) + 1.0F);
    const Rgb open = spread * up_.dot(lamp_) * lighting.lamp + mix(lighting.floor, lighting.sky, 5.0F / 6.0F);
    sample.light = Rgb(0.3F * Rgb::Ones() + 0.7F * sample.light.cwiseQuotient(open)).cwiseMin(brightest_ground);
  } else {
    sample.light += eye_light * std::max(0.0F, -sample.normal.dot(direction)) * Rgb::Ones();
    // Colours that mean numbers are to be told from the bar also where the lamp does not shine.
    if (!scene_.surfaces[static_cast<std::size_t>(sample.surface)].values.empty())
      sample.light = mix(sample.light, Rgb::Ones(), field_evenness);
  }
  return sample;
}

}  // namespace voile::picture
