// What the shared library shows to the programs that are linked with it: everything else is hidden (CMakeLists.txt).
#pragma once

#define VOILE_API __attribute__((visibility("default")))
