// What moving a vertex changes, kept to take it back.
#pragma once

#include <tuple>
#include <utility>

#include "star.hpp"

namespace voile::adapt {

/// What moving a vertex changes, to put it back.
class MoveUndo {
 public:
  MoveUndo(const Surface& s, const Star& star)
      : place_(s.place[star.vertex]), size_(s.size[star.vertex]), old_(s.old[star.vertex]), counts_(s.counts) {
    for (Index e : star.spokes) {
      const Index t = e / 3;
      Corner c{s.rest[next(e)], Vec2::Zero(), s.rest_hint[t], s.old_hint[t], s.touched[t], 0.0, 0.0};
      if (!s.texture.empty()) c.texture = s.texture[next(e)];
      if (!s.allowed.empty()) std::tie(c.moved, c.allowed) = std::pair(s.moved[t], s.allowed[t]);
      corners_.push_back(c);
    }
  }
  void operator()(Surface& s, const Star& star) const {
    s.place[star.vertex] = place_;
    s.size[star.vertex] = size_;
    s.old[star.vertex] = old_;
    s.counts = counts_;
    for (std::size_t k = 0; k < corners_.size(); ++k) {
      const Index e = star.spokes[k], t = e / 3;
      const Corner& c = corners_[k];
      s.rest[next(e)] = c.rest;
      s.rest_hint[t] = c.rest_hint;
      s.old_hint[t] = c.old_hint;
      s.touched[t] = c.touched;
      if (!s.texture.empty()) s.texture[next(e)] = c.texture;
      if (!s.allowed.empty()) std::tie(s.moved[t], s.allowed[t]) = std::pair(c.moved, c.allowed);
    }
  }

 private:
  struct Corner {
    Vec3 rest;
    Vec2 texture;
    Index rest_hint, old_hint;
    char touched;
    double moved, allowed;
  };
  Vec3 place_;
  double size_;
  Index old_;
  Counts counts_;
  std::vector<Corner> corners_;
};

}  // namespace voile::adapt
