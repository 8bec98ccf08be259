// The few collective operations that are not hidden in PETSc objects.
#pragma once

#include <mpi.h>

#include <array>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "types.hpp"

namespace voile::mpi {

[[nodiscard]] int rank(MPI_Comm comm);
[[nodiscard]] int size(MPI_Comm comm);

/// The data type of `count` doubles one after another, while it lives.
class Doubles {
 public:
  explicit Doubles(int count);
  ~Doubles();
  Doubles(const Doubles&) = delete;
  Doubles& operator=(const Doubles&) = delete;
  operator MPI_Datatype() const { return type_; }  // NOLINT: meant to be passed as it is

 private:
  MPI_Datatype type_{};
};

/// Copies rank 0's value to every rank. Collective.
void broadcast(MPI_Comm comm, std::string& text);
void broadcast(MPI_Comm comm, std::vector<double>& values);
void broadcast(MPI_Comm comm, std::vector<Index>& values);
void broadcast(MPI_Comm comm, std::vector<std::size_t>& values);

/// The text of the lowest rank that has one, on every rank; empty if none has. Collective.
[[nodiscard]] std::string first_text(MPI_Comm comm, const std::string& own);

/// Sum and largest over the ranks, on every rank. Collective.
[[nodiscard]] double sum(MPI_Comm comm, double value);
[[nodiscard]] long sum(MPI_Comm comm, long value);
[[nodiscard]] double max(MPI_Comm comm, double value);

/// Sums over the ranks, entry by entry, on every rank. Collective.
[[nodiscard]] std::array<double, 5> sum(MPI_Comm comm, const std::array<double, 5>& values);

/// The same in place. Collective; every rank passes the same length.
void sum(MPI_Comm comm, std::vector<double>& values);

/// Smallest over the ranks, entry by entry, on every rank. Collective; every rank passes the same length.
void min(MPI_Comm comm, std::vector<double>& values);

/// Adds the arrays of all ranks into rank 0's. Collective; every rank passes the same length.
void sum_to_root(MPI_Comm comm, std::vector<double>& values);

/// The arrays of all ranks one after another on rank 0; empty elsewhere. Collective.
[[nodiscard]] std::vector<Index> gather_to_root(MPI_Comm comm, const std::vector<Index>& values);

[[nodiscard]] std::vector<double> gather_to_root(MPI_Comm comm, const std::vector<double>& values);

/// The arrays of all ranks, by rank, on every rank. Collective.
[[nodiscard]] std::vector<std::vector<double>> gather_to_all(MPI_Comm comm, const std::vector<double>& values);

/// Sends to[r] to rank r; what each rank has sent to this one. Collective; `to` has a list for each rank.
[[nodiscard]] std::vector<std::vector<Index>> exchange(MPI_Comm comm, const std::vector<std::vector<Index>>& to);

/// For libraries that are written in Fortran.
[[nodiscard]] int fortran_handle(MPI_Comm comm);

/// Runs `work` on rank 0 only. If it throws, every rank throws the same UserError or InternalError. Collective.
void on_root(MPI_Comm comm, const std::function<void()>& work);

/// Runs `work` on every rank. If it throws on any rank, every rank throws the message of the lowest such rank, so that
/// nobody waits in a later collective call. Collective.
void on_all(MPI_Comm comm, const std::function<void()>& work);

}  // namespace voile::mpi
