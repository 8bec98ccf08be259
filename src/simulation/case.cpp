#include "voile/case.hpp"

#include <fmt/format.h>

#include <fstream>
#include <sstream>
#include <system_error>

#include "base/plain_file.hpp"
#include "base/text.hpp"
#include "input/case.hpp"
#include "voile/errors.hpp"

namespace voile {

namespace {

/// Under which a text without a file is named in messages, in its folder.
constexpr const char* nameless = "case.toml";

/// As TOML wants it: with a point or an exponent; inf and nan as they are.
std::string number(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_not_of("-0123456789") == std::string::npos) text += ".0";
  return text;
}

}  // namespace

Case Case::read(const std::filesystem::path& file) {
  std::error_code ignored;
  std::ifstream in = open_input(file);
  if (!in || std::filesystem::is_directory(file, ignored))
    throw UserError(fmt::format("{}: there is no such case file", file.string()));
  std::ostringstream buffer;
  buffer << in.rdbuf();
  return {buffer.str(), file};
}

Case Case::parse(std::string text, const std::filesystem::path& folder) {
  return {std::move(text), folder / nameless};
}

Case& Case::set(const std::string& key, double value) {
  settings_.push_back(key + "=" + number(value));
  return *this;
}

Case& Case::set(const std::string& key, int value) {
  settings_.push_back(fmt::format("{}={}", key, value));
  return *this;
}

Case& Case::set(const std::string& key, bool value) {
  settings_.push_back(key + (value ? "=true" : "=false"));
  return *this;
}

Case& Case::set(const std::string& key, const std::string& value) {
  settings_.push_back(key + "=" + toml_text(value));
  return *this;
}

Case& Case::set(const std::string& key, const std::vector<double>& value) {
  std::string all;
  for (const double x : value) all += (all.empty() ? "" : ", ") + number(x);
  settings_.push_back(key + "=[" + all + "]");
  return *this;
}

std::string Case::text() const {
  return input::echo_case(input::parse_case(text_, file_, settings_));
}

}  // namespace voile
