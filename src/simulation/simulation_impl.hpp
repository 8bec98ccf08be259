// The inner parts of Simulation; private to src/simulation.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/interrupt.hpp"
#include "case_run.hpp"
#include "input/case.hpp"
#include "petsc_scope.hpp"
#include "voile/simulation.hpp"

namespace voile {

struct Simulation::Impl {
  MPI_Comm comm;
  Options options;
  input::Case input;
  PetscOptionsOf petsc;
  std::unique_ptr<simulation::CaseRun> run;
  bool stopped = false;  ///< by a signal, in the last call that took steps
  bool closed = false;   ///< the run has ended: files are complete
  std::vector<std::function<void(const Step&)>> observers;
  std::shared_ptr<const char> identity = std::make_shared<const char>('\0');  ///< by which saved states know their own

  Impl(MPI_Comm on, const Case& given, Options o);
  ~Impl();
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Step step(double until);
  /// Takes steps while signals are heeded, if the options say so. Collective.
  template <class Work>
  auto take_steps(const Work& work) {
    std::optional<SignalScope> signals;
    if (options.signals) signals.emplace();
    stopped = false;
    const auto result = work();
    stopped = SignalScope::stop_asked(comm);
    return result;
  }
  void close();
  [[nodiscard]] std::string reason() const;
  /// On every rank, in global axes; zeros if there is no such vector. Collective.
  [[nodiscard]] std::vector<double> gathered(Vec v, bool is_change = false) const;
  /// Throws UserError if x is no vector of unknowns.
  void require_unknowns(Vec x) const;

  [[nodiscard]] simulation::Epoch& epoch() const { return run->stage().epoch(); }
  [[nodiscard]] system::Model& model() const { return epoch().model(); }
  [[nodiscard]] const system::State& state() const { return epoch().state(); }
  [[nodiscard]] const system::Dofs& dofs() const { return model().dofs(); }
  [[nodiscard]] bool moves() const { return epoch().moves(); }
};

/// What a call of the interface needs of PETSc.
class Call {
 public:
  template <class Impl>
  explicit Call(Impl& of) : scope_(of.petsc) {}

 private:
  PetscOptionsOf::Scope scope_;
};

struct State::Data {
  simulation::CaseRun::Saved saved;
  std::shared_ptr<const char> identity;
};

}  // namespace voile
