// Error checking and ownership for PETSc objects.
#pragma once

#include <petscsf.h>
#include <petscsnes.h>

#include <exception>
#include <utility>

namespace voile::petsc {

/// Throws if `code` is not zero: what a callback threw (see guarded), else UserError where PETSc refuses an option,
/// else OutOfMemory or InternalError, each with PETSc's text. Not collective; options are the same on all ranks.
void check(PetscErrorCode code, const char* where);

/// From now on PETSc prints no error stack: `check` reports what went wrong. Once, after PetscInitialize.
void collect_errors();

/// Keeps the exception in flight for `check` and returns PETSc's code for it.
[[nodiscard]] PetscErrorCode keep_exception() noexcept;

/// Runs the work of a callback. An exception must not cross PETSc's C frames: it becomes an error code, and `check`
/// throws it again, unchanged, once they are left.
template <class Work>
[[nodiscard]] PetscErrorCode guarded(Work&& work) noexcept {
  try {
    work();
  } catch (...) {
    return keep_exception();
  }
  return 0;
}

/// Owns one PETSc object; destroys it collectively on the object's communicator.
template <class Object, PetscErrorCode (*destroy)(Object*)>
class Handle {
 public:
  Handle() = default;
  ~Handle() { reset(); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  Handle(Handle&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Handle& operator=(Handle&& other) noexcept {
    if (this != &other) {
      reset();
      object_ = std::exchange(other.object_, nullptr);
    }
    return *this;
  }
  operator Object() const { return object_; }  // NOLINT: meant to be passed to PETSc as it is
  /// Address for PETSc's Create functions; what was owned before is destroyed.
  Object* out() {
    reset();
    return &object_;
  }
  void reset() {
    if (object_) destroy(&object_);
    object_ = nullptr;
  }

 private:
  Object object_ = nullptr;
};

using VecHandle = Handle<Vec, VecDestroy>;
using MatHandle = Handle<Mat, MatDestroy>;
using SnesHandle = Handle<SNES, SNESDestroy>;
using KspHandle = Handle<KSP, KSPDestroy>;
using ScatterHandle = Handle<VecScatter, VecScatterDestroy>;
using IndexSetHandle = Handle<IS, ISDestroy>;
using StarForestHandle = Handle<PetscSF, PetscSFDestroy>;

/// Another owner of the same vector.
[[nodiscard]] inline VecHandle fraction(Vec v) {
  VecHandle other;
  check(PetscObjectReference(reinterpret_cast<PetscObject>(v)), "PetscObjectReference");
  *other.out() = v;
  return other;
}

/// Read-only view of a vector's local values while it lives.
class ReadArray {
 public:
  explicit ReadArray(Vec v) : vec_(v) { check(VecGetArrayRead(v, &data_), "VecGetArrayRead"); }
  ~ReadArray() { VecRestoreArrayRead(vec_, &data_); }
  ReadArray(const ReadArray&) = delete;
  ReadArray& operator=(const ReadArray&) = delete;
  const double* data() const { return data_; }
  const double& operator[](PetscInt i) const { return data_[i]; }

 private:
  Vec vec_;
  const double* data_ = nullptr;
};

/// Writable view of a vector's local values while it lives.
class WriteArray {
 public:
  explicit WriteArray(Vec v) : vec_(v) { check(VecGetArray(v, &data_), "VecGetArray"); }
  ~WriteArray() { VecRestoreArray(vec_, &data_); }
  WriteArray(const WriteArray&) = delete;
  WriteArray& operator=(const WriteArray&) = delete;
  double* data() const { return data_; }
  double& operator[](PetscInt i) const { return data_[i]; }

 private:
  Vec vec_;
  double* data_ = nullptr;
};

/// Events shown by -log_view under their names. Registered once per process.
struct Events {
  PetscLogEvent residual, tangent, bending_assemble, bending_copy, energy, output, contact_find, contact_clear,
      contact_term, factor_single, refine, incomplete_factor, iterate, remesh;
};
[[nodiscard]] const Events& events();

/// Counts the time between construction and destruction to an event.
class EventScope {
 public:
  explicit EventScope(PetscLogEvent event) : event_(event) { (void)PetscLogEventBegin(event_, 0, 0, 0, 0); }
  ~EventScope() { (void)PetscLogEventEnd(event_, 0, 0, 0, 0); }
  EventScope(const EventScope&) = delete;
  EventScope& operator=(const EventScope&) = delete;

 private:
  PetscLogEvent event_;
};

}  // namespace voile::petsc

/// Calls a PETSc function and throws if it fails, see petsc::check.
#define VOILE_PETSC(call) ::voile::petsc::check((call), #call)
