#include "begin_deck.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "base/plain_file.hpp"
#include "deck_case.hpp"
#include "formats/mesh_file.hpp"
#include "voile/errors.hpp"

namespace voile::cli {

namespace {

namespace fs = std::filesystem;

void write_new(const fs::path& file, const std::string& text) {
  std::error_code error;
  if (fs::exists(fs::symlink_status(file, error)))
    throw UserError(fmt::format("{}: the file exists already; name a new folder", file.string()));
  std::ofstream out(file);
  out << text << std::flush;
  if (!out) throw UserError(fmt::format("{}: cannot be written", file.string()));
}

std::string content(const fs::path& file) {
  std::ifstream in = open_input(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

int count_of(const std::string& what, const std::string& text) {
  int count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

}  // namespace

void begin_from_deck(const fs::path& folder, const fs::path& deck) {
  std::error_code error;
  if (!fs::is_regular_file(deck, error)) throw UserError(fmt::format("{}: there is no such deck", deck.string()));
  require_plain_file(deck);
  const bool nastran = formats::is_nastran(deck);
  const formats::Deck read =
      nastran ? formats::read_nastran_deck(deck.string()) : formats::read_abaqus_deck(deck.string());
  const DeckCase made = deck_case(read, formats::read_mesh(deck.string(), {}));
  for (const std::string& name : read.included)
    if (fs::path(name).lexically_normal().string().starts_with(".."))
      throw UserError(
          fmt::format("{}: *INCLUDE of '{}' lies outside its folder; put the files together", deck.string(), name));
  fs::create_directories(folder, error);
  write_new(folder / "mesh.inp",
            (nastran ? formats::nastran_as_abaqus(deck.string()) : content(deck)) + "\n" + made.sets);
  for (const std::string& name : read.included) {
    fs::create_directories((folder / name).parent_path(), error);
    write_new(folder / name, content(deck.parent_path() / name));
  }
  write_new(folder / "case.toml", made.text);
  const std::string at = folder.lexically_normal().string();
  fmt::print("{} contains a new case from {}: {} material(s), {} support(s), {} load(s).\n", at,
             deck.filename().string(), made.materials, count_of("[[support]]", made.text),
             count_of("[[load]]", made.text));
  for (const std::string& left : made.left) fmt::print("left out: {}\n", left);
  if (!made.has_material) {
    fmt::print("Next: complete {}/case.toml; it has no [[material]] yet.\n", at);
    return;
  }
  fmt::print(
      "Next:\n  voile check {0}/case.toml\n  voile run {0}/case.toml --output {0}/run\n  voile render {0}/run --output "
      "{0}/picture.png\n",
      at);
}

}  // namespace voile::cli
