#include "work.hpp"

#include "contact.hpp"
#include "model.hpp"

namespace voile::system {

ForceWork work_of_forces(Model& model, Vec a, Vec displacement, Vec f, Vec work) {
  const petsc::EventScope scope(petsc::events().residual);
  const auto part = [&](const auto& add, double sign) {
    VOILE_PETSC(VecZeroEntries(work));
    add();
    VOILE_PETSC(VecAXPY(f, sign, work));
    double product = 0.0;
    VOILE_PETSC(VecDot(work, displacement, &product));
    return product;
  };
  const energy::Configuration c = model.potential().configuration(a);
  const Potential::Work inner = model.potential().work(c, a, displacement, f);
  ForceWork w{inner.elastic, inner.viscous};
  if (Contact* contact = model.contact()) {
    w.contact = part([&] { contact->add_gradient(a, work, contact::ContactSet::normal); }, 1.0);
    w.friction = part([&] { contact->add_gradient(a, work, contact::ContactSet::friction); }, 1.0);
  }
  std::vector<Vec3> scratch(static_cast<std::size_t>(model.dofs().local().count()));
  w.loads = part([&] { model.conditions().applied_forces(c, scratch, work); }, -1.0);
  return w;
}

}  // namespace voile::system
