#include "dxf_entities.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "readers.hpp"
#include "voile/errors.hpp"

namespace voile::pattern {

namespace {

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r"), end = text.find_last_not_of(" \t\r");
  return begin == std::string_view::npos ? std::string_view() : text.substr(begin, end - begin + 1);
}

class EntityReader {
 public:
  explicit EntityReader(const std::filesystem::path& file) : file_(file.string()), text_(text_of(file)) {
    if (text_.starts_with("AutoCAD Binary DXF") || text_.starts_with("AC10"))
      throw UserError(fmt::format("{}: this is a binary drawing; export it as an ASCII DXF", file_));
    if (text_.starts_with("\xff\xfe") || text_.starts_with("\xfe\xff"))
      throw UserError(fmt::format("{}: this is text of two bytes for each letter (UTF-16); save it as UTF-8", file_));
  }

  DxfFile run() {
    DxfGroup g;
    std::string section;
    bool named = false;  // whether the group before has begun a section
    bool ends = false;
    while (next(g)) {
      if (g.code == 0) {
        end_entity();
        named = g.text == "SECTION";
        ends = g.text == "EOF";
        if (ends) break;
        if (named || g.text == "ENDSEC")
          section.clear();
        else if (section == "BLOCKS" || section == "ENTITIES")
          begin_entity(g);
      } else if (named && g.code == 2) {
        section = g.text;
        named = false;
        is_in_block_ = false;
      } else if (section == "HEADER") {
        if (g.code == 9) variable_ = g.text;
        if (g.code != 9 && !variable_.empty()) out_.variables.insert({variable_, g.text});
      } else if (is_open_) {
        if (g.code == 8) entity_.layer = g.text;
        entity_.groups.push_back(g);
      }
    }
    end_entity();
    if (!ends)
      out_.notes.push_back(fmt::format(
          "{}: it does not end with EOF; if it was cut short, pieces may be missing: export it again", file_));
    return std::move(out_);
  }

 private:
  bool line(std::string_view& out) {
    if (at_ >= text_.size()) return false;
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    out = trimmed(std::string_view(text_).substr(at_, end - at_));
    at_ = end + 1;
    ++line_;
    return true;
  }

  bool next(DxfGroup& g) {
    std::string_view code, text;
    do {
      if (!line(code)) return false;
    } while (code.empty() && at_ >= text_.size());
    const auto [end, error] = std::from_chars(code.data(), code.data() + code.size(), g.code);
    if (error != std::errc() || end != code.data() + code.size())
      throw UserError(
          fmt::format("{}, line {}: the number of a group is expected here, not '{}': this is no ASCII DXF, or "
                      "a line of it is missing; export it again",
                      file_, line_, code.substr(0, 40)));
    if (!line(text))
      throw UserError(fmt::format("{}: the file ends within a group, at line {}; export it again", file_, line_));
    g.text = text;
    g.line = line_;
    return true;
  }

  void begin_entity(const DxfGroup& g) {
    entity_ = {g.text, "", fmt::format("{}, line {}: {}", file_, g.line, g.text), {}};
    is_open_ = true;
  }

  void end_entity() {
    if (!is_open_) return;
    is_open_ = false;
    if (entity_.type == "BLOCK") {
      out_.blocks.push_back({entity_.text(2), {}});
      is_in_block_ = true;
    } else if (entity_.type == "ENDBLK") {
      is_in_block_ = false;
    } else {
      std::vector<DxfEntity>& to = is_in_block_ ? out_.blocks.back().entities : out_.entities;
      if (entity_.type == "VERTEX" && !to.empty() && to.back().type == "POLYLINE")
        to.back().vertices.push_back(std::move(entity_));
      else if (entity_.type != "SEQEND")
        to.push_back(std::move(entity_));
    }
  }

  std::string file_, text_;
  std::size_t at_ = 0, line_ = 0;
  std::string variable_;
  DxfEntity entity_;
  bool is_open_ = false, is_in_block_ = false;
  DxfFile out_;
};

double number(const DxfEntity& e, const DxfGroup& g) {
  char* end = nullptr;
  const double x = std::strtod(g.text.c_str(), &end);
  if (g.text.empty() || *end != 0 || !std::isfinite(x))
    e.fail(fmt::format("group {} at line {} must be a finite number, not '{}'", g.code, g.line, g.text.substr(0, 40)));
  return x;
}

}  // namespace

void DxfEntity::fail(const std::string& message) const {
  throw UserError(fmt::format("{} on layer '{}': {}", where, layer, message));
}

bool DxfEntity::has(int code) const {
  return std::any_of(groups.begin(), groups.end(), [&](const DxfGroup& g) { return g.code == code; });
}

double DxfEntity::real(int code, double absent) const {
  for (const DxfGroup& g : groups)
    if (g.code == code) return number(*this, g);
  return absent;
}

int DxfEntity::whole(int code, int absent) const {
  const double x = real(code, absent);
  if (x != std::floor(x) || std::abs(x) > 1e9) fail(fmt::format("group {} must be a whole number, not {}", code, x));
  return static_cast<int>(x);
}

std::string DxfEntity::text(int code) const {
  for (const DxfGroup& g : groups)
    if (g.code == code) return g.text;
  return "";
}

std::vector<double> DxfEntity::reals(int code) const {
  std::vector<double> all;
  for (const DxfGroup& g : groups)
    if (g.code == code) all.push_back(number(*this, g));
  return all;
}

Vec2 DxfEntity::point(int x, int y) const {
  if (!has(x) || !has(y)) fail(fmt::format("it has no point: groups {} and {} are missing", x, y));
  return {real(x, 0.0), real(y, 0.0)};
}

DxfFile read_dxf_entities(const std::filesystem::path& file) {
  return EntityReader(file).run();
}

}  // namespace voile::pattern
