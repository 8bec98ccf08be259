// Upper blocks of the tangent of the element kernels, nine numbers each in one array, before they go into the matrix.
//
// A kernel adds a block of two points once, where the whole matrix would take it twice in rows that lie apart; what comes first in
// local numbering, in which a rank's own vertices precede the others, is the row. Triangles with mirror points or vertices with axes
// of their own have blocks to themselves, which are passed on to the unknowns that they depend on.
#pragma once

#include <vector>

#include "voile/system/block_matrix.hpp"
#include "voile/system/dofs.hpp"

namespace voile::system {

class HalfBlocks {
 public:
  HalfBlocks() = default;
  /// The pattern of `base`, which is that of a tangent without contact.
  HalfBlocks(const Dofs& dofs, const BlockMatrix& base);

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
  /// Adds the blocks to the open values of `matrix`, the base or an extension of it, whose pattern has this number.
  void add_to(const Dofs& dofs, const BlockMatrix& matrix, int pattern, const BlockMatrix::Values& values);

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
  [[nodiscard]] Index place_of(Index a, Index b) const;
  [[nodiscard]] Index place_alone(Index a, Index b, bool diagonal);
  void locate(const Dofs& dofs, const BlockMatrix& matrix);

  const Dofs* dofs_ = nullptr;
  const BlockMatrix* base_ = nullptr;
  struct Pair {
    Index a, b;  ///< own block row, global block column
  };
  std::vector<Pair> pairs_;       ///< of the upper blocks
  std::vector<std::size_t> row_;  ///< first block of the base in each row
  std::vector<Index> number_;     ///< of the upper block, for each block of the base; no_index: lower
  struct Alone {
    Index a, b;  ///< local points, ascending
    bool diagonal;
  };
  std::vector<Alone> alone_;  ///< the blocks after them
  Index none_ = 0;            ///< between both
  std::vector<double> values_;
  struct Places {
    Slot upper, lower;  ///< lower: stride 0 on the diagonal and where the row is another rank's
  };
  std::vector<Places> places_;
  int located_ = -1;  ///< number of the pattern that the places belong to
};

}  // namespace voile::system
