#include "results_xdmf.hpp"

#include <array>

#include "base/text.hpp"

namespace voile::results {

namespace {

std::string xml_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

const char* kind(Number n) {
  if (n == Number::uint8) return "UChar";
  return n == Number::float64 || n == Number::float32 ? "Float" : "Int";
}

std::string size_text(std::size_t rows, std::size_t columns) {
  return columns == 1 ? fmt::format("{}", rows) : fmt::format("{} {}", rows, columns);
}

/// All of a dataset.
std::string item(const std::string& path, Number number, std::size_t rows, std::size_t columns) {
  return fmt::format("<DataItem Dimensions=\"{}\" NumberType=\"{}\" Precision=\"{}\" Format=\"HDF\">{}:/{}</DataItem>",
                     size_text(rows, columns), kind(number), bytes_of(number), results_name, path);
}

/// Some rows of it.
std::string item(const Table& t, std::size_t begin, std::size_t rows) {
  const std::string size = size_text(rows, t.columns);
  return fmt::format(
      "<DataItem ItemType=\"HyperSlab\" Dimensions=\"{}\"><DataItem Dimensions=\"3 {}\" Format=\"XML\">{} {} {}"
      "</DataItem>{}</DataItem>",
      size, t.columns == 1 ? 1 : 2, t.columns == 1 ? fmt::format("{}", begin) : fmt::format("{} 0", begin),
      t.columns == 1 ? "1" : "1 1", size, item(t.path, t.number, begin + rows, t.columns));
}

const char* attribute_type(std::size_t components, Centre centre) {
  if (components == 1) return "Scalar";
  if (components == 9) return "Tensor";
  return components == 3 && centre == Centre::vertex ? "Vector" : "Matrix";
}

std::string attribute(const std::string& name, std::size_t components, Centre centre, const std::string& data) {
  return fmt::format("<Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"{}\">{}</Attribute>\n", xml_text(name),
                     attribute_type(components, centre), centre == Centre::vertex ? "Node" : "Cell", data);
}

std::string mesh(std::size_t triangles, const std::string& connectivity, const std::string& points) {
  return fmt::format(
      "<Topology TopologyType=\"Triangle\" NumberOfElements=\"{}\">{}</Topology>\n"
      "<Geometry GeometryType=\"XYZ\">{}</Geometry>\n",
      triangles, connectivity, points);
}

std::string mesh(const Catalogue& c, const EpochPlace& e, std::size_t point) {
  const std::vector<Table>& t = c.tables();
  return mesh(e.triangles, item(t[Catalogue::connectivity], 3 * e.triangle, 3 * e.triangles),
              item(t[Catalogue::points], point, e.vertices));
}

std::string array(const Array& a, const EpochPlace& e, std::size_t begin) {
  return attribute(a.is_field ? shown_name(a.name, a.centre, a.table.columns) : a.name, a.table.columns, a.centre,
                   item(a.table, begin, a.centre == Centre::vertex ? e.vertices : e.triangles));
}

std::string grid(const std::string& name, const std::string& content) {
  return fmt::format("<Grid Name=\"{}\">\n{}</Grid>\n", name, content);
}

std::string at_time(const StepPlace& step, const std::string& content) {
  return grid(fmt::format("step {}", step.number), fmt::format("<Time Value=\"{}\"/>\n", step.time) + content);
}

}  // namespace

std::string xdmf_step(const Catalogue& c, std::size_t step) {
  const StepPlace& place = c.steps()[step];
  const EpochPlace& e = c.epochs()[place.epoch];
  std::string content = mesh(c, e, place.point);
  for (const Array& a : c.arrays())
    if (a.is_field ? a.present[step] != 0 : true) content += array(a, e, static_cast<std::size_t>(a.begin[step]));
  return at_time(place, content);
}

std::string xdmf_mesh(const Catalogue& c) {
  const EpochPlace& e = c.epochs().front();
  std::string content = mesh(c, e, e.point);
  for (const Array& a : c.arrays())
    if (const auto begin = a.of_epoch.find(0); !a.is_field && begin != a.of_epoch.end())
      content += array(a, e, begin->second);
  return grid("mesh", content);
}

std::string xdmf_obstacles(const Catalogue& c, const ObstacleTriangles& obstacles, int step) {
  const std::size_t triangles = obstacles.triangles.size(), vertices = obstacles.positions.size();
  const std::string points =
      step < 0 ? item("voile/obstacles/positions", Number::float32, vertices, 3)
               : item(c.tables()[Catalogue::obstacles], static_cast<std::size_t>(step) * vertices, vertices);
  const std::string content =
      mesh(triangles, item("voile/obstacles/triangles", Number::int32, triangles, 3), points) +
      attribute("obstacle", 1, Centre::triangle, item("voile/obstacles/obstacle", Number::int32, triangles, 1));
  return step < 0 ? grid("obstacles", content) : at_time(c.steps()[static_cast<std::size_t>(step)], content);
}

std::string xdmf_file(const char* name, const std::vector<std::string>& grids, bool steps) {
  std::string body = join(grids, "");
  if (steps)
    body =
        fmt::format("<Grid Name=\"{}\" GridType=\"Collection\" CollectionType=\"Temporal\">\n{}</Grid>\n", name, body);
  return fmt::format("<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n<Domain>\n{}</Domain>\n</Xdmf>\n", body);
}

}  // namespace voile::results
