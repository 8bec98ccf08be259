// Work of the forces of a model in a displacement, each kind for itself.
#include <algorithm>

#include "voile/energy/membrane.hpp"
#include "voile/system/bands.hpp"
#include "voile/system/bending_energy.hpp"
#include "voile/system/contact.hpp"
#include "voile/system/model.hpp"
#include "voile/system/sewing_springs.hpp"
#include "voile/system/term.hpp"

namespace voile::system {

bool Model::stores_by_time() const {
  return bending_->turns() || bands_->rise() || sewing_ || !attachments_->list().empty();
}

/// Adds the forces of a term on the local points to f.
void Model::add_term_forces(const Term& term, const energy::Configuration& c, Vec f) {
  std::fill(force_.begin(), force_.end(), Vec3::Zero());
  term.add_forces(c, force_);
  dofs().add_forces(force_, f);
}

Model::Work Model::work(Vec a, Vec displacement, Vec f) {
  const petsc::EventScope scope(petsc::events().residual);
  Work w;
  const energy::Configuration c = configuration(a);
  const auto along = [&](Vec force) {
    double product = 0.0;
    VOILE_PETSC(VecDot(force, displacement, &product));
    return product;
  };
  const auto part = [&](const auto& add, double sign) {
    VOILE_PETSC(VecZeroEntries(work_));
    add();
    VOILE_PETSC(VecAXPY(f, sign, work_));
    return along(work_);
  };
  bending_->force(a, f);
  const std::vector<double> viscosity = membrane_->kernel.viscosity();
  membrane_->kernel.set_viscosity({});
  for (const Counted& t : terms_) add_term_forces(*t.term, c, f);
  w.internal = along(f);
  if (!viscosity.empty()) {
    (void)part([&] { add_term_forces(*membrane_, c, work_); }, -1.0);
    const double elastic = along(work_);
    membrane_->kernel.set_viscosity(viscosity);
    w.viscous = part([&] { add_term_forces(*membrane_, c, work_); }, 1.0) - elastic;
  }
  if (contact_) {
    w.contact = part([&] { contact_->add_gradient(a, work_, contact::ContactSet::normal); }, 1.0);
    w.friction = part([&] { contact_->add_gradient(a, work_, contact::ContactSet::friction); }, 1.0);
  }
  w.loads = part([&] { conditions_->applied_forces(c, force_, work_); }, -1.0);
  return w;
}

}  // namespace voile::system
