// What the library throws, and with what its program ends. All ranks of a simulation throw alike, and the process can go
// on: other simulations are not touched. A step that does not converge throws nothing: Step::accepted,
// Simulation::converged() and Simulation::reason() tell.
#pragma once

#include <stdexcept>
#include <string>

namespace voile {

/// Exit codes of the program.
enum class Exit : int { done = 0, user_error = 2, not_converged = 3, internal_error = 4, unstable = 5 };

/// A mistake in the user's input. The message names file, key, value and remedy.
class UserError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A broken invariant or a failing library: the user cannot mend it in the input.
class InternalError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Memory that could not be had, on this rank at least.
class OutOfMemory : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace voile
