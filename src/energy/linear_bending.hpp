// The constant part of a triangle's bending energy (bending.hpp), for triangles whose points do not move as unknowns do.
//
//   E = 1/2 sum_ij K_ij u_i.u_j + sum_i f_i.u_i + e_r
#pragma once

#include <utility>
#include <vector>

#include "bending.hpp"
#include "term.hpp"

namespace voile::energy {

class LinearBendingTerm {
 public:
  /// `local`: the element's points in local numbering, in its order.
  void add(const BendingElement& element, std::vector<Index> local, bool owned) {
    items_.push_back({std::move(local), element.stiffness, element.start_force, element.start_energy, owned});
  }

  [[nodiscard]] Index size() const { return static_cast<Index>(items_.size()); }
  [[nodiscard]] const Index* stencil(Index e) const { return items_[e].local.data(); }
  [[nodiscard]] int stencil_size(Index e) const { return static_cast<int>(items_[e].local.size()); }
  [[nodiscard]] bool owned(Index e) const { return items_[e].owned; }

  [[nodiscard]] double energy(Index e, const Configuration& c) const {
    double sum = items_[e].start_energy;
    for (int i = 0; i < stencil_size(e); ++i) {
      const Vec3 start = start_force(e, i);
      sum += c.u[items_[e].local[static_cast<std::size_t>(i)]].dot(0.5 * (force(e, i, c) + start));
    }
    return sum;
  }
  template <class Emit>
  void gradient(Index e, const Configuration& c, Emit&& emit) const {
    for (int i = 0; i < stencil_size(e); ++i) emit(i, force(e, i, c));
  }
  template <class Emit>
  void hessian(Index e, const Configuration&, Emit&& emit) const {
    for (int i = 0; i < stencil_size(e); ++i)
      for (int j = 0; j < stencil_size(e); ++j) emit(i, j, Mat3(items_[e].stiffness(i, j) * Mat3::Identity()));
  }
  template <class Emit>
  void blocks(Index e, Emit&& emit) const {
    for (int i = 0; i < stencil_size(e); ++i)
      for (int j = 0; j < stencil_size(e); ++j) emit(i, j);
  }

 private:
  struct Item {
    std::vector<Index> local;
    Eigen::MatrixXd stiffness;
    Eigen::MatrixX3d start_force;
    double start_energy;
    bool owned;
  };
  [[nodiscard]] Vec3 start_force(Index e, int i) const {
    return items_[e].start_force.rows() > 0 ? Vec3(items_[e].start_force.row(i)) : Vec3(Vec3::Zero());
  }
  [[nodiscard]] Vec3 force(Index e, int i, const Configuration& c) const {
    Vec3 f = start_force(e, i);
    for (int j = 0; j < stencil_size(e); ++j)
      f += items_[e].stiffness(i, j) * c.u[items_[e].local[static_cast<std::size_t>(j)]];
    return f;
  }

  std::vector<Item> items_;
};

}  // namespace voile::energy
