// Expressions of the time t as users write them: muParser's operators and functions, pi, and
// table(t, t0, v0, t1, v1, ...), which interpolates linearly between its pairs and is constant outside them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "base/types.hpp"

namespace voile::input {

/// Parses an expression of t; the function may be copied and outlives everything. Throws UserError that says what is
/// wrong, and so does the function where its value is not finite.
[[nodiscard]] std::function<double(double t)> expression(const std::string& text);
/// An expression of x, y and z [m] and the time t.
struct PlaceExpression {
  std::function<double(const Vec3& x, double t)> value;
  bool in_time = false;  ///< t occurs in it
};
/// Without `time` t is unknown to it. Throws UserError as above.
[[nodiscard]] PlaceExpression place_expression(const std::string& text, bool time);
/// The same of x, y and z [m], for a size [m].
[[nodiscard]] std::function<double(const Vec3& x)> size_expression(const std::string& text);
/// A value for each row of `columns`, of equal lengths, in an expression of their names. Names that are no words of an
/// expression (a=1, force [N]) cannot be in it. Throws UserError that says what is wrong.
[[nodiscard]] std::vector<double> row_expression(const std::string& text, const std::vector<std::string>& names,
                                                 const std::vector<std::vector<double>>& columns);

}  // namespace voile::input
