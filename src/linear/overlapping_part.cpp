#include "overlapping_part.hpp"

#include <algorithm>

namespace voile::linear {

namespace {

/// A sequential matrix, whose values are read as long as this lives.
struct Rows {
  Mat mat;
  const int *starts = nullptr, *columns = nullptr;
  const double* values = nullptr;
  explicit Rows(Mat m) : mat(m) {
    VOILE_PETSC(MatSeqAIJGetCSRAndMemType(mat, &starts, &columns, nullptr, nullptr));
    VOILE_PETSC(MatSeqAIJGetArrayRead(mat, &values));
  }
  ~Rows() { (void)MatSeqAIJRestoreArrayRead(mat, &values); }
  Rows(const Rows&) = delete;
  Rows& operator=(const Rows&) = delete;
};

/// The three that A_p is put together from.
struct Sources {
  Rows inside, outside, others;
  static Mat part(Mat a, bool own) {
    Mat of_own = nullptr, of_others = nullptr;
    VOILE_PETSC(MatMPIAIJGetSeqAIJ(a, &of_own, &of_others, nullptr));
    return own ? of_own : of_others;
  }
  Sources(Mat a, Mat rows_of_others) : inside(part(a, true)), outside(part(a, false)), others(rows_of_others) {}
};

/// Adds the blocks of row i of `outside` whose columns, the `before` first of which precede the rank's `own`, are on that side.
void add_outside(BlockPattern& pattern, const Rows& outside, int i, int before, int own, bool preceding) {
  const int begin = outside.starts[3 * i], stride = outside.starts[3 * i + 1] - begin;
  for (int at = begin; at < begin + stride; at += 3) {
    const int column = outside.columns[at] / 3;
    if ((column < before) != preceding) continue;
    pattern.columns.push_back(column + (preceding ? 0 : own));
    pattern.places.push_back({1, at, stride});
  }
}

}  // namespace

void OverlappingPart::fetch_rows_of_others(Mat a, MatReuse reuse) {
  IS rows = others_, columns = all_;
  Mat* matrices = rows_of_others_.release();
  VOILE_PETSC(MatCreateSubMatrices(a, 1, &rows, &columns, reuse, &matrices));
  rows_of_others_.reset(matrices);
}

BlockPattern OverlappingPart::read_pattern(Mat a) {
  Mat of_others = nullptr;
  const PetscInt* ghosts = nullptr;
  PetscInt begin = 0, end = 0;
  VOILE_PETSC(MatMPIAIJGetSeqAIJ(a, nullptr, &of_others, &ghosts));
  VOILE_PETSC(MatGetOwnershipRange(a, &begin, &end));
  VOILE_PETSC(MatGetLocalSize(of_others, nullptr, &ghosts_count_));
  own_ = end - begin;
  before_ = static_cast<int>(std::lower_bound(ghosts, ghosts + ghosts_count_, begin) - ghosts);
  std::vector<PetscInt> all(ghosts, ghosts + before_);
  for (PetscInt row = begin; row < end; ++row) all.push_back(row);
  all.insert(all.end(), ghosts + before_, ghosts + ghosts_count_);
  VOILE_PETSC(ISCreateGeneral(PETSC_COMM_SELF, ghosts_count_, ghosts, PETSC_COPY_VALUES, others_.out()));
  VOILE_PETSC(
      ISCreateGeneral(PETSC_COMM_SELF, static_cast<PetscInt>(all.size()), all.data(), PETSC_COPY_VALUES, all_.out()));
  rows_of_others_.reset();
  fetch_rows_of_others(a, MAT_INITIAL_MATRIX);
  ghosts_.read(a, of_others, ghosts);
  v_.assign(all.size(), 0.0);

  BlockPattern pattern;
  pattern.full = own_ % 3 == 0 && before_ % 3 == 0 && ghosts_count_ % 3 == 0;
  if (!pattern.full) return pattern;
  const Sources from(a, *rows_of_others_);
  pattern.reserve((own_ + ghosts_count_) / 3,
                  (from.inside.starts[own_] + from.outside.starts[own_] + from.others.starts[ghosts_count_]) / 9);
  const auto add_others = [&](int first, int last) {
    for (int i = first; i < last; ++i, pattern.end_row()) pattern.add(2, from.others.starts, from.others.columns, i);
  };
  add_others(0, before_ / 3);
  for (int i = 0; i < own_ / 3; ++i, pattern.end_row()) {
    pattern.full = pattern.full && is_block_row(from.outside.starts, from.outside.columns, i);
    if (!pattern.full) return pattern;
    add_outside(pattern, from.outside, i, before_ / 3, own_ / 3, true);
    pattern.add(0, from.inside.starts, from.inside.columns, i, before_ / 3);
    add_outside(pattern, from.outside, i, before_ / 3, own_ / 3, false);
  }
  add_others(before_ / 3, ghosts_count_ / 3);
  return pattern;
}

void OverlappingPart::take(Mat a, const std::function<void(const BlockPattern::Values&)>& use) {
  fetch_rows_of_others(a, MAT_REUSE_MATRIX);
  const Sources from(a, *rows_of_others_);
  use({from.inside.values, from.outside.values, from.others.values});
}

double* OverlappingPart::restricted(Vec b) {
  ghosts_.begin(b);
  {
    const petsc::ReadArray from(b);
    std::copy_n(from.data(), own_, v_.begin() + before_);
  }
  ghosts_.end(b);
  const petsc::ReadArray from(ghosts_.values);
  std::copy_n(from.data(), before_, v_.begin());
  std::copy(from.data() + before_, from.data() + ghosts_count_, v_.begin() + before_ + own_);
  return v_.data();
}

void OverlappingPart::add_up(Vec x) {
  {
    const petsc::WriteArray to(ghosts_.values), own(x);
    std::copy_n(v_.begin(), before_, to.data());
    std::copy(v_.begin() + before_ + own_, v_.end(), to.data() + before_);
    std::copy_n(v_.begin() + before_, own_, own.data());
  }
  ghosts_.add(x);
}

}  // namespace voile::linear
