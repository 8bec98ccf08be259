#include "sewing_springs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "base/mpi.hpp"
#include "base/wildcard.hpp"
#include "discretisation.hpp"
#include "energy/seam.hpp"
#include "mesh/weld.hpp"

namespace voile::system {

namespace {

/// When no spring has a length any more, all double their stiffness in this time [s], up to this factor: fabric in
/// tension would keep soft ones open. Before, while all moves, stiff springs that saturate would only cost iterations.
constexpr double doubling_time = 0.03, most_tight = 128.0;
/// Fraction of the length at which closed springs saturate that a step has to resolve.
constexpr double resolved = 0.1;
/// In which the largest force doubles from then on [s]: slowly enough that fabric follows.
constexpr double force_doubling_time = 0.1;
/// Largest speed over the mean one of what begins and ends at rest.
constexpr double peak = 1.5;

/// Speed of the slider that closes a seam; 0: it has none. [m/s]
double zip_speed(const Sewing& sewing, const std::string& seam) {
  const Sewing::Zip* found = nullptr;
  for (const Sewing::Zip& zip : sewing.zips) {
    if (zip.seam == seam) return zip.speed;
    if (star_of(zip.seam, seam)) found = &zip;
  }
  return found ? found->speed : 0.0;
}

}  // namespace

SewingSprings::SewingSprings(const Discretisation& on, Sewing sewing, energy::SeamTerm& term)
    : on_(&on), sewing_(std::move(sewing)), term_(&term) {
  const LocalPoints& local = on.dofs().local();
  const mesh::SurfaceMesh& mesh = on.mesh();
  const std::vector<std::string> sewn = mesh::open_seams(mesh.data(), sewing_.seams);
  for (const mesh::Seam& seam : mesh.data().seams) {
    if (std::find(sewn.begin(), sewn.end(), seam.name) == sewn.end()) continue;
    const std::vector<std::string>& gathered = on.gathered_seams();
    const bool is_gathered = std::find(gathered.begin(), gathered.end(), seam.name) != gathered.end();
    gathers_ = gathers_ || is_gathered;
    const double slider = seam.stations.empty() ? 0.0 : zip_speed(sewing_, seam.name);
    seams_.push_back({seam.name, std::accumulate(seam.lengths.begin(), seam.lengths.end(), 0.0)});
    for (std::size_t k = 0; k < seam.pairs.size(); ++k) {
      const auto& [v, w] = seam.pairs[k];
      const double length = (mesh.positions()[w] - mesh.positions()[v]).norm();
      longest_distance_ = std::max(longest_distance_, length);
      const double delay = slider > 0.0 ? seam.stations[k] / slider : 0.0;
      if (slider > 0.0) zipped_after_ = std::max(zipped_after_, delay + length / sewing_.speed);
      if (on.owned(v) == no_index && on.owned(w) == no_index) continue;
      springs_.push_back({length, sewing_.stiffness * seam.lengths[k], seam.lengths[k], is_gathered && slider == 0.0,
                          delay, seams_.size() - 1});
      term.add({local.local_of[v], local.local_of[w]}, springs_.back().stiffness, sewing_.force * seam.lengths[k],
               length, on.owned(v) != no_index);
    }
  }
}

double SewingSprings::drawing_time() const {
  return (gathers_ ? peak : 1.0) * longest_distance_ / sewing_.speed;
}

double SewingSprings::closing_time() const {
  return std::max(drawing_time(), zipped_after_);
}

double SewingSprings::drawn_in(double time) const {
  const double since = std::max(0.0, time - sewing_.start), whole = drawing_time();
  if (since >= whole) return 1.0;
  const double fraction = since / whole;
  return fraction * fraction * (3.0 - 2.0 * fraction);
}

double SewingSprings::largest_force(double time) const {
  const double since = std::max(0.0, time - sewing_.start - closing_time());
  return std::max(sewing_.force, std::min(sewing_.most_force, sewing_.force * std::exp2(since / force_doubling_time)));
}

std::vector<SewingSprings::Pull> SewingSprings::pulls(const energy::Configuration& c) const {
  std::vector<double> sums(seams_.size()), largest(seams_.size());
  for (std::size_t e = 0; e < springs_.size(); ++e) {
    const auto element = static_cast<Index>(e);
    const double force = term_->force(element, c), part = springs_[e].part;
    if (term_->owned(element)) sums[springs_[e].seam] += force;
    if (part > 0.0) largest[springs_[e].seam] = std::max(largest[springs_[e].seam], force / part);
  }
  mpi::sum(on_->comm(), sums);
  std::vector<Pull> pulls;
  for (std::size_t s = 0; s < seams_.size(); ++s)
    pulls.push_back(
        {seams_[s].name, seams_[s].length > 0.0 ? sums[s] / seams_[s].length : 0.0, mpi::max(on_->comm(), largest[s])});
  return pulls;
}

void SewingSprings::tighten(double time) {
  const double since = std::max(0.0, time - sewing_.start);
  const double tighter = std::min(most_tight, std::exp2(std::max(0.0, since - closing_time()) / doubling_time));
  const double force = largest_force(time);
  resolution_ = since > closing_time() ? resolved * force / (sewing_.stiffness * tighter)
                                       : std::numeric_limits<double>::infinity();
  for (std::size_t e = 0; e < springs_.size(); ++e) {
    const Spring& s = springs_[e];
    const double shortened = sewing_.speed * (since - s.delay);
    const double now = s.gathered        ? s.length * (1.0 - drawn_in(time))
                       : shortened < 0.0 ? std::numeric_limits<double>::infinity()  // no slider yet, no pull
                                         : std::max(0.0, s.length - shortened);
    term_->set(static_cast<Index>(e), now, s.stiffness * tighter, force * s.part);
  }
}

}  // namespace voile::system
