// The drape test of a laboratory, for a fabric file: what `voile drape-test` does.
//
// A disc of fabric is held between two discs of 180 mm, its overhang rests on a plate, and the plate is lowered slowly (ISO 9073-9,
// BS 5058). Each repeat is a case of its own that `voile run` solves in a folder of its own; repeats run side by side.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "drape_shape.hpp"
#include "side_by_side.hpp"
#include "voile/errors.hpp"

namespace voile::cli {

struct DrapeTest {
  enum class Method { plate, weight };
  std::string fabric;  ///< file, or name of a shipped fabric
  int specimen = 300;  ///< diameter [mm]
  int repeats = 6;
  Method method = Method::plate;  ///< the plate is lowered, or without any plate the weight grows
  bool mesh_check = true;         ///< the first repeat once more with finer cells
  bool equilibria = false;        ///< looks for those of the elastic fabric, from these numbers of folds
  int least_folds = 2, most_folds = 12;
  bool elastic = false;          ///< leaves out friction inside the fabric
  double cell = 0.0;             ///< [m]; 0: by the bending length
  int jobs = 0;                  ///< side by side; 0: one for each core
  std::filesystem::path output;  ///< empty: FABRIC_drape
  bool overwrite = false, quiet = false;
};

/// A specimen laid down once more: its centre beside the axis, its warp turned.
struct DrapeRepeat {
  double x = 0.0, y = 0.0;  ///< [m]
  double warp = 0.0;        ///< [degree]
  double cell = 0.0;        ///< [m]
  std::filesystem::path folder{};
  // What came of it.
  bool converged = false, at_rest = false;
  double cpu_seconds = 0.0, recovery_error = 0.0;
  DrapeShape shape{};
  std::vector<Vec3> edge{};  ///< of the specimen, in order [m]
};

/// Of `count` repeats: the first is laid as it should be, the others by a millimetre beside, each turned by 15 degrees more.
[[nodiscard]] std::vector<DrapeRepeat> drape_repeats(int count);

struct DrapeSetting;
/// Cells and friction by the fabric file of the test, and its folder. Throws UserError.
[[nodiscard]] DrapeSetting drape_setting(const DrapeTest& test);
/// Runs all repeats in their folders, so many side by side. Throws StoppedBySignal.
void run_drape_repeats(const DrapeSetting& s, std::vector<DrapeRepeat>& repeats);

/// Whether the command line asks for it.
[[nodiscard]] bool is_drape_test(int argc, char** argv);
/// Reads the rest of the command line, tests, writes and prints. Before MPI starts. Throws UserError.
[[nodiscard]] Exit drape_test_command(int argc, char** argv);

/// Runs the test: all files in the folder of the output. Throws UserError.
[[nodiscard]] Exit run_drape_test(const DrapeTest& test);

}  // namespace voile::cli
