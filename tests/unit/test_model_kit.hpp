// Models and vectors for tests.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>
#include <vector>

#include "system/model.hpp"
#include "test_meshes.hpp"
#include "test_relative.hpp"

namespace voile::testing {

inline energy::Material isotropic(double young, double poisson, double thickness, double density = 0.0) {
  energy::Material m;
  m.membrane = energy::isotropic_membrane(young, poisson, thickness);
  m.bending = energy::bending_from_membrane(m.membrane, thickness);
  m.areal_density = density;
  return m;
}

inline system::Support support(const std::string& group, system::Support::Kind kind) {
  system::Support s;
  s.group = group;
  s.kind = kind;
  return s;
}

/// A PETSc option that is set while it lives.
class Option {
 public:
  Option(const char* name, const char* value) : name_(name) { VOILE_PETSC(PetscOptionsSetValue(nullptr, name, value)); }
  ~Option() { (void)PetscOptionsClearValue(nullptr, name_); }
  Option(const Option&) = delete;
  Option& operator=(const Option&) = delete;

 private:
  const char* name_;
};

inline system::Load load(system::Load::Kind kind, const std::string& group, double magnitude) {
  system::Load l;
  l.kind = kind;
  l.group = group;
  l.magnitude = magnitude;
  return l;
}

inline system::Load load(system::Load::Kind kind, const std::string& group, const Vec3& vector) {
  system::Load l;
  l.kind = kind;
  l.group = group;
  l.vector = vector;
  return l;
}

/// A vector of unknowns per vertex, in global axes, on every rank. Collective.
inline std::vector<Vec3> per_vertex(const system::Model& model, Vec f) {
  std::vector<double> values = model.dofs().gather(f);
  mpi::broadcast(model.dofs().comm(), values);
  std::vector<Vec3> result;
  for (std::size_t i = 0; i < values.size(); i += 3) result.push_back(Eigen::Map<const Vec3>(values.data() + i));
  return result;
}

/// Largest difference of two lists of vectors over the largest of the second.
inline double relative_difference(const std::vector<Vec3>& found, const std::vector<Vec3>& expected) {
  double difference = 0.0, size = 0.0;
  for (std::size_t v = 0; v < expected.size(); ++v) {
    difference = std::max(difference, (found.at(v) - expected[v]).norm());
    size = std::max(size, expected[v].norm());
  }
  return difference / size;
}

/// Sets the unknowns from displacements in global axes given per vertex.
inline void set_displacement(const system::Model& model, Vec a, const std::function<Vec3(Index)>& u) {
  std::vector<double> values(static_cast<std::size_t>(model.dofs().unknowns()));
  for (Index v = 0; v < model.dofs().mesh().vertex_count(); ++v)
    for (int k = 0; k < 3; ++k) values[3 * static_cast<std::size_t>(v) + k] = u(v)[k];
  model.dofs().scatter(values, a);
}

/// Reproducible noise per vertex, independent of the number of ranks.
inline std::function<Vec3(Index)> noise(double size, unsigned seed) {
  return [=](Index v) {
    std::mt19937 random(seed + 7919u * static_cast<unsigned>(v));
    std::uniform_real_distribution<double> d(-size, size);
    const double x = d(random), y = d(random), z = d(random);
    return Vec3(x, y, z);
  };
}

inline double norm(Vec v) {
  double n = 0.0;
  VOILE_PETSC(VecNorm(v, NORM_2, &n));
  return n;
}

inline double dot(Vec a, Vec b) {
  double d = 0.0;
  VOILE_PETSC(VecDot(a, b, &d));
  return d;
}

/// Solves K x = f with MUMPS for the model's current tangent; PCLU if that is not symmetric.
/// By central differences along d: the residual is the derivative of the energy, the exact tangent that of the residual.
inline void check_potential(system::Model& model, Vec a, Vec d, double h = 1e-5) {
  const auto vector = [&] { return model.dofs().create_vector(); };
  petsc::VecHandle moved = vector(), up = vector(), down = vector(), kd = vector(), r = vector();
  model.assemble_tangent(a, {.kind = energy::Tangent::exact});
  model.tangent().multiply(d, kd);
  model.residual(a, r);
  VOILE_PETSC(VecWAXPY(moved, h, d, a));
  const double above = model.energy(moved);
  model.residual(moved, up);
  VOILE_PETSC(VecWAXPY(moved, -h, d, a));
  const double below = model.energy(moved);
  model.residual(moved, down);
  CHECK((above - below) / (2.0 * h) == relative(dot(r, d)).epsilon(1e-6));
  VOILE_PETSC(VecAXPY(up, -1.0, down));
  VOILE_PETSC(VecScale(up, 0.5 / h));
  VOILE_PETSC(VecAXPY(up, -1.0, kd));
  CHECK(norm(kd) > 0.0);
  CHECK(norm(up) < 1e-6 * norm(kd));
}

inline void solve_linear(const system::Model& model, Vec f, Vec x, PCType type = PCCHOLESKY) {
  KSP ksp = nullptr;
  PC pc = nullptr;
  VOILE_PETSC(KSPCreate(model.dofs().comm(), &ksp));
  VOILE_PETSC(KSPSetOperators(ksp, model.tangent().matrix(), model.tangent().matrix()));
  VOILE_PETSC(KSPSetType(ksp, KSPPREONLY));
  VOILE_PETSC(KSPGetPC(ksp, &pc));
  VOILE_PETSC(PCSetType(pc, type));
  VOILE_PETSC(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  VOILE_PETSC(PCFactorSetUpMatSolverType(pc));
  Mat factor = nullptr;
  VOILE_PETSC(PCFactorGetMatrix(pc, &factor));
  VOILE_PETSC(MatMumpsSetIcntl(factor, 14, 200));
  VOILE_PETSC(KSPSolve(ksp, f, x));
  VOILE_PETSC(KSPDestroy(&ksp));
}

/// The tangent assembled last, of a model on one rank, as it stands in full.
inline Eigen::MatrixXd dense_tangent(const system::Model& model) {
  const PetscInt n = model.dofs().unknowns();
  std::vector<PetscInt> all(static_cast<std::size_t>(n));
  std::iota(all.begin(), all.end(), 0);
  Eigen::MatrixXd k(n, n);
  VOILE_PETSC(MatGetValues(model.tangent().matrix(), n, all.data(), n, all.data(), k.data()));
  return k;
}

/// Of answer(communicator), alike on every rank: one rank finds what all of them find.
template <class Answer>
void check_ranks_agree(const Answer& answer) {
  const std::vector<double> one = answer(PETSC_COMM_SELF), all = answer(PETSC_COMM_WORLD);
  REQUIRE(one.size() == all.size());
  double most = 0.0, wrong = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    most = std::max(most, std::abs(one[i]));
    wrong = std::max(wrong, std::abs(one[i] - all[i]));
  }
  CHECK(wrong < 1e-12 * most);
}

}  // namespace voile::testing
