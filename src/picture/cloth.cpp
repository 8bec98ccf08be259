#include "cloth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "base/length_unit.hpp"
#include "voile/errors.hpp"

namespace voile::picture {

namespace {

constexpr float struck_through = 0.3F;  // strength of a print on the wrong side
constexpr float directed = 0.55F;       // fraction of light from the lamp, by which the relief is seen
constexpr float darkest = 0.3F, brightest = 1.7F;
constexpr float gloss = 0.05F;  // of threads
constexpr int gloss_power = 6;
constexpr double least_length = 1e-6, greatest_length = 1e3;  // [m]
constexpr double plain_spacing = 0.4e-3, twill_spacing = 0.5e-3, knit_spacing = 1.2e-3;

double length_of(const std::string& option, const std::string& text) {
  char* end = nullptr;
  const double x = std::strtod(text.c_str(), &end);
  const std::string unit(end);
  const double factor = metres_of(unit);
  if (end == text.c_str() || factor == 0.0)
    throw UserError(fmt::format("{}: '{}' is no length with its unit mm, cm or m, e.g. 10mm", option, text));
  if (!(x * factor >= least_length && x * factor <= greatest_length))
    throw UserError(
        fmt::format("{}: {} is out of the range from {} to {} m", option, text, least_length, greatest_length));
  return x * factor;
}

/// NAME:LENGTH; the length is empty if it is not there.
std::pair<std::string, std::string> split(const std::string& text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) return {text, ""};
  return {text.substr(0, colon), text.substr(colon + 1)};
}

/// Twice integrated square wave of period 2 that is +1 from 0 to 1 and -1 from 1 to 2, but for a constant and a slope.
double twice_integrated(double x) {
  x -= 2.0 * std::floor(0.5 * x);
  return x < 1.0 ? 0.5 * x * (x - 1.0) : 1.5 * x - 0.5 * x * x - 1.0;
}

/// Mean of that square wave round x under a triangle of half width h: it falls with h^-2 beyond the period.
double square_wave(double x, double h) {
  if (h < 1e-3) return x - 2.0 * std::floor(0.5 * x) < 1.0 ? 1.0 : -1.0;
  return (twice_integrated(x + h) - 2.0 * twice_integrated(x) + twice_integrated(x - h)) / (h * h);
}

/// (1 - (t.h)^2)^gloss_power: threads shine where the direction between eye and lamp is square to them (J. Kajiya, T. Kay,
/// SIGGRAPH 1989).
float shine_of(const Vec3f& thread, const Vec3f& half) {
  const float c = thread.dot(half);
  return std::pow(std::max(0.0F, 1.0F - c * c), static_cast<float>(gloss_power));
}

}  // namespace

Rgb print_colour() {
  return from_bytes({238, 233, 220});
}

ClothChoice parse_cloth(const std::string& cloth, const std::string& print) {
  ClothChoice choice;
  if (!cloth.empty()) {
    const auto [name, spacing] = split(cloth);
    if (name == "plain")
      choice = {Weave::plain, plain_spacing};
    else if (name == "twill")
      choice = {Weave::twill, twill_spacing};
    else if (name == "knit")
      choice = {Weave::knit, knit_spacing};
    else
      throw UserError(
          fmt::format("--cloth {}: it is plain, twill or knit, and after ':' the distance of threads", cloth));
    if (name.size() < cloth.size()) choice.spacing = length_of("--cloth", spacing);
  }
  if (print.empty()) return choice;
  const auto [name, width] = split(print);
  if (name != "stripes" && name != "checks")
    throw UserError(fmt::format("--print {}: it is stripes:WIDTH or checks:WIDTH, e.g. stripes:10mm", print));
  choice.print = name == "stripes" ? Print::stripes : Print::checks;
  choice.width = length_of("--print", width);
  return choice;
}

float second_colour(Print print, double width, const Vec2f& place, const Vec2f& u, const Vec2f& v) {
  if (print == Print::none) return 0.0F;
  // A triangle with the variance of the pixel's box.
  const auto wave = [&](int k) {
    return square_wave(static_cast<double>(place[k]) / width, std::sqrt(0.5 * (u[k] * u[k] + v[k] * v[k])) / width);
  };
  return static_cast<float>(print == Print::stripes ? 0.5 * (1.0 + wave(0)) : 0.5 * (1.0 - wave(0) * wave(1)));
}

Cloth::Cloth(const ClothChoice& choice) : choice_(choice) {
  if (!choice.weave) return;
  front_.emplace(*choice.weave, false);
  back_.emplace(*choice.weave, true);
  repeat_ = WeaveTile::repeat(*choice.weave) * static_cast<float>(choice.spacing);
}

Rgb Cloth::colour(const ClothHit& hit, const Rgb& front, const Rgb& back) const {
  const float second = second_colour(choice_.print, choice_.width, hit.place, hit.u, hit.v);
  const Rgb ground = hit.is_front ? front : back;
  const Rgb colour = ground + (hit.is_front ? 1.0F : struck_through) * second * (print_colour() - ground);
  return choice_.weave && !hit.across.isZero(0.0F) ? woven(hit, colour) : colour;
}

Rgb Cloth::woven(const ClothHit& hit, const Rgb& colour) const {
  const Relief r =
      (hit.is_front ? *front_ : *back_)
          .mean(hit.place.cwiseQuotient(repeat_), hit.u.cwiseQuotient(repeat_), hit.v.cwiseQuotient(repeat_));
  // The relief tilts the normal; what the lamp then gives more or less is put into the colour, which no filter smooths.
  const float facing = std::max(0.0F, hit.normal.dot(hit.to_lamp));
  const float tilted =
      std::max(0.0F, facing - r.across * hit.across.dot(hit.to_lamp) - r.along * hit.along.dot(hit.to_lamp));
  const float light = (1.0F - directed + directed * tilted) / (1.0F - directed + directed * facing);
  const Vec3f half = (hit.to_eye + hit.to_lamp).normalized();
  const float shine = gloss * (r.warp * shine_of(hit.along, half) + (1.0F - r.warp) * shine_of(hit.across, half));
  return r.shade * std::clamp(light, darkest, brightest) * colour + shine * Rgb::Ones();
}

}  // namespace voile::picture
