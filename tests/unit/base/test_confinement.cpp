#include <doctest/doctest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "base/child_process.hpp"
#include "base/confinement.hpp"
#include "base/plain_file.hpp"
#include "voile/errors.hpp"

namespace test_confinement {

namespace fs = std::filesystem;
using namespace voile;

namespace {

/// A folder for one test of one process.
struct Folder {
  fs::path path = fs::temp_directory_path() / ("voile_confined_" + std::to_string(getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
};

template <class Work>
std::string confined(const Work& work) {
  return run_in_child("script", [&] {
    if (!confine_process()) return std::string("no filter");
    work();
    return std::string("done");
  });
}

}  // namespace

TEST_CASE("a confined process reads files, and neither writes them nor starts programs") {
  const Folder folder;
  const std::string mine = (folder.path / "mine").string(), marker = (folder.path / "marker").string();
  std::ofstream(mine) << "text";
  if (confined([] {}) == "no filter") return;  // this kernel has none
  std::string text;
  CHECK(confined([&] { std::ifstream(mine) >> text; }) == "done");
  CHECK(confined([] { std::thread([] {}).join(); }) == "done");
  CHECK_THROWS_WITH_AS((void)confined([&] { std::ofstream out(marker); }), doctest::Contains("write a file"),
                       UserError);
  CHECK_THROWS_WITH_AS((void)confined([&] { std::ofstream(mine, std::ios::app) << "more"; }),
                       doctest::Contains("--allow-system-call"), UserError);
  CHECK_THROWS_WITH_AS((void)confined([&] {
                         if (std::system(("touch " + marker).c_str()) == 0) throw UserError("it ran");
                       }),
                       doctest::Contains("run a program"), UserError);
  CHECK_THROWS_WITH_AS((void)confined([&] { std::thread([&] { std::ofstream out(marker); }).join(); }),
                       doctest::Contains("write a file"), UserError);
  CHECK_THROWS_WITH_AS((void)confined([&] { fs::create_directory(marker); }), doctest::Contains("make a folder"),
                       UserError);
  std::error_code ignored;
  CHECK(confined([&] {
          fs::remove(mine, ignored);
          fs::rename(mine, marker, ignored);
          if (socket(AF_INET, SOCK_STREAM, 0) >= 0 || kill(getppid(), 0) == 0) throw UserError("it can");
        }) == "done");
  CHECK(fs::exists(mine));
  CHECK_FALSE(fs::exists(marker));
}

TEST_CASE("the reading of a script, and of any foreign file, is stopped in time") {
  setenv("VOILE_READ_SECONDS", "1", 1);
  CHECK_THROWS_WITH_AS(try_in_child("file", [] { sleep(100); }), doctest::Contains("VOILE_READ_SECONDS"), UserError);
  CHECK_THROWS_WITH_AS((void)confined([] { sleep(100); }), doctest::Contains("VOILE_READ_SECONDS"), UserError);
  unsetenv("VOILE_READ_SECONDS");
}

TEST_CASE("files to read are no devices, and files to write no links") {
  const Folder folder;
  CHECK_THROWS_WITH_AS(require_plain_file("/dev/null"), doctest::Contains("a device"), UserError);
  fs::create_symlink("/dev/zero", folder.path / "to_device");
  CHECK_THROWS_AS((void)open_input(folder.path / "to_device"), UserError);
  CHECK_NOTHROW(require_plain_file(folder.path / "not_there"));
  CHECK_NOTHROW(require_no_link(folder.path / "to_device"));  // as /dev/stdout is
  fs::create_symlink(folder.path / "other", folder.path / "link");
  CHECK_THROWS_WITH_AS(require_no_link(folder.path / "link"), doctest::Contains("symbolic link"), UserError);
}

}  // namespace test_confinement
