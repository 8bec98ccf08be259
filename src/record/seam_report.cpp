#include "seam_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <set>

#include "base/text.hpp"
#include "mesh/weld.hpp"
#include "system/sewing_springs.hpp"
#include "voile/errors.hpp"

namespace voile::record {

namespace {

constexpr std::size_t listed = 3;

mesh::Segment ascending(const mesh::Segment& s) {
  return {std::min(s[0], s[1]), std::max(s[0], s[1])};
}

/// The edges of pieces that a seam runs along, by vertex: the numbered name of an edge comes before its label.
std::map<Index, std::string> edges_along(const mesh::SurfaceMesh& mesh, const std::string& seam) {
  std::map<Index, std::string> edge_of;
  const std::string name = mesh::seam_group(seam);
  if (!mesh.has_group(name)) return edge_of;
  std::set<mesh::Segment> along;
  for (const mesh::Segment& s : mesh.group(name, 1).segments) along.insert(ascending(s));
  const std::string prefix = mesh::seam_group("");
  for (const mesh::Group& g : mesh.groups()) {
    if (g.dimension != 1 || g.name.starts_with(prefix) || g.name.find('/') == std::string::npos) continue;
    for (const mesh::Segment& s : g.segments)
      if (along.count(ascending(s)) > 0)
        for (const Index v : s) edge_of.insert({v, g.name});
  }
  return edge_of;
}

std::vector<Vec3> places_of(const mesh::SurfaceMesh& mesh, const std::vector<double>& displacement) {
  std::vector<Vec3> x = mesh.positions();
  for (std::size_t v = 0; v < x.size(); ++v) x[v] += Eigen::Map<const Vec3>(&displacement[3 * v]);
  return x;
}

}  // namespace

void SeamReport::add(const input::Case& c, system::Model& model, const system::State& state) {
  const mesh::SurfaceMesh& mesh = model.dofs().mesh();
  const std::vector<std::string> sewn = mesh::open_seams(mesh.data(), c.stage.sew);
  if (sewn.empty()) return;
  const system::SewingSprings* springs = model.potential().sewing();
  if (!springs) return;
  const auto pulls = springs->pulls(model.potential().configuration(state.u));
  for (const auto& [name, mean, largest] : pulls) {
    Pull& most = pulls_[name];
    most.last = mean;
    most.largest = std::max(most.largest, largest);
    if (mean > most.mean) most.mean = mean, most.time = state.time;
  }
}

std::vector<SeamMeasure> SeamReport::measure(const input::Case& c, const system::Model& model,
                                             const system::State& state) const {
  const mesh::SurfaceMesh& mesh = model.dofs().mesh();
  const std::vector<double> u = model.dofs().gather(state.u);
  std::vector<SeamMeasure> all;
  if (u.empty()) return all;  // not rank 0
  const std::vector<Vec3> x = places_of(mesh, u);
  for (const std::string& name : mesh::open_seams(mesh.data(), c.stage.sew)) {
    const auto known = pulls_.find(name);
    const Pull pull = known == pulls_.end() ? Pull{} : known->second;
    const mesh::SeamGap widest = mesh::widest_gap(mesh.data(), {name}, x);
    SeamMeasure m{
        name,        mesh::side_lengths(mesh, name), pull.mean, pull.largest, pull.time, pull.last, widest.gap, {},
        widest.place};
    const std::map<Index, std::string> edges = edges_along(mesh, name);
    for (std::size_t side = 0; side < 2; ++side)
      if (const auto at = edges.find(widest.pair[side]); at != edges.end()) m.edges[side] = at->second;
    all.push_back(std::move(m));
  }
  std::stable_sort(all.begin(), all.end(), [](const SeamMeasure& a, const SeamMeasure& b) { return a.gap > b.gap; });
  return all;
}

void write_seams(const std::filesystem::path& folder, const std::vector<SeamMeasure>& seams) {
  const std::filesystem::path file = folder / "seams.csv";
  std::ofstream out(file);
  out << "seam,length_1,length_2,ease_percent,mean_pull,largest_pull,time_of_pull,pull_at_end,gap,edge_1,edge_2,gap_x,"
         "gap_y,gap_"
         "z\n";
  for (const SeamMeasure& s : seams)
    out << fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", csv_name(s.name), s.lengths[0], s.lengths[1],
                       s.ease(), s.mean_pull, s.largest_pull, s.pulled_at, s.pull_at_end, s.gap, csv_name(s.edges[0]),
                       csv_name(s.edges[1]), s.place[0], s.place[1], s.place[2]);
  out << std::flush;
  if (!out) throw UserError(fmt::format("{}: cannot be written", file.string()));
}

std::vector<std::string> seam_lines(const std::vector<SeamMeasure>& seams) {
  std::vector<std::string> lines;
  for (std::size_t k = 0; k < std::min(listed, seams.size()); ++k) {
    const SeamMeasure& s = seams[k];
    lines.push_back(fmt::format(
        "seam '{}': {:.4g} m to {:.4g} m ({:+.1f} %), pulled with up to {:.3g} N/m in the mean, at the end "
        "with {:.3g} N/m, {:.2g} mm open between {} and {}",
        s.name, s.lengths[0], s.lengths[1], s.ease(), s.mean_pull, s.pull_at_end, 1e3 * s.gap, s.edges[0], s.edges[1]));
  }
  return lines;
}

}  // namespace voile::record
