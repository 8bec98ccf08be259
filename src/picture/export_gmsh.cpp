// MSH (version 2.2, text): the mesh at the start with its groups, and fields of all steps as views.
#include <fmt/format.h>
#include <fmt/ostream.h>

#include "exporting.hpp"

namespace voile::picture {

namespace {

/// An element: its number of vertices says what it is; 15, 1 and 2 are Gmsh's numbers of points, lines and triangles.
struct Element {
  int type;
  std::size_t group;
  std::vector<Index> vertices;
};

/// Triangles first, so that the number of a triangle is that of its element. Those in several groups belong to the first.
std::vector<Element> elements_of(const mesh::MeshData& mesh) {
  std::vector<std::size_t> group(mesh.triangles.size(), 0);
  for (std::size_t g = mesh.groups.size(); g-- > 0;)
    if (mesh.groups[g].dimension == 2)
      for (const Index t : mesh.groups[g].triangles) group[static_cast<std::size_t>(t)] = g + 1;
  std::vector<Element> elements;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    elements.push_back({2, group[t], {mesh.triangles[t].begin(), mesh.triangles[t].end()}});
  for (std::size_t g = 0; g < mesh.groups.size(); ++g) {
    if (mesh.groups[g].dimension == 1)
      for (const mesh::Segment& s : mesh.groups[g].segments) elements.push_back({1, g + 1, {s[0], s[1]}});
    if (mesh.groups[g].dimension == 0)
      for (const Index v : mesh.groups[g].vertices) elements.push_back({15, g + 1, {v}});
  }
  return elements;
}

void write_mesh(std::ofstream& to, const mesh::MeshData& mesh) {
  to << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
  fmt::print(to, "$PhysicalNames\n{}\n", mesh.groups.size());
  for (std::size_t g = 0; g < mesh.groups.size(); ++g) {
    std::string name = mesh.groups[g].name;
    std::replace(name.begin(), name.end(), '"', '\'');
    fmt::print(to, "{} {} \"{}\"\n", mesh.groups[g].dimension, g + 1, name);
  }
  fmt::print(to, "$EndPhysicalNames\n$Nodes\n{}\n", mesh.positions.size());
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    fmt::print(to, "{} {} {} {}\n", v + 1, mesh.positions[v][0], mesh.positions[v][1], mesh.positions[v][2]);
  const std::vector<Element> elements = elements_of(mesh);
  fmt::print(to, "$EndNodes\n$Elements\n{}\n", elements.size());
  for (std::size_t i = 0; i < elements.size(); ++i) {
    fmt::print(to, "{} {} 2 {} {}", i + 1, elements[i].type, elements[i].group, elements[i].group + 1);
    for (const Index v : elements[i].vertices) fmt::print(to, " {}", v + 1);
    to << '\n';
  }
  to << "$EndElements\n";
}

/// Gmsh takes 1, 3 or 9 numbers for each place.
void write_field(std::ofstream& to, const results::Field& f, double time, std::size_t frame) {
  const char* kind = f.centre == results::Centre::vertex ? "NodeData" : "ElementData";
  const auto columns = static_cast<std::size_t>(f.components);
  const std::size_t rows = f.values.size() / columns;
  fmt::print(to, "${}\n1\n\"{} [{}]\"\n1\n{}\n3\n{}\n{}\n{}\n", kind, f.name, f.unit, time, frame, f.components, rows);
  for (std::size_t i = 0; i < rows; ++i) {
    fmt::print(to, "{}", i + 1);
    for (std::size_t k = 0; k < columns; ++k) fmt::print(to, " {}", f.values[i * columns + k]);
    to << '\n';
  }
  fmt::print(to, "$End{}\n", kind);
}

}  // namespace

/// A file for each mesh.
Files export_msh(const Exporter& e) {
  Files files;
  std::size_t meshes = 0;
  for (std::size_t i = 0; i < e.size();) {
    OutFile out(meshes == 0 ? e.options().output : e.file(fmt::format("_mesh_{}", meshes)));
    ++meshes;
    write_mesh(out.stream(), e.snapshot(i).state.mesh->data);
    for (std::size_t frame = 0; frame == 0 || (i < e.size() && e.same_mesh(i)); ++frame, ++i)
      for (const results::Field& f : e.fields(i))
        write_field(out.stream(), f, e.time(i) / e.recording().time_unit().seconds, frame);
    out.finish(files);
  }
  return files;
}

}  // namespace voile::picture
