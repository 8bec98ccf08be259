#include "picture_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <thread>

#include "voile/errors.hpp"

namespace voile::cli {

namespace fs = std::filesystem;

namespace {

/// So long the first rank waits for a frame of another before it draws it itself.
constexpr std::chrono::seconds longest_wait{120};
constexpr std::chrono::milliseconds look_again{20};
/// By how much ranks of one job may begin apart.
constexpr std::chrono::seconds apart{5};

std::string as_file_name(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return text;
}

/// Removes a folder in the end, whatever happens before.
struct FolderGoes {
  fs::path folder;
  ~FolderGoes() {
    std::error_code gone_already;
    if (!folder.empty()) fs::remove_all(folder, gone_already);
  }
};

}  // namespace

SharedFrames::SharedFrames(const fs::path& animation, LaunchedRank own, fs::file_time_type begun)
    : own_(std::move(own)), folder_(animation.string() + ".frames_" + as_file_name(own_.job)), begun_(begun) {}

fs::path SharedFrames::file_of(std::size_t frame) const {
  return folder_ / fmt::format("{:06d}.png", frame);
}

bool SharedFrames::is_there(const fs::path& file) const {
  std::error_code error;
  const fs::file_time_type written = fs::last_write_time(file, error);
  return !error && written >= begun_ - apart;
}

picture::Image SharedFrames::fetch(std::size_t frame, const Draw& draw) const {
  const fs::path file = file_of(frame);
  for (auto waited = look_again * 0; waited < longest_wait; waited += look_again) {
    if (is_there(file)) return picture::read_png(file);
    std::this_thread::sleep_for(look_again);
  }
  return draw(frame);
}

void SharedFrames::run(std::size_t count, const Draw& draw, const Take& take) const {
  if (own_.size > 1) {
    std::error_code error;
    fs::create_directories(folder_, error);
    if (error) throw UserError(fmt::format("{}: {}", folder_.string(), error.message()));
  }
  const FolderGoes goes{own_.size > 1 && own_.rank == 0 ? folder_ : fs::path()};
  for (std::size_t i = 0; i < count; ++i) {
    if (own_.rank == 0) {
      take(i, is_own(own_, i) ? draw(i) : fetch(i, draw));
    } else if (is_own(own_, i)) {
      const picture::Image image = draw(i);
      if (!fs::exists(folder_)) return;  // the first rank has waited too long, and drawn the rest itself
      const fs::path part = file_of(i).replace_extension(".part");
      write_png(part, image);
      fs::rename(part, file_of(i));  // so that no half picture is fetched
    }
  }
}

}  // namespace voile::cli
