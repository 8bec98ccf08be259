// voile._core: the library for Python. python/voile/simulation.py says what a user calls it with.
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#ifdef VOILE_PETSC4PY
#include <petsc4py/petsc4py.h>
#endif

#include "voile/voile.hpp"

namespace py = pybind11;

namespace {

using voile::Simulation;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Rows of `columns` numbers; one column is a plain array.
template <class T>
py::array_t<T> rows(const std::vector<T>& values, py::ssize_t columns) {
  const auto count = static_cast<py::ssize_t>(values.size());
  py::array_t<T> all(columns == 1 ? std::vector<py::ssize_t>{count}
                                  : std::vector<py::ssize_t>{count / columns, columns});
  std::copy(values.begin(), values.end(), all.mutable_data());
  return all;
}

/// Of an array with three columns, or an empty one.
std::vector<double> numbers(const Doubles& array) {
  if (array.size() > 0 && (array.ndim() != 2 || array.shape(1) != 3))
    throw voile::UserError("an array of n x 3 numbers is needed: a row per vertex or point");
  return {array.data(), array.data() + array.size()};
}

// ---- PETSc's objects through petsc4py ------------------------------------------------------------------------------------

#ifdef VOILE_PETSC4PY

void need_petsc4py() {
  static const bool is_there = import_petsc4py() == 0;
  if (!is_there) throw py::error_already_set();
}

py::object taken(Vec v) {
  need_petsc4py();
  auto object = py::reinterpret_steal<py::object>(PyPetscVec_New(v));
  (void)VecDestroy(&v);  // the object counts as an owner of its own
  if (!object) throw py::error_already_set();
  return object;
}

py::object taken(Mat m) {
  need_petsc4py();
  auto object = py::reinterpret_steal<py::object>(PyPetscMat_New(m));
  (void)MatDestroy(&m);
  if (!object) throw py::error_already_set();
  return object;
}

Vec vector_of(const py::object& object) {
  need_petsc4py();
  Vec v = PyPetscVec_Get(object.ptr());
  if (PyErr_Occurred()) throw py::error_already_set();
  return v;
}

#else

[[noreturn]] void without() {
  throw py::import_error("voile was built without petsc4py; install python3-petsc4py, and build it again");
}
py::object taken(Vec) {
  without();
}
py::object taken(Mat) {
  without();
}
Vec vector_of(const py::object&) {
  without();
}

#endif

/// Asks before anything is computed.
void require_petsc4py() {
#ifdef VOILE_PETSC4PY
  need_petsc4py();
#else
  without();
#endif
}

// ---- MPI, PETSc, and simulations that are alive ----------------------------------------------------------------------------

MPI_Comm communicator(const py::object& comm) {
  if (comm.is_none()) return MPI_COMM_WORLD;
  if (!py::hasattr(comm, "py2f")) throw py::type_error("comm must be a communicator of mpi4py, or None for all ranks");
  return MPI_Comm_f2c(comm.attr("py2f")().cast<int>());
}

/// Begun by the first simulation, ended when Python ends.
std::unique_ptr<voile::Session>& session() {
  static std::unique_ptr<voile::Session> one;
  return one;
}

/// A simulation that can be ended before Python forgets it: PETSc's objects must go before PETSc does.
class Held {
 public:
  Held(const voile::Case& c, const py::object& comm, voile::Options options) {
    if (!session()) session() = std::make_unique<voile::Session>();
    options.signals = true;
    comm_ = comm;
    simulation_ = std::make_unique<Simulation>(communicator(comm), c, std::move(options));
    static std::size_t begun = 0;
    number_ = begun++;
    alive().emplace(number_, this);
  }
  ~Held() { alive().erase(number_); }
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;

  void close() {
    if (running_ > 0) throw voile::UserError("close(): the simulation is taking steps; not in what observe() calls");
    simulation_.reset();
  }
  /// The result of steps, during which it cannot be closed. As Python's own loops end on Ctrl-C, it ends after a step.
  template <class Steps>
  auto steps(const Steps& take) {
    struct Count {
      int& of;
      explicit Count(int& n) : of(n) { ++of; }
      ~Count() { --of; }
    } const running(running_);
    auto result = take(**this);
    if (!(**this).interrupted()) return result;
    PyErr_SetNone(PyExc_KeyboardInterrupt);
    throw py::error_already_set();
  }
  Simulation& operator*() {
    if (!simulation_) throw voile::UserError("the simulation is closed");
    return *simulation_;
  }
  Simulation* operator->() { return &**this; }

  /// In the order in which they began, the same on all ranks, as ending one is collective.
  static std::map<std::size_t, Held*>& alive() {
    static std::map<std::size_t, Held*> all;
    return all;
  }

 private:
  std::size_t number_ = 0;
  py::object comm_;  // must outlive the simulation
  std::unique_ptr<Simulation> simulation_;
  int running_ = 0;
};

void end_session() {
  for (const auto& [number, one] : Held::alive()) one->close();
  session().reset();
}

template <class Value>
void set_key(voile::Case& c, const std::string& key, const Value& value) {
  c.set(key, value);
}

void declare_values(py::module_& m) {
  py::class_<voile::Case>(m, "Case", "A case: what a case file contains.")
      .def_static("read", &voile::Case::read, py::arg("file"))
      .def_static("parse", &voile::Case::parse, py::arg("text"), py::arg("folder") = ".")
      .def("set", &set_key<bool>, py::arg("key"), py::arg("value").noconvert())
      .def("set", &set_key<int>, py::arg("key"), py::arg("value").noconvert())
      .def("set", &set_key<double>, py::arg("key"), py::arg("value"))
      .def("set", &set_key<std::string>, py::arg("key"), py::arg("value"))
      .def("set", &set_key<std::vector<double>>, py::arg("key"), py::arg("value"))
      .def("text", &voile::Case::text, "The case as TOML: every key with the value in force.");
  py::class_<voile::Step>(m, "Step", "One step, or the attempt at one.")
      .def_readonly("accepted", &voile::Step::accepted,
                    "False: the simulation has come to its end, see Simulation.reason, or to a stage without steps.")
      .def_readonly("number", &voile::Step::number, "Of accepted steps, in the stage.")
      .def_readonly("time", &voile::Step::time, "Reached [s].")
      .def_readonly("load_factor", &voile::Step::load_factor, "Reached.")
      .def_readonly("size", &voile::Step::size, "Of time [s], or of the load factor.")
      .def_readonly("iterations", &voile::Step::iterations, "Of Newton's method, failed attempts included.")
      .def_readonly("rejections", &voile::Step::rejections, "Attempts that failed before.")
      .def_readonly("new_mesh", &voile::Step::new_mesh,
                    "Remeshed or sewn after it: arrays have another length from here on.");
  py::class_<voile::State>(m, "State", "A saved state.").def_property_readonly("time", &voile::State::time, "[s]");
  py::class_<voile::Energy> energy(m, "Energy", "Energies of a state, and of a motion so far [J].");
  energy.def_readonly("membrane", &voile::Energy::membrane)
      .def_readonly("bending", &voile::Energy::bending)
      .def_readonly("contact", &voile::Energy::contact)
      .def_readonly("springs", &voile::Energy::springs)
      .def_readonly("external", &voile::Energy::external,
                    "Potential of dead loads, those of set_forces() included, and energy of gases.")
      .def_readonly("kinetic", &voile::Energy::kinetic)
      .def_readonly("initial", &voile::Energy::initial, "At the start of the motion.")
      .def_readonly("loads", &voile::Energy::loads, "Work of loads since, those of set_forces() included.")
      .def_readonly("supports", &voile::Energy::supports, "Work of what moves supports since.")
      .def_readonly("obstacles", &voile::Energy::obstacles, "Work of what moves obstacles since.")
      .def_readonly("damping", &voile::Energy::damping)
      .def_readonly("drag", &voile::Energy::drag)
      .def_readonly("friction", &voile::Energy::friction)
      .def_readonly("fabric", &voile::Energy::fabric)
      .def_readonly("numerical", &voile::Energy::numerical)
      .def_readonly("unaccounted", &voile::Energy::unaccounted);
}

void declare_steps(py::class_<Held>& c) {
  c.def("close", &Held::close, "Frees it before Python does. Collective.")
      .def(
          "advance", [](Held& s) { return s.steps([](Simulation& of) { return of.advance(); }); },
          "One accepted step, as a Step. UserError after the end; KeyboardInterrupt on Ctrl-C.")
      .def(
          "advance_to", [](Held& s, double t) { return s.steps([&](Simulation& of) { return of.advance_to(t); }); },
          py::arg("t"),
          "Steps until time t [s] exactly, of a motion. Returns whether t is reached: the end of the case may come "
          "first.")
      .def(
          "run", [](Held& s) { return s.steps([](Simulation& of) { return of.run(); }); },
          "Steps to the end; with an output folder the files are complete then. Returns `converged`.")
      .def(
          "observe", [](Held& s, std::function<void(const voile::Step&)> look) { s->observe(std::move(look)); },
          py::arg("look"), "Calls look(step) on every rank after each accepted step.")
      .def_property_readonly(
          "finished", [](Held& s) { return s->finished(); }, "Whether the end is reached, or nothing more can be done.")
      .def_property_readonly(
          "converged", [](Held& s) { return s->converged(); },
          "Whether the end was reached as the case asks for: where `voile run` ends with code 0.")
      .def_property_readonly(
          "reason", [](Held& s) { return s->reason(); }, "Why it has not converged.")
      .def_property_readonly(
          "time", [](Held& s) { return s->time(); }, "[s]")
      .def_property_readonly("load_factor", [](Held& s) { return s->load_factor(); })
      .def_property_readonly(
          "step", [](Held& s) { return s->step(); }, "Accepted steps of the stage.");
}

void declare_arrays(py::class_<Held>& c) {
  c.def(
       "positions", [](Held& s) { return rows(s->positions(), 3); },
       "Positions of the vertices [m], n x 3, in the order in which the mesh was read, on every rank.")
      .def(
          "displacements", [](Held& s) { return rows(s->displacements(), 3); },
          "From the mesh as it was read [m], n x 3.")
      .def(
          "velocities", [](Held& s) { return rows(s->velocities(), 3); }, "Of a motion; zeros otherwise [m/s], n x 3.")
      .def(
          "triangles", [](Held& s) { return rows(s->triangles(), 3); },
          "Vertices of the triangles, counted from 0, n x 3.")
      .def(
          "group", [](Held& s, const std::string& name) { return rows(s->group(name), 1); }, py::arg("name"),
          "Vertices of a group of the mesh.")
      .def_property_readonly("vertex_count", [](Held& s) { return s->vertex_count(); })
      .def_property_readonly("triangle_count", [](Held& s) { return s->triangle_count(); })
      .def(
          "field",
          [](Held& s, const std::string& name) {
            const voile::Field f = s->field(name);
            return rows(f.values, f.components);
          },
          py::arg("name"), "A field as the results have it, e.g. \"bending_moment\" [N], a row per vertex or triangle.")
      .def("_history",
           [](Held& s) {
             const voile::History h = s->history();
             py::dict all;
             for (std::size_t k = 0; k < h.columns.size(); ++k) {
               std::vector<double> column;
               for (const auto& row : h.rows)  // what does not exist is empty in history.csv
                 column.push_back(std::isfinite(row[k]) ? row[k] : std::nan(""));
               all[py::str(h.columns[k])] = rows(column, 1);
             }
             return all;
           })
      .def(
          "energy", [](Held& s) { return s->energy(); }, "Energies of the present state [J].")
      .def(
          "eigenvalues", [](Held& s) { return rows(s->eigenvalues(), 1); },
          "Frequencies [Hz] or critical load factors, lowest first. Of modal and buckling analyses, after run(); "
          "raises UserError otherwise.");
}

void declare_coupling(py::class_<Held>& c) {
  c.def(
       "save", [](Held& s) { return s->save(); }, "The present state, to go back to.")
      .def(
          "restore", [](Held& s, const voile::State& state) { s->restore(state); }, py::arg("state"),
          "Goes back to a saved state of this simulation; not with an output folder.")
      .def(
          "set_forces", [](Held& s, const Doubles& forces) { s->set_forces(numbers(forces)); }, py::arg("forces"),
          "Forces on the vertices [N], n x 3, besides the loads of the case, until they are set again. An empty array "
          "takes "
          "them away, and so does a new mesh.")
      .def(
          "set_obstacle",
          [](Held& s, const std::string& name, const Doubles& positions, double t) {
            s->set_obstacle(name, numbers(positions), t);
          },
          py::arg("name"), py::arg("positions"), py::arg("t"),
          "An obstacle moves on straight lines from its place to these positions of its points [m], n x 3, at time t "
          "[s], and "
          "stays there.")
      .def(
          "obstacle", [](Held& s, const std::string& name) { return rows(s->obstacle(name), 3); }, py::arg("name"),
          "Where the points of an obstacle [m], n x 3.");
}

void declare_petsc(py::class_<Held>& c) {
  c.def(
       "unknowns", [](Held& s) { return require_petsc4py(), taken(s->unknowns()); },
       "The unknowns of the present state [m], as a Vec of petsc4py: a copy, three per vertex in the vertex's own "
       "axes.")
      .def(
          "residual", [](Held& s, const py::object& x) { return taken(s->residual(vector_of(x))); }, py::arg("x"),
          "Internal minus applied forces at x [N], without inertia; where supports hold, how far x is from what they "
          "prescribe [m].")
      .def(
          "tangent", [](Held& s, const py::object& x) { return taken(s->tangent(vector_of(x))); }, py::arg("x"),
          "The derivative of the residual at x [N/m], as a Mat of petsc4py; unit rows and columns where supports hold.")
      .def(
          "to_array", [](Held& s, const py::object& x) { return rows(s->to_array(vector_of(x)), 3); }, py::arg("x"),
          "A vector of unknowns as an array over the vertices in global axes, n x 3.")
      .def(
          "to_unknowns",
          [](Held& s, const Doubles& values) { return require_petsc4py(), taken(s->to_unknowns(numbers(values))); },
          py::arg("values"), "The other way round.");
}

}  // namespace

PYBIND11_MODULE(_core, m) {
  m.doc() = "Voile's library. Use it through the package voile.";
  m.attr("version") = voile::version();
  py::register_exception<voile::UserError>(m, "UserError", PyExc_ValueError);
  py::register_exception<voile::InternalError>(m, "InternalError", PyExc_RuntimeError);
  py::register_exception<voile::OutOfMemory>(m, "OutOfMemory", PyExc_MemoryError);
  declare_values(m);
  py::class_<Held> simulation(m, "Simulation");
  simulation.def(py::init([](const voile::Case& c, const py::object& comm, const std::filesystem::path& output,
                             bool overwrite, bool verbose, const std::string& petsc) {
                   return std::make_unique<Held>(c, comm, voile::Options{output, overwrite, verbose, petsc});
                 }),
                 py::arg("case"), py::arg("comm"), py::arg("output"), py::arg("overwrite"), py::arg("verbose"),
                 py::arg("petsc"));
  declare_steps(simulation);
  declare_arrays(simulation);
  declare_coupling(simulation);
  declare_petsc(simulation);
  py::module_::import("atexit").attr("register")(py::cpp_function(&end_session));
}
