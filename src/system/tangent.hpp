// The tangent of a model: a matrix whose fixed rows and columns are eliminated, and what these couple to.
#pragma once

#include <vector>

#include "base/petsc.hpp"
#include "block_matrix.hpp"
#include "discretisation.hpp"
#include "energy/term.hpp"
#include "low_rank.hpp"

namespace voile::system {

class Term;

/// What a tangent is made of besides the membrane and the follower loads.
struct TangentRequest {
  energy::Tangent kind = energy::Tangent::exact;
  Vec previous = nullptr;                    ///< x_k of energy::Tangent; may be null
  double bending = 1.0;                      ///< factor on the constant bending stiffness
  double damping = 0.0;                      ///< factor on the materials' own damping of bending [1/s]
  double mass = 0.0;                         ///< factor on the mass [1/s^2]
  const BlockMatrix* mass_matrix = nullptr;  ///< consistent mass; null: the lumped one
  Vec masses = nullptr;                      ///< lumped masses instead of the model's, per unknown [kg]; may be null
  Term* extra = nullptr;                     ///< one more term, at the same configuration; null: none
  bool exact_contact = false;                ///< contact with its negative eigenvalues
  bool loads = true;                         ///< with what loads that turn with the sheet or a body change by
};

/// Entries of fixed rows and columns, in the value arrays of a matrix.
struct Eliminated {
  std::vector<Index> diagonal, off_diagonal, unit;
  void apply(const BlockMatrix::Values& values) const;
};
[[nodiscard]] Eliminated find_eliminated(const Discretisation& on, const BlockMatrix& matrix);

class Tangent {
 public:
  Tangent() = default;
  /// With the pattern of `base`, a matrix that lives as long. Collective.
  Tangent(const Discretisation& on, const BlockMatrix& base);

  /// Without what gases add besides.
  [[nodiscard]] Mat matrix() const { return matrix_.mat(); }
  /// That: the tangent is their sum.
  [[nodiscard]] const LowRankChange& change() const { return change_; }
  /// y = (matrix + change) x. Collective.
  void multiply(Vec x, Vec y) const;
  /// Changes whenever the matrix gets another pattern of entries.
  [[nodiscard]] int pattern_version() const { return pattern_version_; }
  /// Force on the free components by the part that couples them to fixed components which are still off their prescribed
  /// values; null if there is none. To be subtracted from the right-hand side.
  [[nodiscard]] Vec fixed_coupling() const { return has_coupling_ ? static_cast<Vec>(coupling_) : nullptr; }

  // For the model, which fills it
  [[nodiscard]] BlockMatrix& blocks() { return matrix_; }
  [[nodiscard]] LowRankChange& change() { return change_; }
  [[nodiscard]] const BlockMatrix& blocks() const { return matrix_; }
  /// Gives it a pattern that holds that of the base. Collective.
  void extend(const BlockMatrix& base, BlockPattern pattern);
  /// Adds a factor times lumped masses, one per unknown.
  void add_mass(const BlockMatrix::Values& values, Vec mass, double factor) const;
  /// Eliminates what is fixed, in the change too, and closes. If something is prescribed, `off` (its own components, zero elsewhere) and
  /// `prescribed` are coupled to the free components first. Collective.
  void close(const BlockMatrix::Values& values, Vec off, Vec prescribed);
  /// Coupling to what is prescribed at a load factor of 1.
  [[nodiscard]] Vec load_coupling() const { return load_coupling_; }

 private:
  const Discretisation* on_ = nullptr;
  BlockMatrix matrix_;
  LowRankChange change_;
  Eliminated eliminated_;
  std::vector<Slot> mass_slots_;
  petsc::VecHandle coupling_, load_coupling_;
  bool has_coupling_ = false;
  int pattern_version_ = 0;
};

}  // namespace voile::system
