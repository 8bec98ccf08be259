#include "stresses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "energy/recovery_error.hpp"
#include "system/failure.hpp"

namespace voile::record {

double von_mises(const Vec3& s) {
  return std::sqrt(std::max(0.0, s[0] * s[0] - s[0] * s[1] + s[1] * s[1] + 3.0 * s[2] * s[2]));
}

namespace {

using Stress = Vec3;  // 11, 22, 12

/// s1 >= s2 and the angle of s1.
Vec3 principal(const Stress& s) {
  const double mean = 0.5 * (s[0] + s[1]), radius = std::hypot(0.5 * (s[0] - s[1]), s[2]);
  return {mean + radius, mean - radius, 0.5 * std::atan2(2.0 * s[2], s[0] - s[1])};
}

/// A field of stresses at one place in the thickness.
class Face {
 public:
  Face(std::string name, std::size_t count, results::Centre centre = results::Centre::triangle)
      : name_(std::move(name)), centre_(centre), stress_(count, Stress::Zero()) {}
  void set(std::size_t t, const Stress& s) { stress_[t] = s; }
  [[nodiscard]] std::vector<double> values() const {
    std::vector<double> all;
    for (const Stress& s : stress_) all.insert(all.end(), s.begin(), s.end());
    return all;
  }
  void add_to(std::vector<results::Field>& fields, bool derived) const {
    fields.push_back(field("stress_", "Pa", 3, [](const Stress& s) { return s; }));
    if (!derived) return;
    fields.push_back(field("principal_stress_", "Pa, Pa, rad", 3, principal));
    fields.push_back(field("von_mises_", "Pa", 1, [](const Stress& s) { return Vec3(von_mises(s), 0.0, 0.0); }));
  }

 private:
  template <class Value>
  [[nodiscard]] results::Field field(const char* prefix, const char* unit, int components, const Value& value) const {
    results::Field f{prefix + name_, unit, centre_, components, {}};
    f.values.reserve(stress_.size() * static_cast<std::size_t>(components));
    for (const Stress& s : stress_) {
      const Vec3 v = value(s);
      for (int k = 0; k < components; ++k) f.values.push_back(v[k]);
    }
    return f;
  }
  std::string name_;
  results::Centre centre_;
  std::vector<Stress> stress_;
};

}  // namespace

namespace {

/// One triangle of each part of the surface around a vertex that is smooth, and the corner that the vertex is of it.
std::vector<std::pair<Index, int>> smooth_parts(const mesh::SurfaceMesh& mesh, const energy::RecoveryError& recovery,
                                                Index v) {
  const auto around = mesh.triangles_of_vertex(v);
  std::vector<Index> left(around.begin(), around.end());
  std::sort(left.begin(), left.end());
  std::vector<std::pair<Index, int>> parts;
  while (!left.empty()) {
    std::vector<Index> part{left.front()};
    left.erase(left.begin());
    const mesh::Triangle& first = mesh.triangles()[part[0]];
    parts.emplace_back(part[0], static_cast<int>(std::find(first.begin(), first.end(), v) - first.begin()));
    for (std::size_t k = 0; k < part.size(); ++k)
      for (int s = 0; s < 3; ++s) {
        if (!recovery.is_smooth(part[k], s)) continue;
        const auto at = std::find(left.begin(), left.end(), mesh.neighbour(part[k], s));
        if (at == left.end()) continue;
        part.push_back(*at);
        left.erase(at);
      }
  }
  return parts;
}

/// Stresses at vertices from those of the triangles at both faces: of the part where von Mises's is largest, if several meet. What both
/// have in common is of stretching, what they differ by of bending.
Face at_vertices(const energy::Sheet& sheet, const energy::RecoveryError& recovery, const std::string& name,
                 const std::vector<double>& own, const std::vector<double>& other) {
  const mesh::SurfaceMesh& mesh = sheet.mesh();
  Face face(name, static_cast<std::size_t>(mesh.vertex_count()), results::Centre::vertex);
  std::vector<double> mean(own.size()), bending(own.size());
  for (std::size_t i = 0; i < own.size(); ++i) {
    mean[i] = 0.5 * (own[i] + other[i]);
    bending[i] = 0.5 * (own[i] - other[i]);
  }
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    Stress most = Stress::Zero();
    for (const auto& [t, corner] : smooth_parts(mesh, recovery, v)) {
      const Stress s = recovery.at_corner(t, corner, mean, false) + recovery.at_corner(t, corner, bending, true);
      if (von_mises(s) > von_mises(most)) most = s;
    }
    face.set(static_cast<std::size_t>(v), most);
  }
  return face;
}

}  // namespace

std::vector<results::Field> stretch_fields(const energy::Sheet& sheet, const system::TriangleFields& fields) {
  const std::vector<energy::Material>& materials = sheet.materials();
  if (std::none_of(materials.begin(), materials.end(), [](const auto& m) { return m.rubber.any(); })) return {};
  results::Field f{"principal_stretch", "1", results::Centre::triangle, 3, {}};
  f.values.assign(fields.membrane_strain.size(), 1.0);
  for (std::size_t t = 0; 3 * t < f.values.size(); ++t) {
    const energy::Hyperelastic& law = sheet.material(static_cast<Index>(t)).rubber;
    if (!law.any()) continue;
    const Vec3 strain = Eigen::Map<const Vec3>(&fields.membrane_strain[3 * t]);
    const energy::Stretches s = energy::stretches_of(law.natural * strain);
    f.values[3 * t] = s.most;
    f.values[3 * t + 1] = s.least;
    f.values[3 * t + 2] = energy::thinning(law, strain);
  }
  return {f};
}

Vec3 face_stress(const energy::Sheet& sheet, const system::TriangleFields& fields, Index triangle, bool top) {
  const energy::Material& m = sheet.material(triangle);
  if (m.layers.empty()) return Vec3::Zero();
  const energy::Layer& layer = top ? m.layers.back() : m.layers.front();
  const energy::SheetState state = system::sheet_state(fields, static_cast<std::size_t>(triangle));
  return energy::layer_stress(m, layer, top ? layer.high : layer.low, state);
}

std::vector<results::Field> stress_fields(const energy::Sheet& sheet, const system::TriangleFields& fields,
                                          bool plies) {
  const std::size_t triangles = fields.membrane_strain.size() / 3;
  std::size_t most_layers = 0;
  for (const energy::Material& m : sheet.materials()) most_layers = std::max(most_layers, m.layers.size());
  Face bottom("bottom", triangles), top("top", triangles);
  std::vector<Face> inner;
  for (std::size_t k = 1; plies && k <= most_layers; ++k)
    for (const char* side : {"bottom", "top"}) inner.emplace_back(fmt::format("ply_{}_{}", k, side), triangles);
  for (std::size_t t = 0; t < triangles; ++t) {
    const std::vector<energy::Layer>& layers = sheet.material(static_cast<Index>(t)).layers;
    if (layers.empty()) continue;
    const energy::SheetState state = system::sheet_state(fields, t);
    const auto at = [&](const energy::Layer& layer, double z) {
      return energy::layer_stress(sheet.material(static_cast<Index>(t)), layer, z, state);
    };
    bottom.set(t, at(layers.front(), layers.front().low));
    top.set(t, at(layers.back(), layers.back().high));
    for (std::size_t k = 0; plies && k < layers.size(); ++k) {
      inner[2 * k].set(t, at(layers[k], layers[k].low));
      inner[2 * k + 1].set(t, at(layers[k], layers[k].high));
    }
  }
  std::vector<results::Field> out;
  bottom.add_to(out, true);
  top.add_to(out, true);
  const energy::RecoveryError recovery(sheet);
  at_vertices(sheet, recovery, "bottom_at_vertices", bottom.values(), top.values()).add_to(out, true);
  at_vertices(sheet, recovery, "top_at_vertices", top.values(), bottom.values()).add_to(out, true);
  for (const Face& f : inner) f.add_to(out, false);
  return out;
}

}  // namespace voile::record
