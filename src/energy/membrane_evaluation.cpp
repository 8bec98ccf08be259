// Evaluation of the membrane: batches by the kernels of the instruction set in use, single elements by the scalar ones.
#include <Eigen/Dense>
#include <algorithm>

#include "voile/energy/membrane.hpp"

namespace voile::energy {

namespace {

KernelState state_of(const Configuration& c) {
  const bool linearised = c.tangent == Tangent::linearised_stress && c.previous;
  return {c.x->data(), c.u->data(), linearised ? c.previous->data() : nullptr, c.tangent == Tangent::positive};
}

}  // namespace

MembraneBatch MembraneTerm::view(const Batches::Batch& b) const {
  const auto number = static_cast<std::size_t>(&b - batches_.all().data());
  const bool viscous = !viscosity_.empty();
  const int* points = batches_.points(b);
  return {batches_.fields(b),
          points,
          points,
          batches_.slots(b),
          viscous ? start_[9 * number].of.data() : nullptr,
          viscous ? ratio_[number].of.data() : nullptr,
          b.size,
          0,
          b.lanes,
          b.flag};
}

MembraneBatch MembraneTerm::view(Index e) const {
  MembraneBatch b = view(batches_.batch_of(e));
  b.scatter = own_positions();
  b.slots = own_pairs();
  b.first = batches_.place(e).lane;
  b.last = b.first + 1;
  return b;
}

void MembraneTerm::start_step(const Configuration& c, double ratio, double inverse_step) {
  std::vector<double> viscosity;
  for (const double time : viscous_time_) viscosity.push_back(ratio + time * inverse_step);
  set_viscosity({});
  if (std::all_of(viscosity.begin(), viscosity.end(), [](double v) { return v == 0.0; })) return;
  start_.resize(9 * batches_.all().size());
  const KernelState state = state_of(c);
  for_batches([&](const MembraneBatch& batch, std::size_t b) {
    kernels_->membrane.strain(shape_, batch, state, start_[9 * b].of.data());
  });
  set_viscosity(std::move(viscosity));
}

void MembraneTerm::set_viscosity(std::vector<double> ratios) {
  viscosity_ = std::move(ratios);
  if (viscosity_.empty()) return;
  ratio_.resize(batches_.all().size());
  for (Index e = 0; e < size(); ++e) {
    const Batches::Place p = batches_.place(e);
    Line& line = ratio_[p.batch];
    for (int lane = p.lane; lane < batch_lanes; ++lane) line.of[lane] = viscosity_[material_[e]];
  }
}

double MembraneTerm::total_energy(const Configuration& c) const {
  double sum = 0.0;
  const KernelState state = state_of(c);
  for_batches([&](const MembraneBatch& batch, std::size_t b) {
    Line energy;
    kernels_->membrane.energy(shape_, batch, state, energy.of.data());
    const Batches::Batch& of = batches_.all()[b];
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(of.lanes); ++lane)
      if (of.owned[lane]) sum += energy.of[lane];
  });
  return sum;
}

void MembraneTerm::add_gradients(const Configuration& c, Vec3* force) const {
  const KernelState state = state_of(c);
  for_batches([&](const MembraneBatch& batch, std::size_t) {
    kernels_->membrane.gradient(shape_, batch, state, force->data());
  });
}

void MembraneTerm::add_tangents(const Configuration& c, double* blocks) const {
  const KernelState state = state_of(c);
  for_batches(
      [&](const MembraneBatch& batch, std::size_t) { kernels_->membrane.tangent(shape_, batch, state, blocks); });
}

double MembraneTerm::energy(Index e, const Configuration& c) const {
  Line energy;
  scalar_kernels().membrane.energy(shape_, view(e), state_of(c), energy.of.data());
  return energy.of[batches_.place(e).lane];
}

std::vector<double> MembraneTerm::gradient_of(Index e, const Configuration& c) const {
  std::vector<double> force(3 * static_cast<std::size_t>(batches_.batch_of(e).size));
  scalar_kernels().membrane.gradient(shape_, view(e), state_of(c), force.data());
  return force;
}

std::vector<double> MembraneTerm::hessian_of(Index e, const Configuration& c) const {
  const auto n = static_cast<std::size_t>(batches_.batch_of(e).size);
  std::vector<double> blocks(9 * n * (n + 1) / 2);
  scalar_kernels().membrane.tangent(shape_, view(e), state_of(c), blocks.data());
  return blocks;
}

Vec3 MembraneTerm::strain(Index e, const Configuration& c) const {
  std::array<Line, 9> all;
  scalar_kernels().membrane.strain(shape_, view(e), state_of(c), all[0].of.data());
  Vec3 strain = Vec3::Zero();
  for (int g = 0; g < shape_.groups; ++g)
    for (int r = 0; r < 3; ++r) strain[r] += shape_.factor[g] * all[3 * g + r].of[batches_.place(e).lane];
  return strain;
}

Vec3 MembraneTerm::force(Index e, const Configuration& c) const {
  return stiffness_[material_[e]] * strain(e, c);
}

}  // namespace voile::energy
