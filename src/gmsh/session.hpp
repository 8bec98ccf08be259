// The Gmsh library while it is in use; private to the program voile-gmsh.
#pragma once

#include <gmsh.h>

#include <string>

#include "base/confinement.hpp"

namespace voile::formats {

/// A script that the user trusts may do everything; what else is read, in a process without rights (confinement.hpp).
enum class Rights { confined, all };
inline Rights rights_of(const std::string& word) {
  return word == "trusted" ? Rights::all : Rights::confined;
}

/// Gmsh keeps ONELAB values and the logger across finalize, and an exception thrown out of its parser leaves the parser
/// unusable for the next file. So errors are collected from the log instead of thrown, and everything is reset.
class Session {
 public:
  explicit Session(Rights rights) {
    gmsh::initialize(0, nullptr, false);
    gmsh::option::setNumber("General.Terminal", 0);
    gmsh::option::setNumber("General.AbortOnError", 0);
    gmsh::option::setNumber("General.NumThreads", 1);
    gmsh::option::setNumber("Mesh.RandomSeed", 1);
    gmsh::onelab::clear();
    gmsh::logger::start();
    filtered_ = rights == Rights::all || confine_process();
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

  /// False: the kernel does not filter system calls, so that only the search for dangerous commands protects the user.
  [[nodiscard]] bool filtered() const { return filtered_; }

 private:
  bool filtered_ = true;
};

}  // namespace voile::formats
