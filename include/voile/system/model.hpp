// The discrete problem of one mesh: terms, constraints, matrices and loads, divided over the ranks.
//
// Symbols   a     vector of unknowns, three per vertex in the vertex's own axes Q_v (see constraints.hpp)       [m]
//           u_v   = Q_v a_v displacement;  mirror points follow from the vertices (see patch.hpp)
//           lambda  load factor;  f_d dead loads that follow it, f_c constant ones                              [N]
//           K_b   constant bending stiffness, assembled once and copied into each tangent                       [N/m]
//                 (with the springs to the ground, which are constant too)
//           f_b   constant force of bending at a = 0: where the start is not the rest shape (bending.hpp), and of
//                 clamps that turn (model_motion.cpp)                                                               [N]
//           E_t    terms of the potential (term.hpp): membrane, bending of curved rest shapes beyond K_b, ties  [J]
//           E_k    contact and friction (contact.hpp)                                                           [J]
//   r(a)  = K_b a + f_b + sum_t dE_t/da + dE_k/da - lambda f_d - f_c - f_follower(a, lambda)       free components
//   r_i   = a_i - lambda abar_i - motion_i(t) - h_i                                     fixed components
// h is zero, or puts what supports hold where it was when they took hold of it (take_hold).
// Elements that touch an owned vertex are evaluated by its rank, so that rows are complete without communication;
// energies count each triangle once, on its owner.
#pragma once

#include <memory>
#include <vector>

#include "voile/base/petsc.hpp"
#include "voile/energy/bending.hpp"
#include "voile/energy/loads.hpp"
#include "voile/energy/membrane.hpp"
#include "voile/energy/sheet.hpp"
#include "voile/energy/spring.hpp"
#include "voile/mesh/partition.hpp"
#include "voile/mesh/patch.hpp"
#include "voile/system/block_matrix.hpp"
#include "voile/system/conditions.hpp"
#include "voile/system/constraints.hpp"
#include "voile/system/contact.hpp"
#include "voile/system/dofs.hpp"
#include "voile/system/recovery.hpp"
#include "voile/system/term.hpp"

namespace voile::system {

/// What a model is built from besides the mesh.
struct ModelInput {
  energy::ElementOptions element;
  std::vector<energy::Material> materials;
  std::vector<Support> supports;
  std::vector<Load> loads;
  ContactInput contact;
  std::vector<PointMass> masses = {};
  std::vector<Spring> springs = {};
  bool motion_by_load = false;  ///< supports move with the load factor in place of the time
};

struct Energies {
  double membrane = 0.0, bending = 0.0;  ///< [J]
  double external = 0.0;                 ///< work potential of dead loads, -f.u [J]
  double contact = 0.0;                  ///< barriers and lagged friction [J]
  double springs = 0.0;                  ///< [J]
};

/// What a tangent is made of besides the membrane and the follower loads.
struct TangentRequest {
  energy::Tangent kind = energy::Tangent::exact;
  Vec previous = nullptr;                    ///< previous iterate for Tangent::linearised_stress; may be null
  double bending = 1.0;                      ///< factor on the constant bending stiffness
  double damping = 0.0;                      ///< factor on the materials' own damping of bending [1/s]
  double mass = 0.0;                         ///< factor on the mass [1/s^2]
  const BlockMatrix* mass_matrix = nullptr;  ///< consistent mass; null: the lumped one
  Term* extra = nullptr;                     ///< one more term, at the same configuration; null: none
  bool exact_contact = false;                ///< contact with its negative eigenvalues
};

class Model {
 public:
  /// Builds everything. Collective; the mesh must be the same on all ranks and outlive the model.
  /// Throws UserError on every rank for unknown groups and contradictions.
  Model(MPI_Comm comm, const mesh::SurfaceMesh& mesh, ModelInput input);
  ~Model();
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;

  [[nodiscard]] MPI_Comm comm() const { return dofs_->comm(); }
  [[nodiscard]] const mesh::SurfaceMesh& mesh() const { return *mesh_; }
  /// Numbering, halo, fixed components, and what needs nothing but these.
  [[nodiscard]] const Dofs& dofs() const { return *dofs_; }
  [[nodiscard]] const energy::Sheet& sheet() const { return *sheet_; }
  [[nodiscard]] const Constraints& constraints() const { return constraints_; }
  /// Contact, or null if the case has none.
  [[nodiscard]] Contact* contact() const { return contact_.get(); }
  /// Changes whenever the tangent gets another pattern of entries.
  [[nodiscard]] int pattern_version() const { return pattern_version_; }
  /// False if follower loads make the tangent unsymmetric.
  [[nodiscard]] bool symmetric() const { return !any_follower_; }

  /// Load factor of all later evaluations; supports go with it if the input says so. Collective.
  void set_load_factor(double factor);
  [[nodiscard]] double load_factor() const { return load_factor_; }
  /// Time of all later evaluations: supports with a motion go where they are then, loads with a history change.
  /// Collective.
  void set_time(double time);
  /// Sets the fixed components of a to their prescribed values. Collective.
  void enforce_supports(Vec a) const;
  /// Supports take hold of what they hold where it is in state a: from now on prescribed displacements and motions count
  /// from there, a change of the load factor from `load_factor`, of the time (or of the load factor in its place) from
  /// `time`. Collective.
  void take_hold(Vec a, double time, double load_factor);

  /// r(a) as above. Collective.
  void residual(Vec a, Vec r);
  /// Internal minus applied forces on every component, fixed ones included: there it is the reaction. Collective.
  void unbalanced_force(Vec a, Vec f);
  /// Norm of the larger of applied forces and reactions of the last residual: what a residual is small against. [N]
  [[nodiscard]] double force_scale() const { return force_scale_; }
  /// From now on bending energies are found by the change since a: K_b u sums stiff forces that nearly cancel, and near
  /// a the differences of energies would be lost in its round-off. Collective.
  void count_energy_from(Vec a);
  /// Stored minus external energy, viscous part of the time step included; only meaningful for a symmetric model.
  /// Collective.
  [[nodiscard]] double energy(Vec a);
  /// The same in parts, without viscosity. Collective.
  [[nodiscard]] Energies energies(Vec a);

  /// Tangent at a. Fixed rows and columns are eliminated. Collective.
  void assemble_tangent(Vec a, const TangentRequest& request);
  /// Tangent at a, with inertia-like shift times the lumped mass on the diagonal. `previous` (may be null) is the
  /// previous iterate for Tangent::linearised_stress. Fixed rows and columns are eliminated. Collective.
  void assemble_tangent(Vec a, Vec previous, energy::Tangent tangent, double shift);
  [[nodiscard]] Mat tangent_matrix() const { return tangent_.mat(); }
  /// Force on the free components by the part of the last tangent that couples them to fixed components which are still
  /// off their prescribed values; null if there is none. To be subtracted from the right-hand side.
  [[nodiscard]] Vec fixed_coupling() const { return has_coupling_ ? static_cast<Vec>(coupling_) : nullptr; }
  /// f = -dr/dlambda at a: how the load grows with the load factor. Where displacements are prescribed it needs the
  /// tangent assembled last, which must be that at a. Collective.
  void load_direction(Vec a, Vec f);
  /// The constant bending stiffness without elimination.
  [[nodiscard]] Mat bending_matrix() const { return bending_.mat(); }
  /// Sum over the materials of their bending damping times their bending stiffness [N s/m], constant, without
  /// elimination; null if no material damps bending.
  [[nodiscard]] Mat damping_matrix() const { return damping_ ? damping_->mat() : nullptr; }

  /// Remembers state a as the start of a time step: viscosity = relaxation time / time step; the materials' own
  /// relaxation times count with inverse_step = 1 / time step. Collective.
  void start_step(Vec a, double viscosity, double inverse_step = 0.0);
  /// The triangles whose elements this rank evaluates, and whether it counts them.
  struct Element {
    Index triangle;
    std::array<Index, 3> points;  ///< local
    bool owned;
  };
  [[nodiscard]] const std::vector<Element>& elements() const { return elements_; }

  /// Lumped mass per unknown: areal density (1 kg/m^2 where the material has none) times a third of the triangles.
  [[nodiscard]] Vec mass() const { return mass_; }
  /// Consistent mass of linear triangles, m/12 (1 + delta_ij) per pair of corners, with the density that each material
  /// has and zero rows and columns where the displacement is fixed. The pattern is the tangent's. Collective.
  [[nodiscard]] BlockMatrix consistent_mass() const;
  [[nodiscard]] double total_area() const { return total_area_; }

  /// Collective; values on rank 0.
  [[nodiscard]] TriangleFields triangle_fields(Vec a);

 private:
  /// Entries of fixed rows and columns, in the value arrays of a matrix.
  struct Eliminated {
    std::vector<Index> diagonal, off_diagonal, unit;
  };
  struct Build;
  /// A term of the potential and the name under which its energy is counted.
  struct Counted {
    std::unique_ptr<Term> term;
    double Energies::*part;
  };

  [[nodiscard]] energy::Configuration configuration(Vec a);
  void add_term_forces(const Term& term, const energy::Configuration& c, Vec f);
  [[nodiscard]] Energies energies_of_step(Vec a);
  void find_coupling(Vec a);
  static void eliminate(const Eliminated& entries, const BlockMatrix::Values& values);

  // Construction, in this order.
  [[nodiscard]] std::vector<char> find_elements(Build& build, const std::vector<Spring>& springs);
  void build_terms(Build& build, const std::vector<Spring>& springs);
  void tie(const Spring& spring, ElementTerm<energy::SpringTerm>& ties) const;
  template <class Kernel>
  ElementTerm<Kernel>& add_term(double Energies::*part);
  [[nodiscard]] BlockPattern make_pattern(const Build& build) const;
  void assemble_bending(Build& build, const std::vector<Spring>& springs);
  void make_vectors();
  [[nodiscard]] Eliminated find_eliminated_entries(const BlockMatrix& matrix) const;
  void build_loads(const std::vector<Load>& loads, const std::vector<PointMass>& masses);
  [[nodiscard]] Vec force_of(const Load& load);
  void add_springs(const std::vector<Spring>& springs, const BlockMatrix::Values& values);
  [[nodiscard]] double spring_energy(Vec a) const;
  void add_follower(const Load& load);
  void build_mass(const std::vector<PointMass>& masses);
  void extend_tangent(BlockPattern pattern);
  void move_supports(double time);
  void turn_clamps(double time);
  void assemble_turning();
  void take_start(const energy::BendingElement& element, bool owned);
  void close_start();
  /// Owned local vertex of a vertex of the mesh, or no_index.
  [[nodiscard]] Index owned(Index v) const {
    const Index i = dofs_->local().local_of[v];
    return i < dofs_->local().owned ? i : no_index;
  }

  const mesh::SurfaceMesh* mesh_;
  int rank_ = 0;
  std::vector<energy::Material> materials_;
  mesh::Partition partition_;
  Constraints constraints_;
  std::unique_ptr<mesh::PatchMesh> patches_;
  std::unique_ptr<energy::Sheet> sheet_;
  std::unique_ptr<Dofs> dofs_;
  std::vector<Vec3> u_, x_, previous_u_, previous_x_, force_;  ///< of the local points

  std::vector<Element> elements_;
  std::vector<Counted> terms_;
  ElementTerm<energy::MembraneTerm>* membrane_ = nullptr;  ///< one of terms_
  ElementTerm<energy::FollowerTerm> followers_;
  bool any_follower_ = false;
  Recovery recovery_;

  BlockMatrix bending_, tangent_;
  std::optional<BlockMatrix> damping_;
  Eliminated eliminated_, base_eliminated_;  ///< of the tangent, and of matrices with the pattern of the elements alone
  std::unique_ptr<Contact> contact_;
  int pattern_version_ = 0;
  std::vector<Slot> mass_slots_;
  petsc::VecHandle mass_, dead_, constant_, work_, sum_, reference_, coupling_, load_coupling_, prescribed_, motion_,
      hold_;
  double reference_bending_ = 0.0;  ///< twice the bending energy of reference_ [J]
  struct Mover {                    ///< an owned vertex whose support moves
    Index local;
    int support;
  };
  std::vector<Support> supports_;
  std::vector<Mover> movers_;
  bool motion_by_load_ = false;
  struct TurningElement {  ///< bending of a triangle whose stencil has a mirror point that turns; local points
    std::vector<Index> points;
    Eigen::MatrixXd stiffness;
    Eigen::MatrixX3d start_force;  ///< empty where the start is bent as the rest shape is
    bool owned;
  };
  std::vector<TurningElement> turning_;
  bool turns_ = false;                                 ///< on some rank there are such elements
  std::vector<Mat3> turns_now_;                        ///< rotation of each support
  BlockMatrix steady_bending_;                         ///< K_b without them
  petsc::VecHandle steady_force_, bending_force_;      ///< f_b without clamps that turn, and all of it [N]
  double steady_offset_ = 0.0, bending_offset_ = 0.0;  ///< twice the constant bending energies at a = 0 [J]
  struct TimedLoad {                                   ///< with a history of its own
    std::function<double(double)> history;
    int factor;  ///< number among the follower term's
    petsc::VecHandle force;
  };
  std::vector<TimedLoad> timed_;
  petsc::VecHandle always_;  ///< the part of constant_ that does not change with time
  struct NodalSpring {
    Index vertex;    ///< owned, local
    Mat3 stiffness;  ///< in the vertex's own axes [N/m]
  };
  std::vector<NodalSpring> springs_;
  bool any_spring_ = false;
  std::vector<std::pair<Index, double>> masses_;  ///< of owned vertices, besides the sheet's [kg]
  bool has_coupling_ = false, has_prescribed_ = false;
  double load_factor_ = 0.0, force_scale_ = 0.0, total_area_ = 0.0;
};

}  // namespace voile::system
