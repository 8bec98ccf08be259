// Bytes handed to another program of this project through a file.
#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "voile/errors.hpp"

namespace voile::formats {

/// A file that another program reads; owned, removed on destruction. Throws UserError if it cannot be written. Not collective.
class Message {
 public:
  explicit Message(const std::string& bytes) {
    std::string name = (std::filesystem::temp_directory_path() / "voile_XXXXXX").string();
    const int descriptor = mkstemp(name.data());
    if (descriptor >= 0) close(descriptor);
    path_ = name;
    std::ofstream out(path_, std::ios::binary);
    out << bytes << std::flush;
    if (descriptor < 0 || !out) throw UserError(fmt::format("{}: cannot be written; is there room on the disk?", name));
  }
  ~Message() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  Message(const Message&) = delete;
  Message& operator=(const Message&) = delete;
  [[nodiscard]] std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

}  // namespace voile::formats
