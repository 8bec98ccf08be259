#include "recovery.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <tuple>

#include "base/mpi.hpp"
#include "energy/angle_bending.hpp"
#include "energy/bending.hpp"
#include "energy/curvature.hpp"
#include "energy/joint.hpp"
#include "energy/loads.hpp"
#include "energy/membrane.hpp"
#include "energy/sheet.hpp"
#include "natural_states.hpp"

namespace voile::system {

namespace {

/// A curvature of a triangle besides that of its operator.
void add_curvature(const energy::Sheet& sheet, Index triangle, const Vec3& kappa, TriangleFields& f) {
  const auto add = [&](std::vector<double>& to, const Vec3& value) {
    for (int k = 0; k < 3; ++k) to[3 * static_cast<std::size_t>(triangle) + k] += value[k];
  };
  add(f.curvature, kappa);
  add(f.whole_curvature, kappa);
  add(f.bending_moment, sheet.material(triangle).bending * kappa);
  add(f.membrane_force, -sheet.material(triangle).coupling * kappa);
}

/// What the turn of joints adds to the curvature of the triangles there.
void add_joints(const energy::Sheet& sheet, const energy::JointTerm& joints, const energy::Configuration& c,
                TriangleFields& f) {
  for (Index e = 0; e < joints.size(); ++e) {
    if (!joints.owned(e)) continue;
    const Eigen::VectorXd angles = joints.angles(e, c);
    for (const energy::JointElement::Bend& bend : joints.element(e).bends)
      add_curvature(sheet, bend.triangle, bend.of_angles * angles, f);
  }
}

}  // namespace

void Recovery::add(Index triangle, const energy::BendingElement& element, const std::vector<Index>& local,
                   Index membrane, Index angles) {
  items_.push_back({triangle, membrane, angles, points_.size(), static_cast<int>(local.size()), element.rest_curvature,
                    element.start_normal, element.start_bend});
  for (std::size_t i = 0; i < local.size(); ++i) {
    points_.push_back(local[i]);
    weights_.push_back(element.operator_.col(static_cast<Eigen::Index>(i)));
  }
}

void Recovery::end_adding() {
  items_.shrink_to_fit();
  points_.shrink_to_fit();
  weights_.shrink_to_fit();
}

TriangleFields Recovery::fields(MPI_Comm comm, const energy::Sheet& sheet, Index triangles, const Sources& from,
                                const energy::Configuration& c) const {
  const auto size = 3 * static_cast<std::size_t>(triangles);
  TriangleFields f;
  for (auto* v : {&f.membrane_strain, &f.membrane_force, &f.curvature, &f.whole_curvature, &f.bending_moment})
    v->assign(size, 0.0);
  f.in_plane.assign(size / 3, 0.0);
  const auto store = [](std::vector<double>& to, Index t, const Vec3& value) {
    for (int k = 0; k < 3; ++k) to[3 * static_cast<std::size_t>(t) + k] = value[k];
  };
  if (from.natural && from.natural->has_temperatures()) f.temperature.assign(2 * (size / 3), 0.0);
  const std::vector<Vec3> strains = from.membrane.strains(c);
  for (const Item& r : items_) {
    const Vec3& strain = strains[r.membrane];
    store(f.membrane_strain, r.triangle, strain);
    if (!f.temperature.empty())
      std::tie(f.temperature[2 * static_cast<std::size_t>(r.triangle)],
               f.temperature[2 * static_cast<std::size_t>(r.triangle) + 1]) = from.natural->temperature(r.triangle);
    const Mat3 &stiffness = sheet.material(r.triangle).bending, &coupling = sheet.material(r.triangle).coupling;
    if (r.angles != no_index) {  // nothing in the plane bends
      const Vec3 kappa = from.angles.curvature(r.angles, c);
      store(f.curvature, r.triangle, kappa);
      store(f.whole_curvature, r.triangle, kappa + from.angles.rest_curvature(r.angles));
      store(f.bending_moment, r.triangle, stiffness * kappa);
      store(f.membrane_force, r.triangle, from.membrane.force(r.membrane, strain));
      continue;
    }
    const Index* p = points_.data() + r.start;
    const Vec3 edge = c.x[p[1]] - c.x[p[0]], normal = edge.cross(Vec3(c.x[p[2]] - c.x[p[0]])).normalized();
    // n.k'(x) - kappa0 with k'(x) = kappa0 N_s + r + B'u.
    Vec3 kappa = (normal.dot(r.start_normal) - 1.0) * r.rest_curvature + r.start_bend * normal;
    Mat3 bend = r.rest_curvature * r.start_normal.transpose() + r.start_bend;
    for (int i = 0; i < r.count; ++i) {
      kappa += normal.dot(c.u[p[i]]) * weights_[r.start + i];
      bend += weights_[r.start + i] * c.u[p[i]].transpose();
    }
    const Mat3 in_plane = bend - (bend * normal) * normal.transpose();
    f.in_plane[static_cast<std::size_t>(r.triangle)] = 0.5 * in_plane.cwiseProduct(stiffness * in_plane).sum();
    if (energy::couples(sheet.material(r.triangle)))  // slopes of free sides follow the strain
      kappa += (Mat3::Identity() - energy::free_side_projector(sheet, r.triangle)) *
               Eigen::LLT<Mat3>(stiffness).solve(coupling * strain);
    store(f.whole_curvature, r.triangle, kappa + r.rest_curvature);
    if (from.natural) kappa -= from.natural->curvature_change(r.triangle);
    store(f.curvature, r.triangle, kappa);
    store(f.bending_moment, r.triangle, stiffness * kappa - coupling * strain);
    store(f.membrane_force, r.triangle, from.membrane.force(r.membrane, strain) - coupling * kappa);
  }
  if (from.joints) add_joints(sheet, *from.joints, c, f);
  for (const energy::EdgeBend& bend : from.edge_bends) add_curvature(sheet, bend.triangle, bend.curvature, f);
  for (auto* v : {&f.membrane_strain, &f.membrane_force, &f.curvature, &f.whole_curvature, &f.bending_moment,
                  &f.temperature, &f.in_plane}) {
    mpi::sum_to_root(comm, *v);
    if (mpi::rank(comm) != 0) v->clear();
  }
  return f;
}

}  // namespace voile::system
