#include "case_declarations.hpp"

namespace voile::input {

Declarations::Declarations()
    : top_(top_keys(case_)),
      keys_{{"units", keys_of(case_.units)},
            {"mesh", keys_of(case_.mesh)},
            {"panel", keys_of(panel_)},
            {"seam", keys_of(seam_)},
            {"mark", keys_of(mark_)},
            {"sewing", keys_of(case_.sewing)},
            {"element", keys_of(case_.element)},
            {"material", keys_of(material_)},
            {"support", keys_of(support_, motion_)},
            {"rigid", keys_of(rigid_)},
            {"periodic", keys_of(periodic_)},
            {"load", keys_of(load_)},
            {"temperature", keys_of(temperature_)},
            {"form", keys_of(case_.form)},
            {"hinge", keys_of(hinge_)},
            {"imperfection", keys_of(imperfection_)},
            {"mass", keys_of(mass_)},
            {"spring", keys_of(spring_)},
            {"contact", keys_of(case_.contact)},
            {"obstacle", keys_of(obstacle_)},
            {"landmark", keys_of(landmark_)},
            {"contact_rule", keys_of(rule_)},
            {"attachment", keys_of(attachment_)},
            {"steps", keys_of(case_.steps)},
            {"eigen", keys_of(case_.eigen)},
            {"harmonic", keys_of(case_.harmonic)},
            {"time", keys_of(case_.time, case_.dynamics.mass)},
            {"initial_velocity", keys_of(initial_velocity_)},
            {"damping", damping_keys(case_.dynamics)},
            {"air", keys_of(case_.dynamics.drag)},
            {"drape", keys_of(case_.drape)},
            {"remesh", keys_of(case_.remesh)},
            {"probe", keys_of(probe_)},
            {"output", keys_of(case_.output)},
            {"stage", keys_of(case_.stage)},
            {"petsc", petsc_keys(case_)}} {}

}  // namespace voile::input
