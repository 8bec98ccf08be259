// The Gmsh library while it is in use; private to the program voile-gmsh.
#pragma once

#include <gmsh.h>

namespace voile::io {

/// Gmsh keeps ONELAB values and the logger across finalize, and an exception thrown out of its parser leaves the parser
/// unusable for the next file. So errors are collected from the log instead of thrown, and everything is reset.
class Session {
 public:
  Session() {
    gmsh::initialize(0, nullptr, false);
    gmsh::option::setNumber("General.Terminal", 0);
    gmsh::option::setNumber("General.AbortOnError", 0);
    gmsh::option::setNumber("General.NumThreads", 1);
    gmsh::option::setNumber("Mesh.RandomSeed", 1);
    gmsh::onelab::clear();
    gmsh::logger::start();
  }
  ~Session() {
    try {
      gmsh::logger::stop();
      gmsh::onelab::clear();
      gmsh::finalize();
    } catch (...) {
    }  // a destructor must not throw; the result is already copied
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
};

}  // namespace voile::io
