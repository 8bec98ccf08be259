// voile-manikin: what `voile manikin` does: a body to try garments on, and how it moves.
#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>
#include <optional>

#include "base/terminal.hpp"
#include "command_program.hpp"
#include "geometry/intersections.hpp"
#include "manikin/figure.hpp"

namespace {

using namespace voile;
namespace fs = std::filesystem;

struct Request {
  fs::path file;
  std::string kind = "figure", motion, person = "woman";
  std::optional<double> height, bust, waist, hip, inseam;
  double arms = 25.0, size = 0.03;                                          ///< degrees, m
  std::optional<double> seconds, frames_per_second, speed, cadence, angle;  ///< s, 1/s, m/s, 1/s, degrees
};

constexpr std::array motions{std::pair{"walk", manikin::Motion::walk}, std::pair{"run", manikin::Motion::run},
                             std::pair{"turn", manikin::Motion::turn}, std::pair{"lift", manikin::Motion::lift},
                             std::pair{"sit", manikin::Motion::sit}};

void declare(CLI::App& cli, Request& r) {
  CLI::App* c = cli.add_subcommand("manikin", "Make a dress form or a figure that moves from measurements");
  c->footer(
      "Lengths are metres. z is up from the floor, the body faces -y and walks that way. With --motion the "
      "positions of all frames go to a .pc2 beside the .obj, for the keys frames and frames_per_second of an "
      "obstacle; named points (waist, left wrist, ...) to a .landmarks.csv.");
  c->add_option("file", r.file, "File to write (.obj); replaced if it exists")->required();
  c->add_option("--kind", r.kind, "figure: with head, arms and legs; form: a tailor's, on a stand [figure]")
      ->check(CLI::IsMember({"figure", "form"}));
  c->add_option("--person", r.person, "woman, man or child: what is not given is as usual for them [woman]")
      ->check(CLI::IsMember({"woman", "man", "child"}));
  c->add_option("--height", r.height, "Of the figure, or of who the form is for [woman 1.74, man 1.80, child 1.16]");
  c->add_option("--bust", r.bust, "Girth by a tape [woman 0.88, man 0.98, child by the height]");
  c->add_option("--waist", r.waist, "Girth by a tape [woman 0.68, man 0.84, child by the height]");
  c->add_option("--hip", r.hip, "Girth by a tape [woman 0.94, man 0.98, child by the height]");
  c->add_option("--inseam", r.inseam, "From the floor to the crotch [by the height; 0.80 of 1.74]");
  c->add_option("--arms", r.arms, "Angle of the arms from the vertical, in degrees [25]");
  c->add_option("--size", r.size, "Length of the edges of triangles [0.03]");
  std::vector<std::string> names;
  for (const auto& [name, motion] : motions) names.emplace_back(name);
  c->add_option("--motion", r.motion, "walk, run, turn, lift the left arm or sit down, from standing [none]")
      ->check(CLI::IsMember(names));
  c->add_option("--seconds", r.seconds, "How long it moves [3]");
  c->add_option("--fps", r.frames_per_second, "Frames per second [50]");
  c->add_option("--speed", r.speed, "walk, run: in m/s, once under way [walk 1.0, run 2.5; less of children]");
  c->add_option("--cadence", r.cadence, "walk, run: steps per second [walk 1.8, run 2.7]");
  c->add_option("--angle", r.angle, "turn: about the vertical; lift: of the arm, in degrees [turn 180, lift 90]");
}

void write_obj(const fs::path& file, const geometry::TriangleSoup& surface) {
  std::ofstream out(file);
  for (const Vec3& p : surface.positions) out << fmt::format("v {:.7f} {:.7f} {:.7f}\n", p.x(), p.y(), p.z());
  for (const mesh::Triangle& t : surface.triangles) out << fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  if (!out.flush()) throw UserError(fmt::format("{}: cannot be written", file.string()));
}

/// Names for the places of pieces: where joints are, and the middle of the trunk at the heights of girths.
std::vector<std::pair<std::string, Vec3>> landmarks_of(const manikin::Shape& shape) {
  const manikin::Levels& l = shape.levels();
  std::vector<std::pair<std::string, Vec3>> named;
  for (const auto& [name, z] : {std::pair{"neck", l.neck}, {"bust", l.bust}, {"waist", l.waist}, {"hip", l.hip}})
    named.emplace_back(name, Vec3(0.0, 0.0, z));
  if (shape.kind() == manikin::Kind::form) return named;
  named.emplace_back("crotch", Vec3(0.0, 0.0, l.crotch));
  const manikin::Joints& j = shape.joints();
  for (const auto& [name, at] : {std::pair{"shoulder", j.shoulder},
                                 {"elbow", j.elbow},
                                 {"wrist", j.wrist},
                                 {"hip joint", j.hip},
                                 {"knee", j.knee},
                                 {"ankle", j.ankle}}) {
    named.emplace_back(std::string("left ") + name, at);
    named.emplace_back(std::string("right ") + name, Vec3(-at.x(), at.y(), at.z()));
  }
  return named;
}

fs::path write_landmarks(fs::path file, const manikin::Shape& shape) {
  file.replace_extension(".landmarks.csv");
  std::ofstream out(file);
  for (const auto& [name, p] : landmarks_of(shape))
    out << fmt::format("{},{:.7f},{:.7f},{:.7f}\n", name, p.x(), p.y(), p.z());
  if (!out.flush()) throw UserError(fmt::format("{}: cannot be written", file.string()));
  return file;
}

template <class Value>
void put(std::ofstream& out, Value value) {
  static_assert(sizeof(Value) == 4);
  out.write(reinterpret_cast<const char*>(&value), 4);
}

/// See formats/point_cache.hpp.
void write_pc2(const fs::path& file, const std::vector<std::vector<Vec3>>& frames) {
  std::ofstream out(file, std::ios::binary);
  out.write("POINTCACHE2\0", 12);
  put(out, std::int32_t{1});
  put(out, static_cast<std::int32_t>(frames.front().size()));
  put(out, 0.0F);
  put(out, 1.0F);
  put(out, static_cast<std::int32_t>(frames.size()));
  for (const auto& frame : frames)
    for (const Vec3& p : frame)
      for (int c = 0; c < 3; ++c) put(out, static_cast<float>(p[c]));
  if (!out.flush()) throw UserError(fmt::format("{}: cannot be written", file.string()));
}

/// No obstacle may intersect itself; files hold single precision.
void check_frames(const manikin::Figure& figure, const std::vector<std::vector<Vec3>>& frames,
                  const std::string& motion) {
  const std::string other = motion == "lift" || motion == "turn" ? "another --angle" : "a lower --speed";
  for (std::size_t f = 0; f < frames.size(); ++f) {
    std::vector<Vec3> stored;
    for (const Vec3& p : frames[f]) stored.emplace_back(p.cast<float>().cast<double>());
    if (const auto pairs = geometry::intersecting_triangles(stored, figure.surface.triangles); !pairs.empty()) {
      const Vec3& at = stored[static_cast<std::size_t>(figure.surface.triangles[pairs.front().first][0])];
      throw UserError(fmt::format(
          "the figure intersects itself in frame {} at ({:.3f}, {:.3f}, {:.3f}); try {}, another angle of --arms or a "
          "finer --size",
          f, at.x(), at.y(), at.z(), motion == "sit" ? "girths nearer to the usual ones" : other));
    }
  }
}

manikin::Measurements measurements_of(const Request& r) {
  const auto person = r.person == "man"     ? manikin::Person::man
                      : r.person == "child" ? manikin::Person::child
                                            : manikin::Person::woman;
  manikin::Measurements m = manikin::usual_measurements(person, r.height.value_or(manikin::usual_height(person)));
  m.bust = r.bust.value_or(m.bust);
  m.waist = r.waist.value_or(m.waist);
  m.hip = r.hip.value_or(m.hip);
  m.inseam = r.inseam.value_or(m.inseam);
  m.arm_angle = r.arms * std::numbers::pi / 180.0;
  return m;
}

manikin::MotionOptions motion_of(const Request& r, double inseam) {
  const auto* const motion =
      std::find_if(motions.begin(), motions.end(), [&](const auto& m) { return m.first == r.motion; });
  manikin::MotionOptions o = manikin::usual_motion(motion->second, inseam);
  o.seconds = r.seconds.value_or(o.seconds);
  o.frames_per_second = r.frames_per_second.value_or(o.frames_per_second);
  o.speed = r.speed.value_or(o.speed);
  o.cadence = r.cadence.value_or(o.cadence);
  if (r.angle) o.angle = *r.angle * std::numbers::pi / 180.0;
  return o;
}

/// An option that would do nothing is a mistake.
void refuse_idle(const Request& r) {
  const bool steps = r.motion == "walk" || r.motion == "run", turns = r.motion == "turn" || r.motion == "lift";
  if ((r.speed || r.cadence) && !steps)
    throw UserError(fmt::format("{} goes with --motion walk or run; leave it out", r.speed ? "--speed" : "--cadence"));
  if (r.motion.empty() && (r.seconds || r.frames_per_second))
    throw UserError(fmt::format("{} goes with --motion; leave it out", r.seconds ? "--seconds" : "--fps"));
  if (r.angle && !turns) throw UserError("--angle goes with --motion turn or lift; leave it out");
}

void make(const Request& r) {
  refuse_idle(r);
  if (r.file.extension() != ".obj")
    throw UserError(fmt::format("{}: a manikin is written as .obj; give the file that ending", r.file.string()));
  const auto kind = r.kind == "form" ? manikin::Kind::form : manikin::Kind::figure;
  if (kind == manikin::Kind::form && !r.motion.empty() && r.motion != "turn")
    throw UserError(
        fmt::format("--motion {}: a form has no limbs; make a --kind figure, or let the form turn", r.motion));
  const manikin::Figure figure = manikin::make_figure(measurements_of(r), kind, r.size);
  std::vector<std::vector<Vec3>> frames;
  manikin::MotionOptions moving;
  if (!r.motion.empty()) {
    moving = motion_of(r, figure.shape.measurements().inseam);
    frames = manikin::frames(figure, moving);
    check_frames(figure, frames, r.motion);
  }
  write_obj(r.file, figure.surface);
  const manikin::Levels& l = figure.shape.levels();
  fmt::print("{}: {} vertices, {} triangles\n", r.file.string(), figure.surface.positions.size(),
             figure.surface.triangles.size());
  fmt::print("girth of bust {:.4f} m at height {:.4f}, waist {:.4f} at {:.4f}, hip {:.4f} at {:.4f}\n",
             figure.girths.bust, l.bust, figure.girths.waist, l.waist, figure.girths.hip, l.hip);
  fmt::print("{}: names of points of it, for the key landmarks of an obstacle\n",
             write_landmarks(r.file, figure.shape).string());
  if (frames.empty()) return;
  const fs::path cache = fs::path(r.file).replace_extension(".pc2");
  write_pc2(cache, frames);
  fmt::print("{}: {} frames, {:g} per second; none intersects itself\n", cache.string(), frames.size(),
             moving.frames_per_second);
}

}  // namespace

int main(int argc, char** argv) {
  keep_output_streams();
  return cli::command_program(argc, argv, "Bodies to try garments on", "give a larger --size, or fewer frames",
                              [](CLI::App& cli) {
                                auto request = std::make_shared<Request>();
                                declare(cli, *request);
                                return [request] { make(*request); };
                              });
}
