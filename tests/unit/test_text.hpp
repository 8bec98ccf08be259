// Messages that tests look into.
#pragma once

#include <string>

namespace voile::testing {

inline bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace voile::testing
