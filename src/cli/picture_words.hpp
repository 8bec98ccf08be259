// Options of several words or numbers.
#pragma once

#include <string>
#include <vector>

namespace voile::cli {

/// The words between separators that are not empty.
[[nodiscard]] std::vector<std::string> words_of(const std::string& text, char separator);

/// Numbers separated by commas. Throws UserError with the name of the option if they are not `count` finite numbers.
[[nodiscard]] std::vector<double> numbers_of(const std::string& option, const std::string& text, std::size_t count);

/// WIDTHxHEIGHT [pixels]. Throws UserError.
void take_size(const std::string& text, int& width, int& height);

}  // namespace voile::cli
