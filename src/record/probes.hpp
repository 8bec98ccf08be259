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
  std::vector<double> ease;          ///< per vertex [m]; only if some probe needs it
  std::vector<Vec3> stresses = {};   ///< of each probe of stress, likewise [Pa]
  std::vector<Vec3> on_obstacles{};  ///< force on each obstacle of the stage, likewise [N]
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
  [[nodiscard]] bool need_stresses() const { return any(input::Probe::Kind::stress); }
  [[nodiscard]] bool need_contact() const { return any(input::Probe::Kind::contact); }
  [[nodiscard]] bool need_reactions() const { return any(input::Probe::Kind::reaction); }
  /// Of each probe of stress: 11, 22, 12. On rank 0. [Pa]
  [[nodiscard]] std::vector<Vec3> stresses(const system::Model& model, const system::TriangleFields& fields) const;
  [[nodiscard]] std::vector<std::string> columns() const;
  /// In the order of the columns. On rank 0.
  [[nodiscard]] std::vector<double> values(const Observed& state, const system::Model& model) const;
  /// Components of the probes that vibrate (displacement, reaction, stress): their columns, and their values where all that is
  /// observed is a change. The second on rank 0.
  struct Component {
    std::string column;
    input::Probe::Kind kind;
    std::size_t probe;  ///< its number
    int axis;           ///< x, y, z; 11, 22, 12
  };
  [[nodiscard]] std::vector<Component> vibrating() const;
  [[nodiscard]] std::vector<double> vibrating_values(const Observed& change) const;
  /// The displacement probe of that name, with one component, as a linear function of the unknowns. Collective.
  [[nodiscard]] petsc::VecHandle functional(const std::string& name, const system::Model& model) const;

 private:
  struct Members {
    std::vector<Index> vertices;
    std::vector<int> components;
    std::vector<double> weights;  ///< of the vertices in a mean, together 1: by area of a surface, by length of a curve
    Index triangle = no_index;    ///< of a stress
  };
  [[nodiscard]] bool any(input::Probe::Kind kind) const;
  /// Of the vertices above the ground, on the axis that points up. [m]
  [[nodiscard]] static std::vector<double> heights(const Members& m, const std::vector<double>& displacement,
                                                   const mesh::SurfaceMesh& mesh, double ground);
  [[nodiscard]] std::vector<double> components_of(const input::Probe& probe, const Members& m,
                                                  const Observed& state) const;

  const input::Case& case_;
  std::vector<Members> members_;
};

}  // namespace voile::record
