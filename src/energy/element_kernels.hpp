// Element kernels over batches of eight triangles, compiled once per instruction set and chosen at start.
//
// Plain arrays only: what lies behind these functions is compiled with other options than the rest of the program. Every array
// of a batch has `batch_lanes` numbers for each thing it holds, one per triangle; the lanes that a last batch has too many repeat
// one of its triangles and are never counted.
#pragma once

namespace voile::energy {

constexpr int batch_lanes = 8;

/// The state that kernels are given: three numbers per local point.
struct KernelState {
  const double* x = nullptr;         ///< positions [m]
  const double* u = nullptr;         ///< displacements [m]
  const double* previous = nullptr;  ///< positions of the previous iterate; null unless the stress is linearised
  bool positive = false;             ///< the tangent is to have no negative part
  const double *stress_x = nullptr, *stress_u = nullptr;  ///< where the stress is wanted; null: there
};

/// Which strains a membrane element has; see membrane.hpp. Samples 0 to 2 are the sides, 3 is the triangle alone.
struct MembraneShape {
  int first_sample = 0, last_sample = 4;  ///< last: one beyond
  int groups = 2;                         ///< strains that energies are taken of
  int group[4] = {0, 0, 0, 1};            ///< of each sample
  double weight[4] = {};                  ///< of each sample in the strain of its group
  double factor[3] = {};                  ///< of each group in the energy
  bool corrected = false;                 ///< for chords
  int rubbing = 0;                        ///< group whose shear rubs where yarns do
};

/// Places of a membrane element's numbers.
namespace membrane_fields {
constexpr int side = 0;               ///< d_{s,alpha,k} at 8 s + 4 alpha + k
constexpr int own = 24;               ///< at 3 alpha + k
constexpr int metric = 30;            ///< what is taken off each group's strain, 3 each
constexpr int stiffness = 39;         ///< L of A C = L L^T: 11 21 31 22 32 33
constexpr int plain = 45;             ///< so many without correction
constexpr int chord = 45;             ///< -1/12, or 0 beside a crease
constexpr int place = 46;             ///< y of the six points
constexpr int start = 58;             ///< K at the start, seven vectors
constexpr int bending = 79;           ///< A D: 11 12 13 22 23 33
constexpr int trace = 85;             ///< R
constexpr int start_invariants = 91;  ///< A (q_D - q_D at rest), q_S - q_S at rest at the start
constexpr int weights = 93;           ///< B'_i, seven for each point
}  // namespace membrane_fields

/// Places of the numbers of yarns that stiffen and rub in the plane (yarn_law.hpp).
namespace yarn_law_fields {
constexpr int turn = 0;        ///< strains in yarn axes from those in material axes, three rows
constexpr int slip = 9;        ///< p
constexpr int stiffness = 10;  ///< A G_s
constexpr int limit = 11;      ///< A H0
constexpr int rise = 12;       ///< A h
constexpr int knots = 13;      ///< e_j, A c_j of each: along warp, along weft, in shear
}  // namespace yarn_law_fields

/// Places of the numbers of hyperelastic laws (hyperelastic.hpp).
namespace rubber_fields {
constexpr int natural = 0;         ///< strains from the natural state from those from the rest shape, three rows
constexpr int is = 9;              ///< 1 where a triangle has such a law, otherwise 0
constexpr int c10 = 10;            ///< A c10
constexpr int c01 = 11;            ///< A c01
constexpr int shear_modulus = 12;  ///< A mu at zero strain
constexpr int terms = 13;          ///< A mu_p, alpha_p of each
}  // namespace rubber_fields

struct MembraneBatch {
  const double* fields;
  const int* gather;        ///< local point of each stencil position
  const int* scatter;       ///< where forces go to; its order says which block of a pair is the upper one
  const int* slots;         ///< where the nine numbers of pairs i <= j go to, row by row
  const double* start;      ///< strains at the start of a time step, 3 per group; null: no viscosity
  const double* viscosity;  ///< c
  const double* law;        ///< numbers of yarns that stiffen or rub; null: of none
  int knots;                ///< of each direction
  const double* rubber;     ///< numbers of hyperelastic laws; null: of none
  int terms;                ///< Ogden's, of each
  int points;               ///< stencil positions
  int first, last;          ///< lanes to be done
  bool fourth;              ///< whether a triangle has a term of fourth order
};

struct MembraneKernels {
  /// Strains of the groups, 3 each, one per lane, to `strain`.
  void (*strain)(const MembraneShape& shape, const MembraneBatch& batch, const KernelState& state, double* strain);
  /// Adds to three numbers per point of `scatter` [N]; energies, one per lane, to `energy` [J].
  void (*gradient)(const MembraneShape& shape, const MembraneBatch& batch, const KernelState& state, double* force,
                   double* energy);
  /// Adds to the nine numbers at each slot [N/m].
  void (*tangent)(const MembraneShape& shape, const MembraneBatch& batch, const KernelState& state, double* blocks);
};

/// Edges with two triangles (a, b, p) and (b, a, q): edge_angle.hpp.
struct EdgeBatch {
  const int* points;   ///< a, b, p, q
  const int* scatter;  ///< where forces go to, and the order, as in MembraneBatch
  const int* slots;    ///< where the blocks of pairs go to: aa ab ap aq bb bp bq pp pq qq
  int lanes;
  double* angle;   ///< theta
  double* slopes;  ///< of each edge sixteen numbers: its derivatives by a, b, p, q, each with a zero behind
  double* pull;    ///< derivative of the energy by theta
};
struct EdgeKernels {
  void (*angles)(const EdgeBatch& batch, const KernelState& state);
  /// Angles and slopes.
  void (*slopes)(const EdgeBatch& batch, const KernelState& state);
  /// Adds pull times slope to the forces.
  void (*gradient)(const EdgeBatch& batch, const KernelState& state, double* force);
  /// Adds pull times second derivatives.
  void (*tangent)(const EdgeBatch& batch, const KernelState& state, double* blocks);
};

/// Where the angle at an edge acts on a triangle.
struct HingeAt {
  int edge;
  unsigned char at[4];  ///< stencil positions of a, b, p, q
};
/// Places of the numbers of a triangle that bends by angles (angle_bending.hpp). All curvatures are times L^T, A D = L L^T.
namespace angle_fields {
constexpr int rest = 0;      ///< kappa0
constexpr int start = 3;     ///< r, a vector for each component
constexpr int weights = 12;  ///< B'_i, three for each point
}  // namespace angle_fields
struct AngleBatch {
  const double* fields;
  const int *gather, *scatter, *slots;  ///< as in MembraneBatch
  const HingeAt* hinges;                ///< of all triangles
  const double* hinge_weights;          ///< of each four numbers: c_e H_e and a zero
  const int *first_hinge, *last_hinge;  ///< of each lane; last: one beyond
  int points, first, last;
};
struct AngleKernels {
  /// Adds to the pulls of edges and to forces, the latter without those through angles; energies, one per lane, to `energy`.
  void (*gradient)(const AngleBatch& batch, const KernelState& state, const double* angles, double* pulls,
                   double* force, double* energy);
  /// Adds to the pulls of edges and to blocks, the latter without second derivatives of angles.
  void (*tangent)(const AngleBatch& batch, const double* angles, const double* slopes, double* pulls, double* blocks);
};

/// Places of the numbers of a triangle whose bending depends on its normal (bending.hpp); its points 0, 1, 2 are the corners.
namespace curved_fields {
constexpr int rest_energy = 0;     ///< e0
constexpr int normal = 1;          ///< N_s
constexpr int start_coupling = 4;  ///< w
constexpr int coupling = 7;        ///< c_i, one for each point
}  // namespace curved_fields
struct CurvedBatch {
  const double* fields;
  const int *gather, *scatter, *slots;  ///< as in MembraneBatch; only the pairs of corners with all points have blocks
  int points, first, last;
};
struct CurvedKernels {
  /// Adds to forces; energies, one per lane, to `energy`.
  void (*gradient)(const CurvedBatch& batch, const KernelState& state, double* force, double* energy);
  void (*tangent)(const CurvedBatch& batch, const KernelState& state, double* blocks);
};

/// Places of the numbers of a triangle whose yarns rub where they bend (yarn_friction.hpp); its points 0, 1, 2 are the corners.
namespace yarn_fields {
constexpr int rest = 0;      ///< kappa0 along warp, along weft, twist
constexpr int start = 3;     ///< k at the start, a vector each
constexpr int weights = 12;  ///< B_i, three for each point
// Of each slider three times, once for each direction:
constexpr int per_slider = 4;       ///< slip p, A D_s, A HB, 1/(A D_s) or 0
constexpr double round_off = 1e-9;  ///< of a slider at its limit, which sticks
}  // namespace yarn_fields
struct YarnBatch {
  const double* fields;
  const double* sliders;
  const int *gather, *scatter, *slots;  ///< as in MembraneBatch
  int points, first, last;
  int slider_count;
};
struct YarnKernels {
  /// Adds to forces; energies of the increment, one per lane, to `energy`.
  void (*gradient)(const YarnBatch& batch, const KernelState& state, double* force, double* energy);
  void (*tangent)(const YarnBatch& batch, const KernelState& state, double* blocks);
};

/// The kernels of one instruction set.
struct ElementKernels {
  const char* name;
  int lanes;
  bool (*usable)();  ///< on this machine
  MembraneKernels membrane;
  EdgeKernels edges;
  AngleKernels angles;
  CurvedKernels curved;
  YarnKernels yarns;
};

/// All variants of this build, the scalar one first.
struct KernelVariants {
  const ElementKernels* const* variants;
  int count;
};
[[nodiscard]] KernelVariants kernel_variants();
/// One triangle at a time.
[[nodiscard]] const ElementKernels& scalar_kernels();
/// The widest that this machine has.
[[nodiscard]] const ElementKernels& batch_kernels();

}  // namespace voile::energy
