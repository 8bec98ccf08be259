#include "ties.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>

#include "base/mpi.hpp"
#include "constraints.hpp"
#include "discretisation.hpp"
#include "voile/errors.hpp"

namespace voile::system {

namespace {

/// Rings of images: as far as fits of a triangle at a curve reach, and its neighbours'.
constexpr int image_rings = 6;
/// Where motions are compared [s].
constexpr std::array trial_times{0.0, 0.37, 1.0};

std::string name_of(const PeriodicPair& p) {
  return fmt::format("[[periodic]] from = '{}', to = '{}'", p.from, p.to);
}

class Resolver {
 public:
  Resolver(const mesh::SurfaceMesh& mesh, const std::vector<PeriodicPair>& pairs, const std::vector<Support>& supports,
           Constraints& constraints)
      : mesh_(mesh), pairs_(pairs), supports_(supports), constraints_(constraints) {}

  void run() {
    if (!mesh_.joints().empty() || mesh_.has_charts())
      throw UserError(fmt::format("{}: {} {}; remove the section", name_of(pairs_.front()), mesh_.source(),
                                  mesh_.has_charts() ? "has a rest shape of its own, which is not continued"
                                                     : "joins sheets, which are not continued"));
    refuse_held_slopes();
    std::vector<mesh::PeriodicCurves> curves;
    for (const PeriodicPair& p : pairs_) curves.push_back({p.from, p.to});
    Ties& ties = constraints_.ties;
    ties.mesh = &mesh_;
    ties.sheet =
        std::make_shared<const mesh::ContinuedSurface>(mesh::continue_periodically(mesh_, curves, image_rings));
    for (Index v = 0; v < mesh_.vertex_count(); ++v) {
      if (!ties.is_tied(v)) continue;
      require_alike(v);
      constraints_.vertices[v] = {.fixed = {true, true, true}};
    }
    for (std::size_t i = 0; i < pairs_.size(); ++i) add_carrier(i);
  }

 private:
  void refuse_held_slopes() const {
    for (const PeriodicPair& p : pairs_)
      for (const std::string* name : {&p.from, &p.to}) {
        if (!mesh_.has_group(*name)) continue;  // is said with the names that there are
        for (const mesh::Segment& s : mesh_.group(*name).segments)
          for (const mesh::MirrorSide& m : constraints_.mirrors)
            if (mesh_.side_of(m.triangle, s[0], s[1]) == m.side)
              throw UserError(
                  fmt::format("{}: a [[support]] holds the slope of the edge {}-{} of '{}', where the sheet "
                              "continues; use type = \"displacement\", or take the edge out of a group",
                              name_of(p), mesh_.data().vertex_tags[s[0]], mesh_.data().vertex_tags[s[1]], *name));
      }
  }

  /// What holds a vertex that follows another one must hold that one too, and agree with the difference.
  void require_alike(Index v) const {
    const auto own = constraints_.vertices.find(v);
    if (own == constraints_.vertices.end()) return;
    const Ties& ties = constraints_.ties;
    const auto root = constraints_.vertices.find(ties.root(v));
    const VertexSupport& here = own->second;
    if (root == constraints_.vertices.end() || !root->second.axes.isApprox(here.axes) ||
        !std::equal(here.fixed.begin(), here.fixed.end(), root->second.fixed.begin(), std::less_equal<>()))
      fail(v, "a [[support]] holds it otherwise than the vertex that it repeats; hold both alike, or only that one");
    const auto moves_it = [&](int support) { return moves_alike(support, v); };
    if (root->second.motion != here.motion || !std::all_of(here.motion.begin(), here.motion.end(), moves_it))
      fail(v, "a [[support]] moves it otherwise than the vertex that it repeats; leave one of them out of it");
    for (int k = 0; k < 3; ++k)
      if (here.fixed[static_cast<std::size_t>(k)]) require_difference(v, k, here, root->second);
  }

  /// Whether a support has the same motion at a vertex as at its root.
  [[nodiscard]] bool moves_alike(int support, Index v) const {
    if (support < 0 || !supports_[static_cast<std::size_t>(support)].motion) return true;
    constexpr double round_off = 1e-9;
    const Vec3 &x = mesh_.positions()[v], &root = mesh_.positions()[constraints_.ties.root(v)];
    const auto& motion = supports_[static_cast<std::size_t>(support)].motion;
    return std::all_of(trial_times.begin(), trial_times.end(),
                       [&](double t) { return (motion(x, t) - motion(root, t)).norm() <= round_off * mesh_.extent(); });
  }

  void require_difference(Index v, int k, const VertexSupport& here, const VertexSupport& root) const {
    constexpr double round_off = 1e-9;
    const Vec3 direction = here.axes.col(k);
    double apart = root.value[k] - here.value[k], size = std::abs(root.value[k]) + std::abs(here.value[k]);
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      const int n = constraints_.ties.periods(v, i);
      if (n == 0) continue;
      for (int c = 0; c < 3; ++c) {
        if (std::abs(direction[c]) < round_off) continue;
        if (!pairs_[i].held[static_cast<std::size_t>(c)])
          fail(v,
               "a [[support]] holds it and the vertex that it repeats, so that their difference is not free; "
               "prescribe that component of `difference`");
        apart += n * pairs_[i].difference[c] * direction[c];
        size += std::abs(pairs_[i].difference[c]);
        if (pairs_[i].motion)
          for (const double t : trial_times)
            if (const Vec3 d = pairs_[i].motion(t); std::abs(d[c]) > 0.0)
              fail(v,
                   "a [[support]] holds it, and `difference` moves it; leave it out of the support, or hold it in "
                   "other directions");
      }
    }
    if (std::abs(apart) > round_off * size)
      fail(v,
           "the displacement that a [[support]] gives it is not that of the vertex it repeats and `difference`; "
           "correct one of them");
  }

  [[noreturn]] void fail(Index v, const char* why) const {
    const auto pair = std::find_if(pairs_.begin(), pairs_.end(), [&](const PeriodicPair& p) {
      return constraints_.ties.periods(v, static_cast<std::size_t>(&p - pairs_.data())) != 0;
    });
    const Vec3& x = mesh_.positions()[v];
    throw UserError(fmt::format("{}: vertex {} ({:.6g}, {:.6g}, {:.6g}): {}", name_of(*pair),
                                mesh_.data().vertex_tags[v], x.x(), x.y(), x.z(), why));
  }

  /// The first vertex of the curve that repeats another one by this pair alone.
  void add_carrier(std::size_t i) {
    const PeriodicPair& p = pairs_[i];
    mesh::ContinuedSurface::Shift one{};
    one[i] = 1;
    for (const Index v : mesh_.group(p.to, 1).vertices) {
      if (constraints_.ties.sheet->shift[v] != one) continue;
      constraints_.ties.carriers.push_back(v);
      VertexSupport held;
      held.fixed = p.held;
      held.value = p.difference;
      if (p.motion) held.motion.fill(static_cast<int>(supports_.size() + i));
      constraints_.vertices[v] = held;
      return;
    }
    throw UserError(name_of(p) +
                    ": every vertex repeats others by more than this pair; refine the mesh along the curve");
  }

  const mesh::SurfaceMesh& mesh_;
  const std::vector<PeriodicPair>& pairs_;
  const std::vector<Support>& supports_;
  Constraints& constraints_;
};

}  // namespace

std::vector<Index> Ties::unknowns_of(const std::vector<Index>& vertices) const {
  std::vector<Index> all;
  for (const Index v : vertices) {
    all.push_back(root(v));
    for (std::size_t i = 0; i < carriers.size(); ++i)
      if (periods(v, i) != 0) all.push_back(carriers[i]);
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

void Ties::spread(std::vector<char>& marked) const {
  if (!any()) return;
  for (std::size_t v = 0; v < marked.size(); ++v)
    if (marked[v]) marked[root(static_cast<Index>(v))] = 1;
  for (std::size_t v = 0; v < marked.size(); ++v) marked[v] = marked[root(static_cast<Index>(v))];
}

void resolve_periodic(const mesh::SurfaceMesh& mesh, const std::vector<PeriodicPair>& pairs,
                      const std::vector<Support>& supports, Constraints& constraints) {
  if (!pairs.empty()) Resolver(mesh, pairs, supports, constraints).run();
}

std::vector<mesh::MirrorSide> continued_mirrors(const mesh::ContinuedSurface& sheet,
                                                const std::vector<mesh::MirrorSide>& mirrors,
                                                std::vector<int>& turned_by) {
  std::vector<mesh::MirrorSide> all = mirrors;
  const mesh::SurfaceMesh& surface = *sheet.surface;
  for (Index t = 0; t < surface.triangle_count(); ++t) {
    if (sheet.original[t] == t) continue;
    for (std::size_t k = 0; k < mirrors.size(); ++k) {
      if (mirrors[k].triangle != sheet.original[t]) continue;
      all.push_back({t, mirrors[k].side, mirrors[k].reflection});
      turned_by.push_back(turned_by[k]);
    }
  }
  return all;
}

namespace {

/// Takes what supports carry out of the forces that hold differences: each repetition of a vertex has an equal part of its
/// reaction.
void leave_reactions(const Discretisation& on, const petsc::ReadArray& force, std::vector<double>& all) {
  const Constraints& constraints = on.constraints();
  const Ties& ties = constraints.ties;
  std::map<Index, std::vector<Index>> repetitions;
  for (Index v = 0; v < on.mesh().vertex_count(); ++v)
    if (ties.is_tied(v)) repetitions[ties.root(v)].push_back(v);
  for (const auto& [root, tied] : repetitions) {
    const auto support = constraints.vertices.find(root);
    const Index at = on.owned(root);
    if (at == no_index || support == constraints.vertices.end()) continue;
    Vec3 reaction = Vec3::Zero();
    for (Index k = 0; k < 3; ++k)
      if (support->second.fixed[static_cast<std::size_t>(k)]) reaction[k] = force[3 * at + k];
    reaction = on.dofs().to_global(root, reaction) / static_cast<double>(tied.size() + 1);
    for (const Index v : tied)
      for (std::size_t i = 0; i < ties.carriers.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k)
          if (constraints.vertices.at(ties.carriers[i]).fixed[k])
            all[6 * i + 3 + k] -= ties.periods(v, i) * reaction[static_cast<Eigen::Index>(k)];
  }
}

}  // namespace

std::vector<double> periodic_values(const Discretisation& on, Vec a, Vec f) {
  const std::vector<Index>& carriers = on.constraints().ties.carriers;
  std::vector<double> all(6 * carriers.size(), 0.0);
  {
    const petsc::ReadArray difference(a), force(f);
    for (std::size_t i = 0; i < carriers.size(); ++i)
      if (const Index at = on.owned(carriers[i]); at != no_index)
        for (std::size_t k = 0; k < 3; ++k) {
          all[6 * i + k] = difference[3 * at + static_cast<Index>(k)];
          all[6 * i + 3 + k] = force[3 * at + static_cast<Index>(k)];
        }
    leave_reactions(on, force, all);
  }
  mpi::sum_to_root(on.comm(), all);
  return all;
}

}  // namespace voile::system
