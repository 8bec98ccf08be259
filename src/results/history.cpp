#include <fmt/format.h>
#include <hdf5.h>

#include <cmath>
#include <fstream>

#include "base/text.hpp"
#include "hdf5_file.hpp"
#include "results.hpp"
#include "voile/errors.hpp"

namespace voile::results {

namespace fs = std::filesystem;

struct HistoryWriter::Impl {
  fs::path file;
  std::ofstream out;
  std::size_t columns;

  void line(const std::string& text) {
    out << text << '\n' << std::flush;
    if (!out) fail_writing(file);
  }
};

HistoryWriter::HistoryWriter(const fs::path& file, const std::vector<std::string>& columns)
    : impl_(std::make_unique<Impl>(Impl{file, std::ofstream(file), columns.size()})) {
  std::vector<std::string> names;
  for (const std::string& column : columns) names.push_back(csv_name(column));
  impl_->line(join(names, ","));
}

HistoryWriter::~HistoryWriter() = default;
HistoryWriter::HistoryWriter(HistoryWriter&&) noexcept = default;
HistoryWriter& HistoryWriter::operator=(HistoryWriter&&) noexcept = default;

void HistoryWriter::write(const std::vector<double>& values) {
  if (values.size() != impl_->columns)
    throw InternalError(
        fmt::format("{}: {} values for {} columns", impl_->file.string(), values.size(), impl_->columns));
  std::vector<std::string> texts;  // a value that does not exist stays empty
  for (const double x : values)
    texts.push_back(std::isfinite(x) ? fmt::format("{}", x) : "");  // the shortest text that reads back the same
  impl_->line(join(texts, ","));
}

std::string hdf5_version() {
  unsigned major = 0, minor = 0, release = 0;
  H5get_libversion(&major, &minor, &release);
  return fmt::format("{}.{}.{}", major, minor, release);
}

}  // namespace voile::results
