#include "geo_safety.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string_view>

#include "base/plain_file.hpp"
#include "base/text.hpp"
#include "voile/errors.hpp"

namespace voile::formats {

namespace {

namespace fs = std::filesystem;

/// Wherever they stand.
constexpr std::array<std::string_view, 6> always{"SystemCall", "NonBlockingSystemCall", "NonblockingSystemCall",
                                                 "OnelabRun",  "ExternalProcess",       "CreateDir"};
/// Words of plain language too: only with something like a file or command behind them.
constexpr std::array<std::string_view, 3> with_argument{"System", "Save", "Print"};
constexpr std::array<std::string_view, 3> printing{"Printf", "Error", "Warning"};
constexpr std::array<std::string_view, 4> including{"Include", "Merge", "MergeWithBoundingBox", "ShapeFromFile"};
/// Gmsh starts programs for these.
constexpr std::array<std::string_view, 6> programs{".gz", ".py", ".m", ".exe", ".ol", ".sh"};

bool in_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_';
}

bool is_quote(char c) {
  return c == '"' || c == '\'';
}

class Scan {
 public:
  Scan(fs::path file, std::set<fs::path>& seen) : file_(std::move(file)), seen_(seen) {
    std::ifstream in = open_input(file_);
    std::stringstream buffer;
    buffer << in.rdbuf();
    text_ = buffer.str();
  }

  void run() {
    for (std::size_t i = 0; i < text_.size();) {
      if (!in_word(text_[i])) {
        ++i;
        continue;
      }
      std::size_t end = i;
      while (end < text_.size() && in_word(text_[end])) ++end;
      judge(std::string_view(text_).substr(i, end - i), i, end);
      i = end;
    }
  }

 private:
  [[noreturn]] void refuse(std::size_t at, const std::string& what) const {
    const auto line = std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at), '\n') + 1;
    throw UserError(
        fmt::format("{}:{}: {}; a script could do anything with your files, so this is refused: remove it, or give "
                    "--allow-system-call "
                    "if you trust the file",
                    file_.string(), line, what));
  }

  /// First place from `at` on that is neither blank nor comment.
  [[nodiscard]] std::size_t behind_blanks(std::size_t at) const {
    for (;;) {
      while (at < text_.size() && std::isspace(static_cast<unsigned char>(text_[at]))) ++at;
      if (at >= text_.size()) return text_.size();
      if (text_.compare(at, 2, "//") == 0)
        at = std::min(text_.find('\n', at), text_.size());
      else if (text_.compare(at, 2, "/*") == 0)
        at = std::min(text_.find("*/", at + 2), text_.size() - 2) + 2;
      else
        return at;
    }
  }
  [[nodiscard]] char at(std::size_t i) const { return i < text_.size() ? text_[i] : '\0'; }

  /// A text in quotes, or a word that goes on as an expression of texts does.
  [[nodiscard]] bool is_expression(std::size_t begin) const {
    if (is_quote(at(begin))) return true;
    std::size_t end = begin;
    while (in_word(at(end))) ++end;
    if (end == begin) return false;
    const std::size_t behind = behind_blanks(end);
    const char next = at(behind);
    return next == '(' || next == '[' || next == ';' || next == '~' || (next == '.' && in_word(at(behind + 1))) ||
           text_.compare(std::min(behind, text_.size()), 2, "::") == 0;
  }

  /// The message goes into a file: "(...) > name".
  [[nodiscard]] bool is_redirected(std::size_t open) const {
    if (at(open) != '(' && at(open) != '[') return false;
    int depth = 0;
    for (std::size_t i = open; i < text_.size(); ++i) {
      if (is_quote(text_[i])) i = std::min(text_.find(text_[i], i + 1), text_.size());
      const char c = at(i);
      depth += c == '(' || c == '[' ? 1 : c == ')' || c == ']' ? -1 : 0;
      if (depth == 0) return at(behind_blanks(i + 1)) == '>';
    }
    return true;  // never closed: whatever follows is not what it seems
  }

  void judge(std::string_view word, std::size_t begin, std::size_t end) {
    const std::size_t next = behind_blanks(end);
    const std::string name(word);
    if (contains(always, word)) refuse(begin, fmt::format("'{}' runs a program or writes to the disk", name));
    if (contains(with_argument, word) && is_expression(next))
      refuse(begin, fmt::format("'{}' runs a program or writes a file", name));
    if (contains(printing, word) && is_redirected(next)) refuse(begin, fmt::format("'{}' writes into a file", name));
    if (word == "Plugin" && at(next) == '(') {
      const std::size_t plugin = behind_blanks(next + 1);
      std::size_t stop = plugin;
      while (in_word(at(stop))) ++stop;
      if (const std::string which = text_.substr(plugin, stop - plugin); which != "Crack")
        refuse(begin, fmt::format("'Plugin({})' may write files", which));
    }
    if (contains(including, word)) follow(name, begin, next);
  }

  /// What is included or merged is read as a script unless it is known for something else.
  void follow(const std::string& word, std::size_t begin, std::size_t next) {
    if (!is_quote(at(next))) {
      if (is_expression(next))
        refuse(begin, fmt::format("'{}' reads a file whose name is known only as the script runs", word));
      return;
    }
    const std::size_t close = std::min(text_.find(text_[next], next + 1), text_.size());
    const fs::path named = file_.parent_path() / text_.substr(next + 1, close - next - 1);
    if (contains(programs, named.extension().string()))
      refuse(begin, fmt::format("'{}' of '{}' runs a program", word, named.filename().string()));
    std::error_code ignored;
    if (fs::exists(named, ignored)) require_plain_file(named);
    if (!fs::is_regular_file(named, ignored) || !seen_.insert(named.lexically_normal()).second) return;
    Scan other(named, seen_);
    // A merged mesh holds no commands; an included file is a script whatever it begins with.
    if (word == "Include" || word == "ShapeFromFile" || !other.text_.starts_with("$MeshFormat")) other.run();
  }

  fs::path file_;
  std::string text_;
  std::set<fs::path>& seen_;
};

}  // namespace

void check_script_name(const std::string& file) {
  const std::string name = fs::absolute(file).string();
  for (const char c : name)
    if (c == '"' || c == '\\' || static_cast<unsigned char>(c) < 32)
      throw UserError(fmt::format(
          "{}: the path of a script must not contain quotes, backslashes or line breaks; rename the file or its folder",
          printable(file)));
}

void refuse_dangerous_commands(const std::string& file) {
  std::set<fs::path> seen{fs::path(file).lexically_normal()};
  Scan(file, seen).run();
  std::error_code ignored;
  if (fs::is_regular_file(file + ".opt", ignored)) Scan(file + ".opt", seen).run();  // Gmsh reads it too
}

}  // namespace voile::formats
