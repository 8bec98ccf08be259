#include "plain_file.hpp"

#include <fmt/format.h>

#include <string_view>

#include "voile/errors.hpp"

namespace voile {

namespace fs = std::filesystem;

void require_plain_file(const fs::path& file) {
  std::error_code ignored;
  const fs::file_status status = fs::status(file, ignored);
  if (!fs::exists(status) || fs::is_regular_file(status) || fs::is_directory(status)) return;
  throw UserError(fmt::format(
      "{}: this is a pipe, a socket or a device; only files are read: give one, or copy what it sends into one",
      file.string()));
}

void require_no_link(const fs::path& file) {
  std::error_code ignored;
  if (!fs::is_symlink(file, ignored)) return;
  const fs::file_status target = fs::status(file, ignored);
  if (fs::exists(target) && !fs::is_regular_file(target) && !fs::is_directory(target)) return;
  throw UserError(
      fmt::format("{}: this is a symbolic link, and nothing is written through one; remove it, or give another name",
                  file.string()));
}

std::ifstream open_input(const fs::path& file) {
  require_plain_file(file);
  std::ifstream in(file, std::ios::binary);
  if (in) rewind(in);
  return in;
}

std::optional<std::string> text_of_file(const std::filesystem::path& file) {
  std::error_code ignored;
  std::ifstream in = open_input(file);
  if (!in || std::filesystem::is_directory(file, ignored)) return std::nullopt;
  return std::string(std::istreambuf_iterator<char>(in), {});
}

void rewind(std::ifstream& in) {
  constexpr std::string_view mark = "\xef\xbb\xbf";
  char first[3] = {0, 0, 0};
  in.clear();
  in.seekg(0);
  in.read(first, 3);
  in.clear();
  in.seekg(std::string_view(first, 3) == mark ? 3 : 0);
}

}  // namespace voile
