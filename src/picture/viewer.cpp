#include "viewer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "colour_map.hpp"
#include "exporting.hpp"
#include "field_values.hpp"
#include "voile/errors.hpp"

// The page, as the assembler has put it into the program (CMakeLists.txt).
extern "C" const char voile_viewer[];
// three.js with its OrbitControls; empty if it was not there when the program was built.
extern "C" const char voile_three[];

namespace voile::picture {

namespace {

using Json = nlohmann::ordered_json;

/// Bytes of an array as base64.
template <class Value>
std::string base64(const std::vector<Value>& values) {
  static constexpr char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto* bytes = reinterpret_cast<const unsigned char*>(values.data());
  const std::size_t count = values.size() * sizeof(Value);
  std::string text;
  text.reserve((count + 2) / 3 * 4);
  for (std::size_t i = 0; i < count; i += 3) {
    const std::size_t here = std::min<std::size_t>(3, count - i);
    unsigned word = 0;
    for (std::size_t k = 0; k < 3; ++k) word = word << 8U | (k < here ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text += k <= here ? letters[word >> (18U - 6U * static_cast<unsigned>(k)) & 63U] : '=';
  }
  return text;
}

struct Box {
  Vec3f low = Vec3f::Constant(std::numeric_limits<float>::max()), high = -low;
  void add(const std::vector<Vec3f>& points) {
    for (const Vec3f& x : points) {
      low = low.cwiseMin(x);
      high = high.cwiseMax(x);
    }
  }
  [[nodiscard]] std::string packed(const std::vector<Vec3f>& points) const {
    std::vector<std::uint16_t> q;
    q.reserve(3 * points.size());
    for (const Vec3f& x : points)
      for (int k = 0; k < 3; ++k) {
        const float width = high[k] - low[k];
        q.push_back(static_cast<std::uint16_t>(std::lround(width > 0.0F ? 65535.0F * (x[k] - low[k]) / width : 0.0F)));
      }
    return base64(q);
  }
};

/// Triangles that frames share, each set once.
class Meshes {
 public:
  std::size_t add(const std::vector<mesh::Triangle>& triangles) {
    if (const auto at = std::find(known_.begin(), known_.end(), triangles); at != known_.end())
      return static_cast<std::size_t>(at - known_.begin());
    std::vector<std::uint32_t> flat;
    for (const mesh::Triangle& t : triangles)
      for (const Index v : t) flat.push_back(static_cast<std::uint32_t>(v));
    json.push_back(base64(flat));
    known_.push_back(triangles);
    return known_.size() - 1;
  }
  Json json = Json::array();

 private:
  std::vector<std::vector<mesh::Triangle>> known_;
};

/// Values of a field at every moment, and what its colours mean.
struct Shown {
  FieldChoice choice;
  std::string label;
  bool on_triangles = false;
  double low = std::numeric_limits<double>::infinity(), high = -low;

  [[nodiscard]] Json values(const Recording& recording, const Moment& moment) {
    const results::StoredRun& run = recording.parts()[moment.part].run;
    if (!moment.step || !run.has_field(*moment.step, choice.name)) return nullptr;
    const FieldValues v = field_values(recording, moment, choice);
    label = v.label;
    on_triangles = v.on_triangles;
    for (const float x : v.values)
      if (std::isfinite(x)) {
        low = std::min<double>(low, x);
        high = std::max<double>(high, x);
      }
    return base64(v.values);
  }
  [[nodiscard]] Json json() const {
    const ColourScale scale = low <= high ? make_scale(low, high) : make_scale(0.0, 0.0);
    std::vector<std::uint8_t> colours;
    for (int i = 0; i <= 256; ++i)
      for (const std::uint8_t c : to_bytes(scale.map(static_cast<float>(i) / 256.0F))) colours.push_back(c);
    return {{"label", label},
            {"on_triangles", on_triangles},
            {"low", scale.low},
            {"high", scale.high},
            {"colours", base64(colours)}};
  }
};

}  // namespace

void write_viewer(const Recording& recording, const std::vector<Moment>& moments, const ViewerOptions& options) {
  if (*voile_three == '\0')
    throw UserError("view: this program was built without three.js; install it (package libjs-three) and build again");
  ExportOptions exported;
  exported.rate = options.rate;
  exported.bodies = options.bodies;
  const Exporter e(recording, moments, exported);
  Box box;
  for (std::size_t i = 0; i < e.size(); ++i) {
    const Snapshot s = e.snapshot(i);
    box.add(s.sheet.positions);
    box.add(s.bodies.positions);
  }
  std::vector<Shown> shown;
  for (const std::string& text : options.fields) shown.push_back({parse_field(text), ""});
  Meshes meshes;
  Json run{{"rate", options.rate}, {"unit", recording.unit()}, {"frames", Json::array()}, {"fields", Json::array()}};
  for (std::size_t i = 0; i < e.size(); ++i) {
    const Snapshot s = e.snapshot(i);
    Json frame{{"caption", recording.caption(moments[i])},
               {"mesh", meshes.add(s.sheet.triangles)},
               {"x", box.packed(s.sheet.positions)},
               {"bodies", nullptr},
               {"body_mesh", 0},
               {"values", Json::array()}};
    if (!s.bodies.triangles.empty()) {
      frame["bodies"] = box.packed(s.bodies.positions);
      frame["body_mesh"] = meshes.add(s.bodies.triangles);
    }
    for (Shown& field : shown) frame["values"].push_back(field.values(recording, moments[i]));
    run["frames"].push_back(std::move(frame));
  }
  for (const Shown& field : shown) {
    // The message of who looks for it in the last step names the nearest.
    if (field.label.empty() && moments.back().step)
      (void)recording.parts()[moments.back().part].run.field(*moments.back().step, field.choice.name,
                                                             recording.mesh(moments.back())->data);
    run["fields"].push_back(field.json());
  }
  run["meshes"] = std::move(meshes.json);
  for (int k = 0; k < 3; ++k) {
    run["low"].push_back(box.low[k]);
    run["high"].push_back(box.high[k]);
    run["up"].push_back(recording.up()[k]);
  }
  std::string page = voile_viewer;
  const std::string three = "/*THREE*/", place = "/*RUN*/null";
  // Nothing of the run may end the script it stands in.
  std::string text;
  for (const char c : run.dump(-1, ' ', true, Json::error_handler_t::replace)) {
    if (c == '/' && !text.empty() && text.back() == '<') text += '\\';
    text += c;
  }
  page.replace(page.find(place), place.size(), text);
  page.replace(page.find(three), three.size(), voile_three);
  OutFile out(options.output);
  Files files;
  out.stream() << page;
  out.finish(files);
}

}  // namespace voile::picture
