// Results as scenes and finished pictures: what is shown and how, views on one sheet, titles, colour bar.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "field_values.hpp"
#include "ray_tracer.hpp"
#include "recording.hpp"
#include "worst_seam.hpp"

namespace voile::picture {

struct ShowOptions {
  int width = 1280, height = 960;
  Quality quality = Quality::final();
  int threads = 0;
  std::string field;                               ///< NAME[:COMPONENT]; empty: plain
  std::optional<std::pair<double, double>> range;  ///< of colours; else that of all moments
  bool mesh_lines = false, partition = false, panels = false, contours = false, seams = false, ground = true,
       obstacles = true;
  ClothChoice cloth;  ///< how the sheet looks instead of smooth
  bool stamp = true;  ///< time or load factor
  std::string title;
  std::vector<std::string> views{"three-quarter"};
  std::optional<Vec3> eye, target;  ///< a place of the camera instead [m]
  std::optional<Vec3> up;
  std::optional<double> creases;  ///< edges that are folded by more are red [rad]
  std::optional<double> scale;    ///< of displacements; of modes the largest displacement [m]
};

/// Pictures of moments that belong together: one camera, one scale of colours, one ground.
class Show {
 public:
  /// Looks through all moments. Throws UserError as Recording does, and if no moment has the field.
  Show(const Recording& recording, std::vector<Moment> moments, ShowOptions options);
  [[nodiscard]] const std::vector<Moment>& moments() const { return moments_; }
  [[nodiscard]] Image picture(const Moment& moment) const;

 private:
  void survey();
  void survey_field(const Moment& moment, std::pair<double, double>& range);
  void choose_scale();
  void find_planes();
  [[nodiscard]] Scene scene(const Moment& moment) const;
  [[nodiscard]] Surface sheet(const Moment& moment, const State& state) const;
  void add_bodies(const Moment& moment, const State& state, Scene& scene) const;
  void make_cloth(const State& state, Surface& s) const;
  [[nodiscard]] std::optional<FieldValues> values(const Moment& moment) const;
  void find_seams();
  void letter(Image& image, const Moment& moment) const;
  [[nodiscard]] double bar_room(double line) const;
  void draw_bar(Image& image) const;

  const Recording& recording_;
  std::vector<Moment> moments_;
  ShowOptions options_;
  double scale_ = 1.0;
  Vec3 up_ = Vec3::UnitZ();
  std::vector<Vec3> points_;  ///< that the picture must hold
  std::optional<double> ground_;
  ColourScale colours_;
  std::vector<std::optional<WorstSeam>> seams_;  ///< of each part, or of the one before it; empty: not asked for
  std::shared_ptr<const Cloth> cloth_;           ///< null: smooth
  std::string label_;                            ///< of the colour bar; empty: none
};

}  // namespace voile::picture
