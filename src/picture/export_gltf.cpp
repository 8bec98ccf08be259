// GLB (glTF 2.0, binary): the motion as morph targets.
//
// A node holds at most so many frames as browsers take morph targets, its first frame being the mesh itself; the next node
// begins with the last frame of the one before, or with a new mesh where the mesh changes. A node is there, with scale 1, from
// its first frame to its last, and elsewhere has scale 0. Weights run linearly from frame to frame.
//
// Cloth has textures in flat coordinates (a, l), a set (a, -l)/repeat for each: the print as base colour, the weave as normals
// and occlusion. Its vertices on seams are there once for each panel. The sheen is that of KHR_materials_sheen.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/decompositions.hpp"
#include "cloth_images.hpp"
#include "exporting.hpp"
#include "scene.hpp"
#include "voile/errors.hpp"

namespace voile::picture {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_frames = 200;
constexpr Bytes3 sheet_colour{66, 119, 178};
constexpr int type_float = 5126, type_unsigned = 5125, target_vertices = 34962, target_indices = 34963;

/// Triangles of a body as they are drawn, and its frames.
struct Chunk {
  std::vector<mesh::Triangle> triangles;
  std::vector<std::vector<Vec3f>> frames;
  std::vector<double> times;
  std::vector<std::array<Vec2f, 3>> flat{};  ///< of cloth, see scene.hpp
};

class Gltf {
 public:
  Gltf(const Vec3& up, double metres, const ClothChoice& cloth) : turn_(metres * rotation_between(up, Vec3::UnitY())) {
    json_["asset"] = {{"version", "2.0"}, {"generator", "Voile"}};
    json_["scene"] = 0;
    json_["scenes"] = Json::array({{{"nodes", Json::array()}}});
    for (const char* list : {"nodes", "meshes", "materials", "accessors", "bufferViews"}) json_[list] = Json::array();
    add_material("sheet", sheet_colour);
    if (cloth.any()) add_cloth(cloth);
  }

  /// Positions of a body at the times of its frames.
  void add(const std::string& name, const Chunk& chunk, int material, bool begins, bool ends);
  void write(const std::filesystem::path& file, Files& files);

 private:
  void add_material(const char* name, const Bytes3& colour) {
    const Rgb c = from_bytes(colour);
    json_["materials"].push_back(
        {{"name", name},
         {"doubleSided", true},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", {c[0], c[1], c[2], 1.0}}, {"metallicFactor", 0.0}, {"roughnessFactor", 0.8}}}});
  }
  /// Gives the sheet's material its textures.
  void add_cloth(const ClothChoice& cloth);
  int tangent_accessor(const std::vector<Vec3f>& tangents);
  /// Texture coordinates of all sets.
  void add_coordinates(const SplitSheet& split, Json& attributes);
  /// A texture of the next set of coordinates, whose repeat is so large [m].
  Json texture(const Image& image, const Vec2f& repeat);
  template <class Value>
  int view(const std::vector<Value>& values, int target) {
    const std::size_t begin = bytes_.size(), size = values.size() * sizeof(Value);
    const auto* from = reinterpret_cast<const char*>(values.data());
    bytes_.insert(bytes_.end(), from, from + size);
    Json v{{"buffer", 0}, {"byteOffset", begin}, {"byteLength", size}};
    if (target) v["target"] = target;
    json_["bufferViews"].push_back(v);
    return static_cast<int>(json_["bufferViews"].size()) - 1;
  }
  int accessor(int view, int component, std::size_t count, const char* type) {
    json_["accessors"].push_back(
        {{"bufferView", view}, {"componentType", component}, {"count", count}, {"type", type}});
    return static_cast<int>(json_["accessors"].size()) - 1;
  }
  int vectors(const std::vector<Vec3f>& x) {
    const int a = accessor(view(x, target_vertices), type_float, x.size(), "VEC3");
    Vec3f low = Vec3f::Constant(std::numeric_limits<float>::max()), high = -low;
    for (const Vec3f& p : x) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    json_["accessors"].back()["min"] = {low[0], low[1], low[2]};
    json_["accessors"].back()["max"] = {high[0], high[1], high[2]};
    return a;
  }
  int numbers(const std::vector<float>& x) {
    const int a = accessor(view(x, 0), type_float, x.size(), "SCALAR");
    json_["accessors"].back()["min"] = {*std::min_element(x.begin(), x.end())};
    json_["accessors"].back()["max"] = {*std::max_element(x.begin(), x.end())};
    return a;
  }
  [[nodiscard]] std::vector<Vec3f> turned(const std::vector<Vec3f>& x) const {
    std::vector<Vec3f> result;
    for (const Vec3f& p : x) result.emplace_back((turn_ * p.cast<double>()).cast<float>());
    return result;
  }
  void animate(int node, const std::vector<double>& times, bool begins, bool ends);
  void channel(int node, const char* path, int input, int output, const char* interpolation) {
    Json& a = json_["animations"];
    if (a.is_null()) a = Json::array({{{"name", "run"}, {"channels", Json::array()}, {"samplers", Json::array()}}});
    a[0]["samplers"].push_back({{"input", input}, {"output", output}, {"interpolation", interpolation}});
    a[0]["channels"].push_back(
        {{"sampler", a[0]["samplers"].size() - 1}, {"target", {{"node", node}, {"path", path}}}});
  }

  Mat3 turn_;                   ///< to metres, y upwards
  std::vector<Vec2f> repeats_;  ///< of the sets of texture coordinates [m]
  Json json_;
  std::vector<char> bytes_;
};

std::vector<Vec3f> difference(const std::vector<Vec3f>& a, const std::vector<Vec3f>& b) {
  std::vector<Vec3f> d;
  for (std::size_t i = 0; i < a.size(); ++i) d.emplace_back(a[i] - b[i]);
  return d;
}

/// One normal per vertex.
std::vector<Vec3f> vertex_normals(const std::vector<Vec3f>& x, const std::vector<mesh::Triangle>& triangles) {
  std::vector<Vec3f> normals(x.size(), Vec3f(0, 1, 0));
  const std::vector<Vec3f> corners = corner_normals(x, triangles, 3.2);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) normals[static_cast<std::size_t>(triangles[t][i])] = corners[3 * t + i];
  return normals;
}

Json Gltf::texture(const Image& image, const Vec2f& repeat) {
  if (!json_.contains("images")) {
    for (const char* list : {"images", "textures"}) json_[list] = Json::array();
    json_["samplers"] = Json::array({{{"magFilter", 9729}, {"minFilter", 9987}}});  // linear, with mipmaps; repeating
  }
  while (bytes_.size() % 4 != 0) bytes_.push_back('\0');
  json_["images"].push_back({{"bufferView", view(png_bytes(image), 0)}, {"mimeType", "image/png"}});
  while (bytes_.size() % 4 != 0) bytes_.push_back('\0');
  json_["textures"].push_back({{"sampler", 0}, {"source", json_["images"].size() - 1}});
  const auto known = std::find(repeats_.begin(), repeats_.end(), repeat);
  const auto set = known - repeats_.begin();
  if (known == repeats_.end()) repeats_.push_back(repeat);
  return {{"index", json_["textures"].size() - 1}, {"texCoord", set}};
}

void Gltf::add_cloth(const ClothChoice& cloth) {
  Json m = json_["materials"][0];  // a copy: textures move what json_ holds
  if (cloth.weave) {
    const Vec2f repeat = WeaveTile::repeat(*cloth.weave) * static_cast<float>(cloth.spacing);
    m["normalTexture"] = texture(normal_image(*cloth.weave), repeat);
    m["occlusionTexture"] = texture(shade_image(*cloth.weave), repeat);
  }
  if (cloth.print != Print::none) {
    m["pbrMetallicRoughness"]["baseColorTexture"] = texture(print_image(cloth.print, from_bytes(sheet_colour)),
                                                            Vec2f::Constant(static_cast<float>(2.0 * cloth.width)));
    m["pbrMetallicRoughness"]["baseColorFactor"] = {1.0, 1.0, 1.0, 1.0};  // the texture has the colour
  }
  m["extensions"]["KHR_materials_sheen"] = {{"sheenColorFactor", {0.25, 0.25, 0.25}}, {"sheenRoughnessFactor", 0.4}};
  json_["extensionsUsed"] = Json::array({"KHR_materials_sheen"});
  json_["materials"][0] = std::move(m);
}

int Gltf::tangent_accessor(const std::vector<Vec3f>& tangents) {
  std::vector<Eigen::Vector4f> with_sign;  // 1: the warp lies to the left, seen against the normal
  for (const Vec3f& t : tangents) with_sign.emplace_back(t[0], t[1], t[2], 1.0F);
  return accessor(view(with_sign, target_vertices), type_float, with_sign.size(), "VEC4");
}

void Gltf::add_coordinates(const SplitSheet& split, Json& attributes) {
  for (std::size_t set = 0; set < repeats_.size(); ++set) {
    std::vector<Vec2f> uv;
    for (const Vec2f& x : split.flat) uv.emplace_back(x[0] / repeats_[set][0], -x[1] / repeats_[set][1]);
    attributes[fmt::format("TEXCOORD_{}", set)] = accessor(view(uv, target_vertices), type_float, uv.size(), "VEC2");
  }
}

/// `begins`, `ends`: nothing comes before or after it, so that it stays.
void Gltf::add(const std::string& name, const Chunk& chunk, int material, bool begins, bool ends) {
  if (material == static_cast<int>(json_["materials"].size())) add_material("bodies", {196, 192, 186});
  SplitSheet split{chunk.triangles, {}, {}};
  if (!chunk.flat.empty()) split = split_at_seams(chunk.triangles, chunk.flat);
  const auto each = [&](std::vector<Vec3f> x) {
    if (split.origin.empty()) return x;
    std::vector<Vec3f> result;
    for (const Index v : split.origin) result.push_back(x[static_cast<std::size_t>(v)]);
    return result;
  };
  const auto normals_of = [&](const std::vector<Vec3f>& x) { return each(vertex_normals(x, chunk.triangles)); };
  const std::vector<Vec3f> base = turned(chunk.frames.front()), normals = normals_of(base);
  std::vector<std::uint32_t> corners;
  for (const mesh::Triangle& t : split.triangles)
    for (const Index v : t) corners.push_back(static_cast<std::uint32_t>(v));
  Json primitive{{"attributes", {{"POSITION", vectors(each(base))}, {"NORMAL", vectors(normals)}}},
                 {"indices", accessor(view(corners, target_indices), type_unsigned, corners.size(), "SCALAR")},
                 {"material", material}};
  const bool has_textures = !chunk.flat.empty();
  std::vector<Vec3f> tangents;
  if (has_textures) {
    tangents = tangents_of(split, each(base), normals);
    primitive["attributes"]["TANGENT"] = tangent_accessor(tangents);
    add_coordinates(split, primitive["attributes"]);
  }
  for (std::size_t i = 1; i < chunk.frames.size(); ++i) {
    const std::vector<Vec3f> x = turned(chunk.frames[i]), n = normals_of(x);
    const int positions = vectors(each(difference(x, base)));
    Json target{{"POSITION", positions}, {"NORMAL", vectors(difference(n, normals))}};
    if (has_textures) target["TANGENT"] = vectors(difference(tangents_of(split, each(x), n), tangents));
    primitive["targets"].push_back(target);
  }
  Json mesh{{"name", name}, {"primitives", Json::array({primitive})}};
  if (chunk.frames.size() > 1) mesh["weights"] = std::vector<float>(chunk.frames.size() - 1, 0.0F);
  json_["meshes"].push_back(mesh);
  const int node = static_cast<int>(json_["nodes"].size());
  json_["nodes"].push_back({{"name", name}, {"mesh", json_["meshes"].size() - 1}});
  json_["scenes"][0]["nodes"].push_back(node);
  animate(node, chunk.times, begins, ends);
}

/// `times`: of the frames, and one more when the next node takes over.
void Gltf::animate(int node, const std::vector<double>& times, bool begins, bool ends) {
  const std::size_t frames =
      json_["meshes"].back().contains("weights") ? json_["meshes"].back()["weights"].size() + 1 : 1;
  if (frames > 1) {
    std::vector<float> at(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(frames)),
        weights(frames * (frames - 1), 0.0F);
    for (std::size_t i = 1; i < frames; ++i) weights[i * (frames - 1) + i - 1] = 1.0F;
    const int input = numbers(at);
    channel(node, "weights", input, numbers(weights), "LINEAR");
  }
  if (begins && ends) return;
  std::vector<float> at;
  std::vector<Vec3f> scale;
  const auto key = [&](double time, float size) {
    at.push_back(static_cast<float>(time));
    scale.push_back(Vec3f::Constant(size));
  };
  if (!begins) key(0.0, 0.0F);
  key(times.front(), 1.0F);
  if (!ends) key(times.back(), 0.0F);
  const int input = numbers(at);
  channel(node, "scale", input, accessor(view(scale, 0), type_float, scale.size(), "VEC3"), "STEP");
}

void Gltf::write(const std::filesystem::path& file, Files& files) {
  json_["buffers"] = Json::array({{{"byteLength", bytes_.size()}}});
  std::string text = json_.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  bytes_.resize((bytes_.size() + 3) / 4 * 4, '\0');
  const std::size_t total = 12 + 8 + text.size() + 8 + bytes_.size();
  if (total > std::numeric_limits<std::uint32_t>::max())
    throw UserError(fmt::format("{}: a GLB has at most 4 GB; take fewer steps (--steps FIRST:LAST:STRIDE), or usda",
                                file.string()));
  OutFile out(file);
  const auto number = [&](std::size_t n) { out.put(static_cast<std::uint32_t>(n)); };
  out.stream() << "glTF";
  number(2);
  number(total);
  number(text.size());
  out.stream() << "JSON" << text;
  number(bytes_.size());
  out.stream().write("BIN\0", 4);
  out.stream().write(bytes_.data(), static_cast<std::streamsize>(bytes_.size()));
  out.finish(files);
}

}  // namespace

Files export_glb(const Exporter& e) {
  const double metres = e.recording().metres();
  const ClothChoice cloth = e.options().cloth.in_unit(metres);
  Gltf gltf(e.recording().up(), metres, cloth);
  for (const bool of_sheet : {true, false}) {
    Chunk chunk;
    std::size_t nodes = 0;
    const auto flush = [&](bool ends) {
      if (chunk.frames.empty() || chunk.triangles.empty()) return;
      gltf.add(fmt::format("{}_{}", of_sheet ? "sheet" : "bodies", nodes), chunk, of_sheet ? 0 : 1, nodes == 0, ends);
      ++nodes;
    };
    for (std::size_t i = 0; i < e.size(); ++i) {
      Snapshot s = e.snapshot(i);
      Body& body = of_sheet ? s.sheet : s.bodies;
      if (!body.moves && i > 0 && body.triangles == chunk.triangles) continue;
      const bool changes = i > 0 && body.triangles != chunk.triangles;
      if (changes || chunk.frames.size() == most_frames) {
        std::vector<Vec3f> last = chunk.frames.back();
        const double when = chunk.times.back();
        if (changes) chunk.times.push_back(s.time);
        flush(false);
        chunk = changes ? Chunk{} : Chunk{chunk.triangles, {std::move(last)}, {when}, std::move(chunk.flat)};
      }
      chunk.triangles = body.triangles;
      if (of_sheet && cloth.any() && chunk.flat.empty())
        chunk.flat = flat_coordinates(s.state.mesh->data, e.recording().materials());
      chunk.frames.push_back(std::move(body.positions));
      chunk.times.push_back(s.time);
    }
    flush(true);
  }
  Files files;
  gltf.write(e.options().output, files);
  return files;
}

}  // namespace voile::picture
