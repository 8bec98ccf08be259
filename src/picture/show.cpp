#include "show.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "lettering.hpp"
#include "pieces.hpp"
#include "voile/errors.hpp"

namespace voile::picture {

namespace {

constexpr double sheet_crease = 75.0 / 57.29578, body_crease = 40.0 / 57.29578;  // [rad]
constexpr double mode_size = 0.12;   // of a mode as it is shown [sizes of the sheet]
constexpr double near_bodies = 0.3;  // what of bodies is so near to the sheet is in the picture [sizes of the motion]
constexpr std::size_t most_points = 1'500'000;
constexpr float cloth_sheen = 0.9F, wrong_side_paleness = 0.2F;
constexpr int bar_ticks = 6;  // numbers at the colour bar, about

const Bytes3 soft_ink{96, 102, 110};

// The right side of the fabric and the wrong side, and what it lies on.
const Bytes3 right_side{66, 119, 178}, wrong_side{226, 170, 112}, body_colour{196, 192, 186};

struct Extent {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  void add(const Vec3& x) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  [[nodiscard]] double size() const { return low.x() <= high.x() ? (high - low).norm() : 0.0; }
  [[nodiscard]] double distance(const Vec3& x) const { return (x - x.cwiseMax(low).cwiseMin(high)).norm(); }
};

double line_height(const Image& image) {
  return std::clamp(std::min(image.height(), image.width()) / 36.0, 9.0, 60.0);
}

}  // namespace

Show::Show(const Recording& recording, std::vector<Moment> moments, ShowOptions options)
    : recording_(recording), moments_(std::move(moments)), options_(std::move(options)) {
  up_ = options_.up ? options_.up->normalized() : recording.up();
  choose_scale();
  if (options_.seams) find_seams();
  options_.cloth = options_.cloth.in_unit(recording.metres());
  if (options_.cloth.any()) cloth_ = std::make_shared<const Cloth>(options_.cloth);
  survey();
}

void Show::find_seams() {
  bool found = false;
  for (const Recording::Part& part : recording_.parts()) {
    std::optional<WorstSeam> own = worst_seam(recording_.folder() / part.stage / "seams.csv");
    if (!own && !seams_.empty()) own = seams_.back();
    found = found || own;
    seams_.push_back(std::move(own));
  }
  if (!found)
    throw UserError(fmt::format(
        "--seams: {} has no seams.csv, which a stage that sews writes at its end, among what is shown; show the "
        "run of a garment that has been sewn, and with --stage that stage",
        recording_.folder().string()));
}

void Show::choose_scale() {
  scale_ = options_.scale.value_or(1.0);
  if (options_.scale || moments_.empty() || !recording_.parts()[moments_.front().part].modes) return;
  Extent box;
  for (const Vec3& x : recording_.state(moments_.front(), 0.0).positions) box.add(x);
  scale_ = mode_size * box.size();
}

/// What the pictures must hold, the height of the ground, the range of the field.
void Show::survey() {
  Extent box;
  double lowest = std::numeric_limits<double>::infinity();
  std::pair<double, double> range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  std::vector<Vec3> bodies;
  std::optional<double> floor;
  for (const Moment& moment : moments_) {
    const State state = recording_.state(moment, scale_);
    const std::size_t stride = 1 + state.positions.size() * moments_.size() / most_points;
    for (std::size_t i = 0; i < state.positions.size(); ++i) {
      box.add(state.positions[i]);
      lowest = std::min(lowest, state.positions[i].dot(up_));
      if (i % stride == 0) points_.push_back(state.positions[i]);
    }
    if (options_.obstacles) {
      const Bodies found = find_bodies(recording_.parts()[moment.part].run.obstacles(), state.obstacles, up_);
      if (found.floor) floor = std::max(floor.value_or(-std::numeric_limits<double>::infinity()), *found.floor);
      for (const Vec3& x : found.solid_points) {
        lowest = std::min(lowest, x.dot(up_));
        bodies.push_back(x);
      }
    }
    if (!options_.field.empty()) survey_field(moment, range);
  }
  for (const Vec3& x : bodies)
    if (box.distance(x) < near_bodies * box.size()) points_.push_back(x);
  if (options_.ground && std::isfinite(lowest)) ground_ = floor.value_or(lowest - 1e-3 * box.size());
  if (options_.field.empty()) return;
  if (label_.empty()) {
    const Moment& last = moments_.back();
    if (!last.step) throw UserError(fmt::format("--field {}: there are no steps yet", options_.field));
    (void)recording_.parts()[last.part].run.field(*last.step, parse_field(options_.field).name,
                                                  recording_.mesh(last)->data);
  }
  if (range.first > range.second) range = {0.0, 0.0};
  if (options_.range) range = *options_.range;
  colours_ = make_scale(range.first, range.second);
}

void Show::survey_field(const Moment& moment, std::pair<double, double>& range) {
  const std::optional<FieldValues> found = values(moment);
  if (!found) return;
  label_ = found->label;
  for (const float x : found->values)
    if (std::isfinite(x)) range = {std::min<double>(range.first, x), std::max<double>(range.second, x)};
}

/// Nothing if the step does not have the field.
std::optional<FieldValues> Show::values(const Moment& moment) const {
  const FieldChoice choice = parse_field(options_.field);
  const results::StoredRun& run = recording_.parts()[moment.part].run;
  if (!moment.step || !run.has_field(*moment.step, choice.name)) return std::nullopt;
  return field_values(recording_, moment, choice);
}

Surface Show::sheet(const Moment& moment, const State& state) const {
  Surface s;
  s.positions = single(state.positions);
  s.triangles = state.mesh->data.triangles;
  s.normals = corner_normals(s.positions, s.triangles, sheet_crease);
  s.front = from_bytes(right_side);
  s.back = from_bytes(wrong_side);
  s.sheen = 0.6F;
  s.mesh_lines = options_.mesh_lines;
  if (options_.contours || options_.panels || options_.seams) s.marked_sides = group_borders(state.mesh->data);
  if (options_.creases) s.red_sides = folded_sides(state.mesh->data, state.positions, *options_.creases);
  if (options_.seams && seams_[moment.part]) {
    const std::vector<std::uint8_t> seam = seam_sides(state.mesh->data, seams_[moment.part]->name);
    s.red_sides.resize(seam.size());
    for (std::size_t t = 0; t < seam.size(); ++t) s.red_sides[t] = static_cast<std::uint8_t>(s.red_sides[t] | seam[t]);
  }
  if (options_.partition)
    for (const int rank : state.mesh->triangle_rank)
      s.triangle_colours.push_back(category_colour(static_cast<std::size_t>(rank)));
  if (options_.panels)
    for (const std::size_t panel : panels_of(state.mesh->data)) s.triangle_colours.push_back(category_colour(panel));
  if (cloth_) make_cloth(state, s);
  if (options_.field.empty()) return s;
  s.sheen = 0.0F;
  if (const std::optional<FieldValues> found = values(moment)) {
    s.values = found->values;
    s.values_on_triangles = found->on_triangles;
  }
  // A step without the field is grey.
  if (s.values.empty()) s.values.assign(s.positions.size(), std::numeric_limits<float>::quiet_NaN());
  return s;
}

/// Threads, a print, a paler wrong side, and the thickness of the sheet unless colours mean something.
void Show::make_cloth(const State& state, Surface& s) const {
  const std::vector<SheetMaterial>& materials = recording_.materials();
  s.cloth = cloth_;
  s.flat = flat_coordinates(state.mesh->data, materials);
  s.back = s.front + wrong_side_paleness * (Rgb::Ones() - s.front);
  s.sheen = cloth_sheen;
  const double known = materials.empty() ? 0.0 : materials.front().thickness;
  const double thickness = known > 0.0 ? known : options_.cloth.spacing;
  if (thickness > 0.0 && options_.field.empty() && s.triangle_colours.empty()) thicken(s, thickness);
}

void Show::add_bodies(const Moment& moment, const State& state, Scene& scene) const {
  const Bodies found = find_bodies(recording_.parts()[moment.part].run.obstacles(), state.obstacles, up_);
  if (found.triangles.empty()) return;
  Surface& s = scene.surfaces.emplace_back();
  s.positions = single(state.obstacles);
  s.triangles = found.triangles;
  s.normals = corner_normals(s.positions, s.triangles, body_crease);
  s.front = s.back = from_bytes(body_colour);
}

Scene Show::scene(const Moment& moment) const {
  const State state = recording_.state(moment, scale_);
  Scene scene;
  scene.scale = colours_;
  scene.up = up_;
  if (cloth_) scene.lighting = Lighting::studio();
  scene.ground = ground_;
  scene.surfaces.push_back(sheet(moment, state));
  if (options_.obstacles) add_bodies(moment, state, scene);
  return scene;
}

Image Show::picture(const Moment& moment) const {
  Image image(options_.width, options_.height);
  const Scene scene = this->scene(moment);
  const int views = options_.eye ? 1 : static_cast<int>(options_.views.size());
  const double line = line_height(image);
  // Several views leave a strip for the colour bar; a single one only keeps its subject out of it.
  const int width = options_.width - (views > 1 && !label_.empty() ? static_cast<int>(bar_room(line) + 1.6 * line) : 0);
  const int columns =
      std::clamp(static_cast<int>(std::ceil(std::sqrt(views * 0.75 * width / options_.height))), 1, views);
  const int rows = (views + columns - 1) / columns;
  for (int i = 0; i < views; ++i) {
    const int x0 = width * (i % columns) / columns, x1 = width * (i % columns + 1) / columns;
    const int y0 = options_.height * (i / columns) / rows, y1 = options_.height * (i / columns + 1) / rows;
    View view = options_.eye ? View{} : named_view(options_.views[static_cast<std::size_t>(i)], up_);
    view.eye = options_.eye;
    view.target = options_.target;
    // Room for the texts, and for the colour bar at the right.
    Frame frame{0.05, 0.95, 0.05, 0.95};
    const bool lettered = (options_.stamp || !options_.title.empty()) && y0 == 0;
    if (lettered || views > 1) frame.top += (lettered && views > 1 ? 2.6 : 1.6) * line / (y1 - y0);
    if (!label_.empty() && views == 1) frame.right -= (bar_room(line) + 0.2 * line) / (x1 - x0);
    const Camera camera = fit_camera(view, up_, points_, static_cast<double>(x1 - x0) / (y1 - y0), frame);
    image.paste(render(scene, camera, x1 - x0, y1 - y0, options_.quality, options_.threads), x0, y0);
    if (views > 1)
      draw_text(image, x0 + 0.8 * line, y0 + (lettered ? 2.7 : 1.4) * line, view.name, 0.85 * line, soft_ink);
  }
  letter(image, moment);
  if (!label_.empty()) draw_bar(image);
  return image;
}

void Show::letter(Image& image, const Moment& moment) const {
  const double line = line_height(image);
  double x = 0.8 * line;
  if (!options_.title.empty()) {
    draw_text(image, x, 1.5 * line, options_.title, 1.15 * line, ink);
    x = image.width() - 0.8 * line;
  }
  if (!options_.stamp) return;
  std::string text = recording_.caption(moment);
  if (options_.scale && !recording_.parts()[moment.part].modes && scale_ != 1.0)
    text += fmt::format(", displacements \u00d7 {:g}", scale_);
  if (options_.seams && seams_[moment.part])
    text += fmt::format(", widest open: {}, {:.2g} mm", seams_[moment.part]->name, 1e3 * seams_[moment.part]->gap);
  draw_text(image, x, 1.5 * line, text, line, soft_ink, options_.title.empty() ? Align::left : Align::right);
}

/// From the colour bar to the right border: its numbers, on a picture whose lines are so high [pixels].
double Show::bar_room(double line) const {
  double widest = 0.0;
  for (const auto& [value, text] : ticks(colours_.low, colours_.high, bar_ticks))
    widest = std::max(widest, text_width(text, 0.85 * line));
  return std::max(4.4 * line, widest + 1.6 * line);
}

void Show::draw_bar(Image& image) const {
  const double line = line_height(image);
  const int height = static_cast<int>(0.5 * image.height()), width = static_cast<int>(0.7 * line);
  const int top = (image.height() - height) / 2, left = image.width() - static_cast<int>(bar_room(line));
  for (int j = 0; j < height; ++j) {
    const float t = 1.0F - (static_cast<float>(j) + 0.5F) / static_cast<float>(height);
    image.fill(left, top + j, width, 1, to_bytes(colours_.map(t)));
  }
  for (const auto& [value, text] : ticks(colours_.low, colours_.high, bar_ticks)) {
    const int y =
        top + height - 1 - static_cast<int>(std::lround(colours_.place(value) * static_cast<float>(height - 1)));
    image.fill(left + width, y, static_cast<int>(0.25 * line), std::max(1, static_cast<int>(line / 14.0)), ink);
    draw_text(image, left + width + 0.45 * line, y + 0.3 * line, text, 0.85 * line, ink);
  }
  // The name, and below it component and unit.
  const std::size_t cut = std::min(label_.find(", "), label_.find(" ["));
  const double right = image.width() - 0.8 * line;
  draw_text(image, right, top - 1.9 * line, label_.substr(0, cut), 0.9 * line, ink, Align::right);
  if (cut != std::string::npos)
    draw_text(image, right, top - 0.8 * line, label_.substr(label_[cut] == ',' ? cut + 2 : cut + 1), 0.9 * line, ink,
              Align::right);
}

}  // namespace voile::picture
