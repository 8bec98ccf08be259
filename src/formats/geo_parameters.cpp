#include "geo_parameters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <vector>

#include "base/plain_file.hpp"
#include "voile/errors.hpp"

namespace voile::formats {

namespace fs = std::filesystem;

namespace {

std::string text_of(const fs::path& file) {
  std::ifstream in = open_input(file);
  std::stringstream text;
  text << in.rdbuf();
  if (!in) throw UserError(fmt::format("{}: the file cannot be read; check its name and permissions", file.string()));
  return text.str();
}

/// A piece of a script: a word (also a number), a string without its quotes, or one other character.
struct Token {
  enum class Kind { word, string, sign };
  Kind kind;
  std::string text;

  [[nodiscard]] bool is_word(const char* w) const { return kind == Kind::word && text == w; }
  [[nodiscard]] bool is_sign(char c) const { return kind == Kind::sign && text[0] == c; }
  [[nodiscard]] bool opens() const { return is_sign('(') || is_sign('[') || is_sign('{'); }
  [[nodiscard]] bool closes() const { return is_sign(')') || is_sign(']') || is_sign('}'); }
};

bool is_word_character(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_';
}

/// The script in pieces, without blanks and comments.
std::vector<Token> tokens_of(const std::string& text) {
  std::vector<Token> tokens;
  const auto end_of = [&](const char* mark, std::size_t from) { return std::min(text.find(mark, from), text.size()); };
  for (std::size_t i = 0; i < text.size();) {
    std::size_t end = i + 1;
    if (text[i] == '"') {
      end = end_of("\"", i + 1);
      tokens.push_back({Token::Kind::string, text.substr(i + 1, end - i - 1)});
      ++end;
    } else if (text.compare(i, 2, "//") == 0) {
      end = end_of("\n", i);
    } else if (text.compare(i, 2, "/*") == 0) {
      end = end_of("*/", i + 2) + 2;
    } else if (is_word_character(text[i])) {
      while (end < text.size() && is_word_character(text[end])) ++end;
      tokens.push_back({Token::Kind::word, text.substr(i, end - i)});
    } else if (!std::isspace(static_cast<unsigned char>(text[i]))) {
      tokens.push_back({Token::Kind::sign, text.substr(i, 1)});
    }
    i = end;
  }
  // Lets the rules look ahead without asking for the end.
  tokens.insert(tokens.end(), 4, {Token::Kind::sign, " "});
  return tokens;
}

/// Position behind the bracket that closes the one at `open`.
std::size_t behind_brackets(const std::vector<Token>& tokens, std::size_t open) {
  int depth = 0;
  for (std::size_t i = open; i < tokens.size(); ++i) {
    depth += static_cast<int>(tokens[i].opens()) - static_cast<int>(tokens[i].closes());
    if (depth == 0) return i + 1;
  }
  return tokens.size();
}

/// Names in "[a, b = 1, c = {2, Name "x"}]": the words that follow the bracket or a comma outside inner brackets.
void add_constants(const std::vector<Token>& tokens, std::size_t open, GeoParameters& found) {
  const std::size_t end = behind_brackets(tokens, open);
  bool expects_name = true;
  for (std::size_t i = open + 1; i < end;) {
    if (expects_name && tokens[i].kind == Token::Kind::word) found[tokens[i].text] = "";
    expects_name = tokens[i].is_sign(',');
    i = tokens[i].opens() ? behind_brackets(tokens, i) : i + 1;
  }
}

/// The ONELAB name in "[4, Name "Parameters/n"]", under which Gmsh looks the number up.
void add_number(const std::vector<Token>& tokens, const std::string& variable, std::size_t open, GeoParameters& found) {
  const std::size_t end = behind_brackets(tokens, open);
  for (std::size_t i = open; i + 1 < end; ++i)
    if (tokens[i].is_word("Name") && tokens[i + 1].kind == Token::Kind::string) found[variable] = tokens[i + 1].text;
}

void collect(const fs::path& file, GeoParameters& found, std::set<fs::path>& seen) {
  std::error_code ignored;
  if (!seen.insert(file.lexically_normal()).second || !fs::is_regular_file(file, ignored)) return;
  const std::vector<Token> tokens = tokens_of(text_of(file));
  for (std::size_t i = 0; i + 4 < tokens.size(); ++i) {
    const Token &here = tokens[i], &next = tokens[i + 1];
    if (here.is_word("Exit") && next.is_sign(';'))
      throw UserError(fmt::format("{}: the command 'Exit' would end the program; remove it", file.string()));
    if (here.is_word("DefineConstant") && next.opens()) add_constants(tokens, i + 1, found);
    if (here.kind == Token::Kind::word && next.is_sign('=') && tokens[i + 2].is_word("DefineNumber"))
      add_number(tokens, here.text, i + 3, found);
    if (here.is_word("Exists") && next.opens() && tokens[i + 2].kind == Token::Kind::word)
      found.emplace(tokens[i + 2].text, "");
    if (here.is_word("Include") && next.kind == Token::Kind::string)
      collect(file.parent_path() / next.text, found, seen);
  }
}

}  // namespace

GeoParameters geo_parameters(const std::string& file) {
  GeoParameters found;
  std::set<fs::path> seen;
  collect(file, found, seen);
  return found;
}

}  // namespace voile::formats
