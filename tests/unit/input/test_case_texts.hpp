// Case files for tests of reading and of the echo.
#pragma once

#include <string>

namespace voile::testing::cases {

inline const std::string minimal = R"([mesh]
file = "plate.geo"
[[material]]
type = "isotropic"
young = 2.1e11
poisson = 0.3
thickness = 0.01
)";

inline const std::string full = R"(title = "All \"keys\""
analysis = "static"
[mesh]
file = "meshes/plate.geo"
scale = 0.001
size = 2.5
algorithm = 5
parameters = { n = 12, L = 2.5 }
[element]
type = "zhou_sze_2012"
cst_fraction = 0.3
max_patch_condition = 50
crease_angle = 33.3
[[material]]
groups = ["plate", "rim"]
type = "isotropic"
young = 1e6
poisson = 0.3
thickness = 0.1
density = 1000
[[material]]
groups = ["fabric"]
type = "orthotropic"
young_1 = 3e6
young_2 = 1e6
poisson_12 = 0.2
shear_12 = 4e5
thickness = 0.2
direction = [1, 1, 0]
[[material]]
type = "matrices"
membrane = [[2, 1, 0.1], [1, 3, 0], [0.1, 0, 1]]
bending = [[1, 0, 0], [0, 1, 0], [0, 0, 0.5]]
direction = [0, 0, 1]
areal_density = 0.2
[[support]]
group = "left"
type = "displacement"
components = ["z", "x"]
value = [0.1, 0, -0.2]
[[support]]
group = "right"
type = "clamped"
value = [0, 0, 0.5]
[[support]]
group = "top"
type = "symmetry"
normal = [0, 1, 0]
[[support]]
group = "bottom"
type = "symmetry"
[[load]]
type = "line"
group = "right"
vector = [0, 0, -4]
[[load]]
type = "gravity"
vector = [0, 0, -9.81]
constant = true
[[load]]
type = "follower_pressure"
magnitude = -100
group = "plate"
[steps]
final_load_factor = 2
initial_step = 0.1
min_step = 1e-5
max_step = 0.5
stops = [0.1, 0.7, 2]
target_iterations = 5
fallback = false
[[probe]]
name = "tip"
type = "displacement"
point = [0, 0, 0]
components = ["z"]
[[probe]]
name = "pull"
type = "reaction"
group = "left"
[[probe]]
name = "work"
type = "energy"
[output]
fields = ["reaction", "displacement"]
every = 3
[petsc]
options = "-snes_rtol 1e-10 -ksp_view"
)";

}  // namespace voile::testing::cases
