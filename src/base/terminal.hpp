// Standard output and error that never end a run, and what a terminal adds: a line that rewrites itself, colour.
//
// A terminal has both unless NO_COLOR is set, TERM is unset or "dumb", or the program asks for plain output. The line of
// progress disappears before anything else is printed to either stream, by whomever.
#pragma once

#include <string>

namespace voile {

/// Lets `stdout` and `stderr` go on after failed writes, and opens those that are closed, so that no file of results
/// takes their place. A file that has reached its limit (SIGXFSZ) fails as on a full disk. Call it first in main().
void keep_output_streams();

/// Whether something printed to standard output has been lost; what is in its buffer is written first.
[[nodiscard]] bool output_was_lost();

/// From here on no line rewrites itself; with `colours` false words have no colour either.
void use_plain_output(bool colours);

/// Whether show_progress() shows anything: standard output is a terminal that may be rewritten.
[[nodiscard]] bool rewrites_progress();

/// Shows the text (ASCII, without line breaks) instead of the last one, cut to the width of the terminal; at most ten times
/// a second. Does nothing where rewrites_progress() is false.
void show_progress(const std::string& text);

/// The text with the words "error:" and "warning:" in colour where they begin a line or follow "voile: " there; `at_start`:
/// the text begins a line.
[[nodiscard]] std::string coloured(const std::string& text, bool at_start);

}  // namespace voile
