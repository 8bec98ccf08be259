#include "version.hpp"

#include <dmumps_c.h>
#include <fmt/format.h>
#include <metis.h>
#include <mpi.h>
#include <petscsys.h>

#include <array>

#include "formats/gmsh.hpp"
#include "geometry/intersections.hpp"
#include "results/results.hpp"

namespace voile::cli {

namespace {

std::string petsc_version() {
  PetscInt major = 0, minor = 0, patch = 0, release = 0;
  if (PetscGetVersionNumber(&major, &minor, &patch, &release)) return "unknown";
  return fmt::format("{}.{}.{}{}", major, minor, patch, release ? "" : " (development)");
}

std::string mpi_version() {
  std::array<char, MPI_MAX_LIBRARY_VERSION_STRING> text{};
  int length = 0;
  MPI_Get_library_version(text.data(), &length);
  const std::string all(text.data(), static_cast<std::size_t>(length));
  return all.substr(0, all.find_first_of(",\n"));
}

}  // namespace

std::string version_text() {
  return fmt::format(
      "Voile {} ({})\n"
      "PETSc {}\n"
      "MUMPS {}\n"
      "METIS {}.{}.{}\n"
      "HDF5  {}\n"
      "Gmsh  {}\n"
      "CGAL  {}\n"
      "MPI   {}\n",
      VOILE_VERSION, VOILE_COMMIT, petsc_version(), MUMPS_VERSION, METIS_VER_MAJOR, METIS_VER_MINOR, METIS_VER_SUBMINOR,
      results::hdf5_version(), formats::gmsh_version(), geometry::cgal_version(), mpi_version());
}

}  // namespace voile::cli
