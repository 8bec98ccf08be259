// What is remembered per vertex, on a new mesh.
#include "transfer.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>

#include "base/mpi.hpp"
#include "system/attachments.hpp"
#include "system/contact.hpp"

namespace voile::remesh {

Origins origins_of(MPI_Comm comm, const adapt::Remeshed& from) {
  Origins origins;
  origins.kept = from.kept;
  for (const adapt::Remeshed::Source& s : from.source) {
    origins.triangle.push_back(s.triangle);
    origins.weights.insert(origins.weights.end(), s.weights.begin(), s.weights.end());
  }
  mpi::broadcast(comm, origins.triangle);
  mpi::broadcast(comm, origins.weights);
  mpi::broadcast(comm, origins.kept);
  return origins;
}

void carry_contact(const mesh::SurfaceMesh& old_mesh, const Origins& from, results::Checkpoint& c) {
  const std::vector<double> gaps = std::move(c.contact_gaps), passing = std::move(c.passing);
  c.contact_gaps.clear();
  c.passing.clear();
  const auto corners = [&](std::size_t v) {
    const mesh::Triangle t = old_mesh.triangles()[from.triangle[v]];
    return from.kept[v] != no_index ? mesh::Triangle{from.kept[v], from.kept[v], from.kept[v]} : t;
  };
  for (std::size_t v = 0; v < from.kept.size() && !gaps.empty(); ++v) {
    const mesh::Triangle t = corners(v);
    c.contact_gaps.push_back(std::min({gaps[t[0]], gaps[t[1]], gaps[t[2]]}));
  }
  for (std::size_t v = 0; v < from.kept.size() && !passing.empty(); ++v) {
    std::uint64_t all = 0;
    for (Index i : corners(v)) all |= static_cast<std::uint64_t>(passing[i]);
    c.passing.push_back(static_cast<double>(all));
  }
}

void carry_slips(const mesh::SurfaceMesh& old_mesh, const mesh::SurfaceMesh& mesh, const adapt::Remeshed& from,
                 results::Checkpoint& c) {
  if (c.slips.empty()) return;
  const std::size_t each = (c.slips.size() - 1) / static_cast<std::size_t>(old_mesh.triangle_count());
  const std::vector<double> old = std::move(c.slips);
  const auto add = [&](std::vector<double>& to, std::size_t at, double weight, const double* values) {
    for (std::size_t k = 0; k < each; ++k) to[at + k] += weight * values[k];
  };
  const auto of_triangle = [&](Index t) { return old.data() + 1 + each * static_cast<std::size_t>(t); };
  // Means over the triangles around each old vertex, by area.
  std::vector<double> at_vertex(each * static_cast<std::size_t>(old_mesh.vertex_count()), 0.0);
  for (Index v = 0; v < old_mesh.vertex_count(); ++v) {
    double area = 0.0;
    for (const Index t : old_mesh.triangles_of_vertex(v)) area += old_mesh.area(t);
    for (const Index t : old_mesh.triangles_of_vertex(v))
      add(at_vertex, each * static_cast<std::size_t>(v), old_mesh.area(t) / area, of_triangle(t));
  }
  c.slips.assign(1 + each * static_cast<std::size_t>(mesh.triangle_count()), 0.0);
  c.slips[0] = old[0];
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const std::size_t at = 1 + each * static_cast<std::size_t>(t);
    if (const Index same = from.same_triangle[t]; same != no_index) {
      add(c.slips, at, 1.0, of_triangle(same));
      continue;
    }
    for (const Index v : mesh.triangles()[t])
      for (std::size_t i = 0; i < 3; ++i) {
        const Index corner = old_mesh.triangles()[from.source[v].triangle][i];
        add(c.slips, at, from.source[v].weights[i] / 3.0, at_vertex.data() + each * static_cast<std::size_t>(corner));
      }
  }
}

void carry_anchors(const system::Model& model, const mesh::SurfaceMesh& mesh, const Origins& from,
                   results::Checkpoint& c) {
  if (c.anchors.empty()) return;
  std::map<std::pair<int, Index>, system::Anchor> old;
  for (const system::Anchor& a : system::anchors_of(c.anchors)) old.insert({{a.attachment, a.vertex}, a});
  std::vector<system::Anchor> carried;
  for (const system::Attachment& attachment : model.potential().attachments().list()) {
    const std::size_t obstacle = model.potential().attachments().obstacle_of(attachment);
    const std::vector<mesh::Triangle>& triangles = model.contact()->scene().input().obstacles[obstacle].triangles;
    const std::vector<Vec3> points = system::obstacle_points(model.contact()->scene(), obstacle);
    std::vector<Vec3> places(mesh.positions().size());
    std::vector<Index> fresh;
    for (const Index v : system::vertices_of(mesh, attachment)) {
      if (const auto same = old.find({attachment.number, from.kept[v]}); same != old.end()) {
        carried.push_back(same->second);
        carried.back().vertex = v;
        continue;
      }
      Vec3 sum = Vec3::Zero();
      double whole = 0.0;
      for (int i = 0; i < 3; ++i) {
        const Index corner = model.dofs().mesh().triangles()[from.triangle[v]][i];
        const auto at = old.find({attachment.number, corner});
        if (at == old.end()) continue;
        const double w = from.weights[3 * static_cast<std::size_t>(v) + static_cast<std::size_t>(i)];
        sum += w * system::anchor_place(at->second, triangles[at->second.triangle], points);
        whole += w;
      }
      if (attachment.hard || !(whole > 1e-6)) continue;
      places[v] = sum / whole;
      fresh.push_back(v);
    }
    system::Attachment where = attachment;
    where.gap = std::numeric_limits<double>::quiet_NaN();  // the place itself
    const std::vector<system::Anchor> own = system::make_anchors(where, fresh, places, points, triangles);
    carried.insert(carried.end(), own.begin(), own.end());
  }
  c.anchors = system::numbers_of(carried);
}

}  // namespace voile::remesh
