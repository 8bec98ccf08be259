#include <cstdio>
#include <voile/voile.hpp>

int main(int argc, char** argv) {
  voile::Session session(argc, argv);
  voile::Case c = voile::Case::read(argv[1]).set("mesh.parameters.nx", 10);
  voile::Simulation s(MPI_COMM_WORLD, c);
  while (!s.finished()) s.advance();
  const double z = s.positions()[3 * static_cast<std::size_t>(s.group("tip").front()) + 2];
  if (session.rank() == 0) std::printf("load factor %g: the tip is at z = %.6f m\n", s.load_factor(), z);
  return s.converged() ? 0 : 1;
}
