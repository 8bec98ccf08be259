#include "background_size.hpp"

#include <fmt/format.h>

#include <cmath>

#include "formats/gmsh_view.hpp"
#include "voile/errors.hpp"

namespace voile::setup {

BackgroundSize::BackgroundSize(const input::Case& c)
    : file_(c.remesh.background.string()), placement_(c.mesh.options.placement), scale_(c.mesh.options.scale) {}

std::vector<double> BackgroundSize::at(const std::vector<Vec3>& places) {
  const auto key = [](const Vec3& x) { return std::tuple(x[0], x[1], x[2]); };
  std::vector<Vec3> asked, in_file;
  const Mat3 back = placement_.rotation().transpose();
  for (const Vec3& x : places) {
    if (known_.contains(key(x))) continue;
    asked.push_back(x);
    in_file.emplace_back(back * (x - placement_.translate) / scale_);
  }
  const std::vector<double> values = asked.empty() ? std::vector<double>{} : formats::view_values(file_, in_file);
  for (std::size_t i = 0; i < asked.size(); ++i) {
    if (!std::isfinite(values[i]) || values[i] <= 0.0)
      throw UserError(
          fmt::format("{}: [remesh] background: the size at ({:g}, {:g}, {:g}) is {:g}; it must be a positive length",
                      file_, in_file[i][0], in_file[i][1], in_file[i][2], values[i]));
    known_[key(asked[i])] = scale_ * values[i];
  }
  std::vector<double> sizes;
  for (const Vec3& x : places) sizes.push_back(known_.at(key(x)));
  return sizes;
}

}  // namespace voile::setup
