"""The problems of runs/membranes: each yields answers, one number of one mesh with one membrane.

A membrane is its name, with a number after a slash for its share of constant-strain energy: "six_node_corrected/0".
"""

import math
import shutil
from dataclasses import asdict, dataclass

import convergence
import numpy as np
from benchmarks import BENCHMARKS, compare
from cloth import Surface
from jittered import annulus_mesh, strip_mesh
from problems import PATTERNS, PROBLEMS
from solver import ROOT, load_case, run, variant, write_case

OUT = ROOT / "results" / "membranes"
LEVELS = {"cantilever_moment": 2, "slit_annulus": 2, "hemisphere": 3, "scordelis_lo": 3, "hypar_100": 3, "hypar_1000": 3, "hypar_10000": 3,
          "pinched_cylinder_free_100": 3, "pinched_cylinder_free_10000": 3, "twisted_beam_thin_y": 3, "cook_membrane": 2}
STRIPS = (((20, 2), 1.0), ((20, 4), 1.0), ((20, 8), 1.0), ((20, 16), 1.0), ((40, 32), 1.0), ((20, 16), 0.5), ((20, 16), 0.1))
SEEDS = (1, 2, 3)


@dataclass
class Answer:
    row: str       # problem and mesh
    quantity: str
    membrane: str
    value: float   # error in %, unless the quantity says otherwise

    def stored(self):
        return asdict(self)


def element(membrane):
    name, *share = membrane.split("/")
    return {"membrane": name} | ({"cst_share": float(share[0])} if share else {})


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


def strip_answers(membranes, settings, jitter=0.25):
    for (nx, ny), thin in settings:
        for membrane in membranes:
            for seed in SEEDS if jitter else SEEDS[:1]:
                errors = strip_errors(membrane, nx, ny, thin, seed, jitter)
                for quantity, error in zip(("-u", "w"), errors):
                    yield Answer(f"{'uneven' if jitter else 'even'} strip {nx} x {ny}, h/L = {0.01 * thin:g}", quantity, membrane, error)


def strips(membranes):
    """Strips under an end shear with cells of aspect 1 to 8 whose vertices are moved at random by 25 %, three seeds each."""
    yield from strip_answers(membranes, STRIPS)


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
    yield from strip_answers(membranes, [((20, 38), 1.0)], 0.0)


# --------------------------------------------------------------------------------------------- problems of runs/lib

def answers_of(name, membranes, level_list, patterns=tuple(PATTERNS)):
    for membrane in membranes:
        for pattern in patterns:
            for level in level_list:
                for a in convergence.answers_on_mesh(PROBLEMS[name], f"edge_slope/{membrane}", pattern, level, 1):
                    yield Answer(f"{name}, {pattern.replace('_', ' ')}, {a.mesh}", a.quantity, membrane, 100 * a.error)


def problem(name):
    def answers(membranes):
        yield from answers_of(name, membranes, range(LEVELS[name]))
    return answers


def thickness(membranes):
    """The same mesh with thinner and thinner shells: flat at rest, and curved."""
    yield from strip_answers(membranes, [((20, 16), thin) for thin in (1.0, 0.1, 0.01)])
    yield from strip_answers(membranes, [((20, 16), thin) for thin in (1.0, 0.1, 0.01)], 0.0)
    for name in ("hypar_100", "hypar_1000", "hypar_10000"):
        yield from answers_of(name, membranes, [2])
    for name in ("pinched_cylinder_free_100", "pinched_cylinder_free_10000"):
        yield from answers_of(name, membranes, [2])


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


def aims(membranes):
    """The last deflection on the meshes that aims were set for, on each pattern."""
    for name, parameters in AIMS:
        mesh = " x ".join(str(v) for v in parameters.values())
        for pattern in ("one_way",) if name == "cantilever_moment" else PATTERNS:
            own = dict(parameters)
            if name == "slit_annulus" and pattern == "union_jack":
                own["n_circ"] = 64  # a multiple of 8
            for membrane in membranes:
                for q in PROBLEMS[name].solve(pattern, f"edge_slope/{membrane}", own, OUT / f"aim_{name}", 1):
                    yield Answer(f"{name}, {pattern.replace('_', ' ')}, {mesh}", q.name, membrane, 100 * q.error)
    yield from uneven_annulus(membranes)


def curves(membranes):
    """The published curves on one-way meshes of half the vertices of the finest mesh of docs/verification.md."""
    for name in BENCHMARKS:
        whole = PROBLEMS[name]
        parameters = {k: max(1, round(v * whole.factors[-1] / math.sqrt(2))) for k, v in whole.parameters}
        mesh = " x ".join(str(v) for v in parameters.values())
        for membrane in membranes:
            folder = OUT / f"curve_{name}_{membrane.replace('/', '-')}"
            found = list(whole.solve("one_way", f"edge_slope/{membrane}", parameters, folder, 1))
            distances = [q.curve_error for q in found if q.curve_error == q.curve_error]
            yield Answer(f"{name}, {mesh}", "distance of the curve", membrane, 100 * max(distances, default=math.nan))


# ------------------------------------------------------------------------------------------- plate, drum and cloth

def plate_centre(load):
    """Centre deflection / h of a clamped circular plate, R = 1, D = 1, h = 1e-3, nu = 0.3, by von Karman's equations:
    w'' slope p = dw/dr, N radial force:  (p' r)' - p/r = r N p + q r^2/2,  (r^3 N')' = -(E h / 2) r p^2;  the edge is held."""
    young, h, nu, n = 10.92e9, 1e-3, 0.3, 400
    r = np.linspace(0.0, 1.0, n + 1)
    step = r[1]
    slope, force = np.zeros(n + 1), np.zeros(n + 1)
    for factor in np.linspace(0.05, 1.0, 20):
        for _ in range(30):
            residual, matrix = np.zeros(2 * n + 2), np.zeros((2 * n + 2, 2 * n + 2))
            for i in range(1, n):
                x, low, high = r[i], r[i] - step / 2, r[i] + step / 2
                residual[i] = ((slope[i + 1] - slope[i]) * high - (slope[i] - slope[i - 1]) * low) / step**2 - slope[i] / x \
                    - x * force[i] * slope[i] - factor * load * x**2 / 2
                matrix[i, i - 1 : i + 2] = low / step**2, -2 * x / step**2 - 1 / x - x * force[i], high / step**2
                matrix[i, n + 1 + i] = -x * slope[i]
                k = n + 1 + i
                residual[k] = ((force[i + 1] - force[i]) * high**3 - (force[i] - force[i - 1]) * low**3) / step**2 \
                    + young * h / 2 * x * slope[i] ** 2
                matrix[k, k - 1 : k + 2] = low**3 / step**2, -(low**3 + high**3) / step**2, high**3 / step**2
                matrix[k, i] = young * h * x * slope[i]
            residual[0], matrix[0, 0] = slope[0], 1
            residual[n], matrix[n, n] = slope[n], 1
            residual[n + 1] = -3 * force[0] + 4 * force[1] - force[2]
            matrix[n + 1, n + 1 : n + 4] = -3, 4, -1
            residual[-1] = (3 * force[n] - 4 * force[n - 1] + force[n - 2]) / (2 * step) + (1 - nu) * force[n]
            matrix[-1, -3:] = 0.5 / step, -2 / step, 1.5 / step + 1 - nu
            change = np.linalg.solve(matrix, -residual)
            slope, force = slope + change[: n + 1], force + change[n + 1 :]
            if np.abs(change[: n + 1]).max() < 1e-12:
                break
    return abs(np.sum((slope[1:] + slope[:-1]) / 2) * step) / h


def plate(membranes):
    """A clamped circular plate that a pressure bends by some times its thickness, against von Karman's equations."""
    load = 10.92
    exact = plate_centre(load)
    for pattern in PATTERNS:
        for n in (8, 16, 32):
            for membrane in membranes:
                case = variant(load_case(ROOT / "runs" / "linear" / "circular_plate_clamped.toml"),
                               {"mesh.parameters.n": n, "mesh.parameters.pattern": PATTERNS[pattern], "analysis": "static",
                                "element": element(membrane), "load.0.magnitude": load,
                                "material.0.thickness": 1e-3, "material.0.young": 10.92e9})
                result = solved(case, "plate")
                yield Answer(f"clamped disc bent by {exact:.1f} h, {pattern.replace('_', ' ')}, {n}", "centre", membrane,
                             100 * (abs(result.history["centre_z"][-1]) / (1e-3 * exact) - 1) if result else math.nan)


BESSEL = (2.404826, 3.831706, 3.831706, 5.135622, 5.135622, 5.520078)


def drum(membranes):
    """Frequencies of a stretched disc without bending stiffness to speak of; the worst of six."""
    stiffness, strain, density = 1000.0, 0.01, 0.2
    exact = np.array(BESSEL) * math.sqrt(stiffness * (strain + strain**2 / 2) / density) / (2 * math.pi)
    for pattern in PATTERNS:
        for n in (8, 16, 32):
            for membrane in membranes:
                case = {"analysis": "modal", "element": element(membrane), "eigen": {"modes": 6, "load_factor": 1.0},
                        "mesh": {"file": str(ROOT / "meshes" / "disc.geo"),
                                 "parameters": {"radius": 1, "inner_radius": 0.4, "n": n, "pattern": PATTERNS[pattern]}},
                        "material": [{"type": "matrices", "membrane": np.diag([stiffness, stiffness, stiffness / 2]).tolist(),
                                      "bending": np.diag([1e-6, 1e-6, 5e-7]).tolist(), "areal_density": density}],
                        "support": [{"type": "displacement", "group": "edge", "components": ["x", "y", "z"],
                                     "cylinder_axis": [0, 0, 1], "value": [strain, 0, 0]}]}
                result = solved(case, "drum")
                error = math.nan
                if result:
                    found = np.loadtxt(OUT / "drum" / "modes.csv", delimiter=",", skiprows=1, ndmin=2)[:6, 1]
                    error = 100 * max(found / exact - 1, key=abs)
                yield Answer(f"drum, {pattern.replace('_', ' ')}, {n}", "worst of six modes", membrane, error)


FABRICS = ("silk_habutai", "wool_plain", "denim_11oz")


def cloth(membranes):
    """A square of 0.3 m over a disc of 0.12 m: how sharp its folds are, and what finding them takes."""
    for fabric in FABRICS:
        for n in (12, 20):
            for membrane in membranes:
                case = {"analysis": "drape", "element": element(membrane),
                        "mesh": {"file": str(ROOT / "meshes" / "cloth.geo"), "parameters": {"side": 0.3, "radius": 0.06, "n": n}},
                        "material": [{"type": "fabric", "fabric": str(ROOT / "runs" / "fabrics" / f"{fabric}.toml"),
                                      "direction": [1, 0, 0], "warp_angle": 0}],
                        "support": [{"type": "hinged", "group": "disc"}],
                        "load": [{"type": "gravity", "vector": [0, 0, -9.81]}],
                        "probe": [{"name": "stored", "type": "energy"}]}
                result = solved(case, "cloth")
                row = f"{fabric}, {n} edges"
                if result is None:
                    yield Answer(row, "largest dihedral [degrees]", membrane, math.nan)
                    continue
                surface = Surface(result)
                yield Answer(row, "largest dihedral [degrees]", membrane, float(surface.inner_edges()[1].max()))
                yield Answer(row, "mean drop [mm]", membrane, -1e3 * float(surface.fields["displacement"][:, 2].mean()))
                yield Answer(row, "Newton iterations", membrane, result.summary["newton_iterations"])


SECTIONS = {"strips": strips, **{name: problem(name) for name in LEVELS}, "thickness": thickness, "slivers": slivers,
            "plate": plate, "drum": drum, "cloth": cloth, "aims": aims, "curves": curves}
