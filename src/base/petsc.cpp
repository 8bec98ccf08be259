#include "voile/base/petsc.hpp"

#include <fmt/format.h>

#include "voile/base/error.hpp"

namespace voile::petsc {

void check(PetscErrorCode code, const char* where) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  throw InternalError(fmt::format("PETSc error {} ({}) in {}", static_cast<int>(code), text ? text : "unknown", where));
}

const Events& events() {
  static const Events registered = [] {
    PetscClassId id = 0;
    Events e{};
    check(PetscClassIdRegister("Voile", &id), "PetscClassIdRegister");
    const auto add = [&](const char* name, PetscLogEvent& event) {
      check(PetscLogEventRegister(name, id, &event), "PetscLogEventRegister");
    };
    add("VoileResidual", e.residual);
    add("VoileTangent", e.tangent);
    add("VoileBendAssemble", e.bending_assemble);
    add("VoileBendCopy", e.bending_copy);
    add("VoileEnergy", e.energy);
    add("VoileOutput", e.output);
    add("VoileContactFind", e.contact_find);
    add("VoileContactWay", e.contact_way);
    add("VoileContactTerm", e.contact_term);
    add("VoileFactorSingle", e.factor_single);
    add("VoileRefine", e.refine);
    return e;
  }();
  return registered;
}

}  // namespace voile::petsc
