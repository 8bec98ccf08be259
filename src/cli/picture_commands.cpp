#include "picture_commands.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "base/terminal.hpp"
#include "picture/animation.hpp"
#include "picture_frames.hpp"
#include "picture_words.hpp"
#include "voile/errors.hpp"

namespace voile::cli {

namespace fs = std::filesystem;

namespace {

Vec3 vector_of(const std::string& option, const std::string& text) {
  const std::vector<double> x = numbers_of(option, text, 3);
  return {x[0], x[1], x[2]};
}

Vec3 axis_of(const std::string& text) {
  const bool down = !text.empty() && text[0] == '-';
  const std::string name = text.substr(down ? 1 : 0);
  if (name.size() == 1 && name[0] >= 'x' && name[0] <= 'z') return (down ? -1.0 : 1.0) * Vec3::Unit(name[0] - 'x');
  const Vec3 axis = vector_of("--up", text);
  if (axis.norm() == 0.0) throw UserError("--up: the direction has no length");
  return axis.normalized();
}

/// out.png and 12: out_000012.png
fs::path numbered(const fs::path& file, std::size_t number) {
  return file.parent_path() / fmt::format("{}_{:06d}{}", file.stem().string(), number, file.extension().string());
}

/// A print is as large as it is asked for only where the texture is the cloth as it is cut.
void warn_of_texture(const picture::Recording& recording, const picture::ClothChoice& cloth) {
  if (cloth.print == picture::Print::none || launched_rank().rank != 0) return;
  const double stretch = picture::uneven_texture(recording.mesh(recording.select("last").front())->data);
  if (stretch > 0.0)
    fmt::print(
        stderr,
        "voile: warning: --print: the texture coordinates of the mesh are stretched against it by up to {:.0f} %, "
        "and the print with them; its size is true with coordinates of the flat cloth\n",
        100.0 * stretch);
}

}  // namespace

void ResultsOptions::declare(CLI::App& sub, bool modes) {
  sub.add_option("results", results, "Output folder of a run, or its results.vtkhdf")->required();
  sub.add_option("--stage", choice.stage, "Of a run in stages: this one [all]");
  if (modes)
    sub.add_option("--mode", choice.mode, "A mode of vibration or buckling instead of steps")
        ->check(CLI::Range(1, 1'000'000));
}

void ClothOptions::declare(CLI::App& sub) {
  sub.add_option("--cloth", cloth,
                 "Show threads: plain, twill or knit; distance of threads after a colon: twill:0.5mm");
  sub.add_option("--print", print, "Print of true size before deformation: stripes:10mm along the warp, checks:10mm");
}

RenderCommand::RenderCommand(CLI::App& cli) : sub_(cli.add_subcommand("render", "Draw results: PNG, WebP, GIF, MP4")) {
  results_.declare(*sub_, true);
  sub_->add_option("--steps", steps_, "all, last, N, FIRST:LAST or FIRST:LAST:STRIDE [last; all for an animation]");
  sub_->add_option("--output", output_, "PNG to write; several get numbers [picture.png beside the results]");
  CLI::Option* animation =
      sub_->add_option("--animation", animation_, "Animation to write instead: its name ends in .webp, .gif or .mp4");
  sub_->add_option("--rate", rate_, "Frames per second [25]")->needs(animation);
  sub_->add_option("--frames", frames_, "Frames of one swing of a mode [32]")
      ->check(CLI::Range(2, 10000))
      ->needs(animation)
      ->needs("--mode");
  sub_->add_option("--size", size_, "Pixels [1280x960]");
  sub_->add_option("--quality", quality_, "draft or final [final]")->check(CLI::IsMember({"draft", "final"}));
  sub_->add_option("--threads", show_.threads, "Threads [one per core]")->check(CLI::Range(0, 1024));
  sub_->add_flag("--palette", palette_, "256 colours at most: a smaller file (PNG)");
  sub_->add_flag("--quiet", quiet_, "Print errors only");
  declare_look();
  declare_camera();
}

void RenderCommand::declare_look() {
  CLI::Option* field = sub_->add_option(
      "--field", show_.field, "Field as colour: NAME or NAME:COMPONENT, e.g. displacement:z, membrane_force:larger");
  sub_->add_option("--range", range_, "LOW,HIGH of the colours [of all steps shown]")->needs(field);
  sub_->add_option("--scale", scale_,
                   "Factor of displacements [1]; of a mode its largest displacement, in the unit of lengths");
  CLI::Option* partition =
      sub_->add_flag("--partition", show_.partition, "Colour by the rank of the run")->excludes(field);
  sub_->add_flag("--panels", show_.panels, "Colour panels (groups of triangles), with their borders")
      ->excludes(partition)
      ->excludes(field);
  cloth_.declare(*sub_);
  for (CLI::Option* other : {field, partition, sub_->get_option("--panels")})
    sub_->get_option("--print")->excludes(other);
  sub_->add_flag("--contours", show_.contours, "Draw lines of groups, borders of panels and seams");
  sub_->add_flag("--seams", show_.seams, "Draw seams, in red the one that was open widest, by seams.csv");
  sub_->add_flag("--mesh", show_.mesh_lines, "Draw the edges of triangles");
  sub_->add_option("--creases", creases_, "Draw edges red where the sheet is folded by more than these degrees");
  sub_->add_option("--title", show_.title, "Text above the picture");
  sub_->add_flag("--no-stamp", no_stamp_, "Leave out the time or load factor");
  sub_->add_flag("--no-ground", no_ground_, "Leave out the ground and the shadow on it");
  sub_->add_flag("--no-obstacles", no_obstacles_, "Leave out obstacles");
}

void RenderCommand::declare_camera() {
  sub_->add_option(
      "--view", views_,
      "three-quarter, front, back, left, right, top, bottom or AZIMUTH,ELEVATION in degrees; several with / between "
      "them come on one sheet [three-quarter]");
  CLI::Option* eye = sub_->add_option("--eye", eye_, "X,Y,Z of the camera in the unit of lengths, instead of a view");
  sub_->add_option("--target", target_, "X,Y,Z of its target likewise [the middle]")->needs(eye);
  sub_->add_option("--up", up_, "x, y, z, -x, -y, -z or X,Y,Z [against gravity, or z]");
}

void RenderCommand::take_numbers() {
  take_size(size_, show_.width, show_.height);
  show_.quality = quality_ == "draft" ? picture::Quality::draft() : picture::Quality::final();
  if (!range_.empty()) {
    const std::vector<double> ends = numbers_of("--range", range_, 2);
    if (!(ends[0] < ends[1]))
      throw UserError(fmt::format("--range {}: the first number must be the smaller one", range_));
    show_.range = {ends[0], ends[1]};
  }
  show_.views = words_of(views_, '/');
  if (show_.views.empty()) throw UserError("--view: no view is given");
  if (!eye_.empty()) show_.eye = vector_of("--eye", eye_);
  if (!target_.empty()) show_.target = vector_of("--target", target_);
  if (!up_.empty()) show_.up = axis_of(up_);
  if (!(std::abs(scale_) <= 1e9)) throw UserError(fmt::format("--scale {}: it is a number up to 1e9 in size", scale_));
  if (sub_->count("--scale") > 0) show_.scale = scale_;
  if (!(creases_ >= 0.0 && creases_ <= 180.0))
    throw UserError(fmt::format("--creases {}: it is an angle from 0 to 180 degrees", creases_));
  if (sub_->count("--creases") > 0) show_.creases = creases_ * std::numbers::pi / 180.0;
  show_.cloth = picture::parse_cloth(cloth_.cloth, cloth_.print);
  show_.ground = !no_ground_;
  show_.stamp = !no_stamp_;
  show_.obstacles = !no_obstacles_;
}

void RenderCommand::run() {
  take_numbers();
  const picture::Recording recording(results_.results, results_.choice);
  warn_of_texture(recording, show_.cloth);
  if (animation_.empty())
    write_pictures(recording);
  else
    write_animation(recording);
}

void RenderCommand::write_pictures(const picture::Recording& recording) const {
  const int mode = results_.choice.mode;
  const std::string steps = mode > 0 ? std::to_string(mode) : steps_.empty() ? "last" : steps_;
  const picture::Show show(recording, recording.select(steps), show_);
  const fs::path file = output_.empty() ? recording.folder() / "picture.png" : fs::path(output_);
  const LaunchedRank own = launched_rank();
  for (std::size_t i = 0; i < show.moments().size(); ++i) {
    if (!is_own(own, i)) continue;
    const fs::path name = show.moments().size() == 1 ? file : numbered(file, i);
    write_png(name, show.picture(show.moments()[i]), palette_);
    if (!quiet_) fmt::print("wrote {}\n", name.string());
  }
}

void RenderCommand::write_animation(const picture::Recording& recording) const {
  std::vector<picture::Moment> moments;
  if (const int mode = results_.choice.mode; mode > 0) {
    const picture::Moment still = recording.select(std::to_string(mode)).front();
    for (int i = 0; i < frames_; ++i) {
      moments.push_back(still);
      moments.back().swing = std::sin(2.0 * std::numbers::pi * i / frames_);
    }
  } else {
    moments = recording.select(steps_.empty() ? "all" : steps_);
  }
  const picture::Show show(recording, moments, show_);
  const LaunchedRank own = launched_rank();
  const bool writes = own.rank == 0;
  const std::unique_ptr<picture::AnimationWriter> writer =
      writes ? picture::make_animation(animation_, rate_) : nullptr;
  SharedFrames(animation_, own, begun_)
      .run(
          moments.size(), [&](std::size_t i) { return show.picture(moments[i]); },
          [&](std::size_t i, const picture::Image& image) {
            writer->add(image);
            if (!quiet_) show_progress(fmt::format("frame {} of {}", i + 1, moments.size()));
          });
  if (!writes) return;
  writer->finish();
  if (!quiet_) fmt::print("wrote {}\n", animation_);
}

ExportCommand::ExportCommand(CLI::App& cli)
    : sub_(cli.add_subcommand("export",
                              "Write results in other formats: OBJ, STL, PLY, PC2, MDD, GLB, USDA, MSH, VTU, CSV")) {
  results_.declare(*sub_, false);
  sub_->add_option("--to", export_.format,
                   "obj, stl, ply, pc2, mdd, glb, usda, msh, vtu or csv [the ending of --output]");
  sub_->add_option("--steps", steps_,
                   "all, last, N, FIRST:LAST or FIRST:LAST:STRIDE [all; last for obj, stl, ply, csv]");
  sub_->add_option("--output", output_, "File to write; several get numbers [results.FORMAT beside the results]");
  sub_->add_option("--field", fields_, "Fields of ply, csv, msh and vtu, with / between them [all]");
  sub_->add_option("--rate", export_.rate, "Frames per second [25]");
  cloth_.declare(*sub_);
  sub_->add_flag("--no-obstacles", no_obstacles_, "The sheet only");
  sub_->add_flag("--one-mesh", export_.one_mesh,
                 "Put a run that was remeshed on one mesh as fine as any of its own; pc2 and mdd always do");
  sub_->add_option(
      "--tolerance", export_.tolerance,
      "How far it may be away from the meshes of the run, in the case's unit of length [5e-4 of the sheet's extent]");
  sub_->add_flag("--quiet", quiet_, "Print errors only");
}

void ExportCommand::run() {
  std::string& format = export_.format;
  if (format.empty() && output_.empty())
    throw UserError("export: --to FORMAT or --output FILE is needed; see voile export --help");
  if (format.empty()) format = fs::path(output_).extension().string().erase(0, 1);
  const std::string ending = fs::path(output_).extension().string();
  for (const char* other : {"obj", "stl", "ply", "pc2", "mdd", "glb", "usda", "msh", "vtu", "csv"})
    if (ending == std::string(".") + other && format != other)
      throw UserError(fmt::format("export: --to {} and --output {} name two formats; leave one out", format, output_));
  const picture::Recording recording(results_.results, results_.choice);
  export_.output = output_.empty() ? recording.folder() / ("results." + format) : fs::path(output_);
  if (!export_.output.has_extension()) export_.output += "." + format;
  export_.fields = words_of(fields_, '/');
  export_.bodies = !no_obstacles_;
  export_.cloth = picture::parse_cloth(cloth_.cloth, cloth_.print);
  warn_of_texture(recording, export_.cloth);
  const bool one_file_each = format == "obj" || format == "stl" || format == "ply" || format == "csv";
  const std::vector<picture::Moment> moments =
      recording.select(steps_.empty() ? (one_file_each ? "last" : "all") : steps_);
  const picture::Exported exported = export_results(recording, moments, export_);
  if (quiet_) return;
  for (const fs::path& file : exported.files) fmt::print("wrote {}\n", file.string());
  for (const std::string& note : exported.notes) fmt::print("{}\n", note);
}

ViewCommand::ViewCommand(CLI::App& cli)
    : sub_(cli.add_subcommand("view", "Write one HTML file that shows results in a browser")) {
  results_.declare(*sub_, false);
  sub_->add_option("--steps", steps_, "all, last, N, FIRST:LAST or FIRST:LAST:STRIDE [all]");
  sub_->add_option("--field", fields_,
                   "Fields to choose from, NAME or NAME:COMPONENT with / between them [displacement]");
  sub_->add_option("--output", output_, "HTML to write [view.html beside the results]");
  sub_->add_option("--rate", viewer_.rate, "Frames per second [12]")->check(CLI::Range(0.1, 100.0));
  sub_->add_flag("--no-obstacles", no_obstacles_, "The sheet only");
  sub_->add_flag("--quiet", quiet_, "Print errors only");
}

void ViewCommand::run() {
  if (!std::isfinite(viewer_.rate)) throw UserError("--rate: it is a number of frames per second");
  const picture::Recording recording(results_.results, results_.choice);
  viewer_.output = output_.empty() ? recording.folder() / "view.html" : fs::path(output_);
  viewer_.fields = words_of(fields_, '/');
  viewer_.bodies = !no_obstacles_;
  const std::vector<picture::Moment> moments = recording.select(steps_);
  const picture::Moment& last = moments.back();
  if (fields_.empty() && last.step && recording.parts()[last.part].run.has_field(*last.step, "displacement"))
    viewer_.fields = {"displacement"};
  write_viewer(recording, moments, viewer_);
  if (!quiet_) fmt::print("wrote {}\n", viewer_.output.string());
}

}  // namespace voile::cli
