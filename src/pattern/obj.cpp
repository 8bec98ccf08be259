// Pieces that an OBJ file draws as the islands of its texture coordinates.
//
// Symbols   (u, v)  texture coordinates      r   ratio of the lengths of an edge in space and in (u, v)
// Pieces are sewn where rims have edges of the mesh in common, and by lines 'stitch'.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "base/decompositions.hpp"
#include "base/text.hpp"
#include "formats/obj_sheet.hpp"
#include "islands.hpp"
#include "readers.hpp"
#include "voile/errors.hpp"

namespace voile::pattern {

namespace {

/// Texture coordinates nearer than this fraction of their extent are the same, as files with six digits write them.
constexpr double same_texture = 2e-6;
/// Of a piece that counts as flat in space: distance from its plane, as a fraction of its extent.
constexpr double flat_in_space = 1e-4;
/// Of r: spread beyond which it is not a unit; what is near to a usual unit is that.
constexpr double largest_spread = 0.05, near_unit = 0.02;

class ObjReader {
 public:
  ObjReader(const std::filesystem::path& file, const ReadOptions& options)
      : options_(options), sheet_(formats::read_obj_sheet(file.string())), mesh_(sheet_.mesh) {
    pattern_.file = file;
  }

  Pattern run() {
    check_faces();
    measure();
    const DrawnMesh drawn(pattern_.file.string(), mesh_, same_, texture_unit_);
    islands_ = drawn.islands();
    rims_ = drawn.rims(islands_);
    const std::vector<RimSeam> seams = find_rim_seams(rims_, meetings());
    name_islands();
    check_wanted();
    for (std::size_t k = 0; k < islands_.size(); ++k) add_piece(k);
    add_stitches(seams);
    return std::move(pattern_);
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    throw UserError(fmt::format("{}: {}", pattern_.file.string(), message));
  }
  [[nodiscard]] std::size_t face(Index t) const { return mesh_.triangle_tags[static_cast<std::size_t>(t)]; }
  [[nodiscard]] const mesh::Triangle& triangle(Index t) const { return mesh_.triangles[static_cast<std::size_t>(t)]; }
  [[nodiscard]] const Vec2& texture(Index t, std::size_t i) const {
    return mesh_.texture[static_cast<std::size_t>(t)][i % 3];
  }
  [[nodiscard]] Vec3 position(Index v) const { return unit_ * mesh_.positions[static_cast<std::size_t>(v)]; }

  void check_faces() const {
    if (mesh_.triangles.empty()) fail("it has no faces; a piece is cut from those of its texture coordinates (vt)");
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
      for (std::size_t i = 0; i < 3; ++i)
        if (mesh_.texture.empty() || !mesh_.texture[t][i].allFinite())
          fail(
              fmt::format("face {} has no texture coordinates (f v/vt ...), in which pieces are drawn; export them, or "
                          "read the surface itself by [mesh] file",
                          face(static_cast<Index>(t))));
  }

  /// The length of 1 in texture coordinates, and below which distance two of them are the same.
  void measure() {
    unit_ = options_.unit > 0.0 ? options_.unit : 1.0;
    std::vector<double> ratios;
    Vec2 low = texture(0, 0), high = low;
    for (Index t = 0; t < static_cast<Index>(mesh_.triangles.size()); ++t)
      for (std::size_t i = 0; i < 3; ++i) {
        const double drawn = (texture(t, i + 1) - texture(t, i)).norm();
        const double placed = (position(triangle(t)[(i + 1) % 3]) - position(triangle(t)[i])).norm();
        if (drawn > 0.0) ratios.push_back(placed / drawn);
        low = low.cwiseMin(texture(t, i));
        high = high.cwiseMax(texture(t, i));
      }
    if (ratios.empty()) fail("its texture coordinates (vt) are all the same; export those of the pattern");
    texture_unit_ = options_.texture_unit > 0.0 ? options_.texture_unit : unit_of(std::move(ratios));
    same_ = same_texture * texture_unit_ * (high - low).norm();
    for (auto& corners : mesh_.texture)
      for (Vec2& x : corners) x *= texture_unit_;
  }

  [[nodiscard]] double unit_of(std::vector<double> ratios) {
    std::sort(ratios.begin(), ratios.end());
    const auto quantile = [&](double f) {
      return ratios[static_cast<std::size_t>(f * static_cast<double>(ratios.size() - 1))];
    };
    double unit = quantile(0.5);
    if (!(quantile(0.9) - quantile(0.1) <= largest_spread * unit))
      fail(fmt::format(
          "an edge is between {:.4g} and {:.4g} m long in space for each 1 in texture coordinates (vt), so the "
          "size of the pieces is not known; give texture_unit in [[panel]]: the length of 1 of vt in metres",
          quantile(0.1), quantile(0.9)));
    for (const double usual : {1.0, 0.01, 0.001, 0.0254})
      if (std::abs(unit / usual - 1.0) <= near_unit) unit = usual;
    pattern_.notes.push_back(
        fmt::format("{}: 1 in texture coordinates (vt) is taken for {:.6g} m, as edges are long in space; the key "
                    "texture_unit sets it",
                    pattern_.file.string(), unit));
    return unit;
  }

  /// A point of a rim.
  struct RimPoint {
    std::size_t rim, point;
  };

  /// Places that each point of a rim is sewn to: by a vertex in common, or a stitch.
  [[nodiscard]] std::vector<std::vector<std::vector<RimPlace>>> meetings() {
    std::vector<std::vector<std::vector<RimPlace>>> meet(rims_.size());
    std::map<Index, std::vector<RimPoint>> at;
    for (std::size_t r = 0; r < rims_.size(); ++r) {
      meet[r].resize(rims_[r].points.size());
      for (std::size_t i = 0; i < rims_[r].points.size(); ++i) at[rims_[r].vertices[i]].push_back({r, i});
    }
    const auto place = [&](const RimPoint& p) { return RimPlace{p.rim, rims_[p.rim].s[p.point]}; };
    for (const auto& [vertex, points] : at)
      for (const RimPoint& p : points)
        for (const RimPoint& q : points)
          if (p.rim != q.rim || p.point != q.point) meet[p.rim][p.point].push_back(place(q));
    std::size_t inside = 0;
    for (const formats::PointStitch& stitch : sheet_.stitches) {
      const std::vector<RimPlace> others = places_of(stitch, at);
      inside += others.empty() || !at.contains(stitch.vertex) ? 1 : 0;
      for (const RimPoint& p : at[stitch.vertex])
        for (const RimPlace& other : others)
          if (other.rim != p.rim || other.s != rims_[p.rim].s[p.point]) meet[p.rim][p.point].push_back(other);
    }
    if (inside > 0)
      pattern_.notes.push_back(
          fmt::format("{}: {} of {} lines 'stitch' hold a point that is not on the rim of a piece, as of "
                      "a pocket: they are no seams; a [[spring]] of type 'pair' pulls points together",
                      pattern_.file.string(), inside, sheet_.stitches.size()));
    return meet;
  }

  /// Where on rims the second side of a stitch is.
  [[nodiscard]] std::vector<RimPlace> places_of(const formats::PointStitch& stitch,
                                                const std::map<Index, std::vector<RimPoint>>& at) const {
    std::vector<RimPlace> places;
    const bool is_vertex = stitch.from == stitch.to || stitch.fraction == 0.0 || stitch.fraction == 1.0;
    const auto from = at.find(stitch.fraction == 1.0 ? stitch.to : stitch.from);
    if (from == at.end()) return places;
    for (const RimPoint& p : from->second) {
      const Rim& rim = rims_[p.rim];
      const std::size_t n = rim.points.size();
      if (is_vertex) places.push_back({p.rim, rim.s[p.point]});
      if (is_vertex) continue;
      if (rim.vertices[(p.point + 1) % n] == stitch.to)
        places.push_back({p.rim, rim.s[p.point] + stitch.fraction * (rim.s[p.point + 1] - rim.s[p.point])});
      const std::size_t before = (p.point + n - 1) % n;
      if (rim.vertices[before] == stitch.to)
        places.push_back({p.rim, rim.s[before + 1] - stitch.fraction * (rim.s[before + 1] - rim.s[before])});
    }
    return places;
  }

  /// Throws if one that is wanted is not there.
  void check_wanted() const {
    for (const std::string& name : options_.pieces)
      if (!contains(names_, name)) fail(fmt::format("there is no piece '{}':{}", name, suggestion(name, names_)));
  }

  /// By the smallest group that holds all of an island, with numbers where several islands have the same.
  void name_islands() {
    for (const Island& island : islands_) {
      const mesh::Group* best = nullptr;
      for (const mesh::Group& g : mesh_.groups) {
        if (g.dimension != 2 || (best != nullptr && g.triangles.size() >= best->triangles.size())) continue;
        const auto is_in = [&](Index t) { return std::binary_search(g.triangles.begin(), g.triangles.end(), t); };
        if (std::all_of(island.triangles.begin(), island.triangles.end(), is_in)) best = &g;
      }
      names_.push_back(best != nullptr ? best->name : "piece");
    }
    const std::vector<std::string> plain = names_;
    for (std::size_t k = 0, n = plain.size(); k < n; ++k)
      if (std::count(plain.begin(), plain.end(), plain[k]) > 1)
        names_[k] +=
            fmt::format("-{}", std::count(plain.begin(), plain.begin() + static_cast<std::ptrdiff_t>(k), plain[k]));
  }

  void add_piece(std::size_t k) {
    Piece piece;
    piece.name = names_[k];
    first_edge_.resize(rims_.size());
    for (std::size_t r = 0; r < rims_.size(); ++r) {
      if (rims_[r].piece != k) continue;
      first_edge_[r] = piece.edges.size();
      std::vector<Edge> loop;
      for (std::size_t e = 0; e + 1 < rims_[r].breaks.size(); ++e) loop.push_back({rims_[r].curve(e)});
      piece.add_loop(std::move(loop));
    }
    piece.turned = islands_[k].is_turned;
    put_in_place(piece, islands_[k]);
    if (options_.pieces.empty() || contains(options_.pieces, piece.name)) pattern_.pieces.push_back(std::move(piece));
  }

  /// The motion that brings a piece to where it lies in space (Kabsch), or, if it is bent there, its triangles.
  void put_in_place(Piece& piece, const Island& island) const {
    const auto n = static_cast<Eigen::Index>(island.points.size());
    Eigen::Matrix3Xd drawn(3, n), placed(3, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto p = static_cast<std::size_t>(i);
      drawn.col(i) << island.points[p], 0.0;
      placed.col(i) = position(island.vertices[p]);
    }
    const Vec3 from = drawn.rowwise().mean(), to = placed.rowwise().mean();
    const Mat3 covariance = (placed.colwise() - to) * (drawn.colwise() - from).transpose();
    const SingularValues svd = singular_value_decomposition(covariance);
    const double sense = Mat3(svd.u * svd.v.transpose()).determinant() < 0.0 ? -1.0 : 1.0;
    const Mat3 turn = svd.u * Vec3(1.0, 1.0, sense).asDiagonal() * svd.v.transpose();
    const double extent = (drawn.colwise() - from).colwise().norm().maxCoeff();
    const double away = ((placed.colwise() - to) - turn * (drawn.colwise() - from)).colwise().norm().maxCoeff();
    if (away <= flat_in_space * extent) {
      piece.rotation = turn;
      piece.translation = to - turn * from;
      return;
    }
    std::vector<Vec3> space;
    for (const Index v : island.vertices) space.push_back(position(v));
    piece.bent = std::make_shared<const BentShape>(island.points, std::move(space), island.corners);
  }

  void add_stitches(const std::vector<RimSeam>& seams) {
    for (std::size_t k = 0; k < seams.size(); ++k) {
      const RimSeam& seam = seams[k];
      Stitch stitch{{}, seam.is_along ? Sense::along : Sense::against, k};
      bool is_wanted = false;
      for (std::size_t i = 0; i < 2; ++i) {
        const std::string& name = names_[rims_[seam.rims[i]].piece];
        stitch.sides[i] = {name, first_edge_[seam.rims[i]] + seam.edges[i]};
        is_wanted = is_wanted || std::any_of(pattern_.pieces.begin(), pattern_.pieces.end(),
                                             [&](const Piece& p) { return p.name == name; });
      }
      if (is_wanted) pattern_.stitches.push_back(std::move(stitch));
    }
  }

  const ReadOptions& options_;
  formats::ObjSheet sheet_;
  mesh::MeshData& mesh_;
  Pattern pattern_;
  double unit_ = 1.0, texture_unit_ = 1.0, same_ = 0.0;
  std::vector<Island> islands_;
  std::vector<Rim> rims_;
  std::vector<std::string> names_;
  std::vector<std::size_t> first_edge_;  ///< number in its piece of the first edge of each rim
};

}  // namespace

Pattern read_obj(const std::filesystem::path& file, const ReadOptions& options) {
  return ObjReader(file, options).run();
}

}  // namespace voile::pattern
