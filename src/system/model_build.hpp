// Scratch data of Model's construction; private to src/system.
#pragma once

#include <algorithm>
#include <vector>

#include "voile/system/model.hpp"

namespace voile::system {

/// One triangle whose elements this rank evaluates.
struct Model::Build {
  struct Item {
    Index triangle;
    energy::CurvatureOperator curvature;
  };
  std::vector<Item> items;
};

}  // namespace voile::system
