#!/usr/bin/python3
"""Every SNES type and line search that this PETSc has, and linear solvers, on five cases: right, exit code 3, or refused.

    tests/campaign/solver_options.py        about 10 CPU minutes

Right: the measured end is that of the default options, in motion up to what smaller steps change. Exit code 1 if any run
ends with code 0 elsewhere, or with another code.
"""

import math
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "regression"), str(ROOT / "runs" / "lib")]

from harness import OUT  # noqa: E402
from solver import run, variant, write_case  # noqa: E402
from trusting import pushed  # noqa: E402

FOLDER = OUT / "campaign"
TYPES = ("newtonls newtontr newtontrdc qn ksponly ksptransposeonly ngmres anderson nrichardson ncg ngs fas ms nasm aspin composite "
         "python shell patch vinewtonrsls vinewtonssls").split()
SEARCHES = "basic bt l2 cp nleqerr shell ncglinear".split()
LINEAR = ["-ksp_type cg -pc_type jacobi", "-ksp_type gmres -pc_type ilu", "-ksp_type preonly -pc_type jacobi", "-ksp_rtol 0.9 -ksp_type cg",
          "-pc_type lu", "-pc_type none -ksp_type cg -ksp_max_it 3", "-snes_lag_preconditioner 5", "-snes_lag_jacobian 5",
          "-mat_mumps_icntl_35 1 -mat_mumps_cntl_7 1e-3", "-snes_max_it 1", "-snes_linesearch_damping 0.2"]


def cases():
    follower = variant(pushed("static"), {})
    follower["load"].append({"type": "follower_pressure", "magnitude": 0.1})
    drape = variant(pushed("static"), {}) | {"analysis": "drape"}
    return {"static": (pushed("static"), 1e-4), "follower": (follower, 1e-4), "drape": (drape, 1e-4), "motion": (pushed("motion"), 4e-3),
            "contact": (pushed("contact"), 4e-3)}


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    bad = 0
    options = [f"-snes_type {t}" for t in TYPES] + [f"-snes_linesearch_type {s}" for s in SEARCHES] + LINEAR
    for name, (case, tolerance) in cases().items():
        file = write_case(case, FOLDER / f"options_{name}.toml")
        for given in ["", *options]:
            shutil.rmtree(FOLDER / "options", ignore_errors=True)
            done = run(file, FOLDER / "options", 1, given.split(), 300)
            end = done.history["tip_z"][-1] if done.code == 0 else math.nan
            if not given:
                right = end
            good = done.code in (2, 3) or (done.code == 0 and abs(end - right) <= tolerance)
            bad += not good
            print(f"{'ok  ' if good else 'FAIL'} {name}, {given or 'default'}: code {done.code}, {end:.6g}", flush=True)
    print(f"{bad} wrong" if bad else "none wrong")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
