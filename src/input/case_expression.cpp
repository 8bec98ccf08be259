#include <fmt/format.h>
#include <muParser.h>

#include <cctype>
#include <cmath>
#include <cstring>
#include <memory>
#include <numbers>

#include "base/text.hpp"
#include "expression.hpp"
#include "voile/errors.hpp"

namespace voile::input {

namespace {

double table(const double* x, int count) {
  if (count < 3 || count % 2 == 0) throw mu::ParserError("table needs t and then pairs of time and value");
  const double t = x[0];
  for (int i = 3; i < count; i += 2)
    if (!(x[i] > x[i - 2])) throw mu::ParserError("the times of a table must ascend");
  if (t <= x[1]) return x[2];
  for (int i = 3; i < count; i += 2)
    if (t <= x[i]) return x[i - 1] + (x[i + 1] - x[i - 1]) * (t - x[i - 2]) / (x[i] - x[i - 2]);
  return x[count - 1];
}

/// Sets and tries the text. muParser would take the last of numbers with commas between them, and assign to variables.
double parse(mu::Parser& parser, const std::string& text) {
  for (std::size_t at = text.find('='); at != text.npos; at = text.find('=', at + 1)) {
    const bool second = at > 0 && std::strchr("<>!=", text[at - 1]);
    if (!second && (at + 1 == text.size() || text[at + 1] != '='))
      throw UserError(
          fmt::format("'{}': a = alone sets nothing here; write the value itself, and == to compare", text));
  }
  parser.SetExpr(text);
  const double value = parser.Eval();
  if (parser.GetNumResults() != 1)
    throw UserError(fmt::format("'{}': these are {} numbers with commas between them; decimals have a point, as in 0.5",
                                text, parser.GetNumResults()));
  return value;
}

/// A parser and the variable it reads stay together.
struct Parsed {
  double t = 0.0;
  mu::Parser parser;
};

/// What somebody who writes if(...) looks for.
std::string condition_hint(const std::string& text) {
  for (std::size_t at = text.find("if"); at != text.npos; at = text.find("if", at + 2)) {
    const auto is_word = [&](std::size_t i) {
      return i < text.size() && (std::isalnum(static_cast<unsigned char>(text[i])) || text[i] == '_');
    };
    if (!is_word(at + 2) && (at == 0 || !is_word(at - 1)))
      return "; a condition is written t > 1 ? 2 : 3, with the value where it holds and the one where it does not";
  }
  return "";
}

}  // namespace

std::function<double(double)> expression(const std::string& text) {
  auto parsed = std::make_shared<Parsed>();
  try {
    parsed->parser.DefineConst("pi", std::numbers::pi);
    parsed->parser.DefineFun("table", table);
    parsed->parser.DefineVar("t", &parsed->t);
    if (!std::isfinite(parse(parsed->parser, text)))
      throw UserError(fmt::format("'{}' is not a finite number at t = 0", text));
  } catch (const mu::ParserError& e) {
    throw UserError(fmt::format("'{}': {}; write an expression of t such as 0.1*sin(2*pi*t){}", text, e.GetMsg(),
                                condition_hint(text)));
  }
  return [parsed, text](double t) {
    parsed->t = t;
    const double value = parsed->parser.Eval();
    if (!std::isfinite(value)) throw UserError(fmt::format("'{}' is not a finite number at t = {:g}", text, t));
    return value;
  };
}

PlaceExpression place_expression(const std::string& text, bool time) {
  struct AtPlace {
    Vec3 x = Vec3::Zero();
    double t = 0.0;
    mu::Parser parser;
  };
  auto parsed = std::make_shared<AtPlace>();
  PlaceExpression e;
  try {
    parsed->parser.DefineConst("pi", std::numbers::pi);
    parsed->parser.DefineFun("table", table);
    for (int k = 0; k < 3; ++k) parsed->parser.DefineVar(std::string(1, "xyz"[k]), &parsed->x[k]);
    if (time) parsed->parser.DefineVar("t", &parsed->t);
    (void)parse(parsed->parser, text);
    e.in_time = parsed->parser.GetUsedVar().contains("t");
  } catch (const mu::ParserError& error) {
    throw UserError(fmt::format("'{}': {}; write an expression of x, y{} such as 20 + 0.1*x{}", text, error.GetMsg(),
                                time ? ", z and t" : " and z", condition_hint(text)));
  }
  e.value = [parsed, text](const Vec3& x, double t) {
    parsed->x = x;
    parsed->t = t;
    const double value = parsed->parser.Eval();
    if (!std::isfinite(value))
      throw UserError(
          fmt::format("'{}' is not a finite number at ({:g}, {:g}, {:g}) m, t = {:g}", text, x[0], x[1], x[2], t));
    return value;
  };
  return e;
}

std::function<double(const Vec3&)> size_expression(const std::string& text) {
  struct AtPlace {
    Vec3 x = Vec3::Zero();
    mu::Parser parser;
  };
  auto parsed = std::make_shared<AtPlace>();
  try {
    parsed->parser.DefineConst("pi", std::numbers::pi);
    for (int k = 0; k < 3; ++k) parsed->parser.DefineVar(std::string(1, "xyz"[k]), &parsed->x[k]);
    (void)parse(parsed->parser, text);
  } catch (const mu::ParserError& e) {
    throw UserError(fmt::format("'{}': {}; write an expression of x, y and z such as 0.01 + 0.1*x{}", text, e.GetMsg(),
                                condition_hint(text)));
  }
  return [parsed, text](const Vec3& x) {
    parsed->x = x;
    const double value = parsed->parser.Eval();
    if (!std::isfinite(value))
      throw UserError(fmt::format("'{}' is not a finite number at ({:g}, {:g}, {:g}) m", text, x[0], x[1], x[2]));
    return value;
  };
}

std::vector<double> row_expression(const std::string& text, const std::vector<std::string>& names,
                                   const std::vector<std::vector<double>>& columns) {
  std::vector<double> row(names.size()), values(columns.empty() ? 0 : columns.front().size());
  mu::Parser parser;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const bool is_word = !names[k].empty() &&
                         names[k].find_first_not_of(parser.ValidNameChars()) == std::string::npos &&
                         (names[k][0] < '0' || names[k][0] > '9');
    if (is_word) parser.DefineVar(names[k], &row[k]);
  }
  try {
    if (!contains(names, "pi")) parser.DefineConst("pi", std::numbers::pi);
    for (std::size_t i = 0; i < values.size(); ++i) {
      for (std::size_t k = 0; k < names.size(); ++k) row[k] = columns[k][i];
      values[i] = i == 0 ? parse(parser, text) : parser.Eval();
    }
  } catch (const mu::ParserError& e) {
    if (e.GetCode() == mu::ecUNASSIGNABLE_TOKEN)
      throw UserError(fmt::format("there is no column '{}':{}", e.GetToken(), suggestion(e.GetToken(), names)));
    throw UserError(fmt::format("'{}': {}; write the name of a column, or an expression such as -1000*tip_z{}", text,
                                e.GetMsg(), condition_hint(text)));
  }
  return values;
}

}  // namespace voile::input
