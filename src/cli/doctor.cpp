#include "doctor.hpp"

#include <dlfcn.h>
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <vector>

#include "base/mpi.hpp"
#include "base/shipped_files.hpp"
#include "energy/element_kernels.hpp"
#include "mesh/surface_mesh.hpp"
#include "results/stored_step.hpp"
#include "simulation/run.hpp"

namespace voile::cli {

namespace {

namespace fs = std::filesystem;

/// Strip 10 x 1 x 0.1 under a line load at its end, E = 1.2e6: tip deflection of the inextensible elastica.
constexpr double exact_tip = 6.6996, tolerance = 0.005;
constexpr const char* strip_mesh = R"(Point(1) = {0, 0, 0, 1};
Point(2) = {10, 0, 0, 1};
Point(3) = {10, 1, 0, 1};
Point(4) = {0, 1, 0, 1};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Physical Curve("clamp") = {4};
Physical Curve("tip") = {2};
Physical Surface("strip") = {1};
Transfinite Curve{1, 3} = 21;
Transfinite Curve{2, 4} = 3;
Transfinite Surface{1} = {1, 2, 3, 4} Alternate;
)";
constexpr const char* strip_case = R"(title = "Strip of voile doctor"
[mesh]
file = "strip.geo"
[[material]]
type = "isotropic"
young = 1.2e6
poisson = 0.0
thickness = 0.1
[[support]]
group = "clamp"
type = "clamped"
[[load]]
group = "tip"
type = "line"
vector = [0, 0, 4]
[[probe]]
name = "tip"
type = "displacement"
group = "tip"
components = ["z"]
)";

/// Prints the findings on rank 0 and remembers whether one was bad.
class Findings {
 public:
  explicit Findings(MPI_Comm comm) : root_(mpi::rank(comm) == 0) {}
  void ok(const std::string& text) const { say("ok  ", text); }
  void note(const std::string& text) const { say("note", text); }
  void bad(const std::string& text) {
    say("FAIL", text);
    good_ = false;
  }
  [[nodiscard]] bool good() const { return good_; }

 private:
  void say(const char* kind, const std::string& text) const {
    if (root_) fmt::print("{}  {}\n", kind, text);
  }
  bool root_, good_ = true;
};

void check_ranks(Findings& found, MPI_Comm comm) {
  const int ranks = mpi::size(comm);
  const long sum = std::lround(mpi::sum(comm, 1.0));
  if (sum != ranks)
    found.bad(fmt::format("{} ranks add up to {}: this MPI does not work", ranks, sum));
  else if (ranks == 1)
    found.ok("1 rank; `mpirun -n 2 voile doctor` tries several");
  else
    found.ok(fmt::format("{} ranks", ranks));
}

void check_blas(Findings& found) {
  using Product = void (*)(const char*, const char*, const int*, const int*, const int*, const double*, const double*,
                           const int*, const double*, const int*, const double*, double*, const int*);
  // PETSc brings it: which one, only the dynamic linker knows.
  void* const symbol = dlsym(RTLD_DEFAULT, "dgemm_");
  Dl_info info{};
  std::error_code ignored;
  const bool known = symbol && dladdr(symbol, &info) != 0 && info.dli_fname;
  if (!known) return found.bad("there is no BLAS");
  const auto product = reinterpret_cast<Product>(symbol);
  const std::string file = fs::canonical(info.dli_fname, ignored).string();
  const int n = 400;
  const double one = 1.0, zero = 0.0;
  std::vector<double> a(static_cast<std::size_t>(n) * n, 1.0), b = a, c = a;
  const auto begin = std::chrono::steady_clock::now();
  product("N", "N", &n, &n, &n, &one, a.data(), &n, b.data(), &n, &zero, c.data(), &n);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const std::string text = fmt::format("BLAS {}, {:.1f} Gflop/s", file, 2e-9 * n * n * n / seconds);
  if (c.front() != n)
    found.bad(text + ": a product of matrices is wrong");
  else if (file.find("/blas/libblas") != file.npos)
    found.note(text + ": the reference BLAS makes direct solvers several times slower; install libopenblas0-pthread");
  else
    found.ok(text);
}

void check_files(Findings& found) {
  for (const char* name : {"voile-gmsh", "voile-picture", "voile-manikin"})
    if (const fs::path file = program_of_ours(name); access(file.c_str(), X_OK) != 0)
      found.bad(fmt::format("{}: the program is not there; build or install all of Voile", file.string()));
  for (const auto& [folder, ending] : {std::pair{"fabrics", ".toml"}, {"templates", ".md"}})
    if (shipped_names(folder, ending).empty())
      found.bad(fmt::format("{}: no files; install all of Voile", shipped_folder(folder).string()));
  if (std::system("command -v ffmpeg >/dev/null 2>&1") != 0)
    found.note("ffmpeg is not there: `voile render` writes WebP and GIF, but no MP4");
#ifdef __AVX2__
  const char* const built = "AVX2 or newer";
#else
  const char* const built = "any processor";
#endif
  found.ok(fmt::format("element kernels for {}, the rest of the program for {}", energy::batch_kernels().name, built));
}

/// Mean deflection at x = 10 of the last step that was written, and read back with its mesh.
double read_tip(const fs::path& file) {
  const mesh::MeshData data = results::read_step_mesh(file, -1);
  const mesh::SurfaceMesh mesh(data);
  const results::StoredStep step = results::read_step(file, -1, mesh);
  double sum = 0.0;
  int count = 0;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (mesh.positions()[v].x() < 10.0 - 1e-9) continue;
    sum += step.displacement[3 * static_cast<std::size_t>(v) + 2];
    ++count;
  }
  return sum / count;
}

/// Writes the strip, solves it, reads the result: Gmsh, PETSc, MUMPS and HDF5 all have a part.
void check_problem(Findings& found, MPI_Comm comm) {
  std::string folder = (fs::temp_directory_path() / "voile-doctor-XXXXXX").string();
  mpi::on_root(comm, [&] {
    if (!mkdtemp(folder.data())) throw UserError(folder + ": the folder cannot be made; set TMPDIR to another one");
    std::ofstream(fs::path(folder) / "strip.geo") << strip_mesh;
  });
  mpi::broadcast(comm, folder);
  const fs::path results = fs::path(folder) / "results";
  double tip = std::nan("");
  std::string failure;
  try {
    const input::Case c = input::parse_case(strip_case, fs::path(folder) / "case.toml");
    record::RunOptions options;
    options.comm = comm;
    options.output = results;
    options.verbosity = record::Verbosity::quiet;
    const Exit end = simulation::run(c, options);
    if (end != Exit::done) failure = fmt::format("the strip ends with code {}", static_cast<int>(end));
    mpi::on_root(comm, [&] { tip = read_tip(results / "results.vtkhdf"); });
  } catch (const UserError& e) {
    failure = e.what();
  }
  mpi::on_root(comm, [&] {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  });
  std::vector<double> shared{tip};
  mpi::broadcast(comm, shared);
  const double error = shared[0] / exact_tip - 1.0;
  if (!failure.empty())
    found.bad(failure);
  else if (!(std::abs(error) < tolerance))
    found.bad(fmt::format("a bent strip moves by {:.4g} where {} is right", shared[0], exact_tip));
  else
    found.ok(fmt::format(
        "Gmsh, PETSc, MUMPS, HDF5: a strip bent into a hook moves by {:.4g}, {:+.2f} % from the exact answer",
        shared[0], 100.0 * error));
}

}  // namespace

bool doctor() {
  const MPI_Comm comm = MPI_COMM_WORLD;
  Findings found(comm);
  check_ranks(found, comm);
  check_blas(found);
  check_files(found);
  check_problem(found, comm);
  return found.good();
}

}  // namespace voile::cli
