// Equilibria of a drape test: which are the same, and what is written of stable, unstable and missing ones.
#include "cli/drape_equilibria.hpp"

#include <doctest/doctest.h>

#include <cstdio>
#include <fstream>
#include <sstream>

#include "base/mpi.hpp"

namespace test_drape_equilibria {

using namespace voile;

namespace {

cli::DrapeEquilibrium equilibrium(int start, std::size_t folds, double energy, long negative) {
  cli::DrapeEquilibrium e;
  e.start = start;
  e.energy = energy;
  e.negative_eigenvalues = negative;
  e.specimen.converged = true;
  e.specimen.shape.coefficient = 0.7;
  e.specimen.shape.folds.resize(folds);
  return e;
}

}  // namespace

TEST_CASE("equilibria are numbered by energy, the same ones once") {
  std::vector<cli::DrapeEquilibrium> all{equilibrium(0, 8, -6.0e-4, 0), equilibrium(4, 4, -6.4e-4, 0),
                                         equilibrium(5, 5, -6.4e-4 * (1.0 + 1e-7), 0),
                                         equilibrium(8, 8, -6.0e-4 * (1.0 - 1e-7), 1), cli::DrapeEquilibrium{}};
  cli::rank_equilibria(all);
  CHECK(all[2].rank == 1);
  CHECK(all[1].rank == 2);  // as much energy, other folds
  CHECK(all[0].rank == 3);
  CHECK(all[3].rank == 3);
  CHECK(all[4].rank == 0);
  CHECK(cli::has_equilibrium(all));
  CHECK_FALSE(cli::has_equilibrium({cli::DrapeEquilibrium{}}));

  all[4].start = 9;
  const std::string file = "equilibria_" + std::to_string(mpi::rank(MPI_COMM_WORLD)) + ".csv";
  const nlohmann::ordered_json json = cli::write_equilibria(file, all);
  CHECK(json[0]["start"] == "test");
  CHECK(json[0]["stable"] == true);
  CHECK(json[3]["stable"] == false);
  CHECK(json[3]["negative_eigenvalues"] == 1);
  CHECK(json[4]["found"] == false);
  CHECK_FALSE(json[4].contains("energy_mJ"));
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  CHECK(text.str().find("\ntest,8,70.0000,-0.6,0,0,3,0.00\n") != std::string::npos);
  CHECK(text.str().find("\n9,,,,,,,0.00\n") != std::string::npos);
  (void)std::remove(file.c_str());
}

}  // namespace test_drape_equilibria
