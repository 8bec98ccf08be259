#include "patch_cubic.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "base/decompositions.hpp"

namespace voile::energy {

namespace {

/// Of third derivatives, in the root of the mean over the four: their norm is that of the tensor, T111^2 + 3 T112^2 + ..., so that
/// the fit does not depend on the axes.
constexpr double restraint = 0.1;
/// Least singular value over the largest of the fit of a quadratic.
constexpr double least_singular = 3e-3;
constexpr Eigen::Index least_points = 7;

struct Place {
  Index point;
  Vec2 at;    ///< in the plane of the triangle
  Vec3 rest;  ///< in its chart
};

/// Points of the neighbour across side s that lie across its two other sides.
void add_neighbour(const Sheet& sheet, Index t, const mesh::Patch& patch, int s, std::vector<Place>& places) {
  const mesh::SurfaceMesh& mesh = sheet.mesh();
  const Index n = mesh.neighbour(t, s);
  if (n == no_index) return;
  const mesh::Patch far = sheet.patches().patch(n, sheet.frame(n));
  const int so = mesh.side_in_neighbour(t, s), a = (so + 1) % 3, b = (so + 2) % 3;
  // The neighbour's a and b are the triangle's b and a.
  const Vec2 origin = patch.coordinates[static_cast<std::size_t>((s + 2) % 3)];
  const Vec2 along = (far.coordinates[b] - far.coordinates[a]).normalized(),
             wanted = (patch.coordinates[static_cast<std::size_t>((s + 1) % 3)] - origin).normalized();
  const double cosine = along.dot(wanted), sine = along.x() * wanted.y() - along.y() * wanted.x();
  Mat2 turn;
  turn << cosine, -sine, sine, cosine;
  const mesh::Join join = mesh.chart_join(t, s);
  for (const int k : {a, b}) {
    const std::size_t apex = 3 + static_cast<std::size_t>(k);
    if (far.points[apex] == no_index || sheet.is_crease(n, k)) continue;
    places.push_back({far.points[apex], origin + join.stretch * (turn * (far.coordinates[apex] - far.coordinates[a])),
                      patch.rest[static_cast<std::size_t>((s + 2) % 3)] +
                          join.stretch * (join.turn * (far.rest[apex] - far.rest[static_cast<std::size_t>(a)]))});
  }
}

/// The points of the patch and of its neighbours' patches that the bending element has.
std::vector<Place> places_of(const Sheet& sheet, Index t, const mesh::Patch& patch, const std::vector<Index>& allowed) {
  std::vector<Place> places;
  for (std::size_t i = 0; i < 6; ++i)
    if (patch.points[i] != no_index) places.push_back({patch.points[i], patch.coordinates[i], patch.rest[i]});
  for (int s = 0; s < 3; ++s) add_neighbour(sheet, t, patch, s, places);
  std::erase_if(places,
                [&](const Place& p) { return std::find(allowed.begin(), allowed.end(), p.point) == allowed.end(); });
  return places;
}

/// Takes (f,y1y1 ; f,y2y2 ; f,y1y2) to (f,11 ; f,22 ; 2 f,12).
Mat3 second_derivatives(const Mat2& w) {
  Mat3 m;
  const double a = w(0, 0), b = w(0, 1), c = w(1, 0), d = w(1, 1);
  m << a * a, c * c, 2 * a * c, b * b, d * d, 2 * b * d, 2 * a * b, 2 * c * d, 2 * (a * d + b * c);
  return m;
}

/// Rows: K as functions of the places; empty if these do not determine a quadratic.
Eigen::MatrixXd fit(const std::vector<Place>& places, PatchCubic& cubic) {
  const auto n = static_cast<Eigen::Index>(places.size());
  if (n < least_points) return {};
  Mat2 spread = Mat2::Zero();
  for (const Place& p : places)
    spread += (p.at - cubic.centre) * (p.at - cubic.centre).transpose() / static_cast<double>(n);
  cubic.spread = Eigen::LLT<Mat2>(spread).matrixL().solve(Mat2::Identity());
  Eigen::MatrixXd v = Eigen::MatrixXd::Zero(n + 4, 10);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vec2 y = cubic.spread * (places[static_cast<std::size_t>(i)].at - cubic.centre);
    const double a = y.x(), b = y.y();
    v.row(i) << 1.0, a, b, 0.5 * a * a, 0.5 * b * b, a * b, a * a * a, a * a * b, a * b * b, b * b * b;
  }
  const Eigen::Vector4d of_tensor = Eigen::Vector4d(3.0, 1.0, 1.0, 3.0).cwiseSqrt() / std::sqrt(2.0);
  v.bottomRightCorner<4, 4>() = Eigen::Matrix4d((restraint * of_tensor).asDiagonal());
  Eigen::MatrixXd quadratic = v.topLeftCorner(n, 6);
  quadratic.col(5) *= std::sqrt(0.5);  // |H|^2 = H11^2 + H22^2 + 2 H12^2, likewise
  const Eigen::VectorXd singular = singular_values(quadratic);
  if (!(singular[5] > least_singular * singular[0])) return {};
  const Eigen::MatrixXd inverse = LeastSquares(v).solve(Eigen::MatrixXd::Identity(n + 4, n));
  Eigen::MatrixXd k(bend_vectors, n);
  k.topRows<3>() = second_derivatives(cubic.spread) * inverse.middleRows<3>(3);
  k.bottomRows<4>() = inverse.bottomRows<4>();
  return k;
}

}  // namespace

BendWeights PatchCubic::along(const Vec2& a, const Vec2& b) const {
  const Vec2 l = b - a, d = spread * l, m = spread * (0.5 * (a + b) - centre);
  const double x = d.x(), y = d.y();
  BendWeights s;
  s << l.x() * l.x(), l.y() * l.y(), l.x() * l.y(), 6.0 * x * x * m.x(), 2.0 * x * x * m.y() + 4.0 * x * y * m.x(),
      2.0 * y * y * m.x() + 4.0 * x * y * m.y(), 6.0 * y * y * m.y();
  return s;
}

PatchCubic make_patch_cubic(const Sheet& sheet, Index t, const BendingElement& bending) {
  const mesh::Frame frame = sheet.frame(t);
  const mesh::Patch patch = sheet.patches().patch(t, frame);
  PatchCubic cubic;
  cubic.centre = (patch.coordinates[0] + patch.coordinates[1] + patch.coordinates[2]) / 3.0;
  const std::vector<Place> places = places_of(sheet, t, patch, bending.points);
  const Eigen::MatrixXd k = fit(places, cubic);
  Bends at_rest = Bends::Zero();
  if (k.size() == 0) {
    cubic.points = bending.points;
    for (Eigen::Index i = 0; i < bending.operator_.cols(); ++i)
      cubic.weights.push_back((BendWeights() << bending.operator_.col(i), Eigen::Vector4d::Zero()).finished());
    cubic.rest.head<3>() = bending.rest_curvature;
  } else {
    for (std::size_t i = 0; i < places.size(); ++i) {
      const BendWeights w = k.col(static_cast<Eigen::Index>(i));
      cubic.points.push_back(places[i].point);
      cubic.weights.push_back(w);
      at_rest += (places[i].rest - frame.origin) * w.transpose();
    }
    cubic.rest = at_rest.transpose() * frame.normal;
    for (int i = 0; i < 3; ++i) {
      const Vec2 edge = patch.coordinates[(i + 2) % 3] - patch.coordinates[(i + 1) % 3];
      const Vec2 gradient = Vec2(-edge.y(), edge.x()) / (2.0 * patch.area);
      cubic.points.push_back(patch.points[static_cast<std::size_t>(i)]);
      cubic.weights.push_back(-at_rest.transpose() * (frame.e1 * gradient.x() + frame.e2 * gradient.y()));
    }
  }
  if (!sheet.mesh().has_charts()) {
    cubic.start = frame.normal * cubic.rest.transpose();
    return cubic;
  }
  const Vec3 corner = sheet.mesh().start_corner(t, 0);  // keeps round-off small
  for (std::size_t i = 0; i < cubic.points.size(); ++i)
    cubic.start += (sheet.patches().start(cubic.points[i]) - corner) * cubic.weights[i].transpose();
  return cubic;
}

}  // namespace voile::energy
