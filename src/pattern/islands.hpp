// Pieces as a mesh with texture coordinates draws them; private to src/pattern.
//
// Faces that have an edge and its texture coordinates in common belong to one island. Its rims begin edges where they turn.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "mesh/surface_mesh.hpp"
#include "sewn_rims.hpp"

namespace voile::pattern {

/// A connected part of the mesh in the plane.
struct Island {
  std::vector<Index> triangles;         ///< of the file
  std::vector<Index> vertices;          ///< of the file, one for each point
  std::vector<Vec2> points;             ///< [m]
  std::vector<mesh::Triangle> corners;  ///< points of each triangle
  bool is_turned = false;               ///< its faces go round clockwise
};

class DrawnMesh {
 public:
  /// Texture in metres. `same`: distance within which texture coordinates are the same [m]; `unit`: length of 1 of them in
  /// the file, for messages [m]. Keeps a reference to the mesh.
  DrawnMesh(std::string file, const mesh::MeshData& mesh, double same, double unit)
      : file_(std::move(file)), mesh_(mesh), same_(same), unit_(unit) {}

  /// In the order of their first faces. Throws UserError where one folds over.
  [[nodiscard]] std::vector<Island> islands() const;
  /// All rims, island by island, with their corners as breaks. Throws UserError where an island overlaps or touches itself.
  [[nodiscard]] std::vector<Rim> rims(const std::vector<Island>& islands) const;

 private:
  /// A side of a triangle.
  struct Side {
    Index triangle;
    std::size_t corner;
  };

  [[noreturn]] void fail(Index triangle, const Vec2& place, const char* what, const char* remedy) const;
  [[nodiscard]] const mesh::Triangle& triangle(Index t) const { return mesh_.triangles[static_cast<std::size_t>(t)]; }
  [[nodiscard]] const Vec2& texture(Index t, std::size_t i) const {
    return mesh_.texture[static_cast<std::size_t>(t)][i % 3];
  }
  [[nodiscard]] bool is_same(const Vec2& a, const Vec2& b) const { return (a - b).norm() <= same_; }
  [[nodiscard]] bool joins(const Side& a, const Side& b) const;
  void add_points(Island& island) const;
  void orient(Island& island) const;
  [[nodiscard]] std::map<Index, Index> rim_steps(const Island& island) const;
  [[nodiscard]] Rim rim_of(std::size_t k, const Island& island, std::vector<Index> way) const;

  std::string file_;
  const mesh::MeshData& mesh_;
  double same_, unit_;
};

}  // namespace voile::pattern
