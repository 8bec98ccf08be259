// A term of the potential in a distributed model: element kernels (energy/term.hpp) with their places in a matrix.
//
// The potential calls a term once per evaluation; the loop over its elements is inside, so nothing is virtual there. To add
// a term: write its kernel (energy/), collect its elements where Potential builds its terms, and say under which name its
// energy is counted.
#pragma once

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

#include "block_matrix.hpp"
#include "dofs.hpp"
#include "energy/term.hpp"
#include "half_blocks.hpp"

namespace voile::system {

/// Adds the block of two local points to the rows of this rank: mirror points and vertices with axes of their own pass
/// it on to the unknowns they depend on.
inline void add_block(const Dofs& dofs, const BlockMatrix& matrix, Index a, Index b, const Mat3& block,
                      const BlockMatrix::Values& values) {
  const LocalPoints& local = dofs.local();
  if (dofs.is_plain(a) && dofs.is_plain(b)) {
    if (a < local.owned) values.add(matrix.slot(a, local.row_of[b]), block);
    return;
  }
  const std::vector<Dofs::Share> columns = dofs.fractions(b);
  for (const Dofs::Share& row : dofs.fractions(a)) {
    if (row.vertex >= local.owned) continue;
    for (const Dofs::Share& column : columns)
      values.add(matrix.slot(row.vertex, local.row_of[column.vertex]), row.map.transpose() * block * column.map);
  }
}

class Term {
 public:
  Term() = default;
  Term(const Term&) = delete;
  Term& operator=(const Term&) = delete;
  virtual ~Term() = default;

  /// Calls f(points, count) with the local points of every element: what the matrix must have room for.
  virtual void for_stencils(const std::function<void(const Index*, int)>& f) const = 0;
  /// Sum over the elements that this rank counts; 0 for a term without a potential. [J]
  [[nodiscard]] virtual double energy(const energy::Configuration& c) const = 0;
  /// Adds the derivative of the energy, or minus the force, to `force`, one per local point. [N]
  virtual void add_forces(const energy::Configuration& c, std::vector<Vec3>& force) const = 0;
  /// Adds the blocks of the tangent to the open values of `matrix`, whose pattern has this number. [N/m]
  virtual void add_blocks(const energy::Configuration& c, const Dofs& dofs, const BlockMatrix& matrix, int pattern,
                          const BlockMatrix::Values& values) = 0;
  /// For terms whose blocks go to `halves` instead: finds their places there, once; adds them to its open values.
  virtual void locate(HalfBlocks& /*halves*/) {}
  virtual void add_halves(const energy::Configuration& /*c*/, double* /*halves*/) const {}
};

/// The elements of a kernel that runs over batches (energy/batches.hpp). Energy and forces come from one pass; whoever asks for the
/// second at the same configuration gets what was kept.
template <class Kernel>
class BatchTerm final : public Term {
 public:
  Kernel kernel;

  void for_stencils(const std::function<void(const Index*, int)>& f) const override {
    for (Index e = 0; e < kernel.size(); ++e) f(kernel.stencil(e), kernel.stencil_size(e));
  }
  [[nodiscard]] double energy(const energy::Configuration& c) const override {
    if (kernel.size() == 0) return 0.0;
    evaluate(c);
    return kept_.energy;
  }
  void add_forces(const energy::Configuration& c, std::vector<Vec3>& force) const override {
    if (kernel.size() == 0) return;
    evaluate(c);
    for (std::size_t i = 0; i < kept_.force.size(); ++i) force[i] += kept_.force[i];
  }
  void add_blocks(const energy::Configuration& /*c*/, const Dofs& /*dofs*/, const BlockMatrix& /*matrix*/,
                  int /*pattern*/, const BlockMatrix::Values& /*values*/) override {}
  void locate(HalfBlocks& halves) override {
    kernel.locate([&](const Index* points, int count,
                      const auto& depends_on) { return halves.places_of(points, count, depends_on); },
                  halves.none());
    std::size_t points = 0;
    for_stencils([&](const Index* stencil, int count) {
      for (int i = 0; i < count; ++i) points = std::max(points, static_cast<std::size_t>(stencil[i]) + 1);
    });
    kept_.force.resize(points);
  }
  void add_halves(const energy::Configuration& c, double* halves) const override { kernel.add_tangents(c, halves); }

 private:
  void evaluate(const energy::Configuration& c) const {
    const std::size_t count = kept_.force.size();
    if (kept_.version == kernel.version() && std::equal(kept_.x.begin(), kept_.x.end(), c.x) &&
        std::equal(kept_.u.begin(), kept_.u.end(), c.u))
      return;
    kept_.x.assign(c.x, c.x + count);
    kept_.u.assign(c.u, c.u + count);
    kept_.version = kernel.version();
    std::fill(kept_.force.begin(), kept_.force.end(), Vec3::Zero());
    kept_.energy = kernel.add_gradients(c, kept_.force.data());
  }

  struct Kept {
    long version = -1;
    std::vector<Vec3> x, u, force;  ///< of the points that there are elements at
    double energy = 0.0;
  };
  mutable Kept kept_;
};

/// The elements of one kernel.
template <class Kernel>
class ElementTerm final : public Term {
 public:
  Kernel kernel;

  void for_stencils(const std::function<void(const Index*, int)>& f) const override {
    for (Index e = 0; e < kernel.size(); ++e) f(kernel.stencil(e), kernel.stencil_size(e));
  }

  [[nodiscard]] double energy(const energy::Configuration& c) const override {
    double sum = 0.0;
    if constexpr (requires { kernel.energy(0, c); })
      for (Index e = 0; e < kernel.size(); ++e)
        if (kernel.owned(e)) sum += kernel.energy(e, c);
    return sum;
  }

  void add_forces(const energy::Configuration& c, std::vector<Vec3>& force) const override {
    for (Index e = 0; e < kernel.size(); ++e) {
      const Index* stencil = kernel.stencil(e);
      kernel.gradient(e, c, [&](int a, const Vec3& f) { force[stencil[a]] += f; });
    }
  }

  void add_blocks(const energy::Configuration& c, const Dofs& dofs, const BlockMatrix& matrix, int pattern,
                  const BlockMatrix::Values& values) override {
    if (pattern != located_) find_slots(dofs, matrix, pattern);
    for (Index e = 0; e < kernel.size(); ++e) {
      if (special_[e]) {
        const Index* stencil = kernel.stencil(e);
        kernel.hessian(
            e, c, [&](int a, int b, const Mat3& k) { add_block(dofs, matrix, stencil[a], stencil[b], k, values); });
      } else {
        const Slot* slot = slots_.data() + first_slot_[e];
        fetch(e + 1, values);
        kernel.hessian(e, c, [&](int, int, const Mat3& k) { values.add(*slot++, k); });
      }
    }
  }

 private:
  /// Fetches the places of the blocks of an element whose turn comes next: adding to them would mostly be waiting for memory.
  void fetch(Index e, const BlockMatrix::Values& values) const {
    if (e >= kernel.size()) return;
    const std::size_t end = e + 1 < kernel.size() ? first_slot_[e + 1] : slots_.size();
    for (std::size_t at = first_slot_[e]; at < end; ++at) values.fetch(slots_[at]);
  }
  /// Finds the places of all blocks.
  void find_slots(const Dofs& dofs, const BlockMatrix& matrix, int pattern) {
    const LocalPoints& local = dofs.local();
    slots_.clear();
    first_slot_.clear();
    special_.clear();
    for (Index e = 0; e < kernel.size(); ++e) {
      const Index* stencil = kernel.stencil(e);
      const bool special =
          std::any_of(stencil, stencil + kernel.stencil_size(e), [&](Index p) { return !dofs.is_plain(p); });
      special_.push_back(special);
      first_slot_.push_back(slots_.size());
      if (special) continue;
      kernel.blocks(e, [&](int a, int b) {
        const Index row = stencil[a];
        slots_.push_back(row < local.owned ? matrix.slot(row, local.row_of[stencil[b]]) : Slot{});
      });
    }
    slots_.shrink_to_fit();  // what follows has as many, or nearly
    located_ = pattern;
  }

  std::vector<Slot> slots_;              ///< in the order of Kernel::blocks, for plain elements
  std::vector<std::size_t> first_slot_;  ///< per element; special elements have no slots
  std::vector<char> special_;            ///< the stencil has a mirror point or a vertex with axes of its own
  int located_ = -1;                     ///< number of the pattern that the slots belong to
};

}  // namespace voile::system
