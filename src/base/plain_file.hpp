// Opening what a stranger may have made: a pipe would be waited at for ever, a device has no end.
#pragma once

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

namespace voile {

/// Throws UserError if a pipe, a socket or a device has this name, also behind symbolic links.
void require_plain_file(const std::filesystem::path& file);

/// Opens a file to read its bytes, behind a byte-order mark of UTF-8 if it begins with one; fails as std::ifstream does if it is not there. Throws UserError if it is a pipe, a
/// socket or a device.
[[nodiscard]] std::ifstream open_input(const std::filesystem::path& file);
/// All of such a file; nothing if it is a folder or cannot be opened. Throws as open_input() does.
[[nodiscard]] std::optional<std::string> text_of_file(const std::filesystem::path& file);
/// Goes back to where open_input() has begun.
void rewind(std::ifstream& in);

/// Throws UserError if a file that is to be written is a symbolic link to another: in a folder that somebody else has
/// made it may lead to any file of the user's. Devices, as /dev/stdout, may be behind a link.
void require_no_link(const std::filesystem::path& file);

}  // namespace voile
