"""Every problem that runs/convergence refines: its meshes, how it is solved, and what is compared with what."""

import math
import subprocess
from dataclasses import dataclass
from typing import Callable

from benchmarks import BENCHMARKS, compare
from linear import LINEAR, answer
from modes import MODES, computed_modes
from plates import PLATES, plate_case
from solver import load_case, run, variant, write_case

PATTERNS = {"one_way": 0, "union_jack": 1, "unstructured": 2}
TIMEOUT = 1800  # seconds for one run


@dataclass(frozen=True)
class Problem:
    name: str
    title: str
    family: str        # nonlinear, linear, plates, vibration or buckling
    source: str
    parameters: tuple  # of the .geo at level 0; each level multiplies them by the refinement of the level
    factors: tuple     # refinement of each level
    solve: Callable    # (pattern, operator, parameters, folder, ranks) -> one Quantity or more

    def mesh(self, level):
        return {k: v * self.factors[level] for k, v in self.parameters}


@dataclass
class Quantity:
    """One number of one run."""
    name: str
    computed: float
    reference: float
    scale: float       # what an error of 100 % means; the reference itself unless that is zero
    curve_error: float
    summary: dict

    @property
    def error(self):
        return (self.computed - self.reference) / self.scale


def element(operator):
    """Of a type, or "type/fraction of constant-strain energy"."""
    name, *fraction = operator.split("/")
    return {"type": name} | ({"cst_fraction": float(fraction[0])} if fraction else {})


def solved(case, changes, pattern, operator, parameters, folder, ranks):
    """The result of a variant of a case, or None with a word of explanation."""
    case = variant(case, {f"mesh.parameters.{k}": v for k, v in parameters.items()}
                   | {"mesh.parameters.pattern": PATTERNS[pattern], "element": element(operator),
                      "output": {"fields": ["displacement"], "every": 1000}} | changes)
    try:
        result = run(write_case(case, folder.with_name(folder.name + ".toml")), folder, ranks, timeout=TIMEOUT)
    except subprocess.TimeoutExpired:
        print(f"  stopped after {TIMEOUT} s")
        return None
    if result.code != 0:
        said = [line for line in result.text.splitlines() if line.startswith("voile: ")]
        print(f"  ended with code {result.code}: {said[0] if said else ''}")
        return None
    return result


def benchmark_quantities(benchmark):
    def solve(*mesh):
        result = solved(load_case(benchmark.case), {}, *mesh)
        if result is None:
            return
        for c in compare(benchmark, result.history):
            largest = abs(benchmark.points(c.curve)[:, 1]).max()
            scale = c.published if abs(c.published) > 1e-6 * largest else largest
            yield Quantity(c.curve.label, c.final, c.published, scale, c.curve_error, result.summary)
            for number, (computed, published) in enumerate(c.limits, 1):
                yield Quantity(f"limit load {number}", computed, published, abs(published), math.nan, result.summary)
    return solve


def linear_quantities(problem):
    def solve(*mesh):
        result = solved(load_case(problem.case), {}, *mesh)
        if result is not None:
            yield Quantity(problem.column, answer(problem, result), problem.reference, problem.reference, math.nan,
                           result.summary)
    return solve


def mode_quantities(problem):
    def solve(*mesh):
        result = solved(load_case(problem.case), {}, *mesh)
        if result is None:
            return
        for number, (computed, reference) in enumerate(zip(computed_modes(problem, result), problem.reference()), 1):
            yield Quantity(f"mode {number}", float(computed), float(reference), float(reference), math.nan,
                           result.summary)
    return solve


def plate_quantities(pattern, operator, parameters, folder, ranks):
    for plate in PLATES:
        case = plate_case(plate, parameters["n"], PATTERNS[pattern])
        result = solved(case, {}, pattern, operator, parameters, folder / plate.name, ranks)
        if result is not None:
            yield Quantity(plate.label, plate.coefficient(result.history["centre_z"][-1]), plate.exact, plate.exact,
                           math.nan, result.summary)


N8, PANEL8 = (("n", 8),), (("n_axial", 8), ("n_circ", 8))
NONLINEAR_MESHES = {
    "cantilever_shear": ((("nx", 10), ("ny", 1)), (1, 2, 4, 8)),
    "cantilever_moment": ((("nx", 12), ("ny", 1)), (1, 2, 4, 8)),
    "slit_annulus": ((("n_radial", 4), ("n_circ", 40)), (1, 2, 3, 4)),
    "hemisphere": (N8, (1, 2, 4, 6)),
    "pullout_cylinder": ((("n_axial", 4), ("n_circ", 6)), (3, 5, 8)),
    "pinched_cylinder": (PANEL8, (4, 5, 8)),
    **{f"semicylinder_{layup}": ((("n_axial", 10), ("n_circ", 10)), (2, 3, 4))
       for layup in ("isotropic", "0_90_0", "90_0_90")},
    **{name: (PANEL8, (1, 2, 4)) for name in BENCHMARKS if name.startswith("roof")},
}

PROBLEMS = {
    p.name: p
    for p in (
        *(Problem(name, b.title, "nonlinear", b.source, *NONLINEAR_MESHES[name], benchmark_quantities(b))
          for name, b in BENCHMARKS.items()),
        *(Problem(name, p.title, "linear", p.source, p.parameters, p.factors, linear_quantities(p))
          for name, p in LINEAR.items()),
        Problem("plates", "Square plates under uniform pressure, centre deflection", "plates", "closed form and series",
                N8, (1, 2, 4, 8), plate_quantities),
        *(Problem(name, p.title, "vibration" if p.folder == "modal" else "buckling", p.source, p.parameters, p.factors,
                  mode_quantities(p)) for name, p in MODES.items()),
    )
}
