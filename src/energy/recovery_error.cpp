#include "recovery_error.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace voile::energy {

namespace {

using Complex = std::complex<double>;

/// Holds gradients back where triangles do not determine them, as a fraction of their weights.
constexpr double ridge = 1e-6;
/// By how much the lengths of two sides of a seam may differ.
constexpr double same_length = 1e-6;

/// A symmetric tensor in axes to which its own ones are turned: the mean of its normal parts stays, the rest turns twice.
Vec3 turned(const double* tensor, Complex turn) {
  const double mean = 0.5 * (tensor[0] + tensor[1]);
  const Complex rest = Complex(0.5 * (tensor[0] - tensor[1]), tensor[2]) * turn * turn;
  return {mean + rest.real(), mean - rest.real(), rest.imag()};
}

/// Triangles that determine a quadratic well, and rings that are tried for them.
constexpr int enough = 15, most_rings = 3;

double energy_of(const Vec3& resultant, const Mat3& compliance) {
  return 0.5 * resultant.dot(compliance * resultant);
}

}  // namespace

RecoveryError::RecoveryError(const Sheet& sheet) : sheet_(&sheet) {
  const mesh::SurfaceMesh& mesh = sheet.mesh();
  for (const Material& m : sheet.materials()) compliance_.push_back({m.membrane.inverse(), m.bending.inverse()});
  flat_.reserve(static_cast<std::size_t>(mesh.triangle_count()));
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const mesh::Frame frame = sheet.frame(t);
    Flat f{};
    f.area = mesh.area(t);
    for (int i = 0; i < 3; ++i) {
      const Vec2 p = frame.to_plane(mesh.rest_corner(t, i));
      f.corner[i] = {p.x(), p.y()};
      f.goes_on[i] = goes_on(t, i);
    }
    flat_.push_back(f);
  }
}

bool RecoveryError::goes_on(Index t, int s) const {
  const mesh::SurfaceMesh& mesh = sheet_->mesh();
  const Index next = mesh.neighbour(t, s);
  if (next == no_index || sheet_->patches().apex(t, s) == no_index || sheet_->is_crease(t, s) ||
      sheet_->material_index(t) != sheet_->material_index(next) || sheet_->zone(t) != sheet_->zone(next))
    return false;
  const mesh::Join join = mesh.chart_join(t, s);
  const Material& m = sheet_->material(t);
  return join.same_chart || (!m.direction && !m.texture_direction && std::abs(join.stretch - 1.0) < same_length);
}

RecoveryError::Piece RecoveryError::beyond(const Piece& from, int s) const {
  const mesh::SurfaceMesh& mesh = sheet_->mesh();
  const Index next = mesh.neighbour(from.triangle, s);
  const int there = mesh.side_in_neighbour(from.triangle, s), b = (there + 1) % 3, a = (there + 2) % 3;
  const std::array<Complex, 3>& own = flat_[static_cast<std::size_t>(next)].corner;
  // The shared side runs the other way in the neighbour.
  const Complex at_a = from.corner[(s + 1) % 3], at_b = from.corner[(s + 2) % 3];
  Piece p{next, {}, {}, (at_a - at_b) / (own[a] - own[b])};
  p.turn /= std::abs(p.turn);
  p.centre = at_b - p.turn * own[b];
  for (int i = 0; i < 3; ++i) p.corner[i] = p.centre + p.turn * own[i];
  return p;
}

int RecoveryError::grow(std::array<Piece, most>& pieces, int count, const std::vector<Index>& core) const {
  const mesh::SurfaceMesh& mesh = sheet_->mesh();
  const auto touches = [&](Index t) {
    const mesh::Triangle& v = mesh.triangles()[static_cast<std::size_t>(t)];
    return std::any_of(v.begin(), v.end(),
                       [&](Index i) { return std::find(core.begin(), core.end(), i) != core.end(); });
  };
  for (int k = 0; k < count; ++k)
    for (int s = 0; s < 3 && count < most; ++s) {
      const Piece from = pieces[k];
      if (!flat_[static_cast<std::size_t>(from.triangle)].goes_on[s]) continue;
      const Index next = mesh.neighbour(from.triangle, s);
      if (!touches(next)) continue;
      const auto is_next = [next](const Piece& p) { return p.triangle == next; };
      if (std::none_of(pieces.begin(), pieces.begin() + count, is_next)) pieces[count++] = beyond(from, s);
    }
  return count;
}

int RecoveryError::pieces_around(Index t, std::array<Piece, most>& pieces) const {
  const mesh::Triangle& centre = sheet_->mesh().triangles()[static_cast<std::size_t>(t)];
  pieces[0] = {t, flat_[static_cast<std::size_t>(t)].corner, 0.0, 1.0};
  return grow(pieces, 1, {centre.begin(), centre.end()});
}

RecoveryError::Complex RecoveryError::place_of_bending(const Piece& p) const {
  const mesh::PatchMesh& patches = sheet_->patches();
  Complex sum = 0.0;
  int mirrored = 0;
  for (int s = 0; s < 3; ++s) {
    const Index apex = patches.apex(p.triangle, s);
    if (apex == no_index || !patches.is_mirror(apex)) continue;
    ++mirrored;
    sum += 0.5 * (p.corner[static_cast<std::size_t>((s + 1) % 3)] + p.corner[static_cast<std::size_t>((s + 2) % 3)]);
  }
  return mirrored == 0 ? p.centre : sum / static_cast<double>(mirrored);
}

Vec3 RecoveryError::at_corner(Index t, int i, const std::vector<double>& values, bool bending) const {
  const mesh::SurfaceMesh& mesh = sheet_->mesh();
  const Flat& own = flat_[static_cast<std::size_t>(t)];
  std::array<Piece, most> pieces;
  pieces[0] = {t, own.corner, 0.0, 1.0};
  int count = 1;
  std::vector<Index> core{mesh.triangles()[static_cast<std::size_t>(t)][static_cast<std::size_t>(i)]};
  for (int ring = 0; ring < most_rings && count < enough; ++ring) {
    count = grow(pieces, count, core);
    for (int k = 0; k < count; ++k) {
      const mesh::Triangle& v = mesh.triangles()[static_cast<std::size_t>(pieces[k].triangle)];
      core.insert(core.end(), v.begin(), v.end());
    }
  }
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 3> right = Eigen::Matrix<double, 6, 3>::Zero();
  const double size = std::sqrt(own.area);
  for (int k = 0; k < count; ++k) {
    const Piece& p = pieces[k];
    const Complex c = ((bending ? place_of_bending(p) : p.centre) - own.corner[i]) / size;
    const double x = c.real(), y = c.imag();
    const double weight = flat_[static_cast<std::size_t>(p.triangle)].area / (1.0 + std::norm(c));
    Eigen::Matrix<double, 6, 1> basis;
    basis << 1.0, x, y, x * x, y * y, x * y;
    normal += weight * basis * basis.transpose();
    right += weight * basis * turned(&values[3 * static_cast<std::size_t>(p.triangle)], p.turn).transpose();
  }
  normal.diagonal().tail<5>().array() += ridge * normal(0, 0);
  return normal.ldlt().solve(right).row(0).transpose();
}

RecoveryError::Density RecoveryError::of(Index t, const std::vector<double>& force,
                                         const std::vector<double>& moment) const {
  std::array<Piece, most> pieces;
  const int count = pieces_around(t, pieces);
  const Flat& own = flat_[static_cast<std::size_t>(t)];
  // Places over the size of the triangle, so that all unknowns have the unit of a resultant.
  const double size = std::sqrt(own.area);
  Mat3 normal = Mat3::Zero();
  Eigen::Matrix<double, 3, 6> right = Eigen::Matrix<double, 3, 6>::Zero();
  for (int k = 0; k < count; ++k) {
    const Piece& p = pieces[k];
    const auto at = 3 * static_cast<std::size_t>(p.triangle);
    const double weight = flat_[static_cast<std::size_t>(p.triangle)].area;
    const Vec3 basis(1.0, p.centre.real() / size, p.centre.imag() / size);
    normal += weight * basis * basis.transpose();
    right.leftCols<3>() += weight * basis * turned(&force[at], p.turn).transpose();
    right.rightCols<3>() += weight * basis * turned(&moment[at], p.turn).transpose();
  }
  normal.diagonal().tail<2>().array() += ridge * normal(0, 0);
  const Eigen::Matrix<double, 3, 6> fit = normal.ldlt().solve(right);
  Mat2 spread = Mat2::Zero();  // J over the squared size
  for (const Complex& p : own.corner) {
    const Vec2 x(p.real() / size, p.imag() / size);
    spread += x * x.transpose() / 12.0;
  }
  const Compliance& c = compliance_[static_cast<std::size_t>(sheet_->material_index(t))];
  const auto at = 3 * static_cast<std::size_t>(t);
  const auto part = [&](Eigen::Index first, const double* raw, const Mat3& compliance, bool varies) {
    const Eigen::Matrix<double, 3, 3> f = fit.middleCols<3>(first);
    double e = energy_of(f.row(0).transpose() - Eigen::Map<const Vec3>(raw), compliance);
    if (!varies) return e;
    const Mat2 slopes = f.bottomRows<2>() * compliance * f.bottomRows<2>().transpose();
    e += 0.5 * spread.cwiseProduct(slopes).sum();
    return e;
  };
  return {part(0, &force[at], c.membrane, sheet_->options().membrane == MembraneOperator::cst),
          part(3, &moment[at], c.bending, true)};
}

}  // namespace voile::energy
