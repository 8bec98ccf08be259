// Standard output and error that never end a run: a full disk under a log loses lines of the log, nothing else.
#pragma once

namespace voile {

/// Lets `stdout` and `stderr` go on after failed writes, and opens those that are closed, so that no file of results
/// takes their place. A file that has reached its limit (SIGXFSZ) fails as on a full disk. Call it first in main().
void keep_output_streams();

/// Whether something printed to standard output has been lost; what is in its buffer is written first.
[[nodiscard]] bool output_was_lost();

}  // namespace voile
