// Records of tests as CSV: two columns, and what a loop or a curve has to be.
#pragma once

#include <string>
#include <vector>

#include "sheet.hpp"

namespace voile::fit {

/// Rows of two numbers, in SI by `scale`. A first row of words is left out. Throws UserError "file:line: message".
[[nodiscard]] std::vector<RecordPoint> read_rows(const std::string& file, const RecordPoint& scale);

/// Throws UserError unless the record goes out and back, is closed, and turns so that it loses energy. Returns the mean width of its
/// force. `file`: for messages.
double require_loop(const std::vector<RecordPoint>& loop, const std::string& file);
/// Throws UserError unless the record goes one way and rises.
void require_curve(const std::vector<RecordPoint>& curve, const std::string& file);

}  // namespace voile::fit
