// What the library throws. All ranks of a simulation throw alike, and the process can go on: other simulations are not touched.
//
//   UserError       a mistake in the case, in a file or in a call: the message names file, key, value and remedy
//   InternalError   a broken invariant or a failing library
//   OutOfMemory     memory that could not be had
// A step that does not converge throws nothing: Step::accepted, Simulation::converged() and Simulation::reason() tell.
#pragma once

#include "voile/base/error.hpp"
