#include <fmt/format.h>
#include <muParser.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "voile/base/error.hpp"
#include "voile/input/expression.hpp"

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

/// A parser and the variable it reads stay together.
struct Parsed {
  double t = 0.0;
  mu::Parser parser;
};

}  // namespace

std::function<double(double)> expression(const std::string& text) {
  auto parsed = std::make_shared<Parsed>();
  try {
    parsed->parser.DefineConst("pi", std::numbers::pi);
    parsed->parser.DefineFun("table", table);
    parsed->parser.DefineVar("t", &parsed->t);
    parsed->parser.SetExpr(text);
    if (!std::isfinite(parsed->parser.Eval()))
      throw UserError(fmt::format("'{}' is not a finite number at t = 0", text));
  } catch (const mu::ParserError& e) {
    throw UserError(fmt::format("'{}': {}; write an expression of t such as 0.1*sin(2*pi*t)", text, e.GetMsg()));
  }
  return [parsed](double t) {
    parsed->t = t;
    return parsed->parser.Eval();
  };
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
    parsed->parser.SetExpr(text);
    (void)parsed->parser.Eval();
  } catch (const mu::ParserError& e) {
    throw UserError(fmt::format("'{}': {}; write an expression of x, y and z such as 0.01 + 0.1*x", text, e.GetMsg()));
  }
  return [parsed](const Vec3& x) {
    parsed->x = x;
    return parsed->parser.Eval();
  };
}

}  // namespace voile::input
