// All mistakes in the keys of a case at once.
#include <fmt/format.h>

#include "case_declarations.hpp"
#include "case_read.hpp"

namespace voile::input {

std::string with_other_mistakes(const CaseReader& reader, const std::string& first) {
  constexpr std::size_t most = 10;
  const Declarations declared;
  const auto keys = [&](const std::string& section) -> const std::vector<Key>& { return declared.of(section); };
  std::string all = first;
  std::size_t count = 1;
  for (const std::string& text : reader.mistakes(keys))
    if (text != first && ++count <= most) all += "\n" + text;
  return count > most ? all + fmt::format("\nand {} more", count - most) : all;
}

}  // namespace voile::input
