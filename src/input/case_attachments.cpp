// What is held to obstacles, and named points of them.
#include "case_attachments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/text.hpp"

namespace voile::input {

namespace {

/// Which obstacles there are depends on it.
std::string in_stage(const Case& c) {
  return c.stage.name.empty() ? "" : fmt::format(" in stage '{}'", c.stage.name);
}

/// Number in the file of the attachment that is read next.
std::size_t next_number(const Case& c) {
  return c.is_staged() ? c.stage.attachments[c.attachments.size()] : c.attachments.size();
}

/// One that releases before it takes hold would do nothing, nor does a time where there is none.
void check_release(const SectionPlace& place, const Case& c, const system::Attachment& s, const StagesBefore& before) {
  if (std::isfinite(s.release) && c.analysis != Analysis::dynamic && !c.is_staged())
    place.fail("release", "an attachment releases only with analysis = \"dynamic\"");
  if (c.analysis != Analysis::dynamic || s.release > before.end || contains(before.attachments, next_number(c))) return;
  const std::string first = c.is_staged()
                                ? fmt::format(", when stage '{}', the first that names it, begins", c.stage.name)
                                : std::string(", when the run begins");
  place.fail("release", fmt::format("{:g} s: it takes hold at {:g} s{}, which is after its release; give a later time, "
                                    "or remove the key or the attachment",
                                    s.release, before.end, first));
}

}  // namespace

void StagesBefore::add(const Case& stage) {
  if (stage.analysis == Analysis::dynamic) end = stage.time.options.end_time;
  if (stage.attachments.empty()) return;  // an analysis without contact
  attachments.insert(attachments.end(), stage.stage.attachments.begin(), stage.stage.attachments.end());
}

void check_attachment(const SectionPlace& place, const Case& c, const system::Attachment& s,
                      const StagesBefore& before) {
  if (s.groups.empty()) place.fail("groups", "the list is empty; name points, curves or surfaces of the mesh");
  if (s.hard && !std::isnan(s.gap))
    place.fail(
        "gap",
        "a hard attachment holds vertices where they are to the surface as it takes hold; remove the key, or hard");
  std::vector<std::string> known;
  for (const ObstacleSection& o : c.obstacles) {
    if (o.type == ObstacleSection::Type::mesh || o.type == ObstacleSection::Type::cylinder)
      known.push_back(o.shape.name);
    else if (o.shape.name == s.obstacle)
      place.fail("obstacle",
                 fmt::format("'{}' has no triangles to hold to; attach to one of type mesh or cylinder", s.obstacle));
  }
  if (std::find(known.begin(), known.end(), s.obstacle) == known.end())
    place.fail("obstacle", fmt::format("there is no [[obstacle]] '{}'{}:{}", s.obstacle, in_stage(c),
                                       suggestion(s.obstacle, known)));
  check_release(place, c, s, before);
}

void check_landmark(const SectionPlace& place, const Case& c, const LandmarkSection& s) {
  if (static_cast<int>(s.point.has_value()) + static_cast<int>(s.near.has_value()) + (s.vertices.empty() ? 0 : 1) != 1)
    place.fail("point", "its place needs one of point, near and vertices");
  for (const double v : s.vertices)
    if (v != std::floor(v)) place.fail("vertices", fmt::format("{}: a whole number is needed", v));
  for (const LandmarkSection& other : c.landmarks)
    if (other.obstacle == s.obstacle && other.name == s.name)
      place.fail("name", fmt::format("'{}': '{}' has another landmark of this name", s.name, s.obstacle));
  if (c.stage.number > 0) return;  // pieces are placed in the first stage, others may be without the obstacle
  std::vector<std::string> known;
  for (const ObstacleSection& o : c.obstacles) {
    known.push_back(o.shape.name);
    if (o.shape.name == s.obstacle && o.type != ObstacleSection::Type::mesh && !s.point)
      place.fail("point", fmt::format("the key is missing; '{}' is no mesh with vertices", s.obstacle));
  }
  if (std::find(known.begin(), known.end(), s.obstacle) == known.end())
    place.fail("obstacle", fmt::format("there is no [[obstacle]] '{}'{}:{}", s.obstacle, in_stage(c),
                                       suggestion(s.obstacle, known)));
}

}  // namespace voile::input
