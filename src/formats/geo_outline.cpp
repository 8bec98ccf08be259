#include "geo_outline.hpp"

#include <fmt/format.h>

#include "base/bytes.hpp"
#include "base/child_process.hpp"
#include "geo_safety.hpp"

namespace voile::formats {

std::vector<GeoFace> read_geo_faces(const std::string& file, const std::map<std::string, double>& parameters,
                                    bool allow_system_call) {
  check_script_name(file);
  if (!allow_system_call) refuse_dangerous_commands(file);
  std::vector<std::string> words{file, "outlines", allow_system_call ? "trusted" : "confined"};
  for (const auto& [name, value] : parameters) words.insert(words.end(), {name, fmt::format("{:a}", value)});
  ByteReader in(run_beside(file, "voile-gmsh", words));
  std::size_t count = 0;
  in.get(count);
  std::vector<GeoFace> faces(count);
  for (GeoFace& face : faces) {
    in.get(face.name);
    in.get(count);
    face.loops.resize(count);
    for (std::vector<GeoCurve>& loop : face.loops) {
      in.get(count);
      loop.resize(count);
      for (GeoCurve& curve : loop) {
        in.get(curve.name);
        in.get(curve.start_name);
        in.get(curve.points);
        in.get(curve.derivatives);
      }
    }
  }
  return faces;
}

}  // namespace voile::formats
