#include "gas.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/mpi.hpp"
#include "energy/volume.hpp"
#include "gas_surface.hpp"
#include "term.hpp"

namespace voile::system {

namespace {

/// Whether nothing moves a vertex, a support neither.
bool stays(const Discretisation& on, Index v) {
  if (!on.dofs().is_held(v)) return false;
  const VertexSupport& support = on.constraints().vertices.at(v);
  return !support.moves() && support.value.squaredNorm() == 0.0;
}

}  // namespace

Gas::Gas(const Discretisation& on, const Load& load)
    : on_(&on),
      ambient_(load.ambient),
      excess_(load.magnitude),
      exponent_(load.exponent),
      added_(load.added_volume),
      leak_area_(load.leak_area),
      density_(load.density),
      term_(std::make_unique<ElementTerm<energy::VolumeTerm>>()) {
  const GasSurface surface = gas_surface(on.mesh(), load);
  origin_ = surface.origin;
  term_->kernel.set_origin(origin_);
  const LocalPoints& local = on.dofs().local();
  // As for the other elements: whatever adds to rows of this rank, those of rigid bodies among them.
  const auto evaluated = [&](const std::vector<Index>& vertices) {
    return std::any_of(vertices.begin(), vertices.end(), [&](Index v) { return on.owned(v) != no_index; }) ||
           on.has_rows_of(vertices);
  };
  std::vector<const GasSurface::Face*> face_of(static_cast<std::size_t>(on.mesh().triangle_count()));
  for (const GasSurface::Face& f : surface.faces) face_of[f.triangle] = &f;
  for (std::size_t k = 0; k < on.elements().size(); ++k) {
    const auto& [triangle, corners, owned] = on.elements()[k];
    const GasSurface::Face* f = face_of[triangle];
    if (!f) continue;
    term_->kernel.add({local.local_of[f->vertices[0]], local.local_of[f->vertices[1]], local.local_of[f->vertices[2]]},
                      owned, on.bulge(k, f->vertices));
  }
  for (const GasSurface::Rim& r : surface.rims) {
    Rim rim;
    rim.count = static_cast<double>(r.vertices.size());
    for (const Index v : r.vertices) {
      rim.held = rim.held && stays(on, v);
      if (const Index i = on.owned(v); i != no_index) rim.owned.push_back(i);
      if (evaluated({v})) rim.points.push_back(local.local_of[v]);
    }
    for (const GasSurface::Side& s : r.sides) {
      const mesh::Triangle& t = on.mesh().triangles()[s.triangle];
      if (evaluated({t[0], t[1], t[2]}))
        term_->kernel.add_side({local.local_of[s.vertices[0]], local.local_of[s.vertices[1]]},
                               static_cast<int>(rims_.size()), on.owns(s.triangle));
    }
    rims_.push_back(std::move(rim));
  }
  energy::Configuration start;
  start.x = local.start.data();
  start_ = volume(start);
}

Gas::~Gas() = default;
Gas::Gas(Gas&&) noexcept = default;
Gas& Gas::operator=(Gas&&) noexcept = default;

void Gas::find_centres(const energy::Configuration& c) const {
  if (rims_.empty()) return;
  std::vector<double> sums(6 * rims_.size(), 0.0);
  const auto add = [&](std::size_t at, const Vec3& v) {
    for (int k = 0; k < 3; ++k) sums[at + static_cast<std::size_t>(k)] += v[k];
  };
  for (std::size_t r = 0; r < rims_.size(); ++r)
    for (const Index i : rims_[r].owned) add(6 * r, (c.x[i] - origin_) / rims_[r].count);
  const energy::VolumeTerm& kernel = term_->kernel;
  for (Index e = 0; e < kernel.size(); ++e) {
    if (kernel.cap(e) < 0 || !kernel.owned(e)) continue;
    const Vec3 a = c.x[kernel.stencil(e)[0]] - origin_, b = c.x[kernel.stencil(e)[1]] - origin_;
    add(6 * static_cast<std::size_t>(kernel.cap(e)) + 3, a.cross(b));
  }
  mpi::sum(on_->comm(), sums);
  std::vector<Vec3> centres;
  for (std::size_t r = 0; r < rims_.size(); ++r) {
    rims_[r].centre = Eigen::Map<const Vec3>(sums.data() + 6 * r);
    rims_[r].area = Eigen::Map<const Vec3>(sums.data() + 6 * r + 3);
    centres.push_back(rims_[r].centre);
  }
  term_->kernel.set_centres(std::move(centres));
}

double Gas::volume(const energy::Configuration& c) const {
  find_centres(c);
  term_->kernel.set_scale(1.0);
  return added_ + mpi::sum(on_->comm(), term_->energy(c));
}

double Gas::compression(double volume) const {
  // No gas has less than no room; the power of a negative ratio may be a number, as for exponent 1.
  if (volume <= 0.0 && exponent_ > 0.0) return std::numeric_limits<double>::quiet_NaN();
  return std::pow(start_ / volume, exponent_);
}

double Gas::reference() const {
  return leaks() ? filled() * std::pow(now_, exponent_) : filled();
}

void Gas::restore(const GasContent& content) {
  content_ = content;
  now_ = content.fraction;
}

void Gas::begin_leak(const energy::Configuration& c, double time) {
  if (!leaks()) return;
  leaking_ = true;
  accepted_time_ = time;
  accepted_volume_ = volume(c);
  now_ = content_.fraction;
}

void Gas::set_time(double time) {
  if (leaking_) now_ = content_after(leaky(), content_.fraction, accepted_volume_, time - accepted_time_);
}

void Gas::end_step(const energy::Configuration& c, double time) {
  if (!leaking_) return;
  const double end = volume(c), middle = 0.5 * (accepted_volume_ + end), before = content_.fraction;
  now_ = content_.fraction = content_after(leaky(), before, middle, time - accepted_time_);
  content_.loss += available_work(leaky(), before, middle) - available_work(leaky(), now_, middle);
  accepted_time_ = time;
  accepted_volume_ = end;
}

GasState Gas::at(const energy::Configuration& c) const {
  GasState s;
  s.volume = volume(c);
  const double change = (s.volume - start_) / start_, excess = leaks() ? reference() - ambient_ : factor_ * excess_;
  s.pressure = reference() * compression(s.volume) - ambient_;
  const double log = std::log1p(change);  // exact where the volume hardly changes
  const double integral = exponent_ == 1.0 ? log : std::expm1((1.0 - exponent_) * log) / (1.0 - exponent_);
  s.energy = start_ * (ambient_ * (change - integral) - excess * integral);
  return s;
}

void Gas::add_gradient(double scale, const energy::Configuration& c, std::vector<Vec3>& points) const {
  term_->kernel.set_scale(scale);
  term_->add_forces(c, points);
  for (const Rim& rim : rims_)
    for (const Index i : rim.points) points[static_cast<std::size_t>(i)] += scale / (6.0 * rim.count) * rim.area;
}

void Gas::add_gradient(double scale, const energy::Configuration& c, std::vector<Vec3>& scratch, Vec f) const {
  std::fill(scratch.begin(), scratch.end(), Vec3::Zero());
  add_gradient(scale, c, scratch);
  on_->dofs().add_forces(scratch, f);
}

void Gas::add_forces(const energy::Configuration& c, std::vector<Vec3>& points) const {
  add_gradient(-at(c).pressure, c, points);
}

void Gas::add_force(const energy::Configuration& c, std::vector<Vec3>& scratch, Vec f) const {
  const double pressure = reference() * compression(volume(c)) - ambient_;
  add_gradient(pressure, c, scratch, f);
}

void Gas::add_direction(const energy::Configuration& c, std::vector<Vec3>& scratch, Vec f) const {
  const double rate = excess_ * compression(volume(c)) * (leaks() ? std::pow(now_, exponent_) : 1.0);
  add_gradient(rate, c, scratch, f);
}

void Gas::add_blocks(const energy::Configuration& c, const BlockMatrix& tangent, int pattern,
                     const BlockMatrix::Values& values, std::vector<Vec3>& scratch, LowRankChange& change) const {
  const double v = volume(c), absolute = reference() * compression(v);
  const double pressure = absolute - ambient_;
  if (exponent_ != 0.0) {  // else a column of no weight, which inertia would count
    petsc::VecHandle g = on_->dofs().create_vector();
    add_gradient(1.0, c, scratch, g);
    change.add(std::move(g), exponent_ * absolute / v);
  }
  term_->kernel.set_scale(-pressure);
  term_->add_blocks(c, on_->dofs(), tangent, pattern, values);
  if (pressure == 0.0) return;
  for (std::size_t r = 0; r < rims_.size(); ++r)
    if (!rims_[r].held) add_rim_columns(rims_[r], static_cast<int>(r), c, -pressure / 6.0, scratch, change);
}

void Gas::add_rim_columns(const Rim& rim, int number, const energy::Configuration& c, double weight,
                          std::vector<Vec3>& scratch, LowRankChange& change) const {
  const energy::VolumeTerm& kernel = term_->kernel;
  for (int k = 0; k < 3; ++k) {
    const Vec3 axis = Vec3::Unit(k);
    petsc::VecHandle centre = on_->dofs().create_vector(), area = on_->dofs().create_vector();
    std::fill(scratch.begin(), scratch.end(), Vec3::Zero());
    for (const Index i : rim.points) scratch[static_cast<std::size_t>(i)] += axis / rim.count;
    on_->dofs().add_forces(scratch, centre);
    std::fill(scratch.begin(), scratch.end(), Vec3::Zero());
    for (Index e = 0; e < kernel.size(); ++e) {
      if (kernel.cap(e) != number) continue;
      const Index a = kernel.stencil(e)[0], b = kernel.stencil(e)[1];
      scratch[static_cast<std::size_t>(a)] += (c.x[b] - origin_).cross(axis);
      scratch[static_cast<std::size_t>(b)] += axis.cross(Vec3(c.x[a] - origin_));
    }
    on_->dofs().add_forces(scratch, area);
    const Eigen::Index n = change.weights.rows();
    change.add(std::move(centre), 0.0);
    change.add(std::move(area), 0.0);
    change.weights(n, n + 1) = change.weights(n + 1, n) = weight;
  }
}

}  // namespace voile::system
