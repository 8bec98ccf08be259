// The library. docs/reference/library.md has a program of ten lines.
#pragma once

#include "voile/case.hpp"
#include "voile/errors.hpp"
#include "voile/session.hpp"
#include "voile/simulation.hpp"
#include "voile/version.hpp"
