// The case file: what a user asks for, parsed strictly from TOML, in SI units.
//
// Every key is declared once, in case_keys.cpp, with its unit, default and meaning; parsing, the echo of the resolved
// case and docs/case-reference.md all come from that declaration.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "voile/base/types.hpp"
#include "voile/energy/element_options.hpp"
#include "voile/energy/material.hpp"
#include "voile/io/gmsh.hpp"
#include "voile/solve/static_options.hpp"
#include "voile/system/conditions.hpp"

namespace voile::app {

struct MeshSection {
  std::filesystem::path file;  ///< resolved relative to the case file
  io::MeshOptions options;
};

/// One named number recorded in history.csv after every accepted step.
struct Probe {
  enum class Kind { displacement, reaction, energy };
  std::string name;  ///< column name; a vector quantity gets suffixes _x _y _z
  Kind kind = Kind::displacement;
  std::string group;            ///< displacement: mean over the group's vertices; reaction: total over them
  std::optional<Vec3> point;    ///< displacement of the vertex nearest to this rest position, instead of `group`
  std::vector<int> components;  ///< 0, 1, 2; empty: all three
};

struct OutputSection {
  std::vector<std::string> fields;  ///< names of fields to write; empty: all
  int every = 1;                    ///< results every so many accepted steps (the last one always)
};

struct Case {
  std::filesystem::path file;
  std::string title;
  std::string analysis = "static";
  MeshSection mesh;
  energy::ElementOptions element;
  std::vector<energy::Material> materials;
  std::vector<system::Support> supports;
  std::vector<system::Load> loads;
  solve::StaticOptions steps;
  std::vector<Probe> probes;
  OutputSection output;
  std::string petsc_options;  ///< as on PETSc's command line; the real command line wins
};

/// Parses and checks everything that needs no mesh. Not collective.
/// Throws UserError naming file, line, key and the nearest valid key or value.
[[nodiscard]] Case parse_case(const std::string& text, const std::filesystem::path& file);

/// The resolved case as TOML: every key with the value in force.
[[nodiscard]] std::string echo_case(const Case& c);

/// docs/case-reference.md, generated from the declarations of the keys.
[[nodiscard]] std::string case_reference_markdown();

}  // namespace voile::app
