// Upper blocks of the tangent of the element kernels, nine numbers each in one array, before they go into the matrix.
//
// A kernel adds a block of two points once, where the whole matrix would take it twice in rows that lie apart; what comes first in
// local numbering, in which a rank's own vertices precede the others, is the row. Triangles with mirror points or vertices with axes
// of their own have blocks to themselves, which are passed on to the unknowns that they depend on.
#pragma once

#include <vector>

#include "block_matrix.hpp"
#include "compact_matrix.hpp"
#include "dofs.hpp"

namespace voile::system {

class HalfBlocks {
 public:
  HalfBlocks() = default;
  /// `base` has the pattern of a tangent without contact. Every element asks twice for its places: before end_counting(), so that only
  /// blocks that are needed are stored, and after it.
  HalfBlocks(const Dofs& dofs, const BlockMatrix& base);
  void end_counting();

  /// Where the blocks of the pairs i <= j of an element's points go to, row by row, which it has to itself if that is necessary.
  /// depends_on(i): whether the element has numbers for point i; where not, a point may be there twice.
  template <class DependsOn>
  [[nodiscard]] std::vector<Index> places_of(const Index* points, int count, DependsOn&& depends_on) {
    const bool special = is_special(points, count, depends_on);
    std::vector<Index> places;
    for (int i = 0; i < count; ++i)
      for (int j = i; j < count; ++j)
        places.push_back(!depends_on(i) || !depends_on(j) ? none_
                         : special                        ? place_alone(points[i], points[j], i == j)
                                                          : place_of(points[i], points[j]));
    return places;
  }
  /// Takes what goes nowhere.
  [[nodiscard]] Index none() const { return none_; }

  /// Sets all blocks to zero and gives their array.
  [[nodiscard]] double* open();
  /// Overwrites the open values of `matrix`, the base or an extension of it, with the blocks and factor K.
  void write_to(const BlockMatrix& matrix, const BlockMatrix::Values& values, const CompactMatrix& k,
                double factor) const;

 private:
  template <class DependsOn>
  [[nodiscard]] bool is_special(const Index* points, int count, DependsOn& depends_on) const {
    for (int i = 0; i < count; ++i) {
      if (!depends_on(i)) continue;
      if (!dofs_->is_plain(points[i])) return true;
      for (int j = 0; j < i; ++j)
        if (points[j] == points[i] && depends_on(j)) return true;
    }
    return false;
  }
  [[nodiscard]] std::size_t block_of(Index row, Index column) const;
  [[nodiscard]] Index place_of(Index a, Index b);
  [[nodiscard]] Index place_alone(Index a, Index b, bool diagonal);

  const Dofs* dofs_ = nullptr;
  const BlockMatrix* base_ = nullptr;
  std::vector<std::size_t> row_;  ///< first block of the base in each row
  /// For each block of the base the number of its upper block, unused, or turned(number) where that is its transpose.
  std::vector<Index> source_;
  static constexpr Index unused = -1;
  [[nodiscard]] static Index turned(Index number) { return -2 - number; }
  struct Alone {
    Index a, b;  ///< local points, ascending
    bool diagonal;
  };
  std::vector<Alone> alone_;  ///< the blocks after those
  Index none_ = 0;            ///< between both
  bool counting_ = true;
  std::vector<double> values_;
};

}  // namespace voile::system
