// VTU: the sheet of each moment as an unstructured grid of VTK with its fields, numbers in binary after the text.
#include <fmt/format.h>
#include <fmt/ostream.h>

#include <cstdint>

#include "exporting.hpp"

namespace voile::picture {

namespace {

constexpr std::uint8_t vtk_triangle = 5;

/// Arrays are announced in the text first and follow behind it, each after its length in bytes.
class Arrays {
 public:
  explicit Arrays(std::ofstream& to) : to_(to) {}
  template <class Number>
  void announce(const char* type, const std::string& name, int components, const std::vector<Number>& values) {
    fmt::print(to_,
               "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n",
               type, name, components, bytes_.size());
    const std::uint64_t length = values.size() * sizeof(Number);
    bytes_.append(reinterpret_cast<const char*>(&length), sizeof(length));
    bytes_.append(reinterpret_cast<const char*>(values.data()), length);
  }
  void write() { to_ << "<AppendedData encoding=\"raw\">\n_" << bytes_ << "\n</AppendedData>\n"; }

 private:
  std::ofstream& to_;
  std::string bytes_;
};

void announce_fields(Arrays& arrays, const std::vector<results::Field>& fields, results::Centre centre) {
  for (const results::Field& f : fields)
    if (f.centre == centre) arrays.announce("Float64", f.name, f.components, f.values);
}

void announce_cells(Arrays& arrays, const std::vector<mesh::Triangle>& triangles) {
  std::vector<std::int64_t> corners, ends;
  for (const mesh::Triangle& t : triangles) {
    corners.insert(corners.end(), t.begin(), t.end());
    ends.push_back(static_cast<std::int64_t>(corners.size()));
  }
  arrays.announce("Int64", "connectivity", 1, corners);
  arrays.announce("Int64", "offsets", 1, ends);
  arrays.announce("UInt8", "types", 1, std::vector<std::uint8_t>(triangles.size(), vtk_triangle));
}

/// `time` in the unit of the case, as lengths are.
void write_vtu(std::ofstream& to, const Snapshot& s, const std::vector<results::Field>& fields, double time) {
  Arrays arrays(to);
  to << "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
        "<UnstructuredGrid>\n<FieldData>\n";
  arrays.announce("Float64", "TimeValue", 1, std::vector<double>{time});
  fmt::print(to, "</FieldData>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<Points>\n",
             s.state.positions.size(), s.sheet.triangles.size());
  std::vector<double> places;
  for (const Vec3& x : s.state.positions) places.insert(places.end(), x.data(), x.data() + 3);
  arrays.announce("Float64", "positions", 3, places);
  to << "</Points>\n<Cells>\n";
  announce_cells(arrays, s.sheet.triangles);
  to << "</Cells>\n<PointData>\n";
  announce_fields(arrays, fields, results::Centre::vertex);
  to << "</PointData>\n<CellData>\n";
  announce_fields(arrays, fields, results::Centre::triangle);
  to << "</CellData>\n</Piece>\n</UnstructuredGrid>\n";
  arrays.write();
  to << "</VTKFile>\n";
}

}  // namespace

Files export_vtu(const Exporter& e) {
  Files files;
  for (std::size_t i = 0; i < e.size(); ++i) {
    OutFile out(e.frame_file(i));
    write_vtu(out.stream(), e.snapshot(i), e.fields(i), e.time(i) / e.recording().time_unit().seconds);
    out.finish(files);
  }
  return files;
}

}  // namespace voile::picture
