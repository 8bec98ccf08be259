#include "sheet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/plain_file.hpp"
#include "base/text.hpp"
#include "heart_loop.hpp"
#include "input/case_fabric_curves.hpp"
#include "record_file.hpp"
#include "sheet_figures.hpp"
#include "voile/errors.hpp"

namespace voile::fit {

namespace {

using input::Dimension;

constexpr double kes_load = 490.3325;             // 500 gf/cm [N/m]
constexpr double fast_load = 0.980665;            // 1 gf/cm [N/m]
constexpr double narrowest = 5e-3, widest = 0.5;  // strips of a cantilever [m]
/// LT from which on a law counts as linear, and between which a law of a fabric file is near.
constexpr double linear_from = 0.99, linear_least = 0.2, linear_to = 1.05;

struct RecordName {
  const char* key;
  Record::Kind kind;
  bool directed;
  Dimension along, force;
};
constexpr std::array record_names{
    RecordName{"bending_loop", Record::Kind::bending_loop, true, Dimension::curvature, Dimension::moment_per_width},
    RecordName{"shear_loop", Record::Kind::shear_loop, false, Dimension::angle, Dimension::force_per_length},
    RecordName{"tension_curve", Record::Kind::tension_curve, true, Dimension::extension, Dimension::force_per_length},
    RecordName{"shear_curve", Record::Kind::shear_curve, false, Dimension::angle, Dimension::force_per_length}};

void require_known(const Sheet& sheet, const std::string& section, const toml::table& table,
                   const std::vector<std::string>& valid) {
  for (const auto& [key, node] : table)
    if (const std::string name(key.str()); !contains(valid, name))
      sheet.fail(line_of(node), section.empty() ? name : section + "." + name,
                 fmt::format("unknown name:{}", suggestion(name, valid)));
}

std::string text_at(const Sheet& sheet, const toml::table& table, const char* key, bool needed) {
  const toml::node* node = table.get(key);
  if (!node && !needed) return "";
  std::string text = node ? node->value<std::string>().value_or("") : "";
  if (text.find_first_not_of(' ') == std::string::npos)
    sheet.fail(node ? line_of(*node) : 0, key, "a text in quotes is needed; describe the fabric in words");
  return text;
}

void read_section(Sheet& sheet, const std::string& section, const toml::table& table) {
  std::vector<std::string> valid = unused_names(section);
  for (const Column& c : columns())
    if (c.section == section) valid.push_back(c.key);
  if (section == "kes") valid.emplace_back("load");
  require_known(sheet, section, table, valid);
  for (const std::string& name : unused_names(section))
    if (table.contains(name)) sheet.unused.push_back(section + "." + name);
  if (const toml::node* load = table.get("load"))
    sheet.load = read_figure(sheet, "kes.load", {Dimension::force_per_length}, "gf/cm", *load).mean;
  for (const Column& c : columns())
    if (const toml::node* node = table.get(c.key); node && c.section == section) read_column(sheet, c, *node);
}

RecordPoint scale_of(const Sheet& sheet, const RecordName& r, const std::string& name, const toml::table& table) {
  const auto valid = [](Dimension d) { return join(input::units_of(d), ", "); };
  const toml::array* units = table.get_as<toml::array>("units");
  if (!units || units->size() != 2 || !(*units)[0].is_string() || !(*units)[1].is_string())
    sheet.fail(
        line_of(table), name + ".units",
        fmt::format("the units of both columns are needed: one of {}, and one of {}", valid(r.along), valid(r.force)));
  const auto factor = [&](std::size_t i, Dimension d) {
    input::Quantity q;
    try {
      q = input::parse_quantity("1 " + *(*units)[i].value<std::string>());
    } catch (const UserError& e) {
      sheet.fail(line_of(*units), name + ".units", e.what());
    }
    if (q.dimension != d)
      sheet.fail(line_of(*units), name + ".units",
                 fmt::format("'{}' is {}, {} is needed: {}", *(*units)[i].value<std::string>(),
                             input::name_of(q.dimension), input::name_of(d), valid(d)));
    return q.value;
  };
  return {factor(0, r.along), factor(1, r.force)};
}

void read_record(Sheet& sheet, const RecordName& r, const std::string& name, Direction direction,
                 const toml::node& node) {
  const toml::table* table = node.as_table();
  if (!table) sheet.fail(line_of(node), name, "a table with file and units is needed");
  require_known(sheet, name, *table, {"file", "units"});
  Record record{r.kind, direction, name, line_of(node), {}, {}, 0.0};
  const RecordPoint scale = scale_of(sheet, r, name, *table);
  const toml::node* file = table->get("file");
  const auto add = [&](const toml::node& one) {
    if (!one.is_string()) sheet.fail(line_of(one), name + ".file", "the name of a CSV file in quotes is needed");
    const std::filesystem::path path = std::filesystem::path(sheet.file).parent_path() / *one.value<std::string>();
    record.files.push_back(path.string());
    record.points.push_back(read_rows(path.string(), scale));
    const bool loop = r.kind == Record::Kind::bending_loop || r.kind == Record::Kind::shear_loop;
    if (loop)
      (void)require_loop(record.points.back(), path.string());
    else
      require_curve(record.points.back(), path.string());
  };
  if (!file) sheet.fail(line_of(node), name + ".file", "the name of a CSV file is needed");
  if (const toml::array* list = file->as_array())
    for (const toml::node& one : *list) add(one);
  else
    add(*file);
  if (record.files.empty()) sheet.fail(line_of(node), name + ".file", "the list is empty; name a CSV file");
  sheet.records.push_back(std::move(record));
}

void read_records(Sheet& sheet, const RecordName& r, const toml::node& node) {
  if (!r.directed) return read_record(sheet, r, r.key, Direction::none, node);
  const toml::table* table = node.as_table();
  if (!table || table->contains("file"))
    sheet.fail(line_of(node), r.key,
               fmt::format("the direction is missing; write [{}.warp] or [{}.weft]", r.key, r.key));
  require_known(sheet, r.key, *table, {"warp", "weft"});
  for (const auto& [direction, record] : *table)
    read_record(sheet, r, fmt::format("{}.{}", r.key, direction.str()),
                direction.str() == "warp" ? Direction::warp : Direction::weft, record);
}

void read_drape(Sheet& sheet, const toml::node& node) {
  const toml::table* table = node.as_table();
  if (!table || !table->contains("coefficient"))
    sheet.fail(line_of(node), "drape", "a table is needed: coefficient, and perhaps folds and specimen");
  require_known(sheet, "drape", *table, {"coefficient", "folds", "specimen"});
  DrapeFigure d;
  d.line = line_of(node);
  d.coefficient = read_figure(sheet, "drape.coefficient", {Dimension::extension}, "", *table->get("coefficient"));
  if (!(d.coefficient.mean < 1.0)) sheet.fail(d.line, "drape.coefficient", "a coefficient below 100 % is needed");
  if (const toml::node* folds = table->get("folds")) d.folds = read_figure(sheet, "drape.folds", {}, "", *folds).mean;
  if (const toml::node* size = table->get("specimen")) {
    d.specimen =
        static_cast<int>(std::lround(1e3 * read_figure(sheet, "drape.specimen", {Dimension::length}, "", *size).mean));
    if (d.specimen != 240 && d.specimen != 300 && d.specimen != 360)
      sheet.fail(line_of(*size), "drape.specimen", "a diameter of 240, 300 or 360 mm is needed");
  }
  sheet.drape = d;
}

const Measurement* find(const Sheet& sheet, const std::string& name) {
  const auto at = std::find_if(sheet.measurements.begin(), sheet.measurements.end(),
                               [&](const Measurement& m) { return m.name == name; });
  return at == sheet.measurements.end() ? nullptr : &*at;
}

/// Figures that a laboratory computes from others.
void mark_compared(Sheet& sheet) {
  for (Measurement& m : sheet.measurements)
    for (const auto& [name, origin] :
         {std::pair{"fast.B-1", "fast.C-1"}, {"fast.B-2", "fast.C-2"}, {"fast.G", "fast.EB5"}})
      if (m.name == name && find(sheet, origin)) m.compared = true;
  for (const char* d : {"warp", "weft"})
    if (find(sheet, fmt::format("kes.EMT.{}", d)) && find(sheet, fmt::format("kes.WT.{}", d)))
      for (Measurement& m : sheet.measurements)
        if (m.name == fmt::format("kes.LT.{}", d)) m.compared = true;
}

/// The law of a fabric file ends at twice the length.
void require_extensions(const Sheet& sheet) {
  constexpr double most = 0.99;
  for (const Measurement& m : sheet.measurements)
    if (m.instrument.kind == Kind::extension && m.figure.mean > most)
      sheet.fail(m.line, m.name,
                 fmt::format("{:g} % is more than a fabric has; check the unit", 100.0 * m.figure.mean));
}

/// Extensions of FAST: two are a secant, with that at 100 gf/cm they are a curve.
void gather_extensions(Sheet& sheet, int number) {
  const Direction direction = number == 1 ? Direction::warp : Direction::weft;
  const auto name = [&](int load) { return fmt::format("fast.E{}-{}", load, number); };
  std::vector<Measurement> found;
  Record curve{Record::Kind::tension_curve, direction, "", 0, {}, {{}}, 0.0};
  for (const int load : {5, 20, 100})
    if (const Measurement* m = find(sheet, name(load))) {
      curve.points[0].push_back({m->figure.mean, load * fast_load});
      found.push_back(*m);
      curve.name += (curve.name.empty() ? "" : ", ") + m->name;
      curve.line = m->line;
      curve.deviation = std::max(curve.deviation, m->figure.deviation / m->figure.mean);
    }
  if (found.empty()) return;
  std::erase_if(sheet.measurements, [&](const Measurement& m) {
    return m.name.starts_with("fast.E") && m.name.ends_with(fmt::format("-{}", number));
  });
  for (std::size_t i = 0; i + 1 < found.size(); ++i)
    if (found[i + 1].figure.mean <= found[i].figure.mean)
      sheet.fail(found[i + 1].line, found[i + 1].name,
                 fmt::format("it has to be greater than {}; correct one of them, or leave it out", found[i].name));
  if (found.size() == 1)
    sheet.fail(found[0].line, found[0].name, "one extension alone gives no stiffness; add another of E5, E20 and E100");
  if (found.back().name == name(100)) {
    sheet.records.push_back(std::move(curve));
    return;
  }
  Measurement m = found[1];
  m.name = fmt::format("{} - {}", name(20), name(5));
  m.instrument.kind = Kind::secant;
  m.figure.mean -= found[0].figure.mean;
  m.figure.deviation = std::hypot(found[0].figure.deviation, found[1].figure.deviation);
  m.figure.count = std::min(found[0].figure.count, found[1].figure.count);
  m.figure.assumed = found[0].figure.assumed || found[1].figure.assumed;
  sheet.measurements.push_back(std::move(m));
}

/// Load of tension, and whether its law is linear.
void settle_tension(Sheet& sheet, Direction direction, const std::string& word) {
  const auto figure = [&](const char* key) {
    const Measurement* m = find(sheet, fmt::format("kes.{}.{}", key, word));
    return m ? m->figure.mean : 0.0;
  };
  const double extension = figure("EMT"), work = figure("WT"), given = figure("LT");
  if (extension == 0.0 && work == 0.0 && given == 0.0) return;
  const Measurement* any = nullptr;
  for (Measurement& m : sheet.measurements)
    if (m.name.starts_with("kes.") && m.name.ends_with("." + word) && m.instrument.kind != Kind::figure) any = &m;
  if (extension == 0.0 || (work == 0.0 && given == 0.0))
    sheet.fail(any->line, any->name,
               fmt::format("EMT and one of WT and LT are needed along the {}; add the other", word));
  const double area = work > 0.0 ? work : 0.5 * given * sheet.load * extension,
               linearity = 2.0 * area / (sheet.load * extension);
  // In strains and forces of the solver, in which 1 is a line.
  const double of_solver = 2.0 * area / (sheet.load / (1.0 + extension) * (extension + 0.5 * extension * extension));
  if (of_solver > linear_to)
    sheet.fail(
        any->line, any->name,
        fmt::format("EMT and WT give LT = {:.3g}: the curve flattens, which two figures do not describe; give it "
                    "as [tension_curve.{}]",
                    linearity, word));
  if (of_solver < linear_least)
    sheet.fail(
        any->line, any->name,
        fmt::format("EMT and WT give LT = {:.3g}: so steep an end is not described by two figures; correct them, or "
                    "give the curve as [tension_curve.{}]",
                    linearity, word));
  for (Measurement& m : sheet.measurements)
    if (m.instrument.kind != Kind::figure && m.instrument.direction == direction && m.name.starts_with("kes.")) {
      m.instrument.load = sheet.load;
      m.instrument.linear = of_solver > linear_from;
    }
}

/// A figure of an instrument: measured like others where its uncertainty is stated, else exact, which is returned.
double settle_instrument(Sheet& sheet, Parameter parameter, const Figure& figure, int line) {
  if (figure.assumed) return figure.mean;
  const ParameterName& name = name_of(parameter);
  Measurement m{name.key, line, {}, name.unit, name.si, figure};
  m.instrument.parameter = parameter;
  sheet.measurements.push_back(m);
  return 0.0;
}

void settle_overhang(Sheet& sheet, const toml::table& root) {
  double angle = 41.5 * degree;
  if (const toml::table* overhang = root.get_as<toml::table>("overhang"))
    if (const toml::node* node = overhang->get("angle")) {
      const Figure figure = read_figure(sheet, "overhang.angle", {Dimension::angle}, "", *node);
      if (figure.mean > 75.0 * degree) sheet.fail(line_of(*node), "overhang.angle", "at most 75 degrees are of use");
      angle = settle_instrument(sheet, Parameter::overhang_angle, figure, line_of(*node));
    }
  for (Measurement& m : sheet.measurements)
    if (m.instrument.kind == Kind::overhang) m.instrument.angle = angle;
}

/// Width of strips along the bias.
void settle_width(Sheet& sheet, const toml::table& root, const char* key, Kind kind) {
  const toml::table* table = root.get_as<toml::table>(key);
  const toml::node* node = table ? table->get("width") : nullptr;
  if (!node) return;
  const double width = read_figure(sheet, std::string(key) + ".width", {Dimension::length}, "", *node).mean;
  if (width < narrowest || width > widest)
    sheet.fail(line_of(*node), std::string(key) + ".width",
               fmt::format("strips are {:g} to {:g} mm wide; correct it", 1e3 * narrowest, 1e3 * widest));
  for (Measurement& m : sheet.measurements)
    if (m.instrument.kind == kind) m.instrument.width = width;
}

void settle_heart_loop(Sheet& sheet, const toml::table& root) {
  const toml::node* loop = root.get("heart_loop");
  if (!loop) return;
  const toml::node* node = loop->is_table() ? loop->as_table()->get("length") : nullptr;
  if (!node)
    sheet.fail(line_of(*loop), "heart_loop.length",
               "the length of the strip between the clamps is needed; write heart_loop = { length = \"200 mm\", warp = "
               "\"60 mm\" }");
  const Figure strip = read_figure(sheet, "heart_loop.length", {Dimension::length}, "", *node);
  for (const Measurement& m : sheet.measurements)
    if (const double part = m.figure.mean / strip.mean;
        m.instrument.kind == Kind::heart_loop && (part < lightest_heart || part > longest_heart))
      sheet.fail(m.line, m.name,
                 fmt::format("the loop is {:.3g} of the strip high: one without weight has {:.4f}, and beyond {} it "
                             "tells nothing; correct height or length, or take a {} strip",
                             part, lightest_heart, longest_heart, part < lightest_heart ? "longer" : "shorter"));
  const double length = settle_instrument(sheet, Parameter::loop_length, strip, line_of(*node));
  for (Measurement& m : sheet.measurements)
    if (m.instrument.kind == Kind::heart_loop) m.instrument.length = length;
}

void settle(Sheet& sheet, const toml::table& root) {
  if (sheet.load == 0.0) sheet.load = kes_load;
  settle_overhang(sheet, root);
  settle_width(sheet, root, "overhang", Kind::overhang);
  settle_width(sheet, root, "bending_length", Kind::bending_length);
  settle_heart_loop(sheet, root);
  mark_compared(sheet);
  require_extensions(sheet);
  gather_extensions(sheet, 1);
  gather_extensions(sheet, 2);
  settle_tension(sheet, Direction::warp, "warp");
  settle_tension(sheet, Direction::weft, "weft");
}

}  // namespace

void Sheet::fail(int line, const std::string& key, const std::string& message) const {
  throw UserError(fmt::format("{}{}: {}: {}", file, line > 0 ? fmt::format(":{}", line) : "", key, message));
}

Sheet parse_sheet(const std::string& text, const std::filesystem::path& file) {
  Sheet sheet;
  sheet.file = file.string();
  toml::table root;
  try {
    root = toml::parse(text);
  } catch (const toml::parse_error& e) {
    throw UserError(
        fmt::format("{}:{}: this is not valid TOML: {}", sheet.file, e.source().begin.line, e.description()));
  }
  std::vector<std::string> valid{"name", "description", "source", "kes", "fast", "drape"};
  for (const RecordName& r : record_names) valid.emplace_back(r.key);
  for (const Column& c : columns())
    if (c.section.empty()) valid.push_back(c.key);
  require_known(sheet, "", root, valid);
  sheet.name = text_at(sheet, root, "name", true);
  sheet.description = text_at(sheet, root, "description", true);
  sheet.source = text_at(sheet, root, "source", false);
  for (const Column& c : columns())
    if (const toml::node* node = root.get(c.key); node && c.section.empty()) read_column(sheet, c, *node);
  for (const char* section : {"kes", "fast"})
    if (const toml::node* node = root.get(section)) {
      if (!node->is_table()) sheet.fail(line_of(*node), section, "a table of figures is needed");
      read_section(sheet, section, *node->as_table());
    }
  for (const RecordName& r : record_names)
    if (const toml::node* node = root.get(r.key)) read_records(sheet, r, *node);
  if (const toml::node* node = root.get("drape")) read_drape(sheet, *node);
  settle(sheet, root);
  return sheet;
}

Sheet read_sheet(const std::filesystem::path& file) {
  const std::optional<std::string> text = text_of_file(file);
  if (!text) throw UserError(fmt::format("{}: there is no such file of measurements", file.string()));
  return parse_sheet(*text, file);
}

}  // namespace voile::fit
