"""Gas in closed and capped volumes against closed forms; modes, ranks, restart, mistakes. Wind that changes in time."""

import math

import numpy as np
from common import fresh
from harness import OUT, solve, test
from panels import Panels
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, least_squares
from scipy.special import jv
from solver import ROOT, run, variant, write_case

RADIUS, YOUNG, POISSON, THICKNESS, DENSITY = 0.5, 1e8, 0.3, 2e-2, 50.0
AMBIENT = 1e5


def octant(cells=8, **more):
    """An eighth of a sphere that a gas fills; the walls of the other parts are planes through its centre, the apex."""
    return {
        "title": "Sphere with gas",
        "mesh": {"file": str(ROOT / "meshes" / "sphere_octant.geo"), "parameters": {"radius": RADIUS, "n": cells, "pattern": 2}},
        "material": [{"type": "isotropic", "young": YOUNG, "poisson": POISSON, "thickness": THICKNESS, "density": DENSITY}],
        "support": [{"type": "symmetry", "group": side} for side in ("equator", "sym_x", "sym_y")],
        "load": [{"type": "gas", "magnitude": 1e4, "ambient": AMBIENT, "exponent": 1.4, "apex": [0, 0, 0]}],
        "probe": [{"name": "pole", "type": "displacement", "group": "pole", "components": ["z"]}],
        "steps": {"initial_step": 1.0},
        "output": {"fields": ["displacement"], "every": 1000},
    } | more


@test
def gas_sphere(report):
    """The radius of a sphere at which tension and a gas that expands balance: (p - p_a) R = 2 E h e/(1 - nu) (1 + e), Green's e."""
    def out_of_balance(w):
        strain, excess = w / RADIUS + 0.5 * (w / RADIUS)**2, 1.1e5 * (1 + w / RADIUS)**-4.2 - AMBIENT
        return excess * (RADIUS + w)**2 - 2 * YOUNG * THICKNESS / (1 - POISSON) * strain * (1 + w / RADIUS) * RADIUS

    exact = brentq(out_of_balance, 0, 0.1 * RADIUS)
    for cells, limit in ((8, 0.006), (16, 0.005)):
        result = solve(f"gas_sphere_{cells}", octant(cells))
        grown = result.displacement()
        found = np.linalg.norm(result.results[-1].mesh.positions + grown, axis=1).mean() - RADIUS
        report.percent(found / exact, limit, f"{cells} cells: the radius grows by {found:.5g} m")
        report.check(result.summary["newton_iterations"] <= 8, f"{result.summary['newton_iterations']} Newton iterations")
    h = solve("gas_sphere_path", octant(8, steps={"control": "arc_length", "initial_step": 0.5, "max_step": 1.0, "final_load_factor": 2.0})).history
    plain = solve("gas_sphere_load", octant(8, steps={"initial_step": 1.0, "final_load_factor": 2.0})).history
    report.below(h["pole_z"][-1] / plain["pole_z"][-1] - 1, 1e-6, "by arc length and by load control")
    report.check(h["negative_pivots"][-1] == 0, "stable")


@test
def gas_box(report):
    """The faces of a box are plane, whatever curvature is fitted to beyond its edges: its volume and the forces on them are exact."""
    side, script = 0.1, OUT / "gas_box.geo"
    script.parent.mkdir(parents=True, exist_ok=True)
    script.write_text(f'DefineConstant[ n = 4 ];\nSetFactory("OpenCASCADE");\nBox(1) = {{0, 0, 0, {side}, {side}, {side}}};\n'
                      f'Physical Surface("bag") = {{1:6}};\nMesh.MeshSizeMin = {side} / n;\nMesh.MeshSizeMax = {side} / n;\n')
    for cells in (2, 4):
        case = {"title": "Box with gas", "analysis": "static", "mesh": {"file": str(script), "parameters": {"n": cells}},
                "material": [{"type": "isotropic", "young": 1e9, "poisson": 0.3, "thickness": 1e-3, "density": 1000}],
                "support": [{"type": "hinged", "group": "bag"}],
                "load": [{"type": "gas", "magnitude": 1000, "ambient": AMBIENT}], "steps": {"initial_step": 1.0}}
        result = solve("gas_box", case)
        report.below(result.history["gas_volume"][-1] / side**3 - 1, 1e-12, f"{cells} cells: volume")
        end = result.results[-1]
        x, forces = end.mesh.positions, end["reaction"]
        inside = (x[:, 2] > 0.99 * side) & np.all((x[:, :2] > 0.01 * side) & (x[:, :2] < 0.99 * side), axis=1)
        report.below(np.abs(forces[inside][:, :2]).max(), 1e-9 * 1000 * side**2, f"{cells} cells: forces along a face")


@test
def dimples(report):
    """A thin sphere under pressure on cells larger than sqrt(R h): its dimples are warned of, where the corrected membrane has them and only there."""
    def octant_under(load, analysis, n, pattern=1, **element):
        return {"title": "Thin sphere", "analysis": analysis,
                "mesh": {"file": str(ROOT / "meshes" / "sphere_octant.geo"), "parameters": {"radius": 0.5, "n": n, "pattern": pattern}},
                "material": [{"type": "isotropic", "young": 1e8, "poisson": 0.3, "thickness": 5e-4}], "load": [load], **element,
                "support": [{"type": "symmetry", "group": g} for g in ("equator", "sym_x", "sym_y")]}

    pressure = {"type": "follower_pressure", "magnitude": 10.0}
    exact = 10.0 * 0.5**2 * 0.7 / (2 * 1e8 * 5e-4)
    text = "single vertices stand out from their neighbours"
    for name, case, dimpled in (("corrected", octant_under(pressure, "linear", 16), True),
                                ("six_node", octant_under(pressure, "linear", 16, element={"type": "six_node"}), False),
                                ("mirrored", octant_under(pressure, "linear", 16, 0), True),  # at the poles alone, on the planes
                                ("static", octant_under(pressure, "static", 16), True),
                                ("fine", octant_under(pressure, "linear", 64), False)):
        result = solve(f"dimples_{name}", case)
        w = np.linalg.norm(result.displacement(), axis=1).max() / exact
        report.check((text in result.text) == dimpled, f"{name}: up to {w:.2f} times the exact growth: {'warned' if text in result.text else 'silent'}")
        report.check((w > 2.0) == dimpled, f"{name}: the warning is where the answer is wrong")


def box(name, lid=True):
    """A cube of 1 m whose walls move along z only; its lid, or its upper rim, is pushed down."""
    p = Panels()
    n = 3
    p.add("floor", (0, 0, 0), (1, 0, 0), (0, 1, 0), n, n)
    for k, (origin, along) in enumerate((((0, 0, 0), (1, 0, 0)), ((1, 0, 0), (0, 1, 0)), ((1, 1, 0), (-1, 0, 0)), ((0, 1, 0), (0, -1, 0)))):
        p.add(f"wall {k}", origin, along, (0, 0, 1), n, n)
    if lid:
        p.add("lid", (0, 0, 1), (1, 0, 0), (0, 1, 0), n, n)
    p.join("rim", [f"wall {k} high" for k in range(4)])
    moved = "lid" if lid else "rim"
    return {
        "title": "Piston",
        "mesh": {"file": str(p.write(OUT / f"{name}.msh"))},
        "material": [{"type": "isotropic", "young": 1e6, "poisson": 0.0, "thickness": 1e-3}],
        "support": [{"type": "hinged", "group": "floor"},
                    {"type": "displacement", "group": moved, "components": ["x", "y", "z"], "value": [0, 0, -0.2]},
                    *({"type": "displacement", "group": f"wall {k}", "components": ["x", "y"]} for k in range(4))],
        "load": [{"type": "gas", "magnitude": 5e3, "ambient": AMBIENT, "exponent": 1.2, "constant": True}],
        "probe": [{"name": "push", "type": "reaction", "group": moved}],
        "steps": {"initial_step": 0.25, "max_step": 0.25},
    }


@test
def gas_piston(report):
    """p V^n in a box that is pressed together, with a lid and with its open rim closed by a fan; the force on the lid."""
    for lid in (True, False):
        name = "gas_piston" if lid else "gas_rim"
        case = box(name, lid)
        h = solve(name, case).history
        volume = 1 - 0.2 * h["load_factor"]
        excess = (AMBIENT + 5e3) * volume**-1.2 - AMBIENT
        energy = 1.05e5 / 0.2 * (volume**-0.2 - 1) + AMBIENT * (volume - 1)
        report.below(np.abs(h["gas_volume"] / volume - 1).max(), 1e-12, f"{name}: volume")
        report.below(np.abs(h["gas_pressure"] / excess - 1).max(), 1e-11, f"{name}: excess pressure")
        report.below(np.abs(h["gas_energy"] / np.where(energy == 0, 1, energy) - (energy != 0)).max(), 1e-9, f"{name}: energy")
        if lid:
            empty = solve("gas_piston_empty", variant(case, {"load": None})).history
            push = empty["push_z"] - h["push_z"]
            report.below(np.abs(push / excess - 1).max(), 1e-9, "force on the lid over pressure times area")


@test
def gas_rigid(report):
    """A force on the rigid lid of a soft box against p V^n; an open rim that moves as a body; alike on 1, 2 and 3 ranks."""
    panels, n = Panels(), 3
    panels.add("floor", (0, 0, 0), (1, 0, 0), (0, 1, 0), n, n)
    for k, (origin, along) in enumerate((((0, 0, 0), (1, 0, 0)), ((1, 0, 0), (0, 1, 0)), ((1, 1, 0), (-1, 0, 0)), ((0, 1, 0), (0, -1, 0)))):
        panels.add(f"wall {k}", origin, along, (0, 0, 1), n, 1)  # no vertex between floor and lid, so that no wall bulges
    panels.add("lid", (0, 0, 1), (1, 0, 0), (0, 1, 0), n, n)
    lid = {"group": "lid", "translation": [0, 0, "free"], "turn": "held", "force": [0, 0, -3e4]}
    case = box("gas_rigid") | {
        "mesh": {"file": str(panels.write(OUT / "gas_rigid.msh"))}, "rigid": [lid], "probe": [],
        "material": [{"type": "isotropic", "young": 1e3, "poisson": 0.0, "thickness": 1e-3}],
        "support": [{"type": "hinged", "group": "floor"}]}
    rim = box("gas_rigid_rim", lid=False) | {"rigid": [{"group": "rim", "name": "lid", "slope": "free"}], "probe": [],
                                             "support": [{"type": "hinged", "group": "floor"}]}
    rim["material"] = [{"type": "isotropic", "young": 1e7, "poisson": 0.0, "thickness": 1e-2}]
    exact = ((AMBIENT + 5e3) / (AMBIENT + 3e4))**(1 / 1.2) - 1
    for name, of in (("gas_rigid", case), ("gas_rigid_rim", rim)):
        places = [solve(name, of, ranks).history["lid_z"][-1] for ranks in (1, 2, 3)]
        report.below(np.ptp(places), 1e-9, f"{name}: ranks differ")
        if of is case:
            report.percent(places[0] / exact, 1e-4, f"{name}: the lid at {places[0]:.6g} m")


def modes_of(result):
    table = np.genfromtxt(result.folder / "modes.csv", delimiter=",", names=True, ndmin=1)
    return table[table.dtype.names[1]]


@test
def gas_kettledrum(report):
    """Axisymmetric modes of a membrane over a closed kettle: J0(x) = -chi/x^2 J2(x), chi = n p pi a^4/(V T) (Morse, Vibration and Sound,
    2nd ed., 1948, section 20); modes with nodal diameters change no volume."""
    radius, tension, density, kettle = 0.15, 1000.0, 0.3, 0.02
    case = {
        "title": "Kettledrum", "analysis": "modal",
        "mesh": {"file": str(ROOT / "meshes" / "disc.geo"), "parameters": {"radius": radius, "n": 16, "pattern": 0}},
        "material": [{"type": "isotropic", "young": 1e9, "poisson": 0.3, "thickness": 1e-5, "density": density / 1e-5,
                      "direction": [1, 0, 0], "prestress": [tension, tension]}],
        "support": [{"type": "hinged", "group": "edge"}],
        "load": [{"type": "gas", "magnitude": 0.0, "ambient": AMBIENT, "exponent": 1.4, "added_volume": kettle}],
        "eigen": {"modes": 6, "mass": "lumped"},
    }
    chi = 1.4 * AMBIENT * math.pi * radius**4 / (kettle * tension)
    to_hertz = math.sqrt(tension / density) / (2 * math.pi * radius)
    first = brentq(lambda x: jv(0, x) + chi / x**2 * jv(2, x), 2.4048, 5.0) * to_hertz
    second = brentq(lambda x: jv(0, x) + chi / x**2 * jv(2, x), 5.52, 8.0) * to_hertz
    for ranks in (1, 2):
        found = modes_of(solve(f"gas_drum_{ranks}", case, ranks))
        for exact, what in ((first, "first axisymmetric"), (3.8317 * to_hertz, "one diameter"), (5.1356 * to_hertz, "two diameters"),
                            (second, "second axisymmetric")):
            near = found[np.argmin(np.abs(found - exact))]
            report.percent(near / exact, 0.01, f"{ranks} rank(s), {what}: {near:.5g} Hz, exact {exact:.5g} Hz")
    report.check(abs(first / (2.4048 * to_hertz) - 1) > 0.1, f"the gas raises the first from {2.4048 * to_hertz:.5g} Hz")


def breathing(**more):
    """The same octant, set free under an excess pressure."""
    load = {"type": "gas", "magnitude": 1e3, "ambient": AMBIENT, "exponent": 1.4, "apex": [0, 0, 0]}
    return octant(8, analysis="dynamic", load=[load], time={"end": 1.2e-3, "step": 2e-5, "spectral_radius": 1.0, "checkpoint_steps": 30}) | more


def grown(history):
    """Mean growth of the radius."""
    return (history["gas_volume"] / history["gas_volume"][0] - 1) * RADIUS / 3


@test
def gas_breathing(report):
    """A sphere breathes at omega^2 = (2 E/((1 - nu) R^2) + 3 n p/(h R))/rho; energy, ranks and restart."""
    stiffness = 2 * YOUNG * THICKNESS / ((1 - POISSON) * RADIUS**2) + 3 * 1.4 * AMBIENT / RADIUS
    exact = math.sqrt(stiffness / (DENSITY * THICKNESS))
    whole = solve("gas_breathing", breathing())
    h = whole.history
    w = grown(h)
    fit = least_squares(lambda p: (p[0] * (1 - np.cos(p[1] * exact * h["time"])) - w) / w.max(), (0.5 * w.max(), 1.0)).x
    report.percent(fit[1], 0.01, f"frequency over that of the closed form, {exact / (2 * math.pi):.5g} Hz")
    report.percent(fit[0] / (1e3 / stiffness), 0.02, "mean of the radius")
    energy = whole.summary["energy"]
    report.below(energy["energy_unaccounted"] / energy["work_of_loads"], 1e-6, "energy unaccounted for, of the work of the gas")
    scale = np.abs(whole.displacement()).max()
    for ranks in (2, 3):
        other = solve(f"gas_breathing_{ranks}", breathing(), ranks)
        report.below(np.abs(other.displacement() - whole.displacement()).max() / scale, 1e-6, f"{ranks} ranks and 1")
        report.below(other.history["gas_volume"][-1] / h["gas_volume"][-1] - 1, 1e-10, "volume")
    solve("gas_breathing_half", variant(breathing(), {"time.end": 6e-4}))
    again = solve("gas_breathing_again", breathing(), 1, ("--restart", OUT / "gas_breathing_half" / "checkpoint.h5"))
    report.below(np.abs(again.displacement() - whole.displacement()).max() / scale, 1e-8, "restarted and unbroken")
    explicit = variant(breathing(), {"time.spectral_radius": None, "time.method": "central_difference", "time.step": 5e-6, "time.checkpoint_steps": None})
    h = solve("gas_breathing_explicit", explicit).history
    report.below(np.abs(grown(h) - np.interp(h["time"], whole.history["time"], w)).max() / w.max(), 0.02, "central differences")


@test
def gas_leak(report):
    """Gas leaves a stiff box by an orifice: 2 p/p_a - 1 = cosh(C - k t) at constant temperature, else by quadrature; what it could do goes
    to the leak. A sphere that leaks breathes: work and loss, ranks, restart to the last bit, central differences."""
    area, density, ambient = 2e-3, 1.2, 1e5
    k = area / 1.0 * math.sqrt(2 * ambient / density)
    for exponent in (1.0, 1.4):
        case = {
            "title": "Leaking box", "analysis": "dynamic",
            "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"n": 4, "side": 0.1}},
            "material": [{"type": "isotropic", "young": 1e13, "poisson": 0.3, "thickness": 1e-2, "density": 1e4}],
            "support": [{"type": "hinged", "group": g} for g in ("left", "right", "bottom", "top")],
            "load": [{"type": "gas", "magnitude": 2e4, "ambient": ambient, "exponent": exponent, "added_volume": 1.0, "constant": True,
                      "leak_area": area, "density": density}],
            "time": {"end": 1.4, "step": 0.05}, "output": {"every": 1000}}
        result = solve(f"gas_leak_{exponent}", case)
        h = result.history
        if exponent == 1.0:
            left = np.maximum(math.acosh(2 * 1.2 - 1) - k * h["time"], 0.0)
            exact = 0.5 * (1 + np.cosh(left)) * ambient
            could = lambda x: ambient * (x * math.log(x) - x + 1)  # noqa: E731
            report.below(h["gas_leak_loss"][-1] / could(1.2) - 1, 1e-5, "all that it could do is lost")
        else:
            def rate(_, m):
                p = 1.2 * ambient * max(m[0], 1e-9) ** exponent
                return [-area * math.sqrt(2 * 1.2 * density * m[0] * max(p - ambient, 0.0)) / (1.2 * density)]
            flow = solve_ivp(rate, (0, 1.4), [1.0], rtol=1e-10, atol=1e-12, t_eval=h["time"])
            exact = 1.2 * ambient * flow.y[0] ** exponent
        report.below(np.abs(h["gas_pressure"] - (exact - ambient)).max() / 2e4, 1e-4, f"n = {exponent:g}: pressure of the box")
        report.check(h["gas_content"][-1] < 0.9 and abs(h["gas_pressure"][-1]) < 5.0, f"content at the end {h['gas_content'][-1]:.5g}")
    leaking = variant(breathing(), {"load": [breathing()["load"][0] | {"leak_area": 0.05}], "time.end": 4e-4, "mesh.parameters.n": 4})
    whole = solve("gas_leak_breathing", leaking)
    h = whole.history
    pressure, volume = h["gas_pressure"] + AMBIENT, h["gas_volume"]
    could = volume * ((pressure - AMBIENT * (pressure / AMBIENT) ** (1 / 1.4)) / 0.4 - AMBIENT * ((pressure / AMBIENT) ** (1 / 1.4) - 1))
    gone = could + h["work_of_loads"] + h["gas_leak_loss"]
    report.check(h["gas_content"][-1] < 0.995 and h["gas_leak_loss"][-1] > 0, f"content {h['gas_content'][-1]:.5g}, loss {h['gas_leak_loss'][-1]:.4g} J")
    report.below(np.abs(gone - gone[0]).max() / h["gas_leak_loss"][-1], 0.01, "work, loss and what is left")
    energy = whole.summary["energy"]
    report.below(energy["energy_unaccounted"] / energy["work_of_loads"], 1e-6, "energy of the sheet unaccounted for")
    other = solve("gas_leak_breathing_2", leaking, 2).history
    report.below(other["gas_content"][-1] / h["gas_content"][-1] - 1, 1e-9, "2 ranks and 1")
    run(write_case(leaking, OUT / "gas_leak_half.toml"), fresh("gas_leak_half"), 1, ["-ts_max_steps", "8"])
    again = solve("gas_leak_again", leaking, 1, ("--restart", OUT / "gas_leak_half" / "checkpoint.h5"))
    report.check(np.array_equal(again.displacement(), whole.displacement()) and again.history["gas_content"][-1] == h["gas_content"][-1]
                 and again.history["gas_leak_loss"][-1] == h["gas_leak_loss"][-1], "restarted: the unbroken run to the last bit")
    report.below(again.history["work_of_loads"][-1] / h["work_of_loads"][-1] - 1, 1e-9, "and the works of it")
    explicit = variant(leaking, {"time.spectral_radius": None, "time.method": "central_difference", "time.step": 5e-6, "time.checkpoint_steps": None})
    report.below(solve("gas_leak_explicit", explicit).history["gas_content"][-1] / h["gas_content"][-1] - 1, 1e-3, "central differences")
    gas = case["load"][0]
    for name, changes, wanted in (
            ("static", {"analysis": "static", "time": None}, ("load.leak_area", "leaks in time")),
            ("constant", {"load": [gas | {"exponent": 0.0}]}, ("load.exponent", "changes nothing")),
            ("vacuum", {"load": [gas | {"ambient": 0.0}]}, ("load.ambient", "needs the pressure outside")),
            ("closed", {"load": [{k: v for k, v in gas.items() if k != "leak_area"}]}, ("load.density", "nothing of the gas leaks")),
            ("negative", {"load": [gas | {"leak_area": -1.0}]}, ("load.leak_area", ">= 0")),
            ("other", {"load": [{"type": "follower_pressure", "magnitude": 1.0, "leak_area": 1.0}]}, ("leak_area", "does not belong"))):
        file = write_case(variant(case, changes), OUT / f"gas_leak_wrong_{name}.toml")
        result = run(file, OUT / f"gas_leak_wrong_{name}")
        report.check(result.code == 2 and file.name in result.text and all(w in result.text for w in wanted),
                     f"{name}: {result.text.strip().splitlines()[-1][:150]}")
    result = run(write_case(leaking, OUT / "gas_leak_results.toml"), OUT / "gas_leak_results", 1, ("--restart", OUT / "gas_leak_half" / "results.vtkhdf"))
    report.check(result.code == 2 and "what is left of a gas" in result.text, "results.vtkhdf do not hold what is left")


@test
def gas_cushion(report):
    """A cushion full of gas falls on the ground: p V^n stays, nothing intersects, the energy adds up."""
    p = Panels()
    n, a = 4, 0.2
    for k, (origin, along, across) in enumerate((((0, 0, 0), (a, 0, 0), (0, a, 0)), ((0, 0, a), (a, 0, 0), (0, a, 0)), ((0, 0, 0), (a, 0, 0), (0, 0, a)),
                                                 ((0, a, 0), (a, 0, 0), (0, 0, a)), ((0, 0, 0), (0, a, 0), (0, 0, a)), ((a, 0, 0), (0, a, 0), (0, 0, a)))):
        p.add(f"side {k}", origin, along, across, n, n)
    case = {
        "title": "Cushion", "analysis": "dynamic",
        "mesh": {"file": str(p.write(OUT / "cushion.msh"))},
        "material": [{"type": "isotropic", "young": 1e7, "poisson": 0.3, "thickness": 1e-3, "density": 300.0}],
        "load": [{"type": "gas", "magnitude": 500.0, "ambient": 2e3, "exponent": 1.4}],
        "obstacle": [{"name": "ground", "type": "plane", "point": [0, 0, -0.01], "normal": [0, 0, 1]}],
        "contact": {"distance": 2e-3}, "damping": {"mass": 5.0},
        "initial_velocity": [{"group": f"side {k}", "velocity": [0, 0, -3]} for k in range(6)],
        "time": {"end": 0.05, "step": 1e-3, "velocity_tolerance": 1e-3},
        "output": {"every": 1000}}
    result = solve("gas_cushion", case)
    h = result.history
    law = (h["gas_pressure"] + 2e3) * h["gas_volume"]**1.4
    report.below(np.abs(law / law[0] - 1).max(), 1e-12, "p V^n")
    report.check(h["gas_volume"].max() / h["gas_volume"].min() > 1.05, f"volume {h['gas_volume'].min():.4g} to {h['gas_volume'].max():.4g} m^3")
    report.check(h["contact_pairs"].max() > 0 and h["intersections"].max() == 0, "contact without intersections")
    energy = result.summary["energy"]
    report.below(energy["energy_unaccounted"] / energy["initial_energy"], 0.02, "energy unaccounted for")


@test
def gas_pressed_out(report):
    """A box that is pressed together by more than its height: no state is accepted whose gas has no room."""
    for name, cells in (("gas_pressed_out", 2), ("gas_pressed_held", 1)):
        panels = Panels()
        for part, z in (("floor", 0), ("lid", 1)):
            panels.add(part, (0, 0, z), (1, 0, 0), (0, 1, 0), 3, 3)
        for k, (origin, along) in enumerate((((0, 0, 0), (1, 0, 0)), ((1, 0, 0), (0, 1, 0)), ((1, 1, 0), (-1, 0, 0)), ((0, 1, 0), (0, -1, 0)))):
            panels.add(f"wall {k}", origin, along, (0, 0, 1), 3, cells)
        case = box(name) | {
            "mesh": {"file": str(panels.write(OUT / f"{name}.msh"))}, "probe": [],
            "material": [{"type": "isotropic", "young": 1e7, "poisson": 0.0, "thickness": 1e-2}],
            "support": [{"type": "hinged", "group": "floor"}, {"type": "hinged", "group": "lid", "value": [0, 0, -1.5]}],
            "load": [{"type": "gas", "magnitude": 5.0}], "steps": {"initial_step": 0.3, "max_step": 0.3}}
        result = run(write_case(case, OUT / f"{name}.toml"), OUT / name)
        least = result.history["gas_volume"].min()
        report.check(result.code == (3 if cells > 1 else 2) and least > 0, f"{name}: code {result.code}, least volume {least:.3g} m^3")


@test
def gas_mistakes(report):
    """What is no gas is refused before the first step, with file, key and remedy."""
    gas = octant()["load"][0]
    flat = {"mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"n": 4}},
            "support": [{"type": "hinged", "group": "left"}], "probe": [], "load": [{k: v for k, v in gas.items() if k != "apex"}]}
    for name, changes, wanted in (
            ("flat", flat, ("[[load]]", "encloses no volume", "added_volume")),
            ("group", {"load": [gas | {"group": "shel"}]}, ("[[load]] group", "shel")),
            ("curve", {"load": [gas | {"group": "equator"}]}, ("[[load]] group", "equator")),
            ("vacuum", {"load": [gas | {"magnitude": -2e5}]}, ("load.magnitude", "more than 0")),
            ("linear", {"analysis": "linear"}, ("load.type", "static, modal or dynamic")),
            ("buckling", {"analysis": "buckling"}, ("load.type", "static, modal or dynamic")),
            ("remesh", {"remesh": {"angle": 0.2}}, ("remesh", "volume")),
            ("key", {"load": [gas | {"type": "follower_pressure"}]}, ("does not belong", "follower_pressure")),
            ("solver", {"petsc": {"options": "-ksp_type cg -pc_type jacobi"}}, ("gas", "complete factor"))):
        file = write_case(octant() | changes, OUT / f"gas_wrong_{name}.toml")
        result = run(file, OUT / f"gas_wrong_{name}")
        report.check(result.code == 2 and all(w in result.text for w in wanted) and (name == "solver" or file.name in result.text),
                     f"{name}: {result.text.strip().splitlines()[-1][:150]}")


@test
def gas_behind_a_rim(report):
    """A gas with added volume behind a rim that moves does not change its volume: that is noted, in statics and in motion; not of a held one."""
    for analysis, more in (("modal", {}), ("dynamic", {"time": {"end": 1e-4, "step": 1e-4}})):
        for held in (False, True):
            case = {"analysis": analysis, "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"n": 4}},
                    "material": [{"type": "isotropic", "young": 1e9, "poisson": 0.3, "thickness": 1e-3, "density": 1000}],
                    "support": [{"type": "hinged", "group": side} for side in (("left", "right", "bottom", "top") if held else ("left",))],
                    "load": [{"type": "gas", "magnitude": 0.0, "added_volume": 0.1, "constant": True}]} | more
            done = solve("gas_rim_moves", case)
            report.check(("note: [[load]] of type \"gas\": its rim moves" in done.text) != held, f"{analysis}, a rim that is {'held' if held else 'loose'}")


@test
def gas_of_any_size(report):
    """A sheet on one held edge above a gas, whose rim moves with it, is alike at every size: a hundred microns, and a fifth of a metre."""
    found = {}
    for side in (0.2, 2e-4, 1e-4):
        case = {"analysis": "static", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"side": side, "n": 8}},
                "material": [{"type": "isotropic", "young": 1e9, "poisson": 0.3, "thickness": side / 200, "density": 1000.0}],
                "support": [{"type": "clamped", "group": "left"}],
                "load": [{"type": "gas", "magnitude": 100.0, "ambient": 1e5, "exponent": 1.4, "added_volume": 1.25 * side**3},
                         {"type": "area", "vector": [0, 0, 2000.0]}],
                "probe": [{"name": "tip", "type": "displacement", "group": "right", "components": ["z"]}]}
        done = solve("gas_of_any_size", case)
        found[side] = np.array([done.history["tip_z"][-1] / side, done.history["gas_pressure"][-1]])
        report.check(done.history["negative_pivots"][-1] == 0, f"{side} m: stable")
    for side in (2e-4, 1e-4):
        report.below(np.abs(found[side] / found[0.2] - 1).max(), 1e-7, f"{side} m: as at 0.2 m, {found[side]}")


def pane(**more):
    """A stiff square plate of 1 m and 1 kg that hangs from its upper edge, in the plane x = 0."""
    p = Panels()
    p.add("pane", (0, 0, 0), (0, 1, 0), (0, 0, -1), 2, 2)
    return {
        "title": "Pane in the wind", "analysis": "dynamic",
        "mesh": {"file": str(p.write(OUT / "pane.msh"))},
        "material": [{"type": "isotropic", "young": 1e8, "poisson": 0.0, "thickness": 0.01, "density": 100.0}],
        "probe": [{"name": "low", "type": "displacement", "group": "pane high"}],
        "output": {"every": 1000},
    } | more


@test
def wind(report):
    """A pane hangs in a wind that rises: sin t/cos^2 t = C rho U^2 A/(2 m g); its hinge bears the wind on its own row, too. A free one
    follows a wind that grows steadily, later by a constant velocity."""
    speed = math.sqrt(2 * 9.81 / (1.2 * 1.2))
    angle = brentq(lambda t: math.sin(t) - math.cos(t)**2, 0, 1.5)
    held = pane(support=[{"type": "hinged", "group": "pane low"}], load=[{"type": "gravity", "vector": [0, 0, -9.81]}],
                air={"density": 1.2, "normal_drag": 1.2, "wind": [f"{speed}*min(1, t)", "0", 0]}, damping={"mass": 3.0},
                time={"end": 8.0, "step": 0.02})
    held["probe"].append({"name": "hinge", "type": "reaction", "group": "pane low"})
    h = solve("wind_pane", held).history
    found = math.asin(h["low_x"][-1])
    report.percent(found / angle, 0.002, f"angle of the pane: {math.degrees(found):.5g} degrees, exact {math.degrees(angle):.5g}")
    push = 9.81 * math.sin(angle)  # of the wind, square to the pane
    for axis, exact in (("x", -push * math.cos(angle)), ("z", 9.81 - push * math.sin(angle))):
        report.percent(h[f"hinge_{axis}"][-1] / exact, 0.002, f"reaction {axis}: {h[f'hinge_{axis}'][-1]:.5g} N, exact {exact:.5g}")
    lag = math.sqrt(2 * 3.0 / (1.2 * 1.2))  # that drags a mass of 1 kg along at 3 m/s^2
    free = pane(air={"density": 1.2, "normal_drag": 1.2, "wind": [f"{lag} + 2 + 3*t", 0, "0"]},
                initial_velocity=[{"group": "pane", "velocity": [2, 0, 0]}], time={"end": 1.0, "step": 0.01})
    h = solve("wind_free", free).history
    exact = 2 * h["time"] + 1.5 * h["time"]**2
    report.below(np.abs(h["low_x"] - exact).max() / exact.max(), 1e-3, "way of the free pane")
    same = solve("wind_unit", variant(free, {"air.wind": ["600 m/min", 0, 0], "time.end": 0.1})).history["low_x"][-1]
    plain = solve("wind_number", variant(free, {"air.wind": [10, 0, 0], "time.end": 0.1, "title": None}))
    report.check(same == plain.history["low_x"][-1], "a wind with its unit")
    report.check("wind_number.toml\n" in plain.text, f"a case without a title: {plain.text.splitlines()[0]}")
    for name, changes, wanted in (("two", {"air.wind": [1, 2]}, ("air.wind", "three are needed")),
                                  ("idle", {"air.normal_drag": 0.0}, ("air.wind", "normal_drag")),
                                  ("alone", {"air": {"density": 1.2}}, ("air.density", "normal_drag", "remove the section")),
                                  ("still", {"analysis": "static", "damping": None, "initial_velocity": None}, ("air.wind", "no wind")),
                                  ("word", {"air.wind": ["1 + s", 0, 0]}, ("air.wind", "expression of t"))):
        result = run(write_case(variant(free, changes), OUT / f"wind_wrong_{name}.toml"), OUT / f"wind_wrong_{name}")
        report.check(result.code == 2 and all(w in result.text for w in wanted), f"{name}: {result.text.strip().splitlines()[-1][:120]}")
