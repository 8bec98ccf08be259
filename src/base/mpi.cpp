#include "mpi.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <new>
#include <numeric>

#include "voile/errors.hpp"

namespace voile::mpi {

namespace {

template <class T>
void broadcast_items(MPI_Comm comm, T& items, MPI_Datatype type) {
  unsigned long count = items.size();
  MPI_Bcast(&count, 1, MPI_UNSIGNED_LONG, 0, comm);
  items.resize(count);
  MPI_Bcast(items.data(), static_cast<int>(count), type, 0, comm);
}

template <class T>
T reduce(MPI_Comm comm, T value, MPI_Datatype type, MPI_Op op) {
  T result{};
  MPI_Allreduce(&value, &result, 1, type, op, comm);
  return result;
}

/// Where each of several arrays begins when they stand one after another, and the end.
std::vector<int> starts_of(const std::vector<int>& counts) {
  std::vector<int> starts(counts.size() + 1, 0);
  std::partial_sum(counts.begin(), counts.end(), starts.begin() + 1);
  return starts;
}

template <class T>
std::vector<std::vector<T>> divided(const std::vector<T>& all, const std::vector<int>& starts) {
  std::vector<std::vector<T>> parts;
  for (std::size_t r = 0; r + 1 < starts.size(); ++r)
    parts.emplace_back(all.begin() + starts[r], all.begin() + starts[r + 1]);
  return parts;
}

template <class T>
std::vector<T> gather_items(MPI_Comm comm, const std::vector<T>& values, MPI_Datatype type) {
  const int own = static_cast<int>(values.size());
  std::vector<int> counts(static_cast<std::size_t>(size(comm)));
  MPI_Gather(&own, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, comm);
  const std::vector<int> starts = starts_of(counts);
  std::vector<T> all(rank(comm) == 0 ? static_cast<std::size_t>(starts.back()) : 0);
  MPI_Gatherv(values.data(), own, type, all.data(), counts.data(), starts.data(), type, 0, comm);
  return all;
}

enum Failure : int { none = 0, user = 1, internal = 2, memory = 3 };

/// What `work` threw, as a value.
Failure outcome(const std::function<void()>& work, std::string& message) {
  try {
    work();
  } catch (const UserError& e) {
    message = e.what();
    return user;
  } catch (const std::filesystem::filesystem_error& e) {  // of a name or a folder that the user has chosen
    message = fmt::format("{}: {}", e.path1().string(), e.code().message());
    return user;
  } catch (const OutOfMemory& e) {
    message = e.what();
    return memory;
  } catch (const std::bad_alloc&) {
    message = "an array could not be had";
    return memory;
  } catch (const std::exception& e) {
    message = e.what();
    return internal;
  }
  return none;
}

void throw_on_failure(int failure, const std::string& message) {
  if (failure == user) throw UserError(message);
  if (failure == internal) throw InternalError(message);
  if (failure == memory) throw OutOfMemory(message);
}

}  // namespace

int rank(MPI_Comm comm) {
  int r = 0;
  MPI_Comm_rank(comm, &r);
  return r;
}

int size(MPI_Comm comm) {
  int n = 1;
  MPI_Comm_size(comm, &n);
  return n;
}

Doubles::Doubles(int count) {
  MPI_Type_contiguous(count, MPI_DOUBLE, &type_);
  MPI_Type_commit(&type_);
}

Doubles::~Doubles() {
  MPI_Type_free(&type_);
}

std::string first_text(MPI_Comm comm, const std::string& own) {
  const int ranks = size(comm), lowest = static_cast<int>(-max(comm, own.empty() ? -ranks : -rank(comm)));
  if (lowest == ranks) return "";
  std::string text = own;
  unsigned long count = text.size();
  MPI_Bcast(&count, 1, MPI_UNSIGNED_LONG, lowest, comm);
  text.resize(count);
  MPI_Bcast(text.data(), static_cast<int>(count), MPI_CHAR, lowest, comm);
  return text;
}

void broadcast(MPI_Comm comm, std::string& text) {
  broadcast_items(comm, text, MPI_CHAR);
}
void broadcast(MPI_Comm comm, std::vector<double>& values) {
  broadcast_items(comm, values, MPI_DOUBLE);
}
void broadcast(MPI_Comm comm, std::vector<Index>& values) {
  broadcast_items(comm, values, MPI_INT32_T);
}
void broadcast(MPI_Comm comm, std::vector<std::size_t>& values) {
  broadcast_items(comm, values, MPI_UNSIGNED_LONG);
}

double sum(MPI_Comm comm, double value) {
  return reduce(comm, value, MPI_DOUBLE, MPI_SUM);
}
long sum(MPI_Comm comm, long value) {
  return reduce(comm, value, MPI_LONG, MPI_SUM);
}
double max(MPI_Comm comm, double value) {
  return reduce(comm, value, MPI_DOUBLE, MPI_MAX);
}

std::array<double, 5> sum(MPI_Comm comm, const std::array<double, 5>& values) {
  std::array<double, 5> all{};
  MPI_Allreduce(values.data(), all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM, comm);
  return all;
}

void sum(MPI_Comm comm, std::vector<double>& values) {
  MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE, MPI_SUM, comm);
}

void min(MPI_Comm comm, std::vector<double>& values) {
  MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE, MPI_MIN, comm);
}

void sum_to_root(MPI_Comm comm, std::vector<double>& values) {
  const bool root = rank(comm) == 0;
  MPI_Reduce(root ? MPI_IN_PLACE : values.data(), root ? values.data() : nullptr, static_cast<int>(values.size()),
             MPI_DOUBLE, MPI_SUM, 0, comm);
}

std::vector<Index> gather_to_root(MPI_Comm comm, const std::vector<Index>& values) {
  return gather_items(comm, values, MPI_INT32_T);
}
std::vector<double> gather_to_root(MPI_Comm comm, const std::vector<double>& values) {
  return gather_items(comm, values, MPI_DOUBLE);
}

std::vector<std::vector<double>> gather_to_all(MPI_Comm comm, const std::vector<double>& values) {
  const int own = static_cast<int>(values.size());
  std::vector<int> counts(static_cast<std::size_t>(size(comm)));
  MPI_Allgather(&own, 1, MPI_INT, counts.data(), 1, MPI_INT, comm);
  const std::vector<int> starts = starts_of(counts);
  std::vector<double> all(static_cast<std::size_t>(starts.back()));
  MPI_Allgatherv(values.data(), own, MPI_DOUBLE, all.data(), counts.data(), starts.data(), MPI_DOUBLE, comm);
  return divided(all, starts);
}

std::vector<std::vector<Index>> exchange(MPI_Comm comm, const std::vector<std::vector<Index>>& to) {
  std::vector<int> sent, received(to.size());
  std::vector<Index> out;
  for (const std::vector<Index>& list : to) {
    sent.push_back(static_cast<int>(list.size()));
    out.insert(out.end(), list.begin(), list.end());
  }
  MPI_Alltoall(sent.data(), 1, MPI_INT, received.data(), 1, MPI_INT, comm);
  const std::vector<int> out_starts = starts_of(sent), in_starts = starts_of(received);
  std::vector<Index> in(static_cast<std::size_t>(in_starts.back()));
  MPI_Alltoallv(out.data(), sent.data(), out_starts.data(), MPI_INT32_T, in.data(), received.data(), in_starts.data(),
                MPI_INT32_T, comm);
  return divided(in, in_starts);
}

int fortran_handle(MPI_Comm comm) {
  return static_cast<int>(MPI_Comm_c2f(comm));
}

void on_root(MPI_Comm comm, const std::function<void()>& work) {
  std::string message;
  int failure = none;
  if (rank(comm) == 0) failure = outcome(work, message);
  MPI_Bcast(&failure, 1, MPI_INT, 0, comm);
  if (failure == none) return;
  broadcast(comm, message);
  throw_on_failure(failure, message);
}

void on_all(MPI_Comm comm, const std::function<void()>& work) {
  std::string message;
  const int failure = outcome(work, message);
  const int here = failure == none ? size(comm) : rank(comm);
  const int first = reduce(comm, here, MPI_INT, MPI_MIN);
  if (first == size(comm)) return;
  int kind = failure;
  MPI_Bcast(&kind, 1, MPI_INT, first, comm);
  unsigned long length = message.size();
  MPI_Bcast(&length, 1, MPI_UNSIGNED_LONG, first, comm);
  message.resize(length);
  MPI_Bcast(message.data(), static_cast<int>(length), MPI_CHAR, first, comm);
  throw_on_failure(kind, message);
}

}  // namespace voile::mpi
