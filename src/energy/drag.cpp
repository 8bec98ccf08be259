#include "drag.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace voile::energy {

void DragTerm::add(const std::array<Index, 3>& points, double area, bool owned) {
  elements_.push_back({points, area, owned});
}

void DragTerm::start_step(const Vec3* x, const Vec3* v) {
  for (Element& el : elements_) {
    const auto& p = el.points;
    const Vec3 n = Vec3(x[p[1]] - x[p[0]]).cross(Vec3(x[p[2]] - x[p[0]])).normalized();
    const Vec3 relative = options_.wind - (v[p[0]] + v[p[1]] + v[p[2]]) / 3.0;
    const Mat3 across = n * n.transpose();
    const double half = 0.5 * options_.air_density * el.area;
    el.drag = half * (options_.normal * std::abs(relative.dot(n)) * across +
                      options_.tangential * relative.norm() * (Mat3::Identity() - across));
  }
}

}  // namespace voile::energy
