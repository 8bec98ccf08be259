// The few collective operations that are not hidden in PETSc objects.
#pragma once

#include <mpi.h>

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "voile/base/types.hpp"

namespace voile::mpi {

[[nodiscard]] int rank(MPI_Comm comm);
[[nodiscard]] int size(MPI_Comm comm);

/// Copies rank 0's value to every rank. Collective.
void broadcast(MPI_Comm comm, std::string& text);
void broadcast(MPI_Comm comm, std::vector<double>& values);
void broadcast(MPI_Comm comm, std::vector<Index>& values);
void broadcast(MPI_Comm comm, std::vector<std::size_t>& values);

/// Copies the text of one rank to every rank. Collective.
void broadcast_from(MPI_Comm comm, int root, std::string& text);

/// Sum and largest over the ranks, on every rank. Collective.
[[nodiscard]] double sum(MPI_Comm comm, double value);
[[nodiscard]] long sum(MPI_Comm comm, long value);
[[nodiscard]] double max(MPI_Comm comm, double value);

/// Smallest over the ranks, entry by entry, on every rank. Collective; every rank passes the same length.
void min(MPI_Comm comm, std::vector<double>& values);

/// Adds the arrays of all ranks into rank 0's. Collective; every rank passes the same length.
void sum_to_root(MPI_Comm comm, std::vector<double>& values);

/// The arrays of all ranks one after another on rank 0; empty elsewhere. Collective.
[[nodiscard]] std::vector<Index> gather_to_root(MPI_Comm comm, const std::vector<Index>& values);

/// For libraries that are written in Fortran.
[[nodiscard]] int fortran_handle(MPI_Comm comm);

/// Runs `work` on rank 0 only. If it throws, every rank throws the same UserError or InternalError. Collective.
void on_root(MPI_Comm comm, const std::function<void()>& work);

/// Runs `work` on every rank. If it throws on any rank, every rank throws the message of the lowest such rank, so that
/// nobody waits in a later collective call. Collective.
void on_all(MPI_Comm comm, const std::function<void()>& work);

}  // namespace voile::mpi
