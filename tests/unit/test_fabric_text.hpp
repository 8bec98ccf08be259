// Text of a fabric file, and what is said of a changed one.
#pragma once

#include <string>

#include "input/fabric.hpp"
#include "test_case_kit.hpp"
#include "test_meshes.hpp"

namespace voile::testing {

inline const std::string fabric_text = R"toml(name = "Test"
description = "A fabric of round figures."
areal_density = "200 g/m^2"
membrane_warp = "2 kN/m"
membrane_weft = 500
membrane_shear = "1 gf/(cm.deg)"
bending_warp = "0.1 gf.cm^2/cm"
bending_weft = "4 uN.m"
[sources]
areal_density = "made up"
membrane_warp = "made up"
membrane_weft = "made up"
membrane_shear = "made up"
bending_warp = "made up"
bending_weft = "made up"
)toml";

inline std::string fabric_error(const std::string& from, const std::string& to) {
  return error_of([&] { (void)input::parse_fabric(replaced(fabric_text, from, to), "f.toml"); });
}

}  // namespace voile::testing
