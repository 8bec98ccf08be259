// One file for each moment: OBJ, STL, PLY, CSV.
#include <fmt/format.h>
#include <fmt/ostream.h>

#include "base/text.hpp"
#include "exporting.hpp"
#include "field_values.hpp"

namespace voile::picture {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little,
              "binary STL, PLY, PC2 and GLB are written as memory has them");

/// `texture`: texture coordinates of the first body's corners, if it has any.
void write_obj(const fs::path& file, const char* unit, const std::vector<const Body*>& bodies,
               const mesh::MeshData* texture, Files& files) {
  OutFile out(file);
  std::ofstream& to = out.stream();
  fmt::print(to, "# lengths in {}\n", unit);
  std::size_t first = 1;
  for (const Body* body : bodies) {
    if (body->triangles.empty()) continue;
    fmt::print(to, "o {}\n", body->name);
    for (const Vec3f& x : body->positions) fmt::print(to, "v {} {} {}\n", x[0], x[1], x[2]);
    const bool textured = body == bodies.front() && texture && !texture->texture.empty();
    if (textured)
      for (const auto& corners : texture->texture)
        for (const Vec2& x : corners) fmt::print(to, "vt {} {}\n", x[0], x[1]);
    for (std::size_t t = 0; t < body->triangles.size(); ++t) {
      to << 'f';
      for (std::size_t i = 0; i < 3; ++i) {
        fmt::print(to, " {}", first + static_cast<std::size_t>(body->triangles[t][i]));
        if (textured) fmt::print(to, "/{}", 3 * t + i + 1);
      }
      to << '\n';
    }
    first += body->positions.size();
  }
  out.finish(files);
}

Files export_obj(const Exporter& e) {
  Files files;
  for (std::size_t i = 0; i < e.size(); ++i) {
    const Snapshot s = e.snapshot(i);
    write_obj(e.frame_file(i), e.recording().unit(), {&s.sheet, &s.bodies}, &s.state.mesh->data, files);
  }
  return files;
}

Files export_stl(const Exporter& e) {
  Files files;
  for (std::size_t i = 0; i < e.size(); ++i) {
    const Snapshot s = e.snapshot(i);
    OutFile out(e.frame_file(i));
    std::string header = fmt::format("sheet and bodies, lengths in {}", e.recording().unit());
    header.resize(80, ' ');
    out.stream() << header;
    out.put(static_cast<std::uint32_t>(s.sheet.triangles.size() + s.bodies.triangles.size()));
    for (const Body* body : {&s.sheet, &s.bodies})
      for (const mesh::Triangle& t : body->triangles) {
        std::array<Vec3f, 4> x;  // the normal, then the corners
        for (std::size_t k = 0; k < 3; ++k) x[k + 1] = body->positions[static_cast<std::size_t>(t[k])];
        x[0] = (x[2] - x[1]).cross(x[3] - x[1]).normalized();
        for (const Vec3f& p : x)
          for (int k = 0; k < 3; ++k) out.put(p[k]);
        out.put(std::uint16_t{0});
      }
    out.finish(files);
  }
  return files;
}

namespace {

std::string column_name(const results::Field& f, int k) {
  const std::string entry = entry_names(f)[static_cast<std::size_t>(k)];
  return entry.empty() ? f.name : f.name + "_" + entry;
}

/// Fields at one kind of place.
std::vector<results::Field> at(std::vector<results::Field> fields, results::Centre centre) {
  std::erase_if(fields, [&](const results::Field& f) { return f.centre != centre; });
  return fields;
}

double value(const results::Field& f, std::size_t row, int k) {
  return f.values[row * static_cast<std::size_t>(f.components) + static_cast<std::size_t>(k)];
}

void ply_properties(OutFile& out, const std::vector<results::Field>& fields) {
  for (const results::Field& f : fields)
    for (int k = 0; k < f.components; ++k) fmt::print(out.stream(), "property float {}\n", column_name(f, k));
}

void ply_values(OutFile& out, const std::vector<results::Field>& fields, std::size_t row, bool there) {
  for (const results::Field& f : fields)
    for (int k = 0; k < f.components; ++k) out.put(there ? static_cast<float>(value(f, row, k)) : 0.0F);
}

}  // namespace

/// The sheet comes first; bodies follow with fields of zero.
Files export_ply(const Exporter& e) {
  Files files;
  for (std::size_t i = 0; i < e.size(); ++i) {
    const Snapshot s = e.snapshot(i);
    const std::vector<results::Field> all = e.fields(i), vertex = at(all, results::Centre::vertex),
                                      face = at(all, results::Centre::triangle);
    OutFile out(e.frame_file(i));
    fmt::print(out.stream(), "ply\nformat binary_little_endian 1.0\ncomment lengths in {}\nelement vertex {}\n",
               e.recording().unit(), s.sheet.positions.size() + s.bodies.positions.size());
    for (const char axis : {'x', 'y', 'z'}) fmt::print(out.stream(), "property float {}\n", axis);
    ply_properties(out, vertex);
    fmt::print(out.stream(), "element face {}\nproperty list uchar int vertex_indices\n",
               s.sheet.triangles.size() + s.bodies.triangles.size());
    ply_properties(out, face);
    out.stream() << "end_header\n";
    for (const Body* body : {&s.sheet, &s.bodies})
      for (std::size_t v = 0; v < body->positions.size(); ++v) {
        for (int k = 0; k < 3; ++k) out.put(body->positions[v][k]);
        ply_values(out, vertex, v, body == &s.sheet);
      }
    for (const Body* body : {&s.sheet, &s.bodies})
      for (std::size_t t = 0; t < body->triangles.size(); ++t) {
        out.put(std::uint8_t{3});
        for (const Index v : body->triangles[t])
          out.put(static_cast<std::int32_t>(v + (body == &s.sheet ? 0 : static_cast<Index>(s.sheet.positions.size()))));
        ply_values(out, face, t, body == &s.sheet);
      }
    out.finish(files);
  }
  return files;
}

namespace {

/// One line for each vertex or triangle; `begin(row)` gives its first columns.
template <class Begin>
void write_table(const fs::path& file, const std::string& header, std::size_t rows,
                 const std::vector<results::Field>& fields, const Begin& begin, Files& files) {
  OutFile out(file);
  out.stream() << header;
  for (const results::Field& f : fields)
    for (int k = 0; k < f.components; ++k) out.stream() << ',' << csv_name(column_name(f, k));
  out.stream() << '\n';
  for (std::size_t row = 0; row < rows; ++row) {
    out.stream() << begin(row);
    for (const results::Field& f : fields)
      for (int k = 0; k < f.components; ++k) fmt::print(out.stream(), ",{}", value(f, row, k));
    out.stream() << '\n';
  }
  out.finish(files);
}

}  // namespace

Files export_csv(const Exporter& e) {
  Files files;
  for (std::size_t i = 0; i < e.size(); ++i) {
    const Snapshot s = e.snapshot(i);
    const std::vector<results::Field> all = e.fields(i);
    const std::string number = e.size() == 1 ? "" : fmt::format("_{:06d}", i);
    write_table(
        e.file(number + "_vertices"), "vertex,x,y,z", s.state.positions.size(), at(all, results::Centre::vertex),
        [&](std::size_t v) {
          const Vec3& x = s.state.positions[v];
          return fmt::format("{},{},{},{}", v, x[0], x[1], x[2]);
        },
        files);
    write_table(
        e.file(number + "_triangles"), "triangle,vertex_0,vertex_1,vertex_2", s.sheet.triangles.size(),
        at(all, results::Centre::triangle),
        [&](std::size_t t) {
          const mesh::Triangle& v = s.sheet.triangles[t];
          return fmt::format("{},{},{},{}", t, v[0], v[1], v[2]);
        },
        files);
  }
  return files;
}

}  // namespace voile::picture
