#include "picture_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/text.hpp"
#include "input/expression.hpp"
#include "picture/recording.hpp"
#include "picture_words.hpp"
#include "record/history_columns.hpp"
#include "voile/errors.hpp"

namespace voile::cli {

namespace fs = std::filesystem;

namespace {

constexpr std::array legends{std::pair{"beside", picture::Legend::beside},
                             std::pair{"top-left", picture::Legend::top_left},
                             std::pair{"top-right", picture::Legend::top_right},
                             std::pair{"bottom-left", picture::Legend::bottom_left},
                             std::pair{"bottom-right", picture::Legend::bottom_right},
                             std::pair{"none", picture::Legend::none}};

/// A column, or an expression of columns.
std::vector<double> values_of(const picture::Table& table, const std::string& text) {
  if (table.has(text)) return table.column(text);
  if (const std::size_t comma = text.find(','); comma != text.npos && table.has(text.substr(0, comma)))
    throw UserError(fmt::format("'{}': several columns are written with / between them, as in {}/{}", text,
                                text.substr(0, comma), text.substr(comma + 1)));
  try {
    std::vector<double> values = input::row_expression(text, table.names, table.columns);
    if (std::none_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); }))
      throw UserError(fmt::format("'{}' is finite in no row", text));
    return values;
  } catch (const UserError& e) {
    throw UserError(fmt::format("{}: {}", table.file.string(), e.what()));
  }
}

std::optional<std::pair<double, double>> range_of(const std::string& option, const std::string& text,
                                                  bool logarithmic) {
  if (text.empty()) return std::nullopt;
  const std::vector<double> ends = numbers_of(option, text, 2);
  if (!(ends[0] < ends[1]))
    throw UserError(fmt::format("{} {}: the first number must be the smaller one", option, text));
  if (logarithmic && ends[0] <= 0.0)
    throw UserError(fmt::format("{} {}: a logarithmic scale begins above 0", option, text));
  return std::pair{ends[0], ends[1]};
}

}  // namespace

PlotCommand::PlotCommand(CLI::App& cli) : sub_(cli.add_subcommand("plot", "Draw curves of the history: SVG, PNG")) {
  sub_->add_option("results", results_, "Output folders of runs, or CSV files");
  sub_->add_option("--x", x_,
                   "Column across; several with / between them [time; probes over which the load factor is drawn]");
  sub_->add_option("--y", y_, "Column upwards; several with / between them [probes; the load factor]");
  const std::array<std::pair<const char*, std::vector<std::string>*>, 3> further{
      {{"--curve", &curves_}, {"--dashed", &dashed_}, {"--points", &points_}}};
  const std::array<const char*, 3> what{
      "A curve, FILE:X:Y or FILE:X:Y:LABEL: columns of a CSV file or run, or expressions of them; may be repeated",
      "The same, dashed; the first in the colour of the first curve",
      "The same as rings, such as points to compare with"};
  for (std::size_t i = 0; i < further.size(); ++i)
    sub_->add_option(further[i].first, *further[i].second, what[i])->allow_extra_args(false);
  sub_->add_option("--labels", labels_, "Names of the runs, with / between them [their folders]");
  sub_->add_option("--title", plot_.title, "Text above");
  sub_->add_option("--output", output_, "SVG or PNG to write [plot.svg beside the first table]");
  sub_->add_option("--size", size_, "Pixels [960x640]");
  sub_->add_flag("--quiet", quiet_, "Print errors only");
  declare_axes();
}

void PlotCommand::declare_axes() {
  sub_->add_option("--x-label", plot_.x.label, "Text of the axis across [the column]");
  sub_->add_option("--y-label", plot_.y.label, "Text of the axis upwards [the column]");
  sub_->add_option("--x-range", x_range_, "LOW,HIGH of the axis across [of the curves]");
  sub_->add_option("--y-range", y_range_, "LOW,HIGH of the axis upwards [of the curves]");
  sub_->add_option("--log", logarithmic_, "Logarithmic scale of x, y or xy")->check(CLI::IsMember({"x", "y", "xy"}));
  sub_->add_flag("--equal", plot_.equal, "A unit across as long as one upwards, for shapes");
  std::vector<std::string> names;
  for (const auto& [name, legend] : legends) names.emplace_back(name);
  sub_->add_option("--legend", legend_, fmt::format("{} [beside]", join(names, ", ")))->check(CLI::IsMember(names));
}

void PlotCommand::take_axes() {
  plot_.x.logarithmic = logarithmic_ == "x" || logarithmic_ == "xy";
  plot_.y.logarithmic = logarithmic_ == "y" || logarithmic_ == "xy";
  plot_.x.range = range_of("--x-range", x_range_, plot_.x.logarithmic);
  plot_.y.range = range_of("--y-range", y_range_, plot_.y.logarithmic);
  if (plot_.equal && !logarithmic_.empty()) throw UserError("plot: --equal goes with linear scales; leave out --log");
  plot_.legend =
      std::find_if(legends.begin(), legends.end(), [&](const auto& l) { return l.first == legend_; })->second;
}

void PlotCommand::choose_columns(const picture::Table& table, std::vector<std::string>& x,
                                 std::vector<std::string>& y) const {
  x = words_of(x_, '/');
  y = words_of(y_, '/');
  std::vector<std::string> probes;
  for (const std::string& name : table.names)
    if (record::is_of_probe(name)) probes.push_back(name);
  const bool in_time = table.has("time");
  if (x.empty() && (in_time || !y.empty())) x = {in_time ? "time" : "load_factor"};
  if (y.empty() && !in_time) y = {"load_factor"};
  std::vector<std::string>& rest = x.empty() ? x : y;
  if (rest.empty()) rest = probes;
  if (rest.empty())
    throw UserError(fmt::format("{}: it has no probes; give --x and --y, which are among {}", table.file.string(),
                                join(table.names, ", ")));
  if (x.size() > 1 && y.size() > 1) throw UserError("plot: either --x or --y may name several columns, not both");
}

void PlotCommand::add_runs() {
  const std::vector<std::string> labels = words_of(labels_, '/');
  std::vector<std::string> x, y;
  std::string unit;
  for (std::size_t i = 0; i < results_.size(); ++i) {
    const picture::Table table = picture::read_table(results_[i]);
    if (i == 0) choose_columns(table, x, y);
    if (i == 0) unit = picture::time_unit_in(fs::absolute(table.file).parent_path()).name;
    const std::string run = i < labels.size() ? labels[i] : fs::absolute(table.file).parent_path().filename().string();
    for (std::size_t k = 0; k < std::max(x.size(), y.size()); ++k) {
      const std::string &of_x = x[x.size() > 1 ? k : 0], &of_y = y[y.size() > 1 ? k : 0];
      const std::string column = x.size() > 1 ? of_x : of_y;
      const std::string label = results_.size() == 1                ? column
                                : std::max(x.size(), y.size()) == 1 ? run
                                                                    : run + ": " + column;
      plot_.curves.push_back(
          {label, values_of(table, of_x), values_of(table, of_y), picture::Stroke::line, plot_.curves.size()});
    }
  }
  if (plot_.x.label.empty() && x.size() == 1)
    plot_.x.label = x.front() == "time" ? fmt::format("time [{}]", unit) : x.front();
  if (plot_.y.label.empty() && y.size() == 1) plot_.y.label = y.front();
}

void PlotCommand::add_curves(const std::string& option, const std::vector<std::string>& wanted,
                             picture::Stroke stroke) {
  std::size_t colour = stroke == picture::Stroke::line ? plot_.curves.size() : 0;
  for (const std::string& text : wanted) {
    // A label may have colons in it.
    std::vector<std::string> parts;
    std::size_t begin = 0;
    for (std::size_t end; parts.size() < 3 && (end = text.find(':', begin)) != std::string::npos; begin = end + 1)
      parts.push_back(text.substr(begin, end - begin));
    parts.push_back(text.substr(begin));
    if (parts.size() < 3 || parts[0].empty() || parts[1].empty() || parts[2].empty())
      throw UserError(fmt::format("{} {}: it is FILE:X:Y, or FILE:X:Y:LABEL", option, text));
    const picture::Table table = picture::read_table(parts[0]);
    const std::string label = parts.size() > 3 ? parts[3] : table.file.stem().string() + ": " + parts[1];
    plot_.curves.push_back({label, values_of(table, parts[1]), values_of(table, parts[2]), stroke, colour++});
  }
}

void PlotCommand::run() {
  take_size(size_, plot_.width, plot_.height);
  take_axes();
  add_runs();
  add_curves("--curve", curves_, picture::Stroke::line);
  add_curves("--dashed", dashed_, picture::Stroke::dashed);
  add_curves("--points", points_, picture::Stroke::points);
  if (plot_.curves.empty())
    throw UserError("plot: the folder of a run, or --curve FILE:X:Y is needed; see voile plot --help");
  if (results_.empty() && output_.empty()) throw UserError("plot: without a run --output FILE is needed");
  const fs::path file =
      output_.empty() ? picture::read_table(results_.front()).file.parent_path() / "plot.svg" : fs::path(output_);
  write_plot(file, plot_);
  if (!quiet_) fmt::print("wrote {}\n", file.string());
}

SheetCommand::SheetCommand(CLI::App& cli) : sub_(cli.add_subcommand("sheet", "Put pictures beside each other: PNG")) {
  sub_->add_option("pictures", pictures_, "PNG files, row by row")->required();
  sub_->add_option("--columns", columns_, "Pictures beside each other [all]")->check(CLI::Range(1, 1000));
  sub_->add_option("--output", output_, "PNG to write")->required();
  sub_->add_flag("--palette", palette_, "256 colours at most: a smaller file");
  sub_->add_flag("--quiet", quiet_, "Print errors only");
}

void SheetCommand::run() const {
  std::vector<picture::Image> pictures;
  for (const std::string& file : pictures_) pictures.push_back(picture::read_png(file));
  write_png(output_, sheet_of(pictures, columns_ > 0 ? columns_ : static_cast<int>(pictures.size())), palette_);
  if (!quiet_) fmt::print("wrote {}\n", output_);
}

}  // namespace voile::cli
