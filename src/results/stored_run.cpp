#include "stored_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "base/plain_file.hpp"
#include "base/text.hpp"
#include "stored_results.hpp"
#include "voile/errors.hpp"

namespace voile::results {

namespace fs = std::filesystem;

namespace {

fs::path results_in(const fs::path& place) {
  std::error_code ignored;
  fs::path file = fs::is_directory(place, ignored) ? place / results_name : place;
  require_plain_file(file);
  if (!fs::is_regular_file(file, ignored))
    throw UserError(fmt::format("{}: there are no results: give the output folder of a run, with {} in it",
                                place.string(), results_name));
  return file;
}

/// Words of requests and answers lie between zeros, which no name has.
std::vector<std::string> words_of(const std::string& bytes) {
  std::vector<std::string> words;
  for (std::size_t at = 0; at < bytes.size(); at += words.back().size() + 1)
    words.push_back(bytes.substr(at, bytes.find('\0', at) - at));
  return words;
}

std::string bytes_of(const std::vector<std::string>& words) {
  std::string bytes;
  for (const std::string& word : words) bytes.append(word).push_back('\0');
  return bytes;
}

std::string bytes_of(const std::vector<double>& values) {
  return {reinterpret_cast<const char*>(values.data()), sizeof(double) * values.size()};
}

std::vector<double> values_of(const std::string& bytes) {
  std::vector<double> values(bytes.size() / sizeof(double));
  std::memcpy(values.data(), bytes.data(), sizeof(double) * values.size());
  return values;
}

/// The answer to "fields STEP", "values STEP ROWS NAME" or "obstacles STEP COUNT".
std::string answer_to(const StoredResults& results, const std::vector<std::string>& request) {
  const auto number = [&](std::size_t i) { return static_cast<std::size_t>(std::stoull(request.at(i))); };
  const std::size_t step = number(1);
  if (request[0] == "obstacles") {
    std::vector<double> values;
    for (const Vec3& x : results.obstacle_positions(step, number(2))) values.insert(values.end(), x.begin(), x.end());
    return bytes_of(values);
  }
  const std::vector<FieldInfo> all = results.fields(step);
  if (request[0] == "fields") {
    std::vector<std::string> words;
    for (const FieldInfo& f : all)
      words.insert(words.end(),
                   {f.name, f.unit, f.centre == Centre::vertex ? "vertex" : "triangle", std::to_string(f.components)});
    return bytes_of(words);
  }
  const auto info = std::find_if(all.begin(), all.end(), [&](const FieldInfo& f) { return f.name == request.at(3); });
  if (info == all.end()) throw UserError(fmt::format("step {} has no field '{}'", step, request[3]));
  return bytes_of(results.values(step, *info, number(2)));
}

/// Answers as long as it is asked; a file that is finished stays open.
std::function<std::string(const std::string&)> reader_of(const fs::path& file) {
  return [file, open = std::shared_ptr<const StoredResults>()](const std::string& bytes) mutable {
    const std::vector<std::string> request = words_of(bytes);
    const Silence silence;
    if (!open && holds_everything(file)) open = std::make_shared<const StoredResults>(file);
    if (open) return answer_to(*open, request);
    return with_results(file, [&](const StoredResults& results) { return answer_to(results, request); });
  };
}

}  // namespace

void leave_hdf5_at_exit() {
  (void)H5dont_atexit();
}

StoredRun::StoredRun(const fs::path& place)
    : file_(results_in(place)), reader_(std::make_shared<LastingChild>(file_.string(), reader_of(file_))) {
  guarded(file_, [&](const StoredResults& results) {
    complete_ = results.complete();
    steps_ = results.steps();
    obstacles_ = results.obstacles();
  });
}

StoredMesh StoredRun::mesh(std::size_t epoch) const {
  return guarded(file_, [&](const StoredResults& results) { return results.mesh(epoch); });
}

std::vector<FieldInfo> StoredRun::fields(std::size_t step) const {
  const std::vector<std::string> words = words_of(reader_->ask(bytes_of({"fields", std::to_string(step)})));
  std::vector<FieldInfo> all;
  for (std::size_t i = 0; i + 3 < words.size(); i += 4)
    all.push_back({words[i], words[i + 1], words[i + 2] == "vertex" ? Centre::vertex : Centre::triangle,
                   std::stoi(words[i + 3])});
  return all;
}

bool StoredRun::has_field(std::size_t step, const std::string& name) const {
  const std::vector<FieldInfo> all = fields(step);
  return std::any_of(all.begin(), all.end(), [&](const FieldInfo& f) { return f.name == name; });
}

Field StoredRun::field(std::size_t step, const std::string& name, const mesh::MeshData& mesh) const {
  const std::vector<FieldInfo> all = fields(step);
  const auto info = std::find_if(all.begin(), all.end(), [&](const FieldInfo& f) { return f.name == name; });
  if (info == all.end()) {
    std::vector<std::string> names;
    for (const FieldInfo& f : all) names.push_back(f.name);
    throw UserError(fmt::format("{}: step {} has no field '{}':{}", file_.string(), steps_[step].number, name,
                                suggestion(name, names)));
  }
  const std::size_t rows = info->centre == Centre::vertex ? mesh.positions.size() : mesh.triangles.size();
  return {info->name, info->unit, info->centre, info->components,
          values_of(reader_->ask(bytes_of({"values", std::to_string(step), std::to_string(rows), name})))};
}

std::vector<Vec3> StoredRun::obstacle_positions(std::size_t step) const {
  if (!obstacles_.moves) return obstacles_.positions;
  const std::vector<double> values = values_of(
      reader_->ask(bytes_of({"obstacles", std::to_string(step), std::to_string(obstacles_.positions.size())})));
  std::vector<Vec3> moved;
  for (std::size_t i = 0; i + 2 < values.size(); i += 3) moved.emplace_back(values[i], values[i + 1], values[i + 2]);
  return moved.empty() ? obstacles_.positions : moved;
}

}  // namespace voile::results
