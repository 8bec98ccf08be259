#include "rigid_inertia.hpp"

#include "base/cross_matrix.hpp"
#include "base/mpi.hpp"
#include "energy/sheet.hpp"

namespace voile::system {

namespace {

/// Lumped mass of each vertex of the mesh, on every rank; 0 on rigid bodies.
std::vector<double> vertex_masses(const Model& model) {
  const Dofs& dofs = model.dofs();
  std::vector<double> masses(static_cast<std::size_t>(dofs.mesh().vertex_count()), 0.0);
  {
    const petsc::ReadArray lumped(model.potential().constant().mass());
    for (Index i = 0; i < dofs.local().owned; ++i) {
      const Index v = dofs.local().point_of[i];
      if (dofs.body_of(v) == no_index) masses[static_cast<std::size_t>(v)] = lumped[3 * i];
    }
  }
  mpi::sum(dofs.comm(), masses);
  return masses;
}

std::vector<Vec3> positions_in(const Model& model, Vec a) {
  std::vector<double> u = model.dofs().gather(a);
  mpi::broadcast(model.dofs().comm(), u);
  std::vector<Vec3> x(u.size() / 3);
  for (std::size_t v = 0; v < x.size(); ++v)
    x[v] = model.dofs().mesh().positions()[static_cast<Index>(v)] + Vec3(u[3 * v], u[3 * v + 1], u[3 * v + 2]);
  return x;
}

/// Where the reference point of a body is, and how it is turned.
struct BodyPlace {
  Vec3 point;
  Mat3 rotation;
};

BodyPlace place_of(const Model& model, std::size_t b) {
  const RigidMotion& motion = model.dofs().motions()[b];
  return {model.discretisation().constraints().bodies[b].point + motion.displacement(),
          Mat3(Mat3::Identity() + motion.turned())};
}

/// Mass of all vertices and bodies, and its centre.
void add_up(const Model& model, const std::vector<double>& masses, const std::vector<Vec3>& x, RigidInertia& all) {
  for (std::size_t v = 0; v < x.size(); ++v) {
    all.mass += masses[v];
    all.centre += masses[v] * x[v];
  }
  const std::vector<BodyMass>& bodies = model.potential().constant().body_mass();
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const BodyPlace at = place_of(model, b);
    all.mass += bodies[b].mass;
    all.centre += bodies[b].mass * at.point + at.rotation * bodies[b].first;
  }
  all.centre /= all.mass;
}

/// What the consistent mass of triangles adds to the lumped one where the acceleration is not the same everywhere.
void make_consistent(const Model& model, const std::vector<Vec3>& acceleration, std::vector<Vec3>& force) {
  const mesh::SurfaceMesh& mesh = model.dofs().mesh();
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const double part = model.discretisation().sheet().material(t).areal_density * mesh.area(t) / 12.0;
    Vec3 sum = Vec3::Zero();
    for (const Index v : mesh.triangles()[t]) sum += acceleration[static_cast<std::size_t>(v)];
    for (const Index v : mesh.triangles()[t])
      force[static_cast<std::size_t>(v)] += part * (sum - 3.0 * acceleration[static_cast<std::size_t>(v)]);
  }
}

/// The forces on vertices, by their number in the mesh, in the unknowns.
petsc::VecHandle in_unknowns(const Model& model, const std::vector<Vec3>& force) {
  const Dofs& dofs = model.dofs();
  petsc::VecHandle f = dofs.create_vector();
  const petsc::WriteArray out(f);
  for (Index i = 0; i < dofs.local().owned; ++i) {
    const Index v = dofs.local().point_of[i];
    if (dofs.body_of(v) != no_index) continue;
    const Vec3 own = dofs.to_own(v, force[static_cast<std::size_t>(v)]);
    for (int k = 0; k < 3; ++k) out[3 * i + k] = own[k];
  }
  return f;
}

/// An acceleration t + W (x - c).
struct Acceleration {
  Vec3 direction = Vec3::Zero();
  Mat3 turn = Mat3::Zero();
  Vec3 centre = Vec3::Zero();
};

/// Adds what the mass of bodies takes, and the forces that their vertices have in `at_vertices`; returns sum m |a|^2 over them.
double add_bodies(const Model& model, const Acceleration& a, const std::vector<Vec3>& at_vertices, Vec f) {
  const std::vector<BodyMass>& bodies = model.potential().constant().body_mass();
  double sum = 0.0;
  if (bodies.empty()) return sum;
  const petsc::WriteArray out(f);
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const BodyPlace at = place_of(model, b);
    const BodyMass& m = bodies[b];
    // Of a point with the arm r: s + S r.
    const Vec3 s = a.direction + a.turn * (at.point - a.centre);
    const Mat3 turn = a.turn * at.rotation;
    BodyForce force{m.mass * s + turn * m.first, s * m.first.transpose() + turn * m.second};
    const RigidBody& body = model.discretisation().constraints().bodies[b];
    for (const Index v : body.members)
      force.add(at_vertices[static_cast<std::size_t>(v)], model.dofs().mesh().positions()[v] - body.point);
    model.dofs().add_body_force(b, force, out);
    sum += m.mass * s.squaredNorm() + 2.0 * s.dot(turn * m.first) + (turn * m.second * turn.transpose()).trace();
  }
  return sum;
}

}  // namespace

RigidInertia rigid_inertia(Model& model, Vec a, Mass kind) {
  (void)model.potential().configuration(a);  // rigid bodies are where the state has them
  RigidInertia all;
  const std::vector<double> masses = vertex_masses(model);
  const std::vector<Vec3> x = positions_in(model, a);
  add_up(model, masses, x, all);
  for (std::size_t k = 0; k < RigidInertia::motions; ++k) {
    const Vec3 axis = Vec3::Unit(static_cast<Eigen::Index>(k % 3));
    std::vector<Vec3> acceleration(x.size(), axis), force(x.size());
    for (std::size_t v = 0; v < x.size(); ++v) {
      if (k >= 3) acceleration[v] = axis.cross(x[v] - all.centre);
      force[v] = masses[v] * acceleration[v];
    }
    if (k >= 3 && kind == Mass::consistent) make_consistent(model, acceleration, force);
    for (std::size_t v = 0; v < x.size() && k >= 3; ++v)
      all.moments[static_cast<Eigen::Index>(k) - 3] += force[v].dot(acceleration[v]);
    all.force[k] = in_unknowns(model, force);
    const Acceleration of_all = k < 3 ? Acceleration{axis} : Acceleration{Vec3::Zero(), cross_matrix(axis), all.centre};
    const double of_bodies = add_bodies(model, of_all, force, all.force[k]);
    if (k >= 3) all.moments[static_cast<Eigen::Index>(k) - 3] += of_bodies;
    model.dofs().clear_fixed(all.force[k]);
  }
  return all;
}

}  // namespace voile::system
