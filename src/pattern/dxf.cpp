// Pieces of a DXF: closed outlines of a drawing, or blocks as AAMA/ASTM D6673 has them, a piece each.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "base/text.hpp"
#include "dxf_block.hpp"
#include "outline.hpp"
#include "readers.hpp"
#include "voile/errors.hpp"

namespace voile::pattern {

namespace {

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// What follows a word such as "Piece Name:" in one of the texts of a block; empty if none has it.
std::string told(const std::vector<DxfEntity>& entities, const std::string& word) {
  for (const DxfEntity& e : entities) {
    if (e.type != "TEXT" && e.type != "MTEXT" && e.type != "ATTRIB") continue;
    const std::string text = e.text(1);
    if (!lower(text).starts_with(word)) continue;
    const std::size_t at = text.find_first_not_of(" \t", word.size());
    if (at != std::string::npos) return text.substr(at, text.find_last_not_of(" \t") + 1 - at);
  }
  return "";
}

class DxfReader {
 public:
  DxfReader(const std::filesystem::path& file, const ReadOptions& options)
      : options_(options), file_(read_dxf_entities(file)) {
    pattern_.file = file;
    pattern_.notes = file_.notes;
  }

  Pattern run() {
    unit_ = options_.unit > 0.0 ? options_.unit : file_unit();
    note_placed();
    std::vector<const DxfBlock*> blocks;
    for (const DxfBlock& b : file_.blocks)
      if (is_piece(b)) blocks.push_back(&b);
    if (blocks.empty() && !options_.nest_size.empty())
      throw UserError(fmt::format(
          "{}: nest_size: its pieces are no blocks of AAMA/ASTM, which have sizes; remove the key", name()));
    if (blocks.empty()) {
      read_drawing();
      if (!placed_.empty() && !pattern_.pieces.empty())
        pattern_.notes.push_back(fmt::format(
            "{}: blocks that are placed are passed over; explode {} if they are pieces", name(), join(placed_, ", ")));
    } else {
      read_blocks(of_size(blocks));
    }
    if (pattern_.pieces.empty() && !blocks.empty())
      throw UserError(fmt::format("{}: `pieces` names none of those there are: {}", name(), join(seen_, ", ")));
    if (pattern_.pieces.empty())
      throw UserError(fmt::format(
          "{}: there is no outline in it; draw each piece as a closed polyline or as lines, arcs and splines "
          "that join, or export blocks of AAMA/ASTM{}{}",
          name(),
          placed_.empty() ? ""
                          : fmt::format("; blocks that are placed are passed over, explode {}", join(placed_, ", ")),
          seen_.empty() ? "" : fmt::format("; `pieces` names none of those there are: {}", join(seen_, ", "))));
    return std::move(pattern_);
  }

 private:
  [[nodiscard]] std::string name() const { return pattern_.file.string(); }
  [[nodiscard]] bool is_wanted(const std::string& piece) const {
    return options_.pieces.empty() ||
           std::find(options_.pieces.begin(), options_.pieces.end(), piece) != options_.pieces.end();
  }

  /// Those of the size that is asked for.
  [[nodiscard]] std::vector<const DxfBlock*> of_size(const std::vector<const DxfBlock*>& blocks) const {
    if (options_.nest_size.empty()) return blocks;
    std::vector<const DxfBlock*> found;
    std::vector<std::string> sizes;
    bool any = false;
    for (const DxfBlock* b : blocks) {
      const std::string size = told(b->entities, "size:");
      any = any || size == options_.nest_size;
      if (size == options_.nest_size || size.empty()) found.push_back(b);  // without one it is of all sizes
      if (!size.empty() && !contains(sizes, size)) sizes.push_back(size);
    }
    if (!any)
      throw UserError(fmt::format("{}: nest_size = \"{}\": {}", name(), options_.nest_size,
                                  sizes.empty() ? "no block has a text 'Size:'; name blocks by the key pieces"
                                                : "no block is of this size; there are " + join(sizes, ", ")));
    return found;
  }

  [[nodiscard]] int variable(const char* key) const {
    const auto at = file_.variables.find(key);
    return at == file_.variables.end() ? -1 : std::atoi(at->second.c_str());
  }

  [[nodiscard]] double file_unit() {
    static const std::map<int, double> units{{1, 0.0254}, {2, 0.3048},  {4, 1e-3}, {5, 1e-2},
                                             {6, 1.0},    {10, 0.9144}, {14, 0.1}};
    std::string words = told(file_.entities, "units:");
    for (const DxfBlock& b : file_.blocks)
      if (words.empty()) words = told(b.entities, "units:");
    words = lower(words);
    if (const auto at = units.find(variable("$INSUNITS")); at != units.end()) {
      const bool is_english = at->first == 1 || at->first == 2 || at->first == 10;
      if (words.starts_with(is_english ? "metric" : "english"))
        pattern_.notes.push_back(fmt::format(
            "{}: its text 'Units: {}' contradicts $INSUNITS, which makes a unit {:g} m and is taken; the key unit of "
            "[[panel]] sets it",
            name(), words, at->second));
      return at->second;
    }
    if (words.starts_with("metric")) return 1e-3;
    if (words.starts_with("english")) return 0.0254;
    const int measurement = variable("$MEASUREMENT");
    if (measurement != 0 && measurement != 1)
      throw UserError(fmt::format(
          "{}: neither $INSUNITS nor $MEASUREMENT nor a text 'Units:' gives the length of a unit; give the key unit "
          "of [[panel]], the length of a unit in metres (0.001 for millimetres)",
          name()));
    pattern_.notes.push_back(
        fmt::format("{}: $MEASUREMENT = {}, so a unit is taken for {}; the key unit of [[panel]] sets it", name(),
                    measurement, measurement == 1 ? "a millimetre" : "an inch"));
    return measurement == 1 ? 1e-3 : 0.0254;
  }

  /// Blocks are read as they are, wherever a drawing places them: in no other size.
  void note_placed() {
    for (const DxfEntity& e : file_.entities) {
      if (e.type != "INSERT") continue;
      const std::string block = e.text(2);
      for (const int scale : {41, 42})
        if (std::abs(std::abs(e.real(scale, 1.0)) - 1.0) > 1e-9)
          e.fail(fmt::format("it places block '{}' {:g} times as large; explode it, or draw the block in its size",
                             block, e.real(scale, 1.0)));
      if (!contains(placed_, block)) placed_.push_back(block);
      ++times_placed_[block];
      if (e.real(41, 1.0) * e.real(42, 1.0) < 0.0) ++times_mirrored_[block];
    }
  }

  /// A block is one piece, as it is drawn, however often and on which side it is to be cut.
  void note_copies(const DxfBlock& b, const std::string& piece) {
    const std::string quantity = told(b.entities, "quantity:");
    const auto of = [&](const std::map<std::string, int>& counts) {
      const auto at = counts.find(b.name);
      return at == counts.end() ? 0 : at->second;
    };
    const int placed = of(times_placed_), mirrored = of(times_mirrored_);
    if (placed <= 1 && mirrored == 0 && (quantity.empty() || quantity == "1")) return;
    std::string why = quantity.empty() || quantity == "1" ? "" : "quantity " + quantity;
    if (placed > 1 || mirrored > 0)
      why += fmt::format("{}placed {} time(s), {} of them mirrored", why.empty() ? "" : ", ", placed, mirrored);
    pattern_.notes.push_back(fmt::format(
        "{}: piece '{}' ({}) is read once, as it is drawn; a [[panel]] of its own, with mirror = true for a "
        "mirrored one, makes another",
        name(), piece, why));
  }

  [[nodiscard]] Piece scaled(Piece piece) const {
    const Mat2 scale = unit_ * Mat2::Identity();
    for (Edge& e : piece.edges) e.curve = e.curve.mapped(scale, Vec2::Zero());
    return piece;
  }

  static std::vector<Edge> edges_of(const std::vector<Curve>& loop) {
    std::vector<Edge> edges;
    for (const Curve& c : loop) edges.push_back({c});
    return edges;
  }

  void read_blocks(const std::vector<const DxfBlock*>& blocks) {
    std::map<std::string, int> count;
    std::string wrong;  // the first mistake
    for (const DxfBlock* b : blocks) ++count[told(b->entities, "piece name:")];
    for (const DxfBlock* b : blocks) {
      // Where sizes of one piece are there, or none has a name, blocks go by their own.
      const std::string own = told(b->entities, "piece name:"),
                        piece_name = own.empty() || count[own] > 1 ? b->name : own;
      seen_.push_back(piece_name);
      if (!is_wanted(piece_name)) continue;
      // One size that is wrong does not keep the others of a nest away, unless it is the one that is asked for.
      const bool alone = blocks.size() == 1 || !options_.pieces.empty();
      std::vector<std::string> notes;
      try {
        Piece piece = scaled(read_block(fmt::format("{}: block '{}'", name(), b->name), *b, notes));
        piece.name = piece_name;
        if (!alone) check_piece(pattern_, piece);
        pattern_.notes.insert(pattern_.notes.end(), notes.begin(), notes.end());
        note_copies(*b, piece_name);
        pattern_.pieces.push_back(std::move(piece));
      } catch (const UserError& e) {
        if (alone) throw;
        if (wrong.empty()) wrong = e.what();
        pattern_.notes.push_back(fmt::format("{}; this piece is left out, `pieces` names those to read", e.what()));
      }
    }
    if (pattern_.pieces.empty() && !wrong.empty()) throw UserError(wrong);
  }

  /// The outline that each one is a hole of, or its own number: of outlines that lie within each other every second one is a
  /// hole in that around it.
  static std::vector<std::size_t> pieces_of(const std::vector<std::vector<Curve>>& outlines) {
    Polygons polygons;
    for (const std::vector<Curve>& outline : outlines) polygons.push_back(polygon_of(outline));
    std::vector<std::vector<std::size_t>> around(outlines.size());
    for (std::size_t k = 0; k < outlines.size(); ++k)
      for (std::size_t other = 0; other < outlines.size(); ++other)
        if (other != k && is_inside(polygons[other], polygons[k].front())) around[k].push_back(other);
    std::vector<std::size_t> piece_of(outlines.size());
    for (std::size_t k = 0; k < outlines.size(); ++k) {
      piece_of[k] = k;
      for (const std::size_t other : around[k])
        if (around[k].size() % 2 == 1 && around[other].size() + 1 == around[k].size()) piece_of[k] = other;
    }
    return piece_of;
  }

  /// Each outline of a layer is a piece, called after the layer.
  void read_drawing() {
    std::vector<std::string> layers;
    for (const DxfEntity& e : file_.entities)
      if (std::find(layers.begin(), layers.end(), e.layer) == layers.end()) layers.push_back(e.layer);
    for (const std::string& layer : layers) {
      const auto wants = [&](const std::string& piece) { return piece == layer || piece.starts_with(layer + "-"); };
      if (!options_.pieces.empty() && std::none_of(options_.pieces.begin(), options_.pieces.end(), wants)) {
        seen_.push_back(layer);
        continue;
      }
      const std::vector<std::vector<Curve>> outlines =
          join_curves(fmt::format("{}: layer '{}'", name(), layer), curves_on(file_.entities, layer), {});
      const std::vector<std::size_t> piece_of = pieces_of(outlines);
      std::size_t count = 0, number = 0;
      for (std::size_t k = 0; k < outlines.size(); ++k) count += piece_of[k] == k ? 1 : 0;
      for (std::size_t k = 0; k < outlines.size(); ++k) {
        if (piece_of[k] != k) continue;
        Piece piece;
        piece.name = count == 1 ? layer : fmt::format("{}-{}", layer, number++);
        seen_.push_back(piece.name);
        if (!is_wanted(piece.name)) continue;
        piece.add_loop(edges_of(outlines[k]));
        for (std::size_t hole = 0; hole < outlines.size(); ++hole)
          if (hole != k && piece_of[hole] == k) piece.add_loop(edges_of(outlines[hole]));
        pattern_.pieces.push_back(scaled(std::move(piece)));
      }
    }
  }

  const ReadOptions& options_;
  DxfFile file_;
  Pattern pattern_;
  std::vector<std::string> seen_;    ///< names of outlines
  std::vector<std::string> placed_;  ///< names of blocks
  std::map<std::string, int> times_placed_, times_mirrored_;
  double unit_ = 0.0;
};

}  // namespace

Pattern read_dxf(const std::filesystem::path& file, const ReadOptions& options) {
  return DxfReader(file, options).run();
}

}  // namespace voile::pattern
