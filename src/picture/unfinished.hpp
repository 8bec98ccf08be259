// Files that are being written; private to src/picture.
#pragma once

#include <filesystem>
#include <utility>

namespace voile::picture {

/// Removes a file that was not finished, as where the disk is full: half a picture is none. Devices and the like stay.
class Unfinished {
 public:
  Unfinished() = default;
  ~Unfinished() {
    std::error_code ignored;
    if (!file_.empty() && std::filesystem::is_regular_file(file_, ignored)) std::filesystem::remove(file_, ignored);
  }
  Unfinished(const Unfinished&) = delete;
  Unfinished& operator=(const Unfinished&) = delete;
  /// To be called once it can be written: what cannot even be opened is not ours.
  void begin(std::filesystem::path file) { file_ = std::move(file); }
  void finish() { file_.clear(); }

 private:
  std::filesystem::path file_;
};

}  // namespace voile::picture
