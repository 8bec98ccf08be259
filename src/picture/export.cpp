#include "export.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/plain_file.hpp"
#include "base/text.hpp"
#include "exporting.hpp"
#include "geometry/intersections.hpp"
#include "mesh/weld.hpp"
#include "voile/errors.hpp"

namespace voile::picture {

namespace fs = std::filesystem;

namespace {

using Writer = Files (*)(const Exporter&);

const std::vector<std::pair<std::string, Writer>>& writers() {
  static const std::vector<std::pair<std::string, Writer>> list{
      {"obj", export_obj}, {"stl", export_stl},   {"ply", export_ply}, {"pc2", export_pc2}, {"mdd", export_mdd},
      {"glb", export_glb}, {"usda", export_usda}, {"msh", export_msh}, {"vtu", export_vtu}, {"csv", export_csv}};
  return list;
}

/// Whether open seams will give two triangles of the sheet a common vertex: contact lets these meet.
bool will_meet(const std::vector<Index>& joined, const mesh::Triangle& a, const mesh::Triangle& b) {
  const auto root = [&](Index v) { return v < static_cast<Index>(joined.size()) ? joined[v] : no_index; };
  return std::any_of(a.begin(), a.end(), [&](Index v) {
    return std::any_of(b.begin(), b.end(),
                       [&](Index w) { return v != w && root(v) != no_index && root(v) == root(w); });
  });
}

const std::set<std::string> with_fields{"ply", "csv", "msh", "vtu"};

/// Leaves out vertices of no triangle, as those of a floor: other programs take them into the extent of what they show.
void leave_out_unused(Body& body) {
  std::vector<Index> renumbered(body.positions.size(), -1);
  for (const mesh::Triangle& t : body.triangles)
    for (const Index v : t) renumbered[static_cast<std::size_t>(v)] = 0;
  std::vector<Vec3f> used;
  for (std::size_t v = 0; v < renumbered.size(); ++v)
    if (renumbered[v] == 0) {
      renumbered[v] = static_cast<Index>(used.size());
      used.push_back(body.positions[v]);
    }
  for (mesh::Triangle& t : body.triangles)
    for (Index& v : t) v = renumbered[static_cast<std::size_t>(v)];
  body.positions = std::move(used);
}

}  // namespace

const std::vector<std::string>& export_formats() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const auto& [name, writer] : writers()) list.push_back(name);
    return list;
  }();
  return names;
}

Exported export_results(const Recording& recording, const std::vector<Moment>& moments, const ExportOptions& options) {
  if (!(options.rate > 0.0)) throw UserError(fmt::format("--rate {}: frames per second are more than 0", options.rate));
  for (const auto& [name, writer] : writers())
    if (name == options.format) {
      if (!options.fields.empty() && !with_fields.contains(name))
        throw UserError(fmt::format("--field: {} files have no fields; those of {} do", name, join(with_fields, ", ")));
      if (options.cloth.any() && name != "glb")
        throw UserError(fmt::format("--cloth, --print: {} files hold no textures of ours; export as glb", name));
      const Exporter exporter(recording, moments, options);
      Files files = writer(exporter);
      return {std::move(files), exporter.notes()};
    }
  throw UserError(
      fmt::format("--to {}: there is no such format: it is one of {}", options.format, join(export_formats(), ", ")));
}

Exporter::Exporter(const Recording& recording, const std::vector<Moment>& moments, const ExportOptions& options)
    : recording_(recording), options_(options) {
  // Motions keep their time, over stages too; other frames follow each other evenly.
  const auto time_of = [&](const Moment& m) -> std::optional<double> {
    const Recording::Part& part = recording.parts()[m.part];
    return part.in_time && m.step ? std::optional(part.run.steps()[*m.step].time) : std::nullopt;
  };
  double time = 0.0;
  for (const Moment& moment : moments) {
    if (!moments_.empty()) {
      const std::optional<double> before = time_of(moments_.back()), now = time_of(moment);
      const bool goes_on = before && now && *now >= *before;
      if (goes_on && *now == *before &&
          moment.part != moments_.back().part) {  // a stage begins where the last has ended
        moments_.back() = moment;
        continue;
      }
      time += goes_on ? (*now - *before) * recording.time_unit().seconds : 1.0 / options.rate;
    }
    moments_.push_back(moment);
    times_.push_back(time);
  }
  if (options.tolerance && !(*options.tolerance > 0.0))
    throw UserError(fmt::format("--tolerance {}: it is more than 0", *options.tolerance));
  for (std::size_t i = 1; i < moments_.size(); ++i) meshes_ += same_mesh(i) ? 0 : 1;
  if (meshes_ > 1 && (options.one_mesh || options.format == "pc2" || options.format == "mdd"))
    one_mesh_ = std::make_unique<Resampled>(recording, moments_, options.tolerance);
}

bool Exporter::same_mesh(std::size_t i) const {
  if (i == 0) return false;
  if (one_mesh_) return true;
  const auto now = recording_.mesh(moments_[i]), before = recording_.mesh(moments_[i - 1]);
  return now == before ||
         (now->data.triangles == before->data.triangles && now->data.positions.size() == before->data.positions.size());
}

void Exporter::put_on_one_mesh(Snapshot& s) const {
  std::vector<Vec3> x = one_mesh_->positions(s.state);
  for (const Resampled::Distance& d : one_mesh_->distances(s.state, x)) distance_ = std::max(distance_, d.length);
  s.state.mesh = one_mesh_->mesh();
  s.state.positions = x;
  // The sheet as body 0, each obstacle triangle as 1: obstacles may meet each other.
  std::vector<mesh::Triangle> triangles = s.state.mesh->data.triangles;
  std::vector<Index> body(triangles.size(), 0);
  for (mesh::Triangle t : s.bodies.triangles) {
    for (Index& v : t) v += static_cast<Index>(x.size());
    triangles.push_back(t);
    body.push_back(1);
  }
  if (!s.bodies.triangles.empty()) x.insert(x.end(), s.state.obstacles.begin(), s.state.obstacles.end());
  const auto both_obstacles = [](Index a, Index b) { return a == 1 && b == 1; };
  const std::vector<geometry::TrianglePair> pairs =
      geometry::intersecting_triangles(x, triangles, body, both_obstacles);
  const std::vector<Index> joined = mesh::joined_vertices(s.state.mesh->data);
  if (!std::all_of(pairs.begin(), pairs.end(), [&](const auto& p) {
        return will_meet(joined, triangles[static_cast<std::size_t>(p.first)],
                         triangles[static_cast<std::size_t>(p.second)]);
      }))
    intersecting_.insert(s.number);
}

std::vector<std::string> Exporter::notes() const {
  if (!one_mesh_ && meshes_ > 1)
    return {fmt::format("{} meshes one after another in {} frames, as in the run; --one-mesh puts all on one", meshes_,
                        size())};
  if (!one_mesh_) return {};
  std::string intersections = "nothing intersects";
  if (!intersecting_.empty())
    intersections = fmt::format("the sheet intersects in {} of {} frames, first at step {}", intersecting_.size(),
                                size(), *intersecting_.begin());
  return {fmt::format("one mesh of {} vertices for all frames: at most {:.2g} {} from the meshes of the run{}; {}",
                      one_mesh_->mesh()->data.positions.size(),
                      recording_.metres() == 1.0 ? 1e3 * distance_ : distance_,
                      recording_.metres() == 1.0 ? "mm" : recording_.unit(),
                      distance_ > one_mesh_->tolerance() ? ", beyond the tolerance" : "", intersections)};
}

Snapshot Exporter::snapshot(std::size_t i) const {
  const Moment& moment = moments_[i];
  Snapshot s;
  s.state = recording_.state(moment, 1.0);
  s.number = recording_.number(moment);
  s.time = time(i);
  const results::ObstacleTriangles& obstacles = recording_.parts()[moment.part].run.obstacles();
  s.bodies = {"bodies", single(s.state.obstacles), {}, obstacles.moves};
  if (options_.bodies) s.bodies.triangles = find_bodies(obstacles, s.state.obstacles, recording_.up()).triangles;
  if (one_mesh_) put_on_one_mesh(s);
  leave_out_unused(s.bodies);
  s.sheet = {"sheet", single(s.state.positions), s.state.mesh->data.triangles, true};
  return s;
}

std::vector<results::Field> Exporter::fields(std::size_t i) const {
  std::vector<results::Field> found;
  const Moment& moment = moments_[i];
  if (!moment.step) return found;
  const results::StoredRun& run = recording_.parts()[moment.part].run;
  std::vector<std::string> names = options_.fields;
  if (names.empty())
    for (const results::FieldInfo& f : run.fields(*moment.step)) names.push_back(f.name);
  const auto mesh = recording_.mesh(moment);
  for (const std::string& name : names) {
    found.push_back(run.field(*moment.step, name, mesh->data));
    if (one_mesh_) found.back() = one_mesh_->field(*mesh, std::move(found.back()));
  }
  return found;
}

fs::path Exporter::file(const std::string& suffix, const std::string& ending) const {
  const fs::path& output = options_.output;
  return output.parent_path() /
         (output.stem().string() + suffix + (ending.empty() ? output.extension().string() : ending));
}

fs::path Exporter::frame_file(std::size_t i) const {
  return size() == 1 ? options_.output : file(fmt::format("_{:06d}", i));
}

namespace {
const fs::path& without_link(const fs::path& file) {
  require_no_link(file);
  return file;
}
}  // namespace

OutFile::OutFile(const fs::path& file) : file_(without_link(file)), out_(file, std::ios::binary) {
  if (!out_) throw UserError(fmt::format("{}: cannot be written; is the folder there?", file.string()));
  unfinished_.begin(file);
}

void OutFile::finish(Files& files) {
  out_.close();
  if (!out_) throw UserError(fmt::format("{}: cannot be written; is there room on the disk?", file_.string()));
  unfinished_.finish();
  files.push_back(file_);
}

}  // namespace voile::picture
