// Meshes that follow the folds: when a run gets a new mesh, and how its state goes on there.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "adapt/remesh.hpp"
#include "adapt/rest_surface.hpp"
#include "adapt/sizing.hpp"
#include "adapt/transfer.hpp"
#include "epoch.hpp"
#include "record/summary.hpp"
#include "results/results.hpp"
#include "setup/background_size.hpp"
#include "setup/obstacle_sizes.hpp"
#include "stage.hpp"

namespace voile::remesh {

/// An epoch on a mesh of its own.
struct RemeshResult {
  std::shared_ptr<const mesh::SurfaceMesh> mesh;
  std::unique_ptr<Epoch> epoch;
};

/// What is conserved, or nearly, across a remeshing.
struct Ledger {
  system::Energies energies;                             ///< [J]
  double kinetic = 0.0, mass = 0.0;                      ///< [J], [kg]
  Vec3 momentum = Vec3::Zero(), angular = Vec3::Zero();  ///< [kg m/s], about the origin [kg m^2/s]
  /// In the sheet, in contact and in springs. [J]
  [[nodiscard]] double stored() const {
    return energies.membrane + energies.bending + energies.contact + energies.springs;
  }
  /// And kinetic. [J]
  [[nodiscard]] double total() const { return stored() + kinetic; }
};

/// CPU seconds of this process.
[[nodiscard]] double cpu_clock();

/// As the log says it; empty if there were no remeshings.
[[nodiscard]] std::string text_of(const record::RemeshingEffort& effort);

class Remesher {
 public:
  /// `first`: the mesh of the case, whose rest shape all later ones approach. Collective.
  Remesher(const Stage& stage, std::shared_ptr<const mesh::SurfaceMesh> first);

  /// Whether the sizes of the state ask for another mesh, at a step that is looked at. Collective.
  [[nodiscard]] bool due(Epoch& epoch, bool finished);
  /// How long edges should be in the state of the epoch, per vertex, on rank 0 [m]. Collective. Throws UserError.
  [[nodiscard]] std::vector<double> wanted_sizes(Epoch& epoch);
  /// The next epoch, or nothing if what was found is refused. `remark` says what was done. Collective.
  [[nodiscard]] std::optional<RemeshResult> adapt(Epoch& epoch, const std::function<void(const std::string&)>& remark);
  /// What all remeshings together came to so far. Not collective.
  [[nodiscard]] record::RemeshingEffort effort() const;
  /// Vertices of a mesh of the sizes that the last call of due() found, about; on rank 0.
  [[nodiscard]] double expected_vertices() const;

 private:
  /// Steps between two looks.
  [[nodiscard]] int every() const;
  [[nodiscard]] std::vector<double> bounds(Epoch& epoch, const std::vector<double>& curvature_squared);
  void bound_by_error(Epoch& epoch, const system::TriangleFields& fields, std::vector<double>& bound) const;
  [[nodiscard]] double time_ahead(const Epoch& epoch) const;
  [[nodiscard]] std::vector<setup::Bend> bends(Epoch& epoch) const;
  void bound_by_obstacles(const std::vector<setup::Bend>& bends, double ahead, const std::vector<Vec3>& places,
                          const std::vector<double>& velocity, std::vector<double>& bound);
  [[nodiscard]] std::vector<char> changeable(const mesh::SurfaceMesh& mesh, const std::vector<char>& marked) const;
  [[nodiscard]] adapt::Limits limits(Epoch& epoch) const;
  struct NewMesh;
  [[nodiscard]] NewMesh make_mesh(Epoch& epoch, const std::vector<double>& size, bool only_splits);
  [[nodiscard]] results::Checkpoint carry_over(Epoch& epoch, const NewMesh& made) const;
  [[nodiscard]] std::optional<RemeshResult> attempt(Epoch& epoch, const std::vector<double>& size, bool only_splits,
                                                    std::string& what);
  [[nodiscard]] Ledger ledger(Epoch& epoch) const;
  [[nodiscard]] bool is_consistent() const;  ///< the mass of the motion
  void keep_momentum(Epoch& old_epoch, Epoch& fresh, const Ledger& before);
  [[nodiscard]] adapt::Momentum momentum(const system::Model& model, const adapt::Motion& motion) const;
  void keep(const system::Model& model, const adapt::Motion& motion, const std::vector<char>& held,
            const adapt::Momentum& wanted, double energy, std::vector<Vec3>& velocity);
  [[nodiscard]] static std::string intersections(Epoch& epoch);
  [[nodiscard]] bool find_equilibrium(Epoch& old_epoch, Epoch& fresh, std::string& what) const;
  [[nodiscard]] bool find_equilibrium_nearby(Epoch& fresh) const;
  [[nodiscard]] static double negligible_energy(const Epoch& epoch);
  [[nodiscard]] double energy_change(const Ledger& before, const Ledger& after, Epoch& fresh) const;
  [[nodiscard]] static petsc::VecHandle inertia_force(Epoch& old_epoch, Epoch& fresh, const NewMesh& made);
  [[nodiscard]] double settle(Epoch& old_epoch, Epoch& fresh, const Ledger& before, const NewMesh& made);
  void write(const Epoch& epoch, const NewMesh& made, const Ledger& before, const Ledger& after, bool accepted,
             double seconds);

  const Stage& stage_;
  const input::RemeshSection& keys_;
  std::shared_ptr<const mesh::SurfaceMesh> first_;
  std::optional<adapt::RestSurface> rest_;       ///< rank 0
  bool curved_ = false;                          ///< whether any chart of it is
  std::optional<results::HistoryWriter> table_;  ///< rank 0
  std::vector<double> size_;                     ///< found by due()
  std::vector<char> near_obstacle_;              ///< per vertex, on rank 0: beside a bend; found by due()
  std::function<double(const Vec3&)> bound_;
  std::optional<setup::BackgroundSize> background_;  ///< rank 0
  double begin_ = cpu_clock(), seconds_ = 0.0;
  double velocity_factor_ = 1.0;  ///< of the last remeshing, on rank 0
  int count_ = 0, refused_ = 0, attempts_ = 0, at_end_ = 0;
};

/// Throws UserError where a case means vertices that a remeshing would multiply: forces, masses and springs at every
/// vertex of a curve or surface; and for a size field that cannot be read. Collective.
void check_remesh(MPI_Comm comm, const input::Case& c, const mesh::SurfaceMesh& mesh);

/// Names the vertices that probes at points record, as groups "probe NAME", so that they stay. Not collective.
void name_probes(const input::Case& c, mesh::MeshData& mesh);

/// The same for a mesh that an earlier run has made from `first`: probes of that run stay on their vertices, those that are
/// new or at another point get theirs. Not collective.
void rename_probes(const input::Case& c, const mesh::SurfaceMesh& first, mesh::MeshData& mesh);

/// What remeshing would do at the start, for `check`. Collective.
[[nodiscard]] std::string remesh_outlook(const Stage& stage, const std::shared_ptr<const mesh::SurfaceMesh>& mesh,
                                         Epoch& epoch);

}  // namespace voile::remesh
