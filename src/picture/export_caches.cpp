// Positions of a mesh that stays: PC2 and MDD, each with the mesh at the first moment as OBJ.
#include <bit>

#include "exporting.hpp"

namespace voile::picture {

namespace {

/// Calls work(suffix, frames) for the sheet, and for bodies that move: their names and positions at every moment.
template <class Work>
Files for_moving(const Exporter& e, const Work& work) {
  Files files;
  std::vector<std::vector<Vec3f>> sheet, bodies;
  bool bodies_move = false;
  for (std::size_t i = 0; i < e.size(); ++i) {
    Snapshot s = e.snapshot(i);
    bodies_move = !s.bodies.triangles.empty() && s.bodies.moves;
    if (i == 0) write_obj(e.file("_mesh", ".obj"), e.recording().unit(), {&s.sheet}, &s.state.mesh->data, files);
    if (i == 0 && !s.bodies.triangles.empty())
      write_obj(e.file("_bodies_mesh", ".obj"), e.recording().unit(), {&s.bodies}, nullptr, files);
    sheet.push_back(std::move(s.sheet.positions));
    if (bodies_move) bodies.push_back(std::move(s.bodies.positions));
  }
  work("", sheet, files);
  if (bodies_move) work("_bodies", bodies, files);
  return files;
}

std::uint32_t swapped(std::uint32_t x) {
  return x >> 24U | (x >> 8U & 0xFF00U) | (x << 8U & 0xFF0000U) | x << 24U;
}

void put_swapped(OutFile& out, float x) {
  out.put(swapped(std::bit_cast<std::uint32_t>(x)));
}

}  // namespace

Files export_pc2(const Exporter& e) {
  return for_moving(e, [&](const char* suffix, const std::vector<std::vector<Vec3f>>& frames, Files& files) {
    OutFile out(e.file(suffix));
    out.stream().write("POINTCACHE2\0", 12);
    out.put(std::int32_t{1});
    out.put(static_cast<std::int32_t>(frames.front().size()));
    out.put(0.0F);  // first frame
    out.put(1.0F);  // frames from sample to sample
    out.put(static_cast<std::int32_t>(frames.size()));
    for (const std::vector<Vec3f>& frame : frames)
      for (const Vec3f& x : frame)
        for (int k = 0; k < 3; ++k) out.put(x[k]);
    out.finish(files);
  });
}

Files export_mdd(const Exporter& e) {
  return for_moving(e, [&](const char* suffix, const std::vector<std::vector<Vec3f>>& frames, Files& files) {
    OutFile out(e.file(suffix));
    out.put(swapped(static_cast<std::uint32_t>(frames.size())));
    out.put(swapped(static_cast<std::uint32_t>(frames.front().size())));
    for (std::size_t i = 0; i < frames.size(); ++i) put_swapped(out, static_cast<float>(e.time(i)));
    for (const std::vector<Vec3f>& frame : frames)
      for (const Vec3f& x : frame)
        for (int k = 0; k < 3; ++k) put_swapped(out, x[k]);
    out.finish(files);
  });
}

}  // namespace voile::picture
