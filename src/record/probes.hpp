// What the [[probe]] sections of a case add to history.csv.
#pragma once

#include <string>
#include <vector>

#include "input/case.hpp"
#include "system/model.hpp"

namespace voile::record {

/// A state as probes see it, gathered on rank 0.
struct Observed {
  std::vector<double> displacement, reaction;  ///< [m], [N]
  system::Energies energies;
  std::vector<double> ease;  ///< per vertex [m]; only if some probe needs it
};

/// What to say of probes whose point is farther from the nearest vertex than the triangles there are large. Not collective.
[[nodiscard]] std::vector<std::string> probe_warnings(const input::Case& c, const mesh::SurfaceMesh& mesh);

class Probes {
 public:
  /// The case must outlive them. Throws UserError for groups that the mesh does not have, and for a probe of ease without
  /// a body.
  Probes(const input::Case& c, const system::Model& model);

  [[nodiscard]] bool need_energies() const { return any(input::Probe::Kind::energy); }
  [[nodiscard]] bool need_ease() const { return any(input::Probe::Kind::ease); }
  [[nodiscard]] std::vector<std::string> columns() const;
  /// In the order of the columns. On rank 0.
  [[nodiscard]] std::vector<double> values(const Observed& state, const system::Model& model) const;
  /// Components of the probes of displacement: their columns, and their values of a displacement (or change of it) that is
  /// gathered. The second on rank 0.
  struct Component {
    std::string column;
    int axis;
  };
  [[nodiscard]] std::vector<Component> displacement_components() const;
  [[nodiscard]] std::vector<double> displacement_values(const std::vector<double>& displacement) const;
  /// The displacement probe of that name, with one component, as a linear function of the unknowns. Collective.
  [[nodiscard]] petsc::VecHandle functional(const std::string& name, const system::Model& model) const;

 private:
  struct Members {
    std::vector<Index> vertices;
    std::vector<int> components;
  };
  [[nodiscard]] bool any(input::Probe::Kind kind) const;
  [[nodiscard]] std::vector<double> components_of(const input::Probe& probe, const Members& m,
                                                  const Observed& state) const;

  const input::Case& case_;
  std::vector<Members> members_;
};

}  // namespace voile::record
