#include "attachments.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "boundary_conditions.hpp"
#include "contact.hpp"
#include "discretisation.hpp"
#include "energy/anchor.hpp"
#include "energy/sheet.hpp"
#include "geometry/closest_triangle.hpp"
#include "voile/errors.hpp"

namespace voile::system {

namespace {

constexpr std::size_t row_length = 8;

Mat3 axes_of(const Vec3& a, const Vec3& b, const Vec3& c) {
  Mat3 f;
  f.col(0) = (b - a).normalized();
  f.col(2) = (b - a).cross(c - a).normalized();
  f.col(1) = Vec3(f.col(2)).cross(Vec3(f.col(0)));
  return f;
}

}  // namespace

std::vector<double> numbers_of(const std::vector<Anchor>& anchors) {
  std::vector<double> all;
  for (const Anchor& a : anchors)
    all.insert(all.end(),
               {static_cast<double>(a.attachment), static_cast<double>(a.vertex), static_cast<double>(a.triangle),
                a.weights[0], a.weights[1], a.offset[0], a.offset[1], a.offset[2]});
  return all;
}

std::vector<Anchor> anchors_of(const std::vector<double>& numbers) {
  std::vector<Anchor> all;
  for (std::size_t i = 0; i + row_length <= numbers.size(); i += row_length) {
    const double* n = numbers.data() + i;
    all.push_back({static_cast<int>(n[0]), static_cast<Index>(n[1]), static_cast<Index>(n[2]), Vec2(n[3], n[4]),
                   Vec3(n[5], n[6], n[7])});
  }
  return all;
}

Vec3 anchor_place(const Anchor& anchor, const mesh::Triangle& triangle, const std::vector<Vec3>& points) {
  const Vec3 &a = points[triangle[0]], &b = points[triangle[1]], &c = points[triangle[2]];
  return a + anchor.weights[0] * (b - a) + anchor.weights[1] * (c - a) + axes_of(a, b, c) * anchor.offset;
}

std::vector<Anchor> make_anchors(const Attachment& attachment, const std::vector<Index>& vertices,
                                 const std::vector<Vec3>& places, const std::vector<Vec3>& points,
                                 const std::vector<mesh::Triangle>& triangles) {
  const geometry::ClosestTriangle closest(points, triangles);
  std::vector<Anchor> anchors;
  for (const Index v : vertices) {
    const Index t = closest.find(places[v]);
    const std::array corners{points[triangles[t][0]], points[triangles[t][1]], points[triangles[t][2]]};
    const Vec3 weights = geometry::nearest_weights(places[v], corners);
    Anchor anchor{attachment.number, v, t, Vec2(weights[1], weights[2]), Vec3::Zero()};
    const Vec3 away = places[v] - anchor_place(anchor, triangles[t], points);
    anchor.offset = axes_of(corners[0], corners[1], corners[2]).transpose() * away;
    if (!std::isnan(attachment.gap)) anchor.offset = {0.0, 0.0, std::copysign(attachment.gap, anchor.offset.z())};
    anchors.push_back(anchor);
  }
  return anchors;
}

std::vector<Index> vertices_of(const mesh::SurfaceMesh& mesh, const Attachment& attachment) {
  std::vector<Index> all;
  for (const std::string& name : attachment.groups) {
    const std::vector<Index>& some = mesh.group(name).vertices;
    all.insert(all.end(), some.begin(), some.end());
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

Attachments::Attachments(const Discretisation& on, std::vector<Attachment> list, const Contact* contact,
                         BoundaryConditions& conditions, energy::AnchorTerm* term)
    : on_(&on), list_(std::move(list)), contact_(contact), conditions_(&conditions), term_(term) {
  for (const Attachment& attachment : list_) {
    const std::size_t obstacle = obstacle_of(attachment);
    if (!attachment.hard)
      hold_softly(attachment, obstacle);
    else
      for (const Index v : vertices_of(on.mesh(), attachment))
        if (on.owned(v) != no_index) held_[{attachment.number, v}] = {on.owned(v), obstacle, true};
  }
}

void Attachments::hold_softly(const Attachment& attachment, std::size_t obstacle) {
  std::map<Index, double> stiffness;  // of a vertex
  for (const std::string& name : attachment.groups) {
    Load like;  // the same lumping as that of loads
    constexpr std::array kinds{Load::Kind::point, Load::Kind::line, Load::Kind::area};
    const auto dimension = static_cast<std::size_t>(on_->mesh().group(name).dimension);
    like.kind = kinds[dimension];
    like.group = name;
    like.vector =
        (std::isnan(attachment.stiffness) ? attachment.usual[dimension] : attachment.stiffness) * Vec3::UnitX();
    spread(*on_, like, [&](Index v, const Vec3& fraction) { stiffness[v] += fraction.x(); });
  }
  for (const auto& [v, k] : stiffness) {
    if (on_->owned(v) == no_index) continue;
    held_[{attachment.number, v}] = {term_->size(), obstacle, false};
    term_->add(on_->dofs().local().local_of[v], k);
  }
}

std::size_t Attachments::obstacle_of(const Attachment& attachment) const {
  if (contact_) {
    const std::vector<contact::Obstacle>& all = contact_->scene().input().obstacles;
    for (std::size_t k = 0; k < all.size(); ++k)
      if (all[k].name == attachment.obstacle && !all[k].triangles.empty()) return k;
  }
  throw UserError(fmt::format("[[attachment]] obstacle '{}': there is no such obstacle of type mesh or cylinder here",
                              attachment.obstacle));
}

void Attachments::attach(Vec a, std::vector<Anchor>& anchors) {
  std::vector<Anchor> all;
  const std::vector<Vec3> places = list_.empty() ? std::vector<Vec3>{} : contact_->scene().positions(a);
  for (const Attachment& attachment : list_) {
    const std::size_t k = obstacle_of(attachment);
    const std::vector<mesh::Triangle>& triangles = contact_->scene().input().obstacles[k].triangles;
    std::vector<Index> free = vertices_of(on_->mesh(), attachment);
    for (const Anchor& anchor : anchors) {
      if (anchor.attachment != attachment.number || std::erase(free, anchor.vertex) == 0) continue;
      if (anchor.triangle < 0 || anchor.triangle >= static_cast<Index>(triangles.size()))
        throw UserError(
            fmt::format("[[attachment]] obstacle '{}': the state that the run continues from was attached to another "
                        "mesh of it; begin with the stage that takes hold",
                        attachment.obstacle));
      all.push_back(anchor);
    }
    if (free.empty()) continue;
    const std::vector<Anchor> own =
        make_anchors(attachment, free, places, obstacle_points(contact_->scene(), k), triangles);
    all.insert(all.end(), own.begin(), own.end());
  }
  anchors = all;
  anchors_ = std::move(all);
  placed_at_.reset();
  place();
}

void Attachments::place() {
  if (anchors_.empty() || placed_at_ == contact_->scene().time()) return;
  placed_at_ = contact_->scene().time();
  std::map<std::size_t, std::vector<Vec3>> points;
  for (const Anchor& anchor : anchors_) {
    const auto at = held_.find({anchor.attachment, anchor.vertex});
    if (at == held_.end()) continue;  // another rank's
    const auto& [element, obstacle, hard] = at->second;
    if (!points.count(obstacle)) points[obstacle] = obstacle_points(contact_->scene(), obstacle);
    const auto& triangles = contact_->scene().input().obstacles[obstacle].triangles;
    const Vec3 place = anchor_place(anchor, triangles[anchor.triangle], points[obstacle]);
    if (hard)
      conditions_->set_displacement(element, place - on_->dofs().local().start[element]);
    else
      term_->set_place(element, place);
  }
}

}  // namespace voile::system
