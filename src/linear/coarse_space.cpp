#include "coarse_space.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "base/petsc.hpp"
#include "block_rows.hpp"
#include "mesh/partition.hpp"

namespace voile::linear {

namespace {

using Block = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>, 0, Eigen::OuterStride<>>;
using Kept = Eigen::Map<Eigen::Matrix3d>;
using Stored = Eigen::Map<const Eigen::Matrix3f>;
using Eigen::Vector3d;

}  // namespace

void CoarseSpace::find_parts(Mat a) {
  Mat inside = a, outside = nullptr;
  PetscBool sequential = PETSC_FALSE;
  VOILE_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(a), MATSEQAIJ, &sequential));
  if (!sequential) VOILE_PETSC(MatMPIAIJGetSeqAIJ(a, &inside, &outside, &ghost_columns_));
  parts_.assign(1, {inside, nullptr, nullptr, 0});
  if (outside) parts_.push_back({outside, nullptr, nullptr, block_rows_});
  for (Part& p : parts_) VOILE_PETSC(MatSeqAIJGetCSRAndMemType(p.mat, &p.starts, &p.columns, nullptr, nullptr));
}

bool CoarseSpace::has_full_blocks() const {
  bool good = true;
  for (const Part& p : parts_)
    for (int i = 0; i < block_rows_; ++i) good = good && is_block_row(p.starts, p.columns, i);
  return mpi::max(comm_, good ? 0.0 : 1.0) == 0.0;
}

void CoarseSpace::number_aggregates(int wanted) {
  const auto all = static_cast<double>(mpi::sum(comm_, static_cast<long>(block_rows_)));
  const int own =
      std::clamp(static_cast<int>(std::lround(wanted * (block_rows_ / all))), std::min(1, block_rows_), block_rows_);
  std::vector<int> start{0}, adjacent;
  for (int i = 0; i < block_rows_; ++i) {
    const Part& p = parts_[0];
    for (int at = p.starts[3 * i]; at < p.starts[3 * i + 1]; at += 3)
      if (p.columns[at] != 3 * i) adjacent.push_back(p.columns[at] / 3);
    start.push_back(static_cast<int>(adjacent.size()));
  }
  aggregate_ = own > 0 ? mesh::divide_graph(std::move(start), std::move(adjacent), own) : std::vector<int>{};
  std::vector<int> number(static_cast<std::size_t>(own), 0);
  for (const int part : aggregate_) number[part] = 1;
  int used = 0;
  for (int& n : number) n = n > 0 ? used++ : -1;
  int before = 0;
  aggregates_ = 0;
  const auto counts = mpi::gather_to_all(comm_, {static_cast<double>(used)});
  for (int r = 0; r < static_cast<int>(counts.size()); ++r) {
    if (r < mpi::rank(comm_)) before += static_cast<int>(counts[r][0]);
    aggregates_ += static_cast<int>(counts[r][0]);
  }
  for (int& part : aggregate_) part = before + number[part];
}

void CoarseSpace::find_fractions(const std::vector<int>& aggregate) {
  fractions_.assign(aggregate.size(), {});
  for (int i = 0; i < block_rows_; ++i) {
    std::map<int, double> around;
    for (const Part& p : parts_)
      for (int at = p.starts[3 * i]; at < p.starts[3 * i + 1]; at += 3)
        around[aggregate[p.first_column + p.columns[at] / 3]] += 1.0;
    std::vector<std::pair<double, int>> found;
    for (const auto& [which, count] : around) found.emplace_back(-count, which);
    std::sort(found.begin(), found.end());
    if (static_cast<int>(found.size()) > most) found.resize(most);
    double all = 0.0;
    for (const auto& [count, which] : found) all += count;
    for (std::size_t k = 0; k < found.size(); ++k) {
      fractions_[i].aggregate[k] = found[k].second;
      fractions_[i].fraction[k] = found[k].first / all;
    }
  }
}

void CoarseSpace::find_targets() {
  slot_starts_.assign(1, 0);
  slots_.clear();
  target_starts_.assign(1, 0);
  targets_.clear();
  int longest = 0;
  for (int i = 0; i < block_rows_; ++i) {
    const auto first = static_cast<std::ptrdiff_t>(slots_.size());
    for (const Part& p : parts_)
      for (int at = p.starts[3 * i]; at < p.starts[3 * i + 1]; at += 3) {
        const Shares& s = fractions_[p.first_column + p.columns[at] / 3];
        for (int k = 0; k < most; ++k) {
          if (s.fraction[k] == 0.0) continue;
          const auto place = std::find(slots_.begin() + first, slots_.end(), s.aggregate[k]);
          targets_.push_back({static_cast<int>(place - slots_.begin() - first), s.fraction[k]});
          if (place == slots_.end()) slots_.push_back(s.aggregate[k]);
        }
        target_starts_.push_back(static_cast<int>(targets_.size()));
      }
    slot_starts_.push_back(static_cast<int>(slots_.size()));
    longest = std::max(longest, slot_starts_[i + 1] - slot_starts_[i]);
  }
  az_.assign(9 * slots_.size(), 0.0F);
  row_.assign(9 * static_cast<std::size_t>(longest), 0.0);
}

bool CoarseSpace::read_pattern(Mat a, int aggregates) {
  static_assert(most == 3, "parts are sent like the coordinates of vertices");
  comm_ = PetscObjectComm(reinterpret_cast<PetscObject>(a));
  PetscInt rows = 0;
  VOILE_PETSC(MatGetLocalSize(a, &rows, nullptr));
  block_rows_ = rows / 3;
  find_parts(a);
  if (!has_full_blocks()) return false;
  number_aggregates(aggregates);
  GhostColumns ghosts;
  petsc::VecHandle own;
  VOILE_PETSC(MatCreateVecs(a, own.out(), nullptr));
  if (parts_.size() > 1) ghosts.read(a, parts_[1].mat, ghost_columns_);
  const auto of_others = [&](auto&& value) -> std::vector<double> {
    if (parts_.size() == 1) return {};
    {
      const petsc::WriteArray to(own);
      for (int i = 0; i < block_rows_; ++i)
        for (int k = 0; k < most; ++k) to[most * i + k] = value(i, k);
    }
    ghosts.begin(own);
    ghosts.end(own);
    PetscInt count = 0;
    VOILE_PETSC(VecGetLocalSize(ghosts.values, &count));
    const petsc::ReadArray from(ghosts.values);
    return {from.data(), from.data() + count};
  };
  std::vector<int> aggregate = aggregate_;
  const std::vector<double> others = of_others([&](int i, int) { return aggregate_[i]; });
  for (std::size_t i = 0; i < others.size(); i += most) aggregate.push_back(static_cast<int>(others[i]));
  find_fractions(aggregate);
  const std::vector<double> which = of_others([&](int i, int k) { return fractions_[i].aggregate[k]; });
  const std::vector<double> fractions = of_others([&](int i, int k) { return fractions_[i].fraction[k]; });
  for (std::size_t at = 0; at < which.size(); ++at) {
    Shares& s = fractions_[block_rows_ + at / most];
    s.aggregate[at % most] = static_cast<int>(which[at]);
    s.fraction[at % most] = fractions[at];
  }
  find_targets();
  e_.assign(9 * static_cast<std::size_t>(aggregates_) * aggregates_, 0.0);
  for (auto* v : {&y_, &c_, &d_}) v->assign(3 * static_cast<std::size_t>(aggregates_), 0.0);
  return true;
}

std::size_t CoarseSpace::sum_row(int i, const std::array<const double*, 2>& values, std::size_t block) {
  std::fill_n(row_.begin(), 9 * (slot_starts_[i + 1] - slot_starts_[i]), 0.0);
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const int first = parts_[p].starts[3 * i], stride = parts_[p].starts[3 * i + 1] - first;
    for (int at = first; at < first + stride; at += 3, ++block) {
      const Block entries(values[p] + at, Eigen::OuterStride<>(stride));
      for (int t = target_starts_[block]; t < target_starts_[block + 1]; ++t)
        Kept(row_.data() + 9 * targets_[t].slot) += targets_[t].fraction * entries;
    }
  }
  return block;
}

bool CoarseSpace::take(Mat a) {
  find_parts(a);
  std::array<const double*, 2> values{};
  for (std::size_t p = 0; p < parts_.size(); ++p) VOILE_PETSC(MatSeqAIJGetArrayRead(parts_[p].mat, &values[p]));
  const int n = 3 * aggregates_;
  std::fill(e_.begin(), e_.end(), 0.0);
  Eigen::Map<Eigen::MatrixXd> e(e_.data(), n, n);
  std::size_t blocks = 0;
  for (int i = 0; i < block_rows_; ++i) {
    const int begin = slot_starts_[i], count = slot_starts_[i + 1] - begin;
    blocks = sum_row(i, values, blocks);
    for (int s = 0; s < count; ++s) {
      const Kept block(row_.data() + 9 * s);
      Eigen::Map<Eigen::Matrix3f>(az_.data() + 9 * static_cast<std::size_t>(begin + s)) = block.cast<float>();
      for (int k = 0; k < most && fractions_[i].fraction[k] != 0.0; ++k)
        e.block<3, 3>(3 * fractions_[i].aggregate[k], 3 * slots_[begin + s]) += fractions_[i].fraction[k] * block;
    }
  }
  for (std::size_t p = 0; p < parts_.size(); ++p) VOILE_PETSC(MatSeqAIJRestoreArrayRead(parts_[p].mat, &values[p]));
  mpi::sum(comm_, e_);
  for (int i = 0; i < n; ++i)
    if (e(i, i) == 0.0) e(i, i) = 1.0;  // of an aggregate that has lost all its fractions to others
  factor_.compute(e);
  return factor_.info() == Eigen::Success;
}

void CoarseSpace::solve_coarse(const std::vector<double>& y, std::vector<double>& c) const {
  Eigen::Map<Eigen::VectorXd> to(c.data(), static_cast<Eigen::Index>(c.size()));
  to = Eigen::Map<const Eigen::VectorXd>(y.data(), to.size());
  factor_.solveInPlace(to);
}

void CoarseSpace::project(const double* b, double* r) {
  std::fill(y_.begin(), y_.end(), 0.0);
  for (int i = 0; i < block_rows_; ++i)
    for (int k = 0; k < most; ++k)
      Eigen::Map<Vector3d>(y_.data() + 3 * fractions_[i].aggregate[k]) +=
          fractions_[i].fraction[k] * Eigen::Map<const Vector3d>(b + 3 * i);
  mpi::sum(comm_, y_);
  solve_coarse(y_, c_);
  for (int i = 0; i < block_rows_; ++i) {
    Vector3d left = Eigen::Map<const Vector3d>(b + 3 * i);
    for (int at = slot_starts_[i]; at < slot_starts_[i + 1]; ++at)
      left.noalias() -= Stored(az_.data() + 9 * static_cast<std::size_t>(at)).cast<double>() *
                        Eigen::Map<const Vector3d>(c_.data() + 3 * slots_[at]);
    Eigen::Map<Vector3d>(r + 3 * i) = left;
  }
}

void CoarseSpace::correct(double* x) {
  std::fill(y_.begin(), y_.end(), 0.0);
  for (int i = 0; i < block_rows_; ++i) {
    const Vector3d part = Eigen::Map<const Vector3d>(x + 3 * i);
    for (int at = slot_starts_[i]; at < slot_starts_[i + 1]; ++at)
      Eigen::Map<Vector3d>(y_.data() + 3 * slots_[at]).noalias() +=
          Stored(az_.data() + 9 * static_cast<std::size_t>(at)).cast<double>().transpose() * part;
  }
  mpi::sum(comm_, y_);
  solve_coarse(y_, d_);
  for (std::size_t i = 0; i < d_.size(); ++i) d_[i] = c_[i] - d_[i];
  for (int i = 0; i < block_rows_; ++i)
    for (int k = 0; k < most; ++k)
      Eigen::Map<Vector3d>(x + 3 * i) +=
          fractions_[i].fraction[k] * Eigen::Map<const Vector3d>(d_.data() + 3 * fractions_[i].aggregate[k]);
}

}  // namespace voile::linear
