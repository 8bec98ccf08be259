// Rays into a scene and the light at what they meet; private to src/picture.
#pragma once

#include <embree3/rtcore.h>

#include <cstdint>

#include "camera.hpp"
#include "scene.hpp"

namespace voile::picture {

/// Numbers that look random: the same for the same pixel and sample, whichever thread asks.
class Noise {
 public:
  explicit Noise(std::uint32_t seed) : state_(seed * 747796405U + 2891336453U) {}
  float operator()() {
    state_ = state_ * 747796405U + 2891336453U;
    std::uint32_t word = ((state_ >> ((state_ >> 28U) + 4U)) ^ state_) * 277803737U;
    word = (word >> 22U) ^ word;
    return static_cast<float>(word >> 8U) * (1.0F / 16777216.0F);
  }

 private:
  std::uint32_t state_;
};

/// What a ray from the eye meets.
struct Sample {
  int surface = -1;  ///< number of the surface; the number of surfaces: the ground; -1: nothing
  Rgb colour{0, 0, 0}, light{1, 1, 1}, shine{0, 0, 0};
  Vec3f normal{0, 0, 0}, point{0, 0, 0};
  float width = 0.0F;
};

/// A scene that rays can be sent into. Not copied; the scene must live as long.
class Tracer {
 public:
  Tracer(const Scene& scene, const Camera& camera, int height, int threads);
  ~Tracer();
  Tracer(const Tracer&) = delete;
  Tracer& operator=(const Tracer&) = delete;

  /// Through a place in the picture (fractions from the upper left).
  [[nodiscard]] Sample look(float column, float row, int sky_rays, Noise& noise) const;
  /// Behind everything, at that row.
  [[nodiscard]] Rgb background(float row) const;

 private:
  struct Corner;
  /// Throws std::bad_alloc or InternalError if Embree has failed.
  void check_device(const char* what) const;
  [[nodiscard]] bool blocked(const Vec3f& from, const Vec3f& direction, float far) const;
  void draw_lines(const Surface& s, std::size_t t, const Eigen::Vector3f& bary, float width, Rgb& colour) const;
  [[nodiscard]] Rgb colour_at(const Surface& s, std::size_t t, const Eigen::Vector3f& bary, bool is_front) const;
  void meet(const RTCRayHit& hit, const Vec3f& direction, Sample& sample, Vec3f& origin, Vec3f& flat) const;
  void take_ground(const Vec3f& direction, Sample& sample) const;
  [[nodiscard]] Rgb cloth_at(const RTCRayHit& hit, const Vec3f& direction, const Sample& sample,
                             const Vec3f& flat) const;
  /// Light of a lamp in the direction `at`, of that colour.
  [[nodiscard]] Rgb lamp(const Vec3f& at, const Rgb& colour, const Vec3f& origin, const Vec3f& flat,
                         const Vec3f& normal, Noise& noise) const;
  [[nodiscard]] Rgb sky(const Vec3f& origin, const Vec3f& flat, const Vec3f& normal, int rays, Noise& noise) const;

  const Scene& scene_;
  const Camera& camera_;
  RTCDevice device_ = nullptr;
  RTCScene rays_ = nullptr;
  Vec3f up_, lamp_, rim_, middle_;
  float size_ = 1.0F, pixel_ = 1.0F;  ///< of the scene; of a pixel at unit depth [m]
};

}  // namespace voile::picture
