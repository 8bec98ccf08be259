#include "case_supports.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "base/text.hpp"
#include "case_loads.hpp"
#include "case_sections.hpp"
#include "voile/errors.hpp"

namespace voile::input {

namespace {

/// What tells motions apart; empty if there is none.
std::string text_of(const MotionInput& m) {
  if (!m.any()) return {};
  std::string text = join(m.translation, ", ") + "; " + m.angle;
  for (const Vec3& v : {m.axis.value_or(Vec3::Zero()), m.centre})
    text += fmt::format("; {} {} {}", v.x(), v.y(), v.z());
  return text;
}

}  // namespace

Motion motion_function(const SectionPlace& place, const MotionInput& m, bool possible, const char* analyses) {
  if (m.angle.empty() != !m.axis)
    place.fail(m.axis ? "rotation_angle" : "rotation_axis", "rotation_axis and rotation_angle go together");
  if (!m.any()) return {};
  if (!possible)
    place.fail(m.translation.empty() ? "rotation_angle" : "motion",
               fmt::format("something moves only with analysis = {}", analyses));
  if (!m.translation.empty() && m.translation.size() != 3)
    place.fail("motion", fmt::format("{} expressions; three are needed, for x, y and z", m.translation.size()));
  std::vector<std::function<double(double)>> u;
  for (const std::string& text : m.translation) u.push_back(time_function(place, "motion", text));
  const auto angle = m.angle.empty() ? nullptr : time_function(place, "rotation_angle", m.angle);
  const Vec3 axis = m.axis ? m.axis->normalized() : Vec3(Vec3::UnitZ()), centre = m.centre;
  return [u, angle, axis, centre](const Vec3& x, double t) {
    Vec3 d = Vec3::Zero();
    if (angle) d = Eigen::AngleAxisd(angle(t) * (std::numbers::pi / 180.0), axis) * (x - centre) - (x - centre);
    for (int k = 0; k < 3 && !u.empty(); ++k) d[k] += u[static_cast<std::size_t>(k)](t);
    return d;
  };
}

void read_supports(const CaseReader& reader, Case& c) {
  for (std::size_t n = 0; n < reader.count("support"); ++n) {
    system::Support support;
    MotionInput motion;
    const SectionPlace place = reader.read("support", n, keys_of(support, motion));
    const bool moves = c.is_staged() || c.analysis == Analysis::dynamic || c.analysis == Analysis::statics ||
                       c.analysis == Analysis::drape;
    support.motion = motion_function(place, motion, moves, "\"dynamic\", \"static\" or \"drape\"");
    support.motion_text = text_of(motion);
    if (support.kind == system::Support::Kind::clamped && motion.axis)
      support.rotation = [angle = time_function(place, "rotation_angle", motion.angle),
                          axis = Vec3(motion.axis->normalized())](double t) {
        return Mat3(Eigen::AngleAxisd(angle(t) * (std::numbers::pi / 180.0), axis));
      };
    if (support.cylinder_axis && support.x_axis)
      place.fail("cylinder_axis",
                 "local axes are either x_axis and y_axis, or those of a cylinder; remove one of them");
    if (support.y_axis && !support.x_axis) place.fail("x_axis", "the key is missing; y_axis is made square to it");
    if (std::isfinite(support.release) && c.analysis != Analysis::dynamic && !c.is_staged())
      place.fail("release", "a support releases only with analysis = \"dynamic\"");
    c.supports.push_back(std::move(support));
    c.motions.push_back(std::move(motion));
  }
}

}  // namespace voile::input
