// Key frames written by the test come back, interpolated, from every format; broken files are refused.
#include <doctest/doctest.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "formats/point_cache.hpp"
#include "voile/errors.hpp"

namespace test_point_cache {

using namespace voile;
namespace fs = std::filesystem;

namespace {

class Folder {
 public:
  Folder() : path(fs::temp_directory_path() / fmt::format("voile_cache_{}", ::getpid())) {
    fs::remove_all(path);
    fs::create_directories(path);
  }
  ~Folder() { fs::remove_all(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] fs::path write(const std::string& name, const std::string& content) const {
    std::ofstream(path / name, std::ios::binary) << content;
    return path / name;
  }
  const fs::path path;
};

template <class Number>
std::string bytes(Number number, std::endian order) {
  const auto raw = std::bit_cast<std::array<char, sizeof(Number)>>(number);
  std::string text(raw.begin(), raw.end());
  if (order != std::endian::native) std::reverse(text.begin(), text.end());
  return text;
}

constexpr int frames = 3, vertices = 4;

/// Exact as float32.
Vec3 key(int frame, int vertex) {
  return {0.5 * vertex, 0.25 * frame * frame, -1.5 * frame + vertex};
}

std::string key_frames(std::endian order) {
  std::string text;
  for (int k = 0; k < frames; ++k)
    for (int v = 0; v < vertices; ++v)
      for (const double x : key(k, v)) text += bytes(static_cast<float>(x), order);
  return text;
}

std::string pc2(float first, float step, std::int32_t count = frames, std::int32_t version = 1) {
  constexpr std::endian order = std::endian::little;
  return std::string("POINTCACHE2\0", 12) + bytes(version, order) + bytes(std::int32_t{vertices}, order) +
         bytes(first, order) + bytes(step, order) + bytes(count, order) + key_frames(order);
}

std::string mdd(const std::array<float, frames>& times, std::int32_t count = frames) {
  constexpr std::endian order = std::endian::big;
  std::string text = bytes(count, order) + bytes(std::int32_t{vertices}, order);
  for (const float t : times) text += bytes(t, order);
  return text + key_frames(order);
}

std::string obj(int frame) {
  std::string text = "# frame\no cloth\n";
  for (int v = 0; v < vertices; ++v) {
    const Vec3 x = key(frame, v);
    text += fmt::format("v {} {} {}\n", x[0], x[1], x[2]);
  }
  return text + "vn 0 0 1\nf 1 2 3\n";
}

/// Times in binary fractions, so that the interpolation is exact.
void check_cache(const formats::PointCache& cache, const std::array<double, frames>& times) {
  CHECK(cache.vertex_count() == vertices);
  CHECK(cache.frame_count() == frames);
  CHECK(cache.start() == times.front());
  CHECK(cache.end() == times.back());
  const auto check = [&](double time, int before, int after, double s) {
    CAPTURE(time);
    const std::vector<Vec3> x = cache.positions(time);
    REQUIRE(x.size() == vertices);
    for (int v = 0; v < vertices; ++v) CHECK(x[v] == Vec3((1.0 - s) * key(before, v) + s * key(after, v)));
  };
  check(times[0] - 10.0, 0, 0, 0.0);
  for (int k = 0; k < frames; ++k) check(times[k], k, k, 0.0);
  for (const int k : {1, 0, 1, 0})  // to and fro
    for (const double s : {0.25, 0.5, 0.875}) check((1.0 - s) * times[k] + s * times[k + 1], k, k + 1, s);
  check(times[2] + 10.0, 2, 2, 0.0);
}

template <class Open>
void complains(const Open& open, const std::string& part) {
  std::string text = "nothing";
  try {
    open();
  } catch (const UserError& e) {
    text = e.what();
  }
  CAPTURE(text);
  CAPTURE(part);
  CHECK(text.find(part) != std::string::npos);
}

}  // namespace

TEST_CASE("PC2 and MDD are read and interpolated") {
  const Folder folder;
  check_cache(formats::PointCache(folder.write("a.pc2", pc2(2.0F, 4.0F)), 8.0), {0.25, 0.75, 1.25});
  check_cache(formats::PointCache(folder.write("b.PC2", pc2(0.0F, 12.0F))), {0.0, 0.5, 1.0});  // 24 frames per second
  check_cache(formats::PointCache(folder.write("c.mdd", mdd({-1.0F, 0.5F, 8.0F}))), {-1.0, 0.5, 8.0});
  formats::PointCache one(folder.write("d.mdd", mdd({0.0F, 1.0F, 2.0F}))), other(folder.path / "a.pc2", 8.0);
  one = std::move(other);
  check_cache(one, {0.25, 0.75, 1.25});
}

TEST_CASE("a sequence of OBJ files is read and interpolated") {
  const Folder folder;
  for (int k = 0; k < frames; ++k) {
    (void)folder.write(fmt::format("cloth_{:04d}.obj", 8 + 4 * k), obj(k));
    (void)folder.write(fmt::format("n{}.obj", std::array{2, 9, 10}[k]), obj(k));
    (void)folder.write(fmt::format("{}.Obj", std::array{"one", "three", "two"}[k]), obj(k));
  }
  (void)folder.write("cloth_12.obj", "too few digits for the pattern");
  (void)folder.write("cloth_0012.obj.bak", "another ending");
  check_cache(formats::PointCache(folder.path / "cloth_%04d.obj", 8.0), {1.0, 1.5, 2.0});
  check_cache(formats::PointCache(folder.path / "n*.obj", 2.0), {0.0, 0.5, 1.0});
  CHECK(
      formats::PointCache(folder.path / "n*.obj").remark().find("after n2.obj comes n9.obj, 7 on where others are 1") !=
      std::string::npos);
  CHECK(formats::PointCache(folder.path / "cloth_0*.obj").remark().empty());
  CHECK(formats::PointCache(folder.path / "*.Obj").remark().empty());
  const formats::PointCache numbered(folder.path / "n%d.obj", 1.0);
  CHECK(numbered.remark().empty());
  CHECK(numbered.start() == 2.0);
  CHECK(numbered.positions(9.5)[1] == Vec3(0.5 * key(1, 1) + 0.5 * key(2, 1)));
  check_cache(formats::PointCache(folder.path / "*.Obj", 4.0), {0.0, 0.25, 0.5});
  fs::remove(folder.path / "cloth_12.obj");
  (void)folder.write("cloth_00012.obj", obj(1));
  complains([&] { formats::PointCache(folder.path / "cloth_%04d.obj"); }, "two files have the number 12");
}

TEST_CASE("what is wrong with a point cache is said") {
  const Folder folder;
  const auto refuse = [&](const std::string& name, const std::string& content, const std::string& part) {
    const fs::path file = folder.write(name, content);
    complains([&] { formats::PointCache cache(file); }, file.string() + ": ");
    complains([&] { formats::PointCache cache(file); }, part);
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::string good = pc2(0.0F, 1.0F), motion = mdd({0.0F, 1.0F, 2.0F});
  complains([&] { formats::PointCache(folder.path / "none.pc2"); }, "there is no such point cache");
  complains([&] { formats::PointCache(folder.path / "none.abc"); }, "unknown kind of point cache '.abc'");
  refuse("a.pc2", "", "the file is empty");
  refuse("a.pc2", "POINTCACHE2", "does not start with POINTCACHE2");
  refuse("a.pc2", std::string(200, 'x'), "does not start with POINTCACHE2");
  refuse("a.pc2", good.substr(0, good.size() - 1), "3 frames of 4 vertices need 176 bytes, but the file has 175");
  refuse("a.pc2", good + "x", "but the file has 177");
  refuse("a.pc2", pc2(0.0F, 1.0F, 2), "2 frames of 4 vertices need 128 bytes");
  refuse("a.pc2", pc2(0.0F, 1.0F, -3), "the header claims -3 frames");
  refuse("a.pc2", pc2(0.0F, 1.0F, 3, 2), "version 2 of PC2");
  refuse("a.pc2", pc2(0.0F, 0.0F), "must be positive");
  refuse("a.pc2", pc2(nan, 1.0F), "the time of frame 0 is not finite");
  std::string broken = good;
  broken.replace(32 + 12 * (vertices + 2) + 4, 4, bytes(nan, std::endian::little));
  refuse("a.pc2", broken, "frame 1: the position of vertex 2 (both counted from 0) is not finite");
  refuse("a.mdd", "abc", "shorter than the header");
  refuse("a.mdd", motion.substr(0, 12), "3 frames of 4 vertices need 164 bytes, but the file has 12");
  refuse("a.mdd", motion.substr(0, 100), "but the file has 100");
  refuse("a.mdd", mdd({0.0F, 1.0F, 2.0F}, std::numeric_limits<std::int32_t>::max()), "need");
  refuse("a.mdd", mdd({0.0F, 2.0F, 2.0F}), "the times of frames 1 and 2 do not ascend");
  refuse("a.mdd", mdd({0.0F, nan, 2.0F}), "the time of frame 1 is not finite");
  complains([&] { formats::PointCache(folder.write("a.pc2", good), 0.0); }, "give a positive number");
  complains([&] { formats::PointCache(folder.write("a.obj", obj(0))); }, "needs a place for the number");
  complains([&] { formats::PointCache(folder.path / "none_%04d.obj"); }, "no file fits this pattern");
  complains([&] { formats::PointCache(folder.path / "none" / "*.obj"); }, "the folder cannot be read");
  complains([&] { formats::PointCache(folder.path / "*_%d.obj"); }, "only one");
  for (const char* content : {"v 1 2\n", "v 1 2 nan\n", "v 1 2 1e999\n"}) {
    (void)folder.write("s1.obj", content);
    complains([&] { formats::PointCache(folder.path / "s*.obj"); },
              "s1.obj: line 1: 'v' must be followed by three finite");
  }
  (void)folder.write("s1.obj", obj(0));
  (void)folder.write("s2.obj", "v 0 0 0\n");
  complains([&] { formats::PointCache(folder.path / "s*.obj"); }, "there are 1 vertices, but 4 in s1.obj");
  (void)folder.write("s2.obj", "f 1 2 3\n");
  complains([&] { formats::PointCache(folder.path / "s*.obj"); }, "there are no vertices");
  const std::string points = obj(1).substr(0, obj(1).find("f "));
  for (const char* same : {"", "f 1 2 3\n", "f 2/1 3/2 1/3\n", "f -4//1 -3//1 -2//1\n"}) {
    (void)folder.write("s2.obj", points + same);
    CHECK_NOTHROW(formats::PointCache(folder.path / "s*.obj"));
  }
  for (const auto& [faces, told] :
       {std::pair{"f 1 3 2\n", "face 1 (counted from 1, 1 in all) is 1 3 2, but 1 2 3 in s1"},
        std::pair{"f 1 2 3\nf 2 3 4\n", "face 2 (counted from 1, 2 in all) is 2 3 4, but not"},
        std::pair{"f 1 2 3 4\n", "s2.obj: face 1 (counted from 1, 1 in all) is 1 2 3 4"}}) {
    (void)folder.write("s2.obj", points + faces);
    complains([&] { formats::PointCache(folder.path / "s*.obj"); }, told);
  }
}

TEST_CASE("a point cache that is cut short while in use is noticed") {
  const Folder folder;
  const formats::PointCache cache(folder.write("a.pc2", pc2(0.0F, 24.0F)));
  fs::resize_file(folder.path / "a.pc2", 40);
  complains([&] { (void)cache.positions(0.5); }, "is the file complete?");
}

}  // namespace test_point_cache
