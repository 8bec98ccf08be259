"""The problems of runs/membranes: each yields answers, one number of one mesh with one membrane.

A membrane is an element type, with a number after a slash for its fraction of constant-strain energy: "corrected/0".
"""

import itertools
import math
import shutil
from dataclasses import asdict, dataclass

import convergence
import random_meshes
from benchmarks import BENCHMARKS, compare
from jittered import annulus_mesh, strip_mesh
from measure import read_log_view
from problems import PATTERNS, PROBLEMS
from problems import element as element_of
from solver import ROOT, load_case, run, variant, write_case

OUT = ROOT / "results" / "membranes"
LEVELS = {"cantilever_moment": 2, "slit_annulus": 2, "hemisphere": 3, "cook_membrane": 2}  # meshes of each, the coarsest
SEEDS = (1, 2, 3)
PLATES = ("buckling_supported", "buckling_panel", "plates", "vibration_supported", "fv12_free", "fv15_rhombic", "fv16_cantilever")
DISTANCE = "distance of the curve"
FABRICS = ("silk_habutai", "wool_plain", "denim_11oz")


@dataclass
class Answer:
    row: str       # problem and mesh
    quantity: str
    membrane: str
    value: float   # error in %, unless the quantity says otherwise

    def stored(self):
        return asdict(self)


def element(membrane):
    return element_of(membrane)


def solved(case, name):
    """The result of a case in an emptied folder; None if it failed."""
    shutil.rmtree(OUT / name, ignore_errors=True)
    result = run(write_case(case, OUT / f"{name}.toml"), OUT / name)
    return result if result.code == 0 else None


# ------------------------------------------------------------------------------------------------------------ strips

def strip_case(membrane, mesh, thin):
    """`thin`: thickness over that of the problem, at the same bending stiffness."""
    case = variant(load_case(BENCHMARKS["cantilever_shear"].case), {"element": element(membrane)})
    case["mesh"] = {"file": str(mesh)}
    case["material"][0] |= {"thickness": 0.1 * thin, "young": 1.2e6 / thin**3}
    return case


def strip_errors(membrane, nx, ny, thin, seed, jitter=0.25):
    """Errors of -u and w at the tip against the elastica [%]."""
    mesh = strip_mesh(OUT / f"strip_{nx}_{ny}_{seed}_{jitter}.msh", nx, ny, jitter, seed=seed)
    case = variant(strip_case(membrane, mesh, thin), {"steps": {"initial_step": 0.05, "max_step": 0.1}})
    result = solved(case, "strip")
    if result is None:
        return math.nan, math.nan
    table, history = BENCHMARKS["cantilever_shear"].reference, result.history
    return tuple(100 * (sign * history[column][-1] / table[reference][-1] - 1) for column, sign, reference in
                 (("tip_x", -1, "minus_u_tip_elastica"), ("tip_z", 1, "w_tip_elastica")))


def slivers(membranes):
    """Linear deflection of even strips by the smallest angle of their cells, and of the sharpest under the whole load."""
    for ny in (2, 8, 16, 38, 76):
        mesh = strip_mesh(OUT / f"even_{ny}.msh", 20, ny, 0.0)
        angle = math.degrees(math.atan2(1 / ny, 0.5))
        for membrane in membranes:
            result = solved(strip_case(membrane, mesh, 1.0) | {"analysis": "linear"}, "sliver")
            exact = 4 * 10**3 / (3 * 1.2e6 * 0.1**3 / 12)
            yield Answer(f"strip 20 x {ny}, {angle:.1f} degrees", "w, linear", membrane,
                         100 * (result.history["tip_z"][-1] / exact - 1) if result else math.nan)
    for membrane in membranes:
        for quantity, error in zip(("-u", "w"), strip_errors(membrane, 20, 38, 1.0, 1, 0.0)):
            yield Answer("even strip 20 x 38, h/L = 0.01", quantity, membrane, error)


# --------------------------------------------------------------------------------------------- problems of runs/lib

def answers_of(name, membranes, level_list, patterns=tuple(PATTERNS)):
    for membrane in membranes:
        for pattern in patterns:
            for level in level_list:
                for a in convergence.answers_on_mesh(PROBLEMS[name], membrane, pattern, level, 1):
                    yield Answer(f"{name}, {pattern.replace('_', ' ')}, {a.mesh}", a.quantity, membrane, 100 * a.error)


def problem(name):
    def answers(membranes):
        yield from answers_of(name, membranes, range(LEVELS[name]))
    return answers


# Meshes that aims were set for, besides the strips: name and its parameters.
AIMS = (("slit_annulus", {"n_radial": 24, "n_circ": 60}), ("hemisphere", {"n": 24}), ("hypar_10000", {"n": 32}), ("hypar_10000", {"n": 64}),
        ("cantilever_moment", {"nx": 24, "ny": 2}), ("cantilever_moment", {"nx": 48, "ny": 4}))


def uneven_annulus(membranes):
    """The slit annulus of 24 x 60 with vertices moved at random by 25 %, three seeds."""
    benchmark = BENCHMARKS["slit_annulus"]
    for membrane in membranes:
        for seed in SEEDS:
            mesh = annulus_mesh(OUT / f"annulus_{seed}.msh", 24, 60, 0.25, seed)
            result = solved(load_case(benchmark.case) | {"mesh": {"file": str(mesh)}, "element": element(membrane)}, "annulus")
            for c in compare(benchmark, result.history) if result else ():
                yield Answer("slit_annulus, moved by 25 %, 24 x 60", c.curve.label, membrane, 100 * (c.final / c.published - 1))


def uneven_hemisphere(membranes):
    """The hemisphere of 24 with vertices moved at random by 25 %, three seeds."""
    benchmark = BENCHMARKS["hemisphere"]
    cells, place, groups = random_meshes.hemisphere({"n": 24})
    for membrane in membranes:
        for seed in SEEDS:
            mesh = random_meshes.grid_mesh(OUT / f"hemisphere_{seed}.msh", cells, place, groups, seed=seed)
            result = solved(load_case(benchmark.case) | {"mesh": {"file": str(mesh)}, "element": element(membrane)}, "hemisphere_random")
            for c in compare(benchmark, result.history) if result else ():
                yield Answer("hemisphere, moved by 25 %, 24", c.curve.label, membrane, 100 * (c.final / c.published - 1))


def aims(membranes):
    """The last deflection on the meshes that aims were set for, on each pattern."""
    for name, parameters in AIMS:
        mesh = " x ".join(str(v) for v in parameters.values())
        for pattern in ("one_way",) if name == "cantilever_moment" else PATTERNS:
            own = dict(parameters)
            if name == "slit_annulus" and pattern == "union_jack":
                own["n_circ"] = 64  # a multiple of 8
            for membrane in membranes:
                for q in PROBLEMS[name].solve(pattern, membrane, own, OUT / f"aim_{name}", 1):
                    yield Answer(f"{name}, {pattern.replace('_', ' ')}, {mesh}", q.name, membrane, 100 * q.error)
    yield from uneven_annulus(membranes)
    yield from uneven_hemisphere(membranes)


def curves(membranes):
    """The published curves on one-way meshes of half the vertices of the finest mesh of docs/verification.md."""
    for name in BENCHMARKS:
        whole = PROBLEMS[name]
        parameters = {k: max(1, round(v * whole.factors[-1] / math.sqrt(2))) for k, v in whole.parameters}
        mesh = " x ".join(str(v) for v in parameters.values())
        for membrane in membranes:
            folder = OUT / f"curve_{name}_{membrane.replace('/', '-')}"
            found = list(whole.solve("one_way", membrane, parameters, folder, 1))
            distances = [q.curve_error for q in found if q.curve_error == q.curve_error]
            yield Answer(f"{name}, {mesh}", DISTANCE, membrane, 100 * max(distances, default=math.nan))
            yield Answer(f"{name}, {mesh}", "Newton iterations", membrane, found[0].summary["newton_iterations"] if found else math.nan)


def worst_of(names, count):
    """The quantity furthest off of each of these problems on its `count` coarsest meshes."""
    def answers(membranes):
        for name, membrane, pattern, level in itertools.product(names, membranes, PATTERNS, range(count)):
            found = convergence.answers_on_mesh(PROBLEMS[name], membrane, pattern, level, 1)
            mesh = " x ".join(str(v) for v in PROBLEMS[name].mesh(level).values())
            yield Answer(f"{name}, {pattern.replace('_', ' ')}, {mesh}", "worst", membrane, 100 * max((a.error for a in found), key=abs, default=math.nan))
    return answers


def in_plane(membranes):
    """What a strip loses by its thickness, h/b = 0.1 against 1e-3, where it bends in its plane; the thick twisted beam; Cook's panel."""
    for nx, ny in ((40, 4), (80, 8)):
        for membrane in membranes:
            tips = []
            for thickness in (0.1, 1e-3):
                case = variant(load_case(BENCHMARKS["cantilever_shear"].case),
                               {"analysis": "linear", "element": element(membrane), "mesh.parameters.nx": nx, "mesh.parameters.ny": ny,
                                "material.0.thickness": thickness, "load.0.vector": [0, thickness, 0], "probe.0.components": ["y", "z"]})
                result = solved(case, "in_plane")
                tips.append(result.history["tip_y"][-1] if result else math.nan)
            yield Answer(f"strip that bends in its plane, {nx} x {ny}", "tip", membrane, 100 * (tips[0] / tips[1] - 1))
    for name in ("twisted_beam_thick_y", "twisted_beam_thick_z", "cook_membrane"):
        yield from answers_of(name, membranes, (2,))


def cost(membranes):
    """Seconds of the assembly as -log_view counts them, on one rank, per triangle: tangents with bending, and residuals. The least of three
    runs, for a machine that does other things."""
    strip = strip_mesh(OUT / "cost.msh", 40, 32, 0.25)
    for row, case in (("hemisphere, one way, 32", variant(load_case(BENCHMARKS["hemisphere"].case), {"mesh.parameters.n": 32})),
                      ("uneven strip 40 x 32", strip_case("zhou_sze_2012", strip, 1.0))):
        for membrane in membranes:
            file = write_case(case | {"element": element(membrane)}, OUT / "cost.toml")
            results = [run(file, OUT / "cost", options=("-log_view",)) for _ in range(3)]
            for event, name in (("VoileTangent", "tangent"), ("VoileResidual", "residual")):
                counted = [read_log_view(r.text).get(event, (1, math.nan)) for r in results]
                value = min(seconds / count for count, seconds in counted) / results[0].summary["triangles"]
                yield Answer(row, f"{name} [us per triangle]", membrane, 1e6 * value)


SECTIONS = {**{name: problem(name) for name in LEVELS}, "slivers": slivers, "aims": aims, "curves": curves,
            "plates": worst_of(PLATES, 3), "in_plane": in_plane, "cost": cost}
