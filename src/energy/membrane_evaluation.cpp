// Evaluation of the membrane: batches by the kernels of the instruction set in use, single elements by the scalar ones.
#include <Eigen/Dense>
#include <algorithm>

#include "membrane.hpp"

namespace voile::energy {

namespace {

KernelState state_of(const Configuration& c) {
  if (c.tangent == Tangent::stress_alone)
    return {coordinates(c.previous), coordinates(c.previous_u), nullptr, false, coordinates(c.x), coordinates(c.u)};
  const bool linearised = c.tangent == Tangent::linearised_stress && c.previous;
  return {coordinates(c.x), coordinates(c.u), linearised ? coordinates(c.previous) : nullptr,
          c.tangent == Tangent::positive};
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
          yarns_.batch(number),
          yarns_.knots(),
          rubber_.batch(number),
          rubber_.terms(),
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
  if (ratios.empty() && viscosity_.empty()) return;
  ++version_;
  viscosity_ = std::move(ratios);
  if (viscosity_.empty()) return;
  ratio_.resize(batches_.all().size());
  for (Index e = 0; e < size(); ++e) {
    const Batches::Place p = batches_.place(e);
    Line& line = ratio_[p.batch];
    for (int lane = p.lane; lane < batch_lanes; ++lane) line.of[lane] = viscosity_[material_[e]];
  }
}

double MembraneTerm::add_gradients(const Configuration& c, Vec3* force) const {
  double sum = 0.0;
  const KernelState state = state_of(c);
  for_batches([&](const MembraneBatch& batch, std::size_t b) {
    Line energy;
    kernels_->membrane.gradient(shape_, batch, state, force->data(), energy.of.data());
    sum += batches_.all()[b].owned_sum(energy);
  });
  return sum;
}

void MembraneTerm::add_tangents(const Configuration& c, double* blocks) const {
  const KernelState state = state_of(c);
  for_batches(
      [&](const MembraneBatch& batch, std::size_t) { kernels_->membrane.tangent(shape_, batch, state, blocks); });
}

std::vector<Vec3> MembraneTerm::rubbing_strains(const Configuration& c) const {
  std::vector<std::array<Line, 9>> groups(batches_.all().size());
  const KernelState state = state_of(c);
  for_batches([&](const MembraneBatch& batch, std::size_t b) {
    kernels_->membrane.strain(shape_, batch, state, groups[b][0].of.data());
  });
  std::vector<Vec3> strains(static_cast<std::size_t>(size()));
  for (Index e = 0; e < size(); ++e) {
    const Batches::Place p = batches_.place(e);
    for (int r = 0; r < 3; ++r) strains[e][r] = groups[p.batch][3 * shape_.rubbing + r].of[p.lane];
  }
  return strains;
}

double MembraneTerm::lost(const Configuration& c) const {
  if (!rubs()) return 0.0;
  const std::vector<Vec3> strains = rubbing_strains(c);
  double sum = 0.0;
  for (Index e = 0; e < size(); ++e)
    if (owned(e)) sum += yarns_.lost_at(batches_.place(e), strains[e]);
  return sum;
}

void MembraneTerm::end_step(const Configuration& c) {
  if (!rubs()) return;
  const std::vector<Vec3> strains = rubbing_strains(c);
  for (Index e = 0; e < size(); ++e) set_slip(e, yarns_.slip_at(batches_.place(e), strains[e]));
}

void MembraneTerm::set_slip(Index e, double slip) {
  yarns_.set_slip(batches_.place(e), slip);
  ++version_;
}

double MembraneTerm::energy(Index e, const Configuration& c) const {
  double energy = 0.0;
  (void)gradient_of(e, c, energy);
  return energy;
}

std::vector<double> MembraneTerm::gradient_of(Index e, const Configuration& c, double& energy) const {
  std::vector<double> force(3 * static_cast<std::size_t>(batches_.batch_of(e).size));
  Line energies;
  scalar_kernels().membrane.gradient(shape_, view(e), state_of(c), force.data(), energies.of.data());
  energy = energies.of[batches_.place(e).lane];
  return force;
}

std::vector<double> MembraneTerm::hessian_of(Index e, const Configuration& c) const {
  const auto n = static_cast<std::size_t>(batches_.batch_of(e).size);
  std::vector<double> blocks(9 * n * (n + 1) / 2);
  scalar_kernels().membrane.tangent(shape_, view(e), state_of(c), blocks.data());
  return blocks;
}

Vec3 MembraneTerm::strain_in(const std::array<Line, 9>& groups, int lane) const {
  Vec3 strain = Vec3::Zero();
  for (int g = 0; g < shape_.groups; ++g)
    for (int r = 0; r < 3; ++r) strain[r] += shape_.factor[g] * groups[3 * g + r].of[lane];
  return strain;
}

Vec3 MembraneTerm::strain(Index e, const Configuration& c) const {
  std::array<Line, 9> groups;
  scalar_kernels().membrane.strain(shape_, view(e), state_of(c), groups[0].of.data());
  return strain_in(groups, batches_.place(e).lane);
}

std::vector<Vec3> MembraneTerm::strains(const Configuration& c) const {
  std::vector<std::array<Line, 9>> groups(batches_.all().size());
  const KernelState state = state_of(c);
  for_batches([&](const MembraneBatch& batch, std::size_t b) {
    kernels_->membrane.strain(shape_, batch, state, groups[b][0].of.data());
  });
  std::vector<Vec3> strains;
  for (Index e = 0; e < size(); ++e)
    strains.push_back(strain_in(groups[batches_.place(e).batch], batches_.place(e).lane));
  return strains;
}

}  // namespace voile::energy
