#include "bands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "discretisation.hpp"
#include "energy/spring.hpp"
#include "voile/errors.hpp"

namespace voile::system {

void Bands::add(const Spring& spring) {
  const LocalPoints& local = on_.dofs().local();
  const mesh::SurfaceMesh& mesh = on_.mesh();
  const mesh::Group& group = mesh.group(spring.group, 1);
  double whole = 0.0;
  for (const mesh::Segment& s : group.segments) whole += mesh.rest_length(s);
  const double fraction = !std::isnan(spring.force)    ? 1.0 / (1.0 + spring.force / spring.stiffness)
                          : !std::isnan(spring.length) ? spring.length / whole
                                                       : 1.0;
  if (!(fraction > 0.0))
    throw UserError(fmt::format("[[spring]] type 'band', group '{}': length = {:g} m; a band has a length",
                                spring.group, spring.length));
  const bool rises = fraction < 1.0 && spring.rise > 0.0 && std::isfinite(spring.start);
  rise_ = rise_ || rises;
  if (on_.is_on_body(group.vertices))
    throw UserError(
        fmt::format("[[spring]] type 'band', group '{}': a vertex of it belongs to a [[rigid]] group; leave "
                    "that vertex out of one of them",
                    spring.group));
  for (const mesh::Segment& s : group.segments) {
    if (on_.owned(s[0]) == no_index && on_.owned(s[1]) == no_index) continue;
    const double rest = mesh.rest_length(s), length = fraction * rest;
    if (rises) edges_.push_back({term_->size(), rest, fraction, spring.stiffness, spring.start, spring.rise});
    term_->add({local.local_of[s[0]], local.local_of[s[1]]}, spring.stiffness / length, length,
               on_.owned(s[0]) != no_index, true);
  }
}

void Bands::tighten(double time) {
  for (const Edge& e : edges_) {
    const double s = std::clamp((time - e.start) / e.rise, 0.0, 1.0);
    const double length = e.rest * (1.0 + s * (e.fraction - 1.0));
    term_->set(e.element, e.stiffness / length, length);
  }
}

}  // namespace voile::system
