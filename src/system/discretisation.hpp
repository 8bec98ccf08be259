// The mesh of one model made discrete: patches, materials, supports and unknowns, divided over the ranks.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "conditions.hpp"
#include "constraints.hpp"
#include "dofs.hpp"
#include "energy/element_options.hpp"
#include "energy/material.hpp"
#include "mesh/partition.hpp"
#include "seam_rules.hpp"

namespace voile::energy {
struct Bulge;
class CurvatureBuilder;
struct CurvatureOperator;
struct JointElement;
class Sheet;
}  // namespace voile::energy

namespace voile::mesh {
class PatchMesh;
}  // namespace voile::mesh

namespace voile::system {

struct HingedEdge;

class Discretisation {
 public:
  /// What couples vertices besides the sheet, and whose borders part its strains.
  struct Couplings {
    const std::vector<Spring>& springs;
    const std::vector<Hinge>& hinges;
    const std::vector<Temperature>& temperatures;
  };
  /// A triangle whose elements this rank evaluates.
  struct Element {
    Index triangle;
    std::array<Index, 3> points;  ///< local
    bool owned;                   ///< this rank counts its energy
  };

  /// Collective; the mesh must be the same on all ranks and outlive it. Throws UserError on every rank for unknown groups
  /// and contradictions.
  Discretisation(MPI_Comm comm, const mesh::SurfaceMesh& mesh, std::vector<energy::Material> materials,
                 const std::vector<Support>& supports, const Couplings& couplings,
                 const energy::ElementOptions& options, const Seams& seams = {},
                 const std::vector<RigidGroup>& rigid = {}, const std::vector<PeriodicPair>& periodic = {});
  ~Discretisation();
  Discretisation(const Discretisation&) = delete;
  Discretisation& operator=(const Discretisation&) = delete;

  [[nodiscard]] MPI_Comm comm() const { return dofs_->comm(); }
  [[nodiscard]] const mesh::SurfaceMesh& mesh() const { return *mesh_; }
  [[nodiscard]] const mesh::Partition& partition() const { return partition_; }
  /// Of a periodic sheet those of the continued surface (ties.hpp).
  [[nodiscard]] const mesh::PatchMesh& patches() const { return *patches_; }
  /// Seams that are gathered: if any, the sheet has another rest shape than the mesh, which is as it is cut.
  [[nodiscard]] const std::vector<std::string>& gathered_seams() const { return drawn_in_.seams; }
  /// With the rest shape from which open seams are drawn in: that of the sheet if there are none.
  [[nodiscard]] const mesh::PatchMesh& patches_before() const {
    return before_.patches ? *before_.patches : draws_in_ ? *patches_ : sheet_patches();
  }
  /// Whether that is another one than the sheet's.
  [[nodiscard]] bool draws_in() const { return draws_in_; }
  [[nodiscard]] const energy::Sheet& sheet() const { return *sheet_; }
  /// The sheet with what it continues to where it is periodic: for elements, whose neighbours may lie there.
  [[nodiscard]] const energy::Sheet& element_sheet() const { return continued_ ? *continued_ : *sheet_; }
  /// Those given, and more for triangles with allowances of seams.
  [[nodiscard]] const std::vector<energy::Material>& materials() const { return materials_; }
  [[nodiscard]] const Constraints& constraints() const { return constraints_; }
  /// Numbering, halo, fixed components.
  [[nodiscard]] const Dofs& dofs() const { return *dofs_; }
  [[nodiscard]] const std::vector<Element>& elements() const { return elements_; }
  [[nodiscard]] bool owns(Index triangle) const { return partition_.triangle_rank[triangle] == rank_; }
  /// Owned local vertex of a vertex of the mesh, or no_index.
  [[nodiscard]] Index owned(Index v) const {
    const Index i = dofs_->local().local_of[v];
    return i < dofs_->local().owned ? i : no_index;
  }
  /// Vertices whose unknowns mesh points depend on, ascending; points may be of the frames of rigid bodies.
  [[nodiscard]] std::vector<Index> unknowns_of(const std::vector<Index>& points) const;
  /// Whether this rank has rows of unknowns that any of these mesh points depends on.
  [[nodiscard]] bool has_rows_of(const std::vector<Index>& points) const { return touches(unknowns_of(points)); }
  /// Whether a rigid body has a vertex among these points.
  [[nodiscard]] bool is_on_body(const std::vector<Index>& points) const;
  /// Mean rest area of a triangle [m^2].
  [[nodiscard]] double mean_area() const;
  /// Turns the mirror points of clamps: the rotation of each support, by number. Not collective.
  void turn_mirrors(const std::vector<Mat3>& rotation) { dofs_->turn_mirrors(rotation); }
  /// What elements()[k] encloses beyond its plane, its corners in this order, in local points. Before take_curvatures().
  [[nodiscard]] energy::Bulge bulge(std::size_t k, const mesh::Triangle& corners) const;
  /// Gives away the curvature operators of elements(), which only the construction of a model needs.
  [[nodiscard]] std::vector<energy::CurvatureOperator> take_curvatures();
  /// Joints of sheets whose springs this rank evaluates, and which of them it counts.
  struct Joints {
    std::vector<energy::JointElement> elements;
    std::vector<char> owned;
  };
  /// Likewise.
  [[nodiscard]] Joints take_joints();

 private:
  /// The same mesh and mirror points with the rest shape of gathered fabric.
  struct GatheredSheet {
    std::vector<std::string> seams;
    std::unique_ptr<mesh::SurfaceMesh> mesh;
    std::unique_ptr<mesh::PatchMesh> patches;
  };
  [[nodiscard]] GatheredSheet gathered_sheet(const std::vector<mesh::Gather>& seams) const;
  [[nodiscard]] const mesh::PatchMesh& sheet_patches() const {
    return drawn_in_.patches ? *drawn_in_.patches : own_patches_ ? *own_patches_ : *patches_;
  }
  [[nodiscard]] std::vector<char> find_elements(const Couplings& couplings);
  void find_joints(energy::CurvatureBuilder& curvature, const std::map<Index, HingedEdge>& hinges,
                   const std::vector<char>& candidate, std::vector<char>& needed);
  void find_grounded_slopes(energy::CurvatureBuilder& curvature, const std::map<Index, HingedEdge>& hinges,
                            const std::vector<char>& candidate, std::vector<char>& needed);
  void require_free(const mesh::Segment& edge, const mesh::TriangleSide& side) const;
  void add_joint(energy::JointElement element, bool is_owned, std::vector<char>& needed);
  void find_rigid_slopes(energy::CurvatureBuilder& curvature, std::vector<char>& needed);
  void prepare_bodies(const std::vector<RigidGroup>& rigid);
  /// Patches and sheets of a mesh, and of what continues it.
  void make_patches();
  void find_notches();
  void continue_sheet(const energy::ElementOptions& options, const std::vector<Temperature>& temperatures);
  [[nodiscard]] std::vector<int> holders() const;
  void need(const std::vector<Index>& points, std::vector<char>& needed) const;
  [[nodiscard]] bool owns_vertex(Index v) const { return partition_.vertex_rank[v] == rank_; }
  [[nodiscard]] bool touches(const std::vector<Index>& vertices) const;

  const mesh::SurfaceMesh* mesh_;
  int rank_;
  std::vector<energy::Material> materials_;
  mesh::Partition partition_;
  Constraints constraints_;
  std::vector<Index> body_of_;  ///< per vertex: rigid body, or no_index; empty: there are none
  std::unique_ptr<mesh::PatchMesh> patches_;
  std::vector<double> joint_factors_;  ///< of the bending energy of each joint of the mesh
  GatheredSheet drawn_in_, before_;    ///< without patches: as it is cut
  bool draws_in_ = false;
  std::unique_ptr<energy::Sheet> sheet_;
  std::unique_ptr<mesh::PatchMesh> own_patches_;  ///< of a periodic sheet: those of the mesh alone
  std::unique_ptr<energy::Sheet> continued_;
  std::unique_ptr<Dofs> dofs_;
  std::vector<Element> elements_;
  std::vector<energy::CurvatureOperator> curvatures_;
  Joints joints_;
};

/// Vertices whose unknowns a set of mesh points depends on, ascending.
[[nodiscard]] std::vector<Index> vertices_of(const mesh::PatchMesh& patches, const std::vector<Index>& points);
/// Points of all elements of a triangle: the bending stencil and the membrane's.
[[nodiscard]] std::vector<Index> stencil_points(const energy::Sheet& sheet, Index t,
                                                const energy::CurvatureOperator& op);

}  // namespace voile::system
