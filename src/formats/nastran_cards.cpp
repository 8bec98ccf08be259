#include "nastran_cards.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <sstream>

#include "abaqus_words.hpp"
#include "mesh_text.hpp"
#include "voile/errors.hpp"

namespace voile::formats {

namespace {

constexpr std::size_t width = 8;

std::string trimmed_upper(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t"), end = text.find_last_not_of(" \t");
  return begin == std::string::npos ? "" : abaqus_upper(text.substr(begin, end - begin + 1));
}

/// As Fortran writes numbers: 1.5-3 and 1.5D-3 are 0.0015.
std::string with_exponent(const std::string& word) {
  std::string text;
  for (std::size_t k = 0; k < word.size(); ++k) {
    const char c = word[k] == 'D' ? 'E' : word[k];
    if (k > 0 && (c == '+' || c == '-') && word[k - 1] != 'E' && word[k - 1] != 'D') text += 'E';
    text += c;
  }
  return text;
}

/// A line cut into its name, data fields and mark of a continuation.
struct Line {
  std::string name, mark;
  std::vector<std::string> fields;
  bool continues = false;
};

std::string with_blanks(const std::string& line) {
  std::string text;
  for (const char c : line) {
    if (c != '\t')
      text += c;
    else
      text.append(width - text.size() % width, ' ');
  }
  return text;
}

/// The first character of a mark may be any.
std::string mark_of(const std::string& text) {
  return text.empty() ? "" : trimmed_upper(text.substr(1));
}

class FileReader {
 public:
  explicit FileReader(const std::string& file) : folder_(std::filesystem::path(file).parent_path()), file_(file) {}

  NastranFile run() {
    in_bulk_ = !has_control();
    read(0);
    return std::move(result_);
  }

 private:
  static constexpr int most_included = 8;

  [[nodiscard]] bool has_control() const {
    std::istringstream in(file_text(file_));
    for (std::string text; std::getline(in, text);)
      if (trimmed_upper(text).starts_with("BEGIN")) return true;
    return false;
  }

  void read(int depth) {
    std::istringstream in(file_text(file_));
    line_ = 0;
    for (std::string text; !ended_ && std::getline(in, text);) {
      ++line_;
      std::string kept = text.substr(0, text.find('$'));
      while (!kept.empty() && std::isspace(static_cast<unsigned char>(kept.back()))) kept.pop_back();
      if (kept.empty()) continue;
      const std::string upper = trimmed_upper(kept);
      if (upper.starts_with("INCLUDE"))
        include(in, kept, depth);
      else if (upper.starts_with("BEGIN"))
        begin(upper);
      else if (in_bulk_ && upper.starts_with("ENDDATA"))
        ended_ = true;
      else if (in_bulk_)
        take(cut(kept));
      else
        result_.control.push_back({upper, {}, file_, line_});
    }
  }

  void begin(const std::string& upper) {
    in_bulk_ = true;
    if (upper.find("SUPER") != std::string::npos || upper.find("AUXMODEL") != std::string::npos)
      fail_in_line(file_, line_, "superelements and auxiliary models are not read; write one model");
  }

  void include(std::istream& in, const std::string& first, int depth) {
    std::string name = first.substr(first.find_first_not_of(" \t") + 7), more;
    const std::size_t line = line_;
    const auto quotes = [&] {
      return std::count_if(name.begin(), name.end(), [](char c) { return c == '\'' || c == '"'; });
    };
    while (quotes() == 1 && std::getline(in, more)) {
      ++line_;
      name += more.substr(std::min(more.find_first_not_of(" \t"), more.size()));
    }
    std::erase_if(name, [](char c) { return c == '\'' || c == '"' || c == '\r'; });
    const std::size_t begin = std::min(name.find_first_not_of(" \t="), name.size());
    name = name.substr(begin, name.find_last_not_of(" \t") + 1 - begin);
    const std::filesystem::path inner(name);
    std::error_code ignored;
    std::filesystem::path at = std::filesystem::path(file_).parent_path() / inner;
    if (!std::filesystem::is_regular_file(at, ignored)) at = folder_ / inner;
    if (name.empty() || inner.is_absolute() || !std::filesystem::is_regular_file(at, ignored))
      fail_in_line(file_, line, fmt::format("INCLUDE: there is no file '{}' beside this one", name));
    if (depth >= most_included)
      fail_in_line(file_, line,
                   fmt::format("files include each other more than {} deep; is it a loop?", most_included));
    result_.included.push_back(name);
    const std::string outer = file_;
    const std::size_t after = line_;
    file_ = at.string();
    read(depth + 1);
    file_ = outer;
    line_ = after;
  }

  [[nodiscard]] Line cut(const std::string& text) const {
    std::vector<std::string> words;
    const bool is_free = text.find(',') != std::string::npos;
    std::string head;
    if (is_free) {
      std::istringstream in(text);
      for (std::string word; std::getline(in, word, ',');) words.push_back(trimmed_upper(word));
      head = words.front();
      words.erase(words.begin());
    } else {
      const std::string line = with_blanks(text);
      head = trimmed_upper(line.substr(0, width));
      const std::size_t each = head.find('*') != std::string::npos ? 2 * width : width;
      for (std::size_t at = width; at < std::min(line.size(), 9 * width); at += each)
        words.push_back(trimmed_upper(line.substr(at, std::min(each, 9 * width - at))));
      if (line.size() > 9 * width) {
        words.resize(8 * width / each);
        words.push_back(line.substr(9 * width, width));
      }
    }
    return as_line(head, std::move(words));
  }

  [[nodiscard]] Line as_line(const std::string& head, std::vector<std::string> words) const {
    Line line;
    const bool large = head.find('*') != std::string::npos;
    const std::size_t most = large ? 4 : 8;
    if (words.size() > most + 1)
      fail_in_line(file_, line_,
                   fmt::format("more than {} fields; continue them on a line that begins with '+' or ','", most));
    if (words.size() == most + 1) {
      line.mark = mark_of(words.back());
      words.pop_back();
    }
    words.resize(most);
    line.fields = std::move(words);
    line.continues = head.empty() || head.front() == '+' || head.front() == '*';
    line.name = line.continues ? (head.empty() ? "" : head.substr(1)) : head.substr(0, head.find('*'));
    while (!line.name.empty() && line.name.back() == ' ') line.name.pop_back();
    const auto replicates = [](const std::string& f) { return f == "=" || f.starts_with("*(") || f.starts_with("=("); };
    if (line.name.starts_with("=") || std::any_of(line.fields.begin(), line.fields.end(), replicates))
      fail_in_line(file_, line_, "replicated cards (=, *) are not read; write every card in full");
    if (!line.continues && (line.name.empty() || !std::isalpha(static_cast<unsigned char>(line.name.front()))))
      fail_in_line(file_, line_, fmt::format("'{}' is no name of a card", head));
    return line;
  }

  void take(Line line) {
    if (!line.continues) {
      result_.cards.push_back({line.name, std::move(line.fields), file_, line_});
    } else {
      if (result_.cards.empty() || line.name != mark_)
        fail_in_line(file_, line_,
                     fmt::format("the continuation '{}' does not follow its card; sort the file", line.name));
      std::vector<std::string>& fields = result_.cards.back().fields;
      fields.insert(fields.end(), line.fields.begin(), line.fields.end());
    }
    mark_ = line.mark;
  }

  std::filesystem::path folder_;
  std::string file_, mark_;
  std::size_t line_ = 0;
  bool in_bulk_ = false, ended_ = false;
  NastranFile result_;
};

}  // namespace

const std::string& NastranCard::field(std::size_t k) const {
  static const std::string blank;
  return k > 0 && k <= fields.size() ? fields[k - 1] : blank;
}

double NastranCard::real(std::size_t k) const {
  double value = 0.0;
  if (!parse_number(with_exponent(field(k)), value))
    fail(fmt::format("field {} is '{}'; a finite number is needed", k + 1, field(k)));
  return value;
}

long NastranCard::whole(std::size_t k) const {
  long value = 0;
  if (!parse_integer(field(k), value)) fail(fmt::format("field {} is '{}'; a whole number is needed", k + 1, field(k)));
  return value;
}

double NastranCard::real(std::size_t k, double otherwise) const {
  return field(k).empty() ? otherwise : real(k);
}

long NastranCard::whole(std::size_t k, long otherwise) const {
  return field(k).empty() ? otherwise : whole(k);
}

std::vector<long> NastranCard::list(std::size_t first, const std::set<long>& known) const {
  std::vector<long> numbers;
  for (std::size_t k = first; k <= fields.size(); ++k) {
    if (field(k).empty()) continue;
    if (field(k) != "THRU") {
      numbers.push_back(whole(k));
      continue;
    }
    const bool by = field(k + 2) == "BY";
    const long end = whole(k + 1), step = by ? whole(k + 3) : 1;
    if (numbers.empty() || end < numbers.back() || step < 1) fail("a range 'A THRU B' must ascend");
    const long begin = numbers.back();
    for (auto n = known.upper_bound(begin); n != known.end() && *n <= end; ++n)
      if ((*n - begin) % step == 0) numbers.push_back(*n);
    k += by ? 3 : 1;
  }
  return numbers;
}

void NastranCard::fail(const std::string& what) const {
  fail_in_line(file, line, name + ": " + what);
}

NastranFile read_nastran_file(const std::string& file) {
  return FileReader(file).run();
}

NastranSystems::NastranSystems(const std::vector<NastranCard>& cards) {
  const auto define = [&](const NastranCard& card, std::size_t first) {
    if (!definitions_.emplace(card.whole(first), std::pair(&card, first)).second)
      card.fail(fmt::format("coordinate system {} is there twice", card.field(first)));
  };
  for (const NastranCard& card : cards) {
    if (card.name == "GRDSET") defaults_ = &card;
    if (card.name.size() != 6 || !card.name.starts_with("CORD") ||
        std::string("RCS").find(card.name[5]) == std::string::npos)
      continue;
    define(card, 1);
    if (card.name[4] == '1' && !card.field(5).empty()) define(card, 5);
  }
  for (const NastranCard& card : cards) {
    if (card.name != "GRID") continue;
    const auto [at, fresh] = grids_.emplace(card.whole(1), &card);
    if (!fresh && at->second->fields != card.fields)
      card.fail(fmt::format("grid point {} is there twice, first in line {}", at->first, at->second->line));
  }
}

Vec3 NastranSystems::point(long id, const NastranCard& user) {
  const auto at = grids_.find(id);
  if (at == grids_.end()) user.fail(fmt::format("there is no grid point {}", id));
  const NastranCard& g = *at->second;
  const long given = defaults_ ? defaults_->whole(2, 0L) : 0L;
  return placed(g.whole(2, given), Vec3(g.real(3, 0.0), g.real(4, 0.0), g.real(5, 0.0)), g);
}

Vec3 NastranSystems::placed(long id, const Vec3& x, const NastranCard& user) {
  if (id == 0) return x;
  const System& s = system(id, user);
  constexpr double degree = std::numbers::pi / 180.0;
  Vec3 local = x;
  if (s.kind == 'C') local = Vec3(x[0] * std::cos(degree * x[1]), x[0] * std::sin(degree * x[1]), x[2]);
  if (s.kind == 'S')
    local = x[0] * Vec3(std::sin(degree * x[1]) * std::cos(degree * x[2]),
                        std::sin(degree * x[1]) * std::sin(degree * x[2]), std::cos(degree * x[1]));
  return s.origin + s.axes * local;
}

const NastranSystems::System& NastranSystems::system(long id, const NastranCard& user) {
  if (const auto known = systems_.find(id); known != systems_.end()) return known->second;
  const auto at = definitions_.find(id);
  if (at == definitions_.end())
    user.fail(
        fmt::format("there is no coordinate system {} (CORD1R, CORD2R, CORD1C, CORD2C, CORD1S or CORD2S); without it "
                    "the places are unknown: add the card",
                    id));
  const auto [card, k] = at->second;
  if (++depth_ > 100) card->fail(fmt::format("coordinate system {} refers to itself", id));
  std::array<Vec3, 3> p;  // origin, on the third axis, in the plane of the first and third
  for (std::size_t i = 0; i < 3; ++i)
    p[i] =
        card->name[4] == '1'
            ? point(card->whole(k + 1 + i), *card)
            : placed(card->whole(2, 0L),
                     Vec3(card->real(3 + 3 * i, 0.0), card->real(4 + 3 * i, 0.0), card->real(5 + 3 * i, 0.0)), *card);
  --depth_;
  const Vec3 z = p[1] - p[0], y = z.cross(p[2] - p[0]);
  if (!(y.norm() > 1e-10 * z.norm() * (p[2] - p[0]).norm())) card->fail("its three points lie on a line");
  System s{card->name[5], p[0], {}};
  s.axes.col(2) = z.normalized();
  s.axes.col(1) = y.normalized();
  s.axes.col(0) = s.axes.col(1).cross(s.axes.col(2));
  return systems_[id] = s;
}

Vec3 NastranSystems::turned(long id, const Vec3& vector, const NastranCard& card) {
  if (id == 0) return vector;
  const System& s = system(id, card);
  if (s.kind != 'R') card.fail(fmt::format("coordinate system {} is curved; give the vector in a rectangular one", id));
  return s.axes * vector;
}

std::map<long, Vec3> NastranSystems::points() {
  std::map<long, Vec3> places;
  for (const auto& [id, card] : grids_) places[id] = point(id, *card);
  return places;
}

}  // namespace voile::formats
