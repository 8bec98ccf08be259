// A simulation of a case: built on a communicator that the caller gives, advanced step by step.
//
// Units are SI. Arrays have three components per vertex, x y z in global axes, one vertex after the other, in the order in
// which the mesh was read; that order does not depend on the ranks. Every rank of the communicator receives the whole array.
// All functions are collective over the communicator unless their comment says otherwise, and throw on every rank
// (errors.hpp). Nothing is written without an output folder, and only warnings are printed unless the options say more.
#pragma once

#include <mpi.h>
#include <petscmat.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "voile/api.hpp"
#include "voile/case.hpp"

namespace voile {

/// One step, or the attempt at one.
struct Step {
  bool accepted =
      false;          ///< false: the simulation has come to its end, Simulation::reason(), or to a stage without steps
  int number = 0;     ///< of accepted steps, in the stage
  double time = 0.0;  ///< reached [s]
  double load_factor = 0.0;  ///< reached
  double size = 0.0;         ///< of time [s], or of the load factor
  int iterations = 0;        ///< of Newton's method, failed attempts included
  int rejections = 0;        ///< attempts that failed before
  bool new_mesh = false;     ///< remeshed or sewn after it: arrays have another length from here on
};

/// Values of one field at the present state.
struct Field {
  std::string name, unit;
  bool on_vertices = true;     ///< otherwise on triangles
  int components = 1;          ///< per vertex or triangle
  std::vector<double> values;  ///< row by row
};

/// What history.csv of a run has: a row for the start of the stage and for each accepted step.
struct History {
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;
};

/// Energies of the present state [J].
struct Energy {
  double membrane = 0.0, bending = 0.0, contact = 0.0, springs = 0.0;
  double external = 0.0;  ///< potential of dead loads, those of set_forces() included, and energy of gases
  double kinetic = 0.0;   ///< of a motion
  // Since a motion began, where [output] energy_balance keeps it: energy at the start, works of loads (those of set_forces()
  // included) and of what moves supports and obstacles, what was taken, and what remains unexplained.
  double initial = 0.0, loads = 0.0, supports = 0.0, obstacles = 0.0;
  double damping = 0.0, drag = 0.0, friction = 0.0, fabric = 0.0, numerical = 0.0, unaccounted = 0.0;
};

struct Options {
  std::filesystem::path output{};  ///< folder of results as `voile run` writes them; empty: nothing is written
  bool overwrite = false;          ///< an earlier run in that folder may be replaced
  bool verbose = false;            ///< prints what `voile run` prints
  std::string petsc{};             ///< options of PETSc for this simulation alone, as on its command line
  bool signals = false;  ///< SIGINT and SIGTERM end it after the step that they meet: Simulation::interrupted()
};

/// A saved state: a value that outlives the simulation it is of.
class VOILE_API State {
 public:
  [[nodiscard]] double time() const { return time_; }
  struct Data;

 private:
  friend class Simulation;
  double time_ = 0.0;
  std::shared_ptr<const Data> data_;
};

class VOILE_API Simulation {
 public:
  /// Reads the mesh, builds the model and prepares the start. `comm` must outlive it; a Session, or who has begun MPI and
  /// PETSc, too. Throws UserError for a case that cannot be run.
  Simulation(MPI_Comm comm, const Case& c, Options options = {});
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  // ---- steps
  /// One accepted step. Throws UserError after finished().
  Step advance();
  /// Steps until time t exactly; the last one is cut to fit. Of a motion only; the end of the case may come first. Returns
  /// whether t is reached. Throws UserError for a time before the present. [s]
  bool advance_to(double t);
  /// Steps to the end, and ends: with an output folder the files are complete. Returns converged().
  bool run();
  /// Whether the end of the case is reached, or nothing more can be done. Not collective.
  [[nodiscard]] bool finished() const;
  /// Whether the end was reached as the case asks for, where `voile run` ends with code 0: not at an unstable equilibrium. Of
  /// modal and buckling analyses, after run(). Not collective.
  [[nodiscard]] bool converged() const;
  /// Why not; empty so far. Not collective.
  [[nodiscard]] std::string reason() const;
  /// Whether a signal has ended the last call that took steps (Options::signals). Not collective.
  [[nodiscard]] bool interrupted() const;
  /// `look` is called on every rank after each accepted step, in the order of the calls. Not collective.
  void observe(std::function<void(const Step&)> look);

  // ---- the present state; not collective
  [[nodiscard]] double time() const;  ///< [s]
  [[nodiscard]] double load_factor() const;
  [[nodiscard]] int step() const;  ///< accepted steps of the stage
  [[nodiscard]] int vertex_count() const;
  [[nodiscard]] int triangle_count() const;
  /// Three vertices per triangle.
  [[nodiscard]] std::vector<int> triangles() const;
  /// Vertices of a group of the mesh. Throws UserError for unknown names.
  [[nodiscard]] std::vector<int> group(const std::string& name) const;

  // ---- arrays
  [[nodiscard]] std::vector<double> positions() const;      ///< [m]
  [[nodiscard]] std::vector<double> displacements() const;  ///< from the mesh as it was read [m]
  [[nodiscard]] std::vector<double> velocities() const;     ///< of a motion; zeros otherwise [m/s]
  /// A field as the results have it, e.g. "bending_moment" (docs/reference/results.md). Throws UserError for unknown names.
  [[nodiscard]] Field field(const std::string& name) const;
  [[nodiscard]] History history() const;
  [[nodiscard]] Energy energy() const;
  /// Frequencies [Hz] or critical load factors, lowest first. Of modal and buckling analyses, after run(); throws UserError
  /// otherwise. Not collective.
  [[nodiscard]] std::vector<double> eigenvalues() const;

  // ---- coupling
  [[nodiscard]] State save() const;
  /// Goes back to a saved state of this simulation, on one rank bit by bit. Throws UserError for a state of another stage, and
  /// with an output folder.
  void restore(const State& state);
  /// Forces on the vertices besides the loads of the case, constant until they are set again, whatever the load factor; rank
  /// 0's count. They are part of energies and of the balance. A new mesh takes them away (Step::new_mesh). Throws UserError for
  /// another length, and for a path with [remesh]. [N]
  void set_forces(const std::vector<double>& forces);
  /// An obstacle goes on straight lines from where it is to `positions` of its points at time t, and stays there: instead of
  /// what the case says of it. Of a motion only. Points: vertices of a mesh, centre of a ball, ends of a capsule's axis, a point
  /// of a plane; without triangles they must move alike. Throws UserError. [m], [s]
  void set_obstacle(const std::string& name, const std::vector<double>& positions, double t);
  /// Where the points of an obstacle are now. Throws UserError for unknown names. Not collective. [m]
  [[nodiscard]] std::vector<double> obstacle(const std::string& name) const;

  // ---- PETSc's objects: the caller destroys what he receives, before the simulation goes or after
  /// The unknowns of the present state: a copy. Three per vertex in the vertex's own axes, numbered by ranks. [m]
  [[nodiscard]] Vec unknowns() const;
  /// Internal minus applied forces at x, without inertia, at the time, load factor and forces in force [N]; in components that
  /// supports hold how far x is from what they prescribe [m]. Of the nonlinear equations, also where the analysis is linear.
  [[nodiscard]] Vec residual(Vec x) const;
  /// The derivative of the residual at x; rows and columns of what supports hold are those of the unit matrix. [N/m]
  [[nodiscard]] Mat tangent(Vec x) const;
  /// Vectors of unknowns as arrays over the vertices in global axes, and back.
  [[nodiscard]] std::vector<double> to_array(Vec x) const;
  [[nodiscard]] Vec to_unknowns(const std::vector<double>& values) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace voile
