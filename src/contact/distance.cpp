#include "distance.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

namespace voile::contact {

namespace {

/// Squares of the sine of the angle between two edges: below the first they are parallel, below the second round-off may have left the
/// minimum to an end point.
constexpr double least_angle = 1e-14, trusted_angle = 1e-6;

void finish(const std::array<Vec3, 4>& x, Closest& r) {
  r.w = r.c[0] * x[0] + r.c[1] * x[1] + r.c[2] * x[2] + r.c[3] * x[3];
  r.distance = r.w.norm();
}

/// Parameter of the point of segment ab nearest to p.
double parameter(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 e = b - a;
  const double length = e.squaredNorm();
  return length > 0.0 ? std::clamp((p - a).dot(e) / length, 0.0, 1.0) : 0.0;
}

/// Point x[i] and segment x[j], x[k] of a pair; `side` is the sign of the point's weight.
Closest point_segment(const std::array<Vec3, 4>& x, int i, int j, int k, double side) {
  Closest r;
  const double s = parameter(x[i], x[j], x[k]);
  r.c[i] = side;
  r.c[j] = -side * (1.0 - s);
  r.c[k] = -side * s;
  if (s > 0.0 && s < 1.0) {
    r.free = 1;
    r.dc[0][j] = side;
    r.dc[0][k] = -side;
  }
  finish(x, r);
  return r;
}

/// Square of the distance of a point from a segment: from its first end to the point r, to its second end e.
inline double squared(const Vec3& r, const Vec3& e) {
  const double length = e.squaredNorm();
  const double s = length > 0.0 ? std::clamp(r.dot(e) / length, 0.0, 1.0) : 0.0;
  return (r - s * e).squaredNorm();
}

void keep_nearer(Closest& best, const Closest& other) {
  if (other.distance < best.distance) best = other;
}

}  // namespace

Closest point_edge(const std::array<Vec3, 4>& x) {
  std::array<Vec3, 4> three = x;
  three[3].setZero();
  return point_segment(three, 0, 1, 2, 1.0);
}

Closest point_triangle(const std::array<Vec3, 4>& x) {
  const Vec3 e1 = x[2] - x[1], e2 = x[3] - x[1], r = x[0] - x[1];
  const double a11 = e1.squaredNorm(), a12 = e1.dot(e2), a22 = e2.squaredNorm(), b1 = r.dot(e1), b2 = r.dot(e2);
  const double det = a11 * a22 - a12 * a12;
  if (det > least_angle * a11 * a22) {
    const double u = (a22 * b1 - a12 * b2) / det, v = (a11 * b2 - a12 * b1) / det;
    if (u > 0.0 && v > 0.0 && u + v < 1.0) {
      Closest inside;
      inside.c = Vec4(1.0, u + v - 1.0, -u, -v);
      inside.free = 2;
      inside.dc[0] = Vec4(0.0, 1.0, -1.0, 0.0);
      inside.dc[1] = Vec4(0.0, 1.0, 0.0, -1.0);
      finish(x, inside);
      return inside;
    }
  }
  Closest best = point_segment(x, 0, 1, 2, 1.0);
  keep_nearer(best, point_segment(x, 0, 2, 3, 1.0));
  keep_nearer(best, point_segment(x, 0, 3, 1, 1.0));
  return best;
}

Closest edge_edge(const std::array<Vec3, 4>& x) {
  const Vec3 a = x[1] - x[0], b = x[3] - x[2], r = x[0] - x[2];
  const double aa = a.squaredNorm(), ab = a.dot(b), bb = b.squaredNorm(), ra = r.dot(a), rb = r.dot(b);
  const double det = aa * bb - ab * ab;
  Closest inside;
  inside.distance = std::numeric_limits<double>::infinity();
  if (det > least_angle * aa * bb) {
    const double s = (ab * rb - bb * ra) / det, t = (aa * rb - ab * ra) / det;
    if (s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0) {
      inside.c = Vec4(1.0 - s, s, t - 1.0, -t);
      inside.free = 2;
      inside.dc[0] = Vec4(-1.0, 1.0, 0.0, 0.0);
      inside.dc[1] = Vec4(0.0, 0.0, 1.0, -1.0);
      finish(x, inside);
      if (det > trusted_angle * aa * bb) return inside;
    }
  }
  Closest best = point_segment(x, 0, 2, 3, 1.0);
  keep_nearer(best, inside);
  keep_nearer(best, point_segment(x, 1, 2, 3, 1.0));
  keep_nearer(best, point_segment(x, 2, 0, 1, -1.0));
  keep_nearer(best, point_segment(x, 3, 0, 1, -1.0));
  return best;
}

double point_edge_distance(const std::array<Vec3, 4>& x) {
  return std::sqrt(squared(x[0] - x[1], x[2] - x[1]));
}

double point_triangle_distance(const std::array<Vec3, 4>& x) {
  const Vec3 e1 = x[2] - x[1], e2 = x[3] - x[1], r = x[0] - x[1];
  const double a11 = e1.squaredNorm(), a12 = e1.dot(e2), a22 = e2.squaredNorm(), b1 = r.dot(e1), b2 = r.dot(e2);
  const double det = a11 * a22 - a12 * a12;
  if (det > least_angle * a11 * a22) {
    const double u = (a22 * b1 - a12 * b2) / det, v = (a11 * b2 - a12 * b1) / det;
    if (u > 0.0 && v > 0.0 && u + v < 1.0) return (r - u * e1 - v * e2).norm();
  }
  return std::sqrt(std::min({squared(r, e1), squared(r, e2), squared(r - e1, e2 - e1)}));
}

double edge_edge_distance(const std::array<Vec3, 4>& x) {
  const Vec3 a = x[1] - x[0], b = x[3] - x[2], r = x[0] - x[2];
  const double aa = a.squaredNorm(), ab = a.dot(b), bb = b.squaredNorm(), ra = r.dot(a), rb = r.dot(b);
  const double det = aa * bb - ab * ab;
  double inside = std::numeric_limits<double>::infinity();
  if (det > least_angle * aa * bb) {
    const double s = (ab * rb - bb * ra) / det, t = (aa * rb - ab * ra) / det;
    if (s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0) {
      inside = (r + s * a - t * b).squaredNorm();
      if (det > trusted_angle * aa * bb) return std::sqrt(inside);
    }
  }
  return std::sqrt(std::min({inside, squared(r, b), squared(r + a, b), squared(-r, a), squared(b - r, a)}));
}

Mat5 distance_hessian(const std::array<Vec3, 4>& x, const Closest& r, Motions& m) {
  const double d = r.distance, size = r.c.norm();
  const Vec3 n = r.w / d;
  const Vec3 t1 = n.unitOrthogonal(), t2 = n.cross(t1);
  m.frame = {n, n, n, t1, t2};
  std::array<Vec4, 3> q{r.c / size, Vec4::Zero(), Vec4::Zero()};
  for (int k = 0; k < r.free; ++k) {
    Vec4 v = r.dc[k];
    for (int j = 0; j <= k; ++j) v -= q[j].dot(v) * q[j];
    q[k + 1] = v.normalized();
  }
  m.weight = {q[0], q[1], q[2], q[0], q[0]};
  Mat5 h = Mat5::Zero();
  h(3, 3) = h(4, 4) = size * size / d;
  if (r.free == 0) return h;
  Eigen::Matrix<double, 5, 2> g = Eigen::Matrix<double, 5, 2>::Zero();
  Mat2 metric = Mat2::Identity();
  std::array<Vec3, 2> t;
  for (int k = 0; k < r.free; ++k) {
    t[k] = r.dc[k][0] * x[0] + r.dc[k][1] * x[1] + r.dc[k][2] * x[2] + r.dc[k][3] * x[3];
    for (int j = 0; j < 3; ++j) g(j, k) = q[j].dot(r.dc[k]) * d;
    g(3, k) = size * t1.dot(t[k]);
    g(4, k) = size * t2.dot(t[k]);
  }
  for (int k = 0; k < r.free; ++k)
    for (int l = 0; l < r.free; ++l) metric(k, l) = t[k].dot(t[l]);
  h -= g * metric.inverse() * g.transpose() / d;
  return h;
}

}  // namespace voile::contact
