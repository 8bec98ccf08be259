// Attachments to obstacles, and bands along edges.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "voile/base/error.hpp"
#include "voile/energy/anchor.hpp"
#include "voile/energy/sheet.hpp"
#include "voile/energy/spring.hpp"
#include "voile/system/contact.hpp"
#include "voile/system/model.hpp"
#include "voile/system/term.hpp"

namespace voile::system {

void Model::add_band(const Spring& spring, ElementTerm<energy::SpringTerm>& bands) const {
  const LocalPoints& local = dofs().local();
  const mesh::SurfaceMesh& mesh = on_->mesh();
  const mesh::Group& group = mesh.group(spring.group, 1);
  double whole = 0.0;
  for (const mesh::Segment& s : group.segments) whole += mesh.rest_length(s);
  const double share = std::isnan(spring.length) ? 1.0 : spring.length / whole;
  if (!(share > 0.0))
    throw UserError(fmt::format("[[spring]] type 'band', group '{}': length = {:g} m; a band has a length",
                                spring.group, spring.length));
  for (const mesh::Segment& s : group.segments) {
    if (on_->owned(s[0]) == no_index && on_->owned(s[1]) == no_index) continue;
    const double length = share * mesh.rest_length(s);
    bands.kernel.add({local.local_of[s[0]], local.local_of[s[1]]}, spring.stiffness / length, length,
                     on_->owned(s[0]) != no_index, true);
  }
}

std::size_t Model::obstacle_of(const Attachment& attachment) const {
  if (contact_) {
    const std::vector<contact::Obstacle>& all = contact_->scene().input().obstacles;
    for (std::size_t k = 0; k < all.size(); ++k)
      if (all[k].name == attachment.obstacle && !all[k].triangles.empty()) return k;
  }
  throw UserError(fmt::format("[[attachment]] obstacle '{}': there is no such obstacle of type mesh or cylinder here",
                              attachment.obstacle));
}

const std::vector<Support>& with_followers(ModelInput& input) {
  for (const Attachment& attachment : input.attachments)
    for (const std::string& group : attachment.groups) {
      if (!attachment.hard) continue;
      Support held;
      held.group = group;
      held.kind = Support::Kind::hinged;
      held.follows = true;
      input.supports.push_back(held);
    }
  return input.supports;
}

void Model::add_attachments(std::vector<Attachment> list) {
  attachments_ = std::move(list);
  if (attachments_.empty()) return;
  ElementTerm<energy::AnchorTerm>& term = *anchor_term_;
  for (const Attachment& attachment : attachments_) {
    const std::size_t obstacle = obstacle_of(attachment);
    if (attachment.hard) {
      for (const Index v : vertices_of(on_->mesh(), attachment))
        if (on_->owned(v) != no_index) anchored_[{attachment.number, v}] = {on_->owned(v), obstacle, true};
      continue;
    }
    std::map<Index, double> stiffness;  // of a vertex
    for (const std::string& name : attachment.groups) {
      Load like;  // the same lumping as that of loads
      constexpr std::array kinds{Load::Kind::point, Load::Kind::line, Load::Kind::area};
      const int dimension = on_->mesh().group(name).dimension;
      like.kind = kinds[static_cast<std::size_t>(dimension)];
      like.group = name;
      like.vector = attachment.stiffness * Vec3::UnitX();
      spread(on_->sheet(), like, [&](Index v, const Vec3& share) { stiffness[v] += share.x(); });
    }
    for (const auto& [v, k] : stiffness) {
      if (on_->owned(v) == no_index) continue;
      anchored_[{attachment.number, v}] = {term.kernel.size(), obstacle, false};
      term.kernel.add(dofs().local().local_of[v], k);
    }
  }
}

void Model::attach(Vec a, std::vector<Anchor>& anchors) {
  std::vector<Anchor> all;
  const std::vector<Vec3> places = attachments_.empty() ? std::vector<Vec3>{} : contact_->scene().positions(a);
  for (const Attachment& attachment : attachments_) {
    const std::size_t k = obstacle_of(attachment);
    const std::vector<mesh::Triangle>& triangles = contact_->scene().input().obstacles[k].triangles;
    std::vector<Index> free = vertices_of(on_->mesh(), attachment);
    for (const Anchor& anchor : anchors) {
      if (anchor.attachment != attachment.number || std::erase(free, anchor.vertex) == 0) continue;
      if (anchor.triangle < 0 || anchor.triangle >= static_cast<Index>(triangles.size()))
        throw UserError(
            fmt::format("[[attachment]] obstacle '{}': the state that the run goes on from was attached to another "
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
  anchored_time_.reset();
  place_anchors();
}

/// Puts the places of anchors where the obstacles are.
void Model::place_anchors() {
  if (anchors_.empty() || anchored_time_ == contact_->scene().time()) return;
  anchored_time_ = contact_->scene().time();
  std::map<std::size_t, std::vector<Vec3>> points;
  for (const Anchor& anchor : anchors_) {
    const auto at = anchored_.find({anchor.attachment, anchor.vertex});
    if (at == anchored_.end()) continue;  // another rank's
    const auto& [element, obstacle, hard] = at->second;
    if (!points.count(obstacle)) points[obstacle] = obstacle_points(contact_->scene(), obstacle);
    const auto& triangles = contact_->scene().input().obstacles[obstacle].triangles;
    const Vec3 place = anchor_place(anchor, triangles[anchor.triangle], points[obstacle]);
    if (hard)
      conditions_->set_displacement(element, place - dofs().local().start[element]);
    else
      anchor_term_->kernel.set_place(element, place);
  }
}

}  // namespace voile::system
