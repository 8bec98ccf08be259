"""Newton's method by hand, from residual and tangent; needs petsc4py."""

import numpy as np
from petsc4py import PETSc
from strip import strip
from voile import Simulation

s = Simulation(strip("static"))
force = np.zeros((s.vertex_count, 3))
tip = s.group("tip")
force[tip, 2] = 0.1 / len(tip)
s.set_forces(force)

x = s.unknowns()
for k in range(20):
    r = s.residual(x)
    print(f"{k}: |r| = {r.norm():.3e} N")
    if r.norm() < 1e-10:
        break
    ksp = PETSc.KSP().create(x.comm)
    ksp.setType("preonly")
    ksp.pc.setType("lu")
    ksp.pc.setFactorSolverType("mumps")
    ksp.setOperators(s.tangent(x))
    dx = x.duplicate()
    ksp.solve(r, dx)
    x.axpy(-1.0, dx)
drop = s.to_array(x)[tip, 2].mean()
assert r.norm() < 1e-10
assert s.run()
found = s.displacements()[tip, 2].mean()
print(f"deflection {drop:.6f} m; the simulation finds {found:.6f} m")
assert abs(drop - found) < 1e-6
