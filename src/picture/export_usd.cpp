// USD as text: points at every moment, faces only where the mesh changes.
#include <fmt/format.h>
#include <fmt/ostream.h>

#include <cmath>

#include "exporting.hpp"
#include "voile/errors.hpp"

namespace voile::picture {

namespace {

std::string up_axis(const Recording& recording) {
  if (recording.up().z() > 0.999) return "Z";
  if (recording.up().y() > 0.999) return "Y";
  throw UserError(
      "--to usda: USD knows +y and +z as upwards only, and gravity in this run points another way; export as glb");
}

void write_points(std::ofstream& to, const std::vector<Vec3f>& points) {
  to << '[';
  for (std::size_t i = 0; i < points.size(); ++i)
    fmt::print(to, "{}({}, {}, {})", i ? ", " : "", points[i][0], points[i][1], points[i][2]);
  to << ']';
}

void write_faces(std::ofstream& to, const std::vector<mesh::Triangle>& triangles, bool counts) {
  to << '[';
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (counts)
      to << (t ? ", 3" : "3");
    else
      fmt::print(to, "{}{}, {}, {}", t ? ", " : "", triangles[t][0], triangles[t][1], triangles[t][2]);
  to << ']';
}

/// An attribute that has a value at some moments. `write(snapshot)` writes one, `is_new(i)` says where.
template <class New, class Write>
void samples(std::ofstream& to, const Exporter& e, const char* name, const New& is_new, const Write& write) {
  std::vector<std::size_t> at;
  for (std::size_t i = 0; i < e.size(); ++i)
    if (is_new(i)) at.push_back(i);
  if (at.size() == 1) {
    fmt::print(to, "        {} = ", name);
    write(e.snapshot(at.front()));
    to << '\n';
    return;
  }
  fmt::print(to, "        {}.timeSamples = {{\n", name);
  for (const std::size_t i : at) {
    fmt::print(to, "            {}: ", e.time(i) * e.options().rate);
    write(e.snapshot(i));
    to << ",\n";
  }
  to << "        }\n";
}

void write_mesh(std::ofstream& to, const Exporter& e, bool of_sheet) {
  const auto body = [of_sheet](const Snapshot& s) -> const Body& { return of_sheet ? s.sheet : s.bodies; };
  std::vector<char> new_faces(e.size(), 0);
  std::vector<mesh::Triangle> before;
  bool moves = of_sheet, there = false;
  for (std::size_t i = 0; i < e.size(); ++i) {
    const Snapshot s = e.snapshot(i);
    new_faces[i] = i == 0 || body(s).triangles != before ? 1 : 0;
    before = body(s).triangles;
    there = there || !before.empty();
    moves = moves || body(s).moves;
  }
  if (!there) return;
  const Rgb colour = from_bytes(of_sheet ? Bytes3{66, 119, 178} : Bytes3{196, 192, 186});
  fmt::print(to,
             "    def Mesh \"{}\"\n    {{\n        uniform token subdivisionScheme = \"none\"\n        uniform bool "
             "doubleSided = 1\n"
             "        color3f[] primvars:displayColor = [({}, {}, {})]\n",
             of_sheet ? "sheet" : "bodies", colour[0], colour[1], colour[2]);
  const auto faces = [&](std::size_t i) { return new_faces[i] != 0; };
  samples(to, e, "int[] faceVertexCounts", faces, [&](const Snapshot& s) { write_faces(to, body(s).triangles, true); });
  samples(to, e, "int[] faceVertexIndices", faces,
          [&](const Snapshot& s) { write_faces(to, body(s).triangles, false); });
  samples(
      to, e, "point3f[] points", [&](std::size_t i) { return moves || faces(i); },
      [&](const Snapshot& s) { write_points(to, body(s).positions); });
  to << "    }\n";
}

}  // namespace

Files export_usda(const Exporter& e) {
  Files files;
  const std::string axis = up_axis(e.recording());
  OutFile out(e.options().output);
  fmt::print(
      out.stream(),
      "#usda 1.0\n(\n    defaultPrim = \"World\"\n    metersPerUnit = {}\n    upAxis = \"{}\"\n    startTimeCode = 0\n"
      "    endTimeCode = {}\n    timeCodesPerSecond = {}\n    framesPerSecond = {}\n)\n\ndef Xform \"World\"\n{{\n",
      e.recording().metres(), axis, e.time(e.size() - 1) * e.options().rate, e.options().rate, e.options().rate);
  write_mesh(out.stream(), e, true);
  write_mesh(out.stream(), e, false);
  out.stream() << "}\n";
  out.finish(files);
  return files;
}

}  // namespace voile::picture
