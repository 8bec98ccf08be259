// Strains, curvatures and stress resultants of a state, per triangle.
//
// Symbols   B'      curvature operator of a triangle,  kappa0 its rest curvature,  n current unit normal
//           r       by how much the start is bent beyond the rest shape,  N_s its normal (bending.hpp)
//           D       bending stiffness [N m];  kappa = (n.N_s - 1) kappa0 + n.r + sum_i (n.u_i) B'_i, or that of the angles
//                   at edges (angle_bending.hpp)
// Theory: docs/theory/curvature.md (1), docs/theory/curved-rest-shapes.md.
#pragma once

#include <vector>

#include "base/mpi.hpp"
#include "base/types.hpp"

namespace voile::energy {
class AngleBendingTerm;
class JointTerm;
struct BendingElement;
struct Configuration;
struct EdgeBend;
class MembraneTerm;
class Sheet;
}  // namespace voile::energy

namespace voile::system {

class NaturalStates;

/// Fields per triangle in material axes, row-major, mesh order, gathered on rank 0. Strains and curvatures are elastic: without
/// those of the natural state (energy/natural_state.hpp).
struct TriangleFields {
  std::vector<double> membrane_strain;  ///< E11, E22, 2 E12
  std::vector<double> membrane_force;   ///< N11, N22, N12 [N/m]
  std::vector<double> curvature;        ///< k11, k22, 2 k12, change from rest [1/m]
  std::vector<double> whole_curvature;  ///< the same with that of the rest shape [1/m]
  std::vector<double> bending_moment;   ///< M11, M22, M12 [N]
  std::vector<double> temperature;      ///< change and difference [K]; empty where there are no temperatures
  std::vector<double> in_plane;  ///< energy of second derivatives in the surface, which bend nothing; one each [J/m^2]
};

class Recovery {
 public:
  /// A triangle that this rank owns: its bending element with its points in local numbering, and the numbers of its
  /// membrane element and of its angles (no_index: it bends without).
  void add(Index triangle, const energy::BendingElement& element, const std::vector<Index>& local, Index membrane,
           Index angles);
  /// After the last add(): gives back what the lists have grown beyond.
  void end_adding();
  /// What fields are taken from.
  struct Sources {
    const energy::MembraneTerm& membrane;
    const energy::AngleBendingTerm& angles;
    const energy::JointTerm* joints;  ///< null: no sheets are joined
    const NaturalStates* natural;     ///< null: the rest shape
    const std::vector<energy::EdgeBend>& edge_bends;
  };
  /// At configuration c of the local points, of the first `triangles` of the sheet. Collective; values on rank 0.
  [[nodiscard]] TriangleFields fields(MPI_Comm comm, const energy::Sheet& sheet, Index triangles, const Sources& from,
                                      const energy::Configuration& c) const;

 private:
  struct Item {
    Index triangle, membrane, angles;
    std::size_t start;
    int count;
    Vec3 rest_curvature, start_normal;
    Mat3 start_bend;
  };
  std::vector<Item> items_;
  std::vector<Index> points_;
  std::vector<Vec3> weights_;
};

}  // namespace voile::system
