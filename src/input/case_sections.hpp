// Sections that may occur several times; private to src/input.
#pragma once

#include <vector>

#include "case_read.hpp"

namespace voile::input {

template <class Section, class Check>
void read_all(const CaseReader& reader, const char* name, std::vector<Section>& items, const Check& check) {
  for (std::size_t n = 0; n < reader.count(name); ++n) {
    Section item;
    const SectionPlace place = reader.read(name, n, keys_of(item));
    check(place, item);
    items.push_back(std::move(item));
  }
}

}  // namespace voile::input
