"""Temperature, initial strain, prestress and imperfections against closed forms; ranks, restart, stages, remeshing, mistakes."""

import math
import re

import numpy as np
from common import fresh, plate, strip
from harness import OUT, solve, test
from panels import Panels
from solver import ROOT, Result, invoke, load_case, run, variant, write_case

YOUNG, POISSON, THICKNESS, EXPANSION = 210e9, 0.3, 0.01, 12e-6
SIDES = ("left", "right", "bottom", "top")
STEEL = {"type": "isotropic", "young": YOUNG, "poisson": POISSON, "thickness": THICKNESS, "expansion": EXPANSION}


def held_plate(cells, kind, **more):
    """A square plate of 1 m whose sides are held, without a load."""
    case = plate(cells, 0.0) | {"material": [STEEL], "support": [{"type": kind, "group": side} for side in SIDES]} | more
    case.pop("load")
    return case


def largest(a, b):
    return float(np.abs(a - b).max() / np.abs(b).max())


@test
def heated_rim(report):
    """Heat through the thickness bends the rim of a cylinder as a moment there does: cells are judged alike, though the heat stores much more energy."""
    case = {"analysis": "linear", "mesh": {"file": str(ROOT / "meshes" / "cylinder.geo"), "parameters": {"radius": 1, "length": 2, "n_axial": 12, "n_circ": 20}},
            "material": [STEEL | {"thickness": 0.02}],
            "support": [{"type": "clamped", "group": "middle"}, {"type": "symmetry", "group": "crown", "normal": [1, 0, 0]}, {"type": "symmetry", "group": "flank", "normal": [0, 0, 1]}]}
    bending = STEEL["young"] * 0.02**3 / (12 * (1 - STEEL["poisson"] ** 2))
    moment = bending * (1 + STEEL["poisson"]) * STEEL["expansion"] * 50 / 0.02
    bent = solve("heated_rim_moment", case | {"load": [{"type": "follower_moment", "group": "end", "magnitude": moment}]})
    heated = solve("heated_rim", case | {"temperature": [{"difference": "50"}]})
    report.percent(np.abs(heated.displacement()).max() / np.abs(bent.displacement()).max(), 0.01, "both deflect alike")
    more = solve("heated_rim_more", case | {"temperature": [{"difference": "50e3"}]})
    report.below(largest(more.displacement() / 1e3, heated.displacement()), 1e-9, "a thousand times the heat moves it a thousand times as far")
    for key in ("recovery_error", "membrane_error"):
        known, found = (r.summary[key]["largest"] if isinstance(r.summary[key], dict) else r.summary[key] for r in (bent, heated))
        report.percent(found / known, 0.05, f"{key}: {found:.3g}, with a moment {known:.3g}")


@test
def cooled_plate(report):
    """A clamped plate that is cooled pulls with E h / (1 - nu) times its strain; linear and nonlinear."""
    change = -100.0
    case = held_plate(8, "clamped", temperature=[{"change": str(change)}],
                      probe=[{"name": "pull", "type": "reaction", "group": "right"}])
    strain = EXPANSION * change
    for analysis, exact in (("linear", strain), ("static", strain + strain**2 / 2)):
        pull = solve(f"cooled_{analysis}", case | {"analysis": analysis}).history["pull_x"][-1]
        report.percent(pull / (-YOUNG * THICKNESS / (1 - POISSON) * exact), 1e-9, f"{analysis}: pull of a side, {pull:.6g} N")
    again = solve("cooled_again", load_case(OUT / "cooled_static" / "resolved_case.toml")).history["pull_x"][-1]
    report.below(again / pull - 1, 1e-12, "the resolved case gives the same")
    # Linear analysis has no square of a strain: ten times the change is ten times the way.
    moved = []
    for change in (800.0, 8000.0):
        free = strip("linear") | {"material": [STEEL], "temperature": [{"change": str(change)}], "support": [
            {"type": "displacement", "group": group, "components": [axis]} for group, axis in (("clamp", "x"), ("side_low", "y"), ("plate", "z"))]}
        free.pop("load")
        moved.append(solve("expanded", free).history["tip_x"][-1])
    report.percent(moved[0] / (10 * EXPANSION * 800.0), 1e-9, "free expansion of 0.96 %")
    report.percent(moved[1] / (10 * moved[0]), 1e-12, "ten times that")
    staged = solve("expanded_stage", {k: v for k, v in free.items() if k != "analysis"} | {"stage": [{"name": "heat", "analysis": "linear"}]})
    report.percent(Result(staged.folder / "heat", 0, "", 0).history["tip_x"][-1] / moved[1], 1e-12, "the same in a stage")
    shrunk = free | {"material": [STEEL | {"initial_strain": [-0.02, -0.02], "direction": [1, 0, 0]}]}
    done = run(write_case({k: v for k, v in shrunk.items() if k != "temperature"}, OUT / "shrunk_linear.toml"), OUT / "shrunk_linear")
    report.check(done.code == 2 and "would move the sheet" in done.text, f"an initial strain that moves the sheet: code {done.code}")


@test
def bimetal_strip(report):
    """A strip, hotter on top, rolls up to an arc of radius h / (alpha d) (Timoshenko, J. Opt. Soc. Am. 11 (1925) 233, one material)."""
    length, thickness, expansion, difference = 10.0, 0.1, 1e-4, 200.0
    material = [{"type": "orthotropic", "young_1": 1.2e6, "young_2": 1.2e6, "poisson_12": 0.0, "shear_12": 0.6e6,
                 "thickness": thickness, "density": 100.0, "direction": [1, 0, 0], "expansion_1": expansion, "expansion_2": 0.0}]

    def distance(row, fraction):
        radius = thickness / (expansion * fraction * difference)
        return math.hypot(row[0] - radius * math.sin(length / radius) + length, row[1] + radius * (1 - math.cos(length / radius))) / length

    for pattern in (0, 1, 2):
        case = strip(nx=40, ny=4) | {"material": material, "temperature": [{"difference": str(difference)}]}
        case.pop("load")
        case["mesh"]["parameters"]["pattern"] = pattern
        h = solve(f"bimetal_{pattern}", case).history
        errors = [distance(row, factor) for *row, factor in zip(h["tip_x"], h["tip_z"], h["load_factor"]) if factor > 0]
        report.below(max(errors), 0.002, f"pattern {pattern}: tip ({h['tip_x'][-1]:.5g}, {h['tip_z'][-1]:.5g}) m, distance / length in {len(errors)} steps")
    case["temperature"][0]["constant"] = True
    case["steps"] = {"final_load_factor": 0.5}
    h = solve("bimetal_constant", case).history
    report.below(distance((h["tip_x"][-1], h["tip_z"][-1]), 1.0), 0.002, "constant, at half the load: distance / length")


def two_layers(**more):
    """Materials 1 below and 2 above, without contraction: [0, 90] of one ply."""
    return {"type": "laminate", "young_1": 2e6, "young_2": 5e5, "poisson_12": 0.0, "shear_12": 4e5, "angles": [0, 90],
            "ply_thicknesses": [0.04, 0.06], "direction": [1, 0, 0], "density": 100.0} | more


def stiffnesses(m):
    """A, B and D along x of two layers."""
    low, high = m["ply_thicknesses"]
    z = (-(low + high) / 2, low - (low + high) / 2, (low + high) / 2)
    return [sum(e * (z[k + 1] ** n - z[k] ** n) / n for k, e in enumerate((m["young_1"], m["young_2"]))) for n in (1, 2, 3)]


@test
def unsymmetric_laminate(report):
    """A cantilever of two layers bends with D - B^2/A (Jones, Mechanics of Composite Materials, 1999, 4.4) and stretches by B/A of its
    curvature; the same plate with its reference surface at its lower face gives the same deflection."""
    material, length, force = two_layers(), 10.0, 1e-3
    a, b, d = stiffnesses(material)
    rigidity = d - b * b / a
    case = strip(nx=40, ny=4, analysis="linear") | {"material": [material], "load": [{"type": "line", "group": "tip", "vector": [0, 0, force]}]}
    for pattern in (0, 1, 2):
        case["mesh"]["parameters"]["pattern"] = pattern
        h = solve(f"two_layers_{pattern}", case).history
        deflection = h["tip_z"][-1]
        report.percent(h["tip_z"][-1] / (force * length**3 / (3 * rigidity)), 0.005, f"pattern {pattern}: deflection {h['tip_z'][-1]:.5g} m")
        report.percent(h["tip_x"][-1] / (b / a * force * length**2 / (2 * rigidity)), 0.005, f"pattern {pattern}: displacement along x")
    # Matrices about the lower face, z' = z + h/2.
    def diagonal(value):
        return [[value, 0, 0], [0, value, 0], [0, 0, value / 2]]
    one, h = 1.2e6 * 0.02, 0.02
    case = strip(nx=40, ny=4) | {"load": [{"type": "line", "group": "tip", "vector": [0, 0, 0.008]}],
                                 "material": [{"type": "matrices", "membrane": diagonal(one), "bending": diagonal(one * h**2 / 12)}]}
    offset = case | {"material": [{"type": "matrices", "membrane": diagonal(one), "coupling": diagonal(one * h / 2),
                                   "bending": diagonal(one * (h**2 / 12 + h**2 / 4))}]}
    middle = solve("middle_surface", case).history["tip_z"][-1]
    report.percent(solve("lower_surface", offset).history["tip_z"][-1] / middle, 0.005, f"reference surface at the lower face: {middle:.5g} m")
    ends = [solve(f"two_layers_ranks_{ranks}", offset, ranks).displacement() for ranks in (1, 2, 3)]
    report.below(max(largest(ends[k], ends[0]) for k in (1, 2)), 1e-7, "2 and 3 ranks and 1")
    resolved = solve("two_layers_resolved", load_case(OUT / "two_layers_2" / "resolved_case.toml")).history["tip_z"][-1]
    report.below(resolved / deflection - 1, 1e-10, "the resolved case gives the same")


def timoshenko(material, change):
    """Curvature and strain of the middle of two free layers (J. Opt. Soc. Am. 11 (1925) 233, eq. 4)."""
    low, high = material["ply_thicknesses"]
    m, n, alpha = low / high, material["young_1"] / material["young_2"], (material["expansion_1"], material["expansion_2"])
    curvature = 6 * (alpha[0] - alpha[1]) * change * (1 + m) ** 2 / (
        (low + high) * (3 * (1 + m) ** 2 + (1 + m * n) * (m * m + 1 / (m * n))))
    a, b, _ = stiffnesses(material)
    return curvature, (b * curvature + change * (material["young_1"] * alpha[0] * low + material["young_2"] * alpha[1] * high)) / a


@test
def bimetal(report):
    """Two metals in a strip that is heated: Timoshenko's curvature, small and large, and the strain of its middle."""
    expansions = {"expansion_1": 2e-4, "expansion_2": 5e-5}
    thick, thin = two_layers(**expansions), two_layers(ply_thicknesses=[0.002, 0.003], **expansions)
    case = strip(nx=40, ny=4) | {"material": [thick], "temperature": [{"change": "20"}]}
    case.pop("load")
    small = solve("bimetal_small", case | {"analysis": "linear", "output": {"stresses": "plies"}})
    h, (curvature, strain) = small.history, timoshenko(thick, 20.0)
    report.percent(h["tip_z"][-1] / (curvature * 100 / 2), 0.003, f"deflection of the tip, linear: {h['tip_z'][-1]:.5g} m")
    report.percent(h["tip_x"][-1] / (10 * strain), 0.003, f"displacement along x, linear: {h['tip_x'][-1]:.5g} m")
    step = small.results[-1]
    middle = np.argmin(np.abs(step.mesh.positions[step.mesh.triangles].mean(axis=1) - (5, 0.5, 0)).sum(axis=1))
    for ply, (young, alpha, low, high) in enumerate(((2e6, 2e-4, -0.05, -0.01), (5e5, 5e-5, -0.01, 0.05)), 1):
        for face, z in (("bottom", low), ("top", high)):
            stress = step[f"stress_ply_{ply}_{face}"][middle][0]
            report.percent(stress / (young * (strain - z * curvature - alpha * 20)), 0.01, f"stress of ply {ply} at its {face}: {stress:.5g} Pa")
    large = case | {"material": [thin], "temperature": [{"change": "5"}],
                    "mesh": case["mesh"] | {"parameters": {"nx": 160, "ny": 2, "width": 0.05}}}
    h, (curvature, strain) = solve("bimetal_large", large).history, timoshenko(thin, 5.0)
    error = math.hypot(h["tip_x"][-1] + 10 - math.sin(10 * curvature) / curvature,
                       h["tip_z"][-1] - (1 - math.cos(10 * curvature)) / curvature) / 10
    report.below(error, 0.005, f"rolled by {10 * curvature:.3g} rad: tip ({h['tip_x'][-1]:.4g}, {h['tip_z'][-1]:.4g}) m, distance / length")


def cylinder_curvature(ply, change):
    """Of a large cooled [0/90] plate, by lamination theory with the other curvature held at 0 (Hyer, J. Compos. Mater. 15 (1981) 175)."""
    e1, e2, nu, t = ply["young_1"], ply["young_2"], ply["poisson_12"], ply["ply_thicknesses"][0]
    c = 1 / (1 - nu * nu * e2 / e1)
    layers = []
    for turned in (False, True):
        q = np.array([[e1, nu * e2], [nu * e2, e2]]) * c
        alpha = np.array([ply["expansion_1"], ply["expansion_2"]])
        layers.append((q[::-1, ::-1], alpha[::-1]) if turned else (q, alpha))
    matrix, right = np.zeros((3, 3)), np.zeros(3)  # of e_x, e_y, k_x
    for (q, alpha), z0, z1 in zip(layers, (-t, 0.0), (0.0, t)):
        shape = lambda z: np.array([[1, 0, -z], [0, 1, 0]])  # noqa: E731
        for g, w in ((-math.sqrt(0.6), 5 / 18), (0.0, 4 / 9), (math.sqrt(0.6), 5 / 18)):
            s = shape((z0 + z1) / 2 + g * (z1 - z0) / 2)
            matrix += w * (z1 - z0) * s.T @ q @ s
            right += w * (z1 - z0) * change * s.T @ q @ alpha
    return np.linalg.solve(matrix, right)[2]


@test
def cooled_unsymmetric_plate(report):
    """A [0/90] square of 15 cm that is cooled becomes a cylinder, not the saddle of the linear theory."""
    ply = {"type": "laminate", "young_1": 181e9, "young_2": 10.3e9, "poisson_12": 0.28, "shear_12": 7.17e9, "angles": [0, 90],
           "ply_thicknesses": [0.25e-3, 0.25e-3], "direction": [1, 0, 0], "expansion_1": 0.02e-6, "expansion_2": 22.5e-6}
    case = plate(20, 0.0) | {
        "material": [ply], "temperature": [{"change": "-150"}], "support": [{"type": "hinged", "group": "centre"}],
        "spring": [{"type": "area", "stiffness": 300.0}], "analysis": "drape",
        "imperfection": [{"type": "expression", "height": "-1e-4*((x - 0.075)/0.075)^2"}]}
    case["mesh"]["parameters"]["side"] = 0.15
    case.pop("load")
    result = solve("hyer", case)
    x, u = result.results[-1].mesh.positions, result.displacement()
    inner = (np.abs(x[:, 0] - 0.075) < 0.05) & (np.abs(x[:, 1] - 0.075) < 0.05)
    p = (x + u)[inner] - 0.075
    terms = np.stack([np.ones(len(p)), p[:, 0], p[:, 1], p[:, 0]**2 / 2, p[:, 1]**2 / 2, p[:, 0] * p[:, 1]], axis=1)
    fit = np.linalg.lstsq(terms, (x + u)[inner, 2], rcond=None)[0]
    exact = cylinder_curvature(ply, -150)
    curved = 3 if abs(fit[3]) > abs(fit[4]) else 4
    report.percent(abs(fit[curved] / exact), 0.03, f"curvature {fit[curved]:.4g} 1/m, of the long cylinder {exact:.4g} 1/m")
    report.below(fit[7 - curved] / exact, 0.05, "curvature across it")


@test
def heated_plate_buckles(report):
    """Simply supported and held in its plane a plate buckles at alpha dT = pi^2 h^2 / (6 (1 + nu) a^2) (Boley & Weiner, 1960)."""
    exact = math.pi**2 * THICKNESS**2 / (6 * (1 + POISSON) * EXPANSION)
    case = held_plate(16, "hinged", analysis="buckling", temperature=[{"change": "1"}], eigen={"modes": 1})
    found = modes_of(solve("heated_buckling", case))[0]
    report.percent(found / exact, 0.035, f"critical change {found:.5g} K")
    # Modes about the heated plate: the frequency falls to 0 as sqrt(1 - T / T_cr).
    cold = held_plate(16, "hinged", analysis="modal", material=[STEEL | {"density": 7800.0}], eigen={"modes": 1})
    heated = cold | {"temperature": [{"change": f"{0.75 * found:.12g}", "constant": True}]}
    ratio = modes_of(solve("heated_modes", heated))[0] / modes_of(solve("cold_modes", cold))[0]
    report.percent(ratio / 0.5, 0.003, f"frequency at three quarters of it: {ratio:.4f} of the cold plate's")


def modes_of(result):
    table = np.genfromtxt(result.folder / "modes.csv", delimiter=",", names=True, ndmin=1)
    return table[table.dtype.names[1]]


@test
def tensioned_membrane(report):
    """Frequencies of a square drum under prestress, f_mn = 1/2 sqrt(N/m) sqrt(m^2 + n^2) / a, and of one pulled more along x."""
    force, density = 1000.0, 0.1
    for name, forces in (("drum", (force, force)), ("drum_x", (2 * force, force))):
        exact = sorted(0.5 * math.sqrt((forces[0] * m * m + forces[1] * n * n) / density) for m in range(1, 5) for n in range(1, 5))[:6]
        case = held_plate(24, "hinged", analysis="modal", eigen={"modes": 6, "mass": "lumped"}, material=[
            {"type": "isotropic", "young": 1e9, "poisson": 0.3, "thickness": 1e-4, "density": density / 1e-4,
             "direction": [1, 0, 0], "prestress": list(forces)}])
        found = modes_of(solve(name, case))
        for k, f in enumerate(exact):
            report.percent(found[k] / f, 0.01, f"{name}: mode {k + 1}, {found[k]:.5g} Hz")


@test
def heated_ranks_and_restart(report):
    """A heated cap on 1, 2 and 3 ranks, and a motion that is heated in time, unbroken and restarted."""
    cap = strip(nx=20, ny=4) | {"material": [{"type": "isotropic", "young": 1.2e6, "poisson": 0.3, "thickness": 0.1, "density": 100.0,
                                              "expansion": 1e-4}],
                                "temperature": [{"change": "50*x"}, {"difference": "20 + 100*t"}]}
    cap.pop("load")
    ends = [solve(f"heated_{ranks}", cap, ranks).displacement() for ranks in (1, 2, 3)]
    for k in (1, 2):
        report.below(largest(ends[k], ends[0]), 1e-7, f"{k + 1} ranks and 1")
    motion = cap | {"analysis": "dynamic", "temperature": [{"difference": "2000*t"}, {"change": "100*sin(20*t)"}],
                    "time": {"end": 0.2, "step": 0.01, "checkpoint_steps": 10}, "damping": {"membrane": 1e-3}}
    whole = solve("heated_whole", motion)
    half = solve("heated_half", variant(motion, {"time.end": 0.1}))
    again = solve("heated_again", motion, 2, ("--restart", half.folder / "checkpoint.h5"))
    report.below(largest(again.displacement(), whole.displacement()), 1e-7, "restarted on 2 ranks and unbroken")
    energy = whole.summary["energy"]
    report.below(energy["energy_unaccounted"] / energy["work_of_supports"], 1e-10, "energy unaccounted for, of what heating brings in")


@test
def heated_stages(report):
    """What a stage has heated stays hot in the next: its modes are those of one case at that temperature."""
    hot = held_plate(8, "clamped", material=[STEEL | {"density": 7800.0}], temperature=[{"change": "15"}])  # stable
    for key in ("analysis", "steps", "output"):
        hot.pop(key, None)
    both = solve("heated_stages", hot | {"stage": [{"name": "heat", "analysis": "static"},
                                                   {"name": "ring", "analysis": "modal", "eigen": {"modes": 2}}]})
    staged = modes_of(Result(both.folder / "ring", both.code, both.text, 0.0))
    single = modes_of(solve("heated_single", hot | {"analysis": "modal", "eigen": {"modes": 2, "load_factor": 1.0}}))
    report.below(largest(staged, single), 1e-8, "frequencies by stages and at load factor 1")


@test
def heated_remeshing(report):
    """A plate that buckles by heat, remeshed on its way, ends with the same deflection."""
    heat = held_plate(12, "hinged", temperature=[{"change": "25"}], steps={"initial_step": 0.05, "max_step": 0.1},
                      imperfection=[{"type": "expression", "height": "1e-3*sin(pi*x)*sin(pi*y)"}])
    plain = solve("heated_plain", heat).history["centre_z"][-1]
    result = solve("heated_remeshed", heat | {"remesh": {"angle": 0.2, "largest": 0.1}})
    report.check(result.summary["remeshing"]["count"] > 0, f"the plate was remeshed {result.summary['remeshing']['count']} times")
    report.percent(result.history["centre_z"][-1] / plain, 0.03, f"deflection {plain:.5g} m")


@test
def shrinking_fabric(report):
    """A fabric that shrinks by 2 % along the warp and 3 % along the weft, cut along and across the warp."""
    for name, angle, share in (("warp", 0.0, -0.02), ("weft", 90.0, -0.03)):
        case = strip(nx=20, ny=4) | {"material": [{"type": "fabric", "fabric": "wool_tropical", "direction": [1, 0, 0],
                                                   "warp_angle": angle, "initial_strain": [-0.02, -0.03]}]}
        case["support"] = case["support"] + [{"type": "displacement", "group": "plate", "components": ["z"]}]
        case.pop("load")
        report.percent(solve(f"shrunk_{name}", case).history["tip_x"][-1] / (10 * share), 0.01, f"along the {name}: change of length")


@test
def imperfect_column(report):
    """The deflection of a strip with its first mode as imperfection grows by 1 / (1 - P / P_cr) (Southwell, 1932)."""
    column = strip(nx=40, ny=2) | {
        "support": [{"type": "hinged", "group": "clamp"},
                    {"type": "displacement", "group": "tip", "components": ["y", "z"]}],
        "load": [{"type": "line", "group": "tip", "vector": [-1, 0, 0]}],
        "probe": [{"name": "middle", "type": "displacement", "point": [5, 0.5, 0], "components": ["z"]}]}
    modes = solve("column_buckling", column | {"analysis": "buckling", "eigen": {"modes": 2}})
    critical = modes_of(modes)[0]
    report.percent(critical / (math.pi**2 * 1.2e6 * 0.1**3 / 12 / 100), 0.01, f"critical force {critical:.5g} N/m")
    amplitude = 1e-3
    path = column | {"steps": {"final_load_factor": 0.8 * critical, "stops": [0.4 * critical, 0.6 * critical],
                               "initial_step": 0.2 * critical, "max_step": 0.2 * critical}}
    imperfect = [{"type": "modes", "results": str(modes.folder), "modes": [1], "amplitudes": [amplitude]}]
    ends = {}
    for name, ranks, imperfection in (
            ("modes", 1, imperfect), ("modes_2", 2, imperfect),
            ("expression", 1, [{"type": "expression", "height": f"{amplitude}*sin(pi*x/10)"}])):
        h = solve(f"column_{name}", path | {"imperfection": imperfection}, ranks).history
        ends[name] = h["middle_z"][-1]
        for share in (0.4, 0.6, 0.8):
            at = int(np.argmin(np.abs(h["load_factor"] - share * critical)))
            report.percent((amplitude + abs(h["middle_z"][at])) / (amplitude / (1 - share)), 0.01,
                           f"{name}: P = {share} P_cr, deflection / imperfection")
    report.below(ends["modes_2"] / ends["modes"] - 1, 1e-7, "2 ranks and 1")


@test
def random_imperfection(report):
    """The same seed gives the same field on 1 and 3 ranks; another one another."""
    shapes = {}
    for name, ranks, seed in (("a", 1, 3), ("b", 3, 3), ("c", 1, 4)):
        case = strip(nx=20, ny=2) | {"imperfection": [{"type": "random", "amplitude": 0.01, "length": 2.0, "seed": seed}]}
        shapes[name] = solve(f"random_{name}", case, ranks).results[-1].mesh.positions
    report.below(np.abs(shapes["a"] - shapes["b"]).max(), 1e-14, "3 ranks and 1 [m]")
    report.check(np.abs(shapes["a"] - shapes["c"]).max() > 1e-3, "another seed")
    report.near(np.abs(shapes["a"][:, 2]).max(), 0.01, 1e-12, "largest height [m]")


@test
def linear_without_stress(report):
    """A linear solution without stress is right and resolved: a plate that is moved or heated, and a laminate that is cooled to a saddle."""
    flat = held_plate(8, "hinged", analysis="linear")
    held = lambda group, axes: {"type": "displacement", "group": group, "components": axes}  # noqa: E731
    p = Panels()
    at = p.add("sheet", (0, 0, 0), (0.2, 0, 0), (0, 0.1, 0), 16, 8)
    for name, vertex in (("corner", at[0, 0]), ("along", at[-1, 0]), ("across", at[0, -1])):
        p.point(name, vertex)
    laminate = {"type": "laminate", "young_1": 140e9, "young_2": 10e9, "poisson_12": 0.3, "shear_12": 5e9, "angles": [0, 90],
                "ply_thicknesses": [0.25e-3], "direction": [1, 0, 0], "expansion_1": 0.0, "expansion_2": 30e-6}
    cases = {
        "moved": flat | {"support": [s | {"value": [0.1, 0.0, 0.2]} for s in flat["support"]]},
        "heated": flat | {"temperature": [{"change": "80"}], "support": [held("left", ["x", "z"]), held("bottom", ["y", "z"])]},
        "cooled": {"analysis": "linear", "mesh": {"file": str(p.write(OUT / "saddle.msh"))}, "material": [laminate], "temperature": [{"change": "-20"}],
                   "support": [held("corner", ["x", "y", "z"]), held("along", ["y", "z"]), held("across", ["z"])],
                   "probe": [{"name": "centre", "type": "displacement", "point": [0.1, 0.05, 0]}]}}
    for name, case in cases.items():
        done = solve(f"stressless_{name}", case)
        report.check("warning" not in done.text and re.search("the energy is off by (0 %|less than 0.01 %)", done.text), f"{name}: {done.text.strip()[-150:]}")
    # Curvature by classical laminate theory: 0.05115538 per kelvin along x, less that along y.
    exact = -20 * 0.05115538 / 2 * (0.1**2 - 0.05**2)
    report.percent(done.history["centre_z"][-1] / exact, 1e-6, "the saddle at its centre")


@test
def linear_under_stress(report):
    """Stresses that the sheet would give way to are no start of a linear analysis; those that supports hold are."""
    held = lambda group, axes: {"type": "displacement", "group": group, "components": axes}  # noqa: E731
    for material, temperature in (({"initial_strain": [4e-4, 4e-4]}, []), ({"prestress": [3.0, 0.0], "direction": [1, 0, 0]}, []), ({}, [{"change": "-40", "constant": True}])):
        case = strip("linear", nx=8, load=[{"type": "line", "group": "tip", "vector": [0, 0, 1e-3]}], temperature=temperature)
        case["material"][0] |= {"expansion": 1e-5} | material
        done = run(write_case(case, OUT / "linear_stressed.toml"), OUT / "linear_stressed")
        report.check(done.code == 2 and "would move the sheet" in done.text, f"{material or temperature}: code {done.code}: {done.text.strip()[-200:]}")
        whole = case | {"analysis": "static"}
        soft = solve("linear_stressed_static", whole).history["tip_z"][-1]
        report.percent(soft / solve("linear_stressless", strip("linear", nx=8, load=case["load"])).history["tip_z"][-1], 0.01, "static finds the sheet without stress")
    taut = strip("linear", nx=8, load=[{"type": "pressure", "magnitude": 1e-3}])
    taut["material"][0] |= {"prestress": [1e4, 0.0], "direction": [1, 0, 0]}
    taut["support"].append(held("tip", ["x", "y", "z"]))
    report.check(solve("linear_taut", taut).code == 0, "prestress between supports")


@test
def hydrostatic_pressure(report):
    """A wall clamped at its foot under water: reaction rho g b^2 / 2 per width, moment by the deflection rho g b^5 / (30 D)."""
    length, weight = 10.0, 1e-4
    case = strip(nx=40, ny=2, analysis="linear") | {
        "load": [{"type": "pressure", "magnitude": weight, "distribution": "10 - x"}],
        "probe": [{"name": "tip", "type": "displacement", "group": "tip"}, {"name": "foot", "type": "reaction", "group": "clamp"}]}
    h = solve("hydrostatic", case).history
    report.percent(-h["foot_z"][-1] / (weight * length**2 / 2), 1e-9, "reaction of the foot")
    report.percent(h["tip_z"][-1] / (weight * length**5 / (30 * 1.2e6 * 0.1**3 / 12)), 0.005, "deflection of the top")


MISTAKES = (
    ("no expansion", {"temperature": [{"change": "10"}]}, "has an expansion"),
    ("no value", {"material": [STEEL], "temperature": [{"group": "plate"}]}, "difference"),
    ("expression", {"material": [STEEL], "temperature": [{"change": "10*q"}]}, "temperature.change: '10*q'"),
    ("not finite", {"material": [STEEL], "temperature": [{"change": "1/(x - x)"}]}, "not a finite number"),
    ("constant in time", {"material": [STEEL], "temperature": [{"change": "10*t", "constant": True}]}, "temperature.constant"),
    ("group", {"material": [STEEL], "temperature": [{"change": "10", "group": "plat"}]}, "plat"),
    ("below nothing", {"material": [STEEL | {"expansion": -0.1}], "temperature": [{"change": "20"}]}, "leaves a length"),
    ("no direction", {"material": [STEEL | {"prestress": [1, 2]}]}, "material.prestress"),
    ("strain in per cent", {"material": [STEEL | {"initial_strain": [-2, -2]}]}, "2 % is 0.02"),
    ("one number", {"material": [STEEL | {"initial_strain": [-0.02]}]}, "give two"),
    ("coupling of angles", {"element": {"type": "angles"}, "material": [two_layers()]}, "element.type"),
    ("coupling too large", {"material": [{"type": "matrices", "membrane": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
                                          "bending": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
                                          "coupling": [[2, 0, 0], [0, 2, 0], [0, 0, 2]], "direction": [1, 0, 0]}]}, "material.coupling"),
    ("one expansion", {"material": [two_layers(expansion_1=1e-5)]}, "material.expansion_2"),
    ("no run", {"imperfection": [{"type": "modes", "results": "nowhere", "modes": [1], "amplitudes": [1e-3]}]}, "imperfection"),
    ("mode 0", {"imperfection": [{"type": "modes", "results": "nowhere", "modes": [0], "amplitudes": [1e-3]}]}, "imperfection.modes"),
    ("amplitudes", {"imperfection": [{"type": "modes", "results": "x", "modes": [1, 2, 3], "amplitudes": [1, 2]}]}, "imperfection.amplitudes"),
    ("height", {"imperfection": [{"type": "expression", "height": "sin("}]}, "imperfection.height"),
    ("height beyond numbers", {"imperfection": [{"type": "expression", "height": "log(x - 99)"}]}, "[[imperfection]] height: 'log(x - 99)' is not a finite number"),
    ("group", {"material": [STEEL], "temperature": [{"change": "10", "group": "tip"}]}, '[[temperature]] group = "tip"'),
    ("load", {"load": [{"type": "pressure", "magnitude": 1, "group": "tip"}]}, '[[load]] group = "tip"'),
    ("unit", {"units": {"length": "furlong"}}, "units.length: unknown unit 'furlong'"),
    ("probe", {"load": [{"type": "line", "group": "tip", "vector": [-1, 0, 0]}], "probe": [{"name": "up", "type": "displacement", "group": "tip", "components": ["z"]}],
               "steps": {"control": "displacement", "control_probe": "up", "final_displacement": 0.1}}, "[steps] control_probe: loads and temperatures do not move it"),
    ("distribution", {"load": [{"type": "pressure", "magnitude": 1, "distribution": "t"}]}, "load.distribution"),
)


@test
def initial_mistakes(report):
    """Mistakes in temperatures, prestress and imperfections end with code 2, the key and a remedy before the first step."""
    for k, (name, sections, words) in enumerate(MISTAKES):
        case = strip() | {"analysis": "static"} | sections
        file = write_case(case, OUT / f"initial_mistake_{k}.toml")
        code, text = invoke(["run", file, "--output", fresh("initial_mistake")] if name == "probe" else ["check", file])
        report.check(code == 2 and words in text, f"{name}: code {code}, {text.strip()[-200:]}")
    modes = solve("mistake_modes", strip(nx=8, ny=1, analysis="modal", eigen__modes=2))
    for words, mode, cells in (("mode 7", 7, 8), ("another mesh", 1, 10)):
        case = strip(nx=cells, ny=1) | {"imperfection": [
            {"type": "modes", "results": str(modes.folder), "modes": [mode], "amplitudes": [1e-3]}]}
        done = run(write_case(case, OUT / "mistake_mode.toml"), fresh("mistake_mode"))
        report.check(done.code == 2 and words in done.text, f"mode {mode} on {cells} cells: code {done.code}, {done.text.strip()[-250:]}")
    still = held_plate(6, "hinged", temperature=[{"change": "1"}], steps={"control": "arc_length", "final_load_factor": 7.0, "initial_step": 1.627, "at_critical_point": "stop"})
    for turned in ([0, 0, 0], [20, 30, 40]):
        still["mesh"]["rotate"] = turned
        done = run(write_case(still, OUT / "mistake_still.toml"), fresh("mistake_still"))
        report.check(done.code == 2 and "until it buckles" in done.text, f"an arc of a plate that heat does not move: code {done.code}, {done.text.strip()[-250:]}")


@test
def expressions_of_growth(report):
    """Buckling and vibrations take how temperatures grow with the load factor: a straight line of t is that of its number; others are refused."""
    column = {"analysis": "buckling", "eigen": {"modes": 1}, "load": []}
    load = {}
    for change in ("1", "t", "1*t + 0", "table(t, 0, 0, 10, 10)", "max(0, t)", "1 + 0*t", "t*t"):
        case = strip("buckling", nx=10, load=[], eigen={"modes": 1}, temperature=[{"change": change}])
        case["material"][0] |= {"expansion": 1e-5}
        case["support"].append({"type": "displacement", "group": "tip", "components": ["x"]})
        code, text = invoke(["check", write_case(case | column, OUT / "growth.toml")])
        report.check(code == (0 if change in ("1", "t", "1*t + 0") else 2), f"{change}: check, code {code}: {text.strip()[-100:]}")
        done = run(OUT / "growth.toml", OUT / "growth")
        straight = change in ("1", "t", "1*t + 0")
        report.check(done.code == (0 if straight else 2) and (straight or "temperature.change" in done.text), f"{change}: code {done.code}{'' if straight else ': ' + done.text.strip()[-160:]}")
        if straight:
            load[change] = done.summary["eigenvalues"][0]
    report.near(load["t"] / load["1"], 1.0, 1e-6, "a multiple of t is its number")
    report.near(load["1*t + 0"] / load["1"], 1.0, 1e-6, "so is its sum with a constant of zero")
