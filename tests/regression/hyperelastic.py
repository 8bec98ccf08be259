"""Hyperelastic membranes against closed forms and a shooting solution; ranks, restart, motion, remeshing, mistakes."""

import csv

import numpy as np
from harness import OUT, solve, test
from rubber import TRELOAR, Law, disc, largest, sphere_pressure, tube_pressure
from rubber_cases import LAWS, THICKNESS, curve_error, drum, peak, sphere, strip, tube
from scipy.optimize import brentq
from solver import ROOT, invoke, load_case, run, variant, write_case


@test
def rubber_strip(report):
    """A strip of three laws, pulled to three times its length: the pull, its width, the true stress; the resolved case, two ranks."""
    for law, (_, exact) in LAWS.items():
        result = solve(f"rubber_strip_{law}", variant(strip(law), {"output.stresses": "surface"}))
        pull, across = exact.forces(3.0, 3.0**-0.5)[0], 3.0**-0.5
        report.percent(result.history["pull_x"][-1] / pull, 1e-9, f"{law}: pull {pull:.6g} N")
        stretch = result.results[-1]["principal_stretch"]
        report.below(np.abs(stretch - [3.0, across, across]).max(), 1e-9, f"{law}: stretches")
        stress = result.results[-1]["principal_stress_top"][:, 0]
        report.below(np.abs(stress / (3.0 * pull / THICKNESS) - 1).max(), 1e-8, f"{law}: true stress")
        report.check("warning" not in result.text, f"{law}: no warning")
    again = solve("rubber_strip_again", load_case(OUT / "rubber_strip_ogden" / "resolved_case.toml"), ranks=2)
    report.below(again.history["pull_x"][-1] / pull - 1, 1e-9, "the resolved case on two ranks")


@test
def rubber_drum(report):
    """A disc inflated past its limit point to three times its length at the pole, against shooting."""
    for law, limit in (("neo_hookean", 0.002), ("mooney_rivlin", 0.002)):
        exact = disc(LAWS[law][1], 3.0)
        result = solve(f"rubber_drum_{law}", drum(law))
        report.percent(result.history["load_factor"][-1], limit, f"{law}: pressure {exact['pressure']:.5g} Pa at the height {exact['height']:.4g} m")
        report.near(result.results[-1]["principal_stretch"][:, 0].max(), 3.0, 0.06, f"{law}: largest stretch")
        report.check("warning" not in result.text, f"{law}: no warning")
    example = solve("rubber_example", load_case(ROOT / "runs" / "balloon" / "case.toml"))
    pole = brentq(lambda pole: disc(Law(TRELOAR["mu"], TRELOAR["alpha"], 5e-4), pole, 0.1)["height"] - 0.25, 3, 6)
    report.near(example.results[-1]["principal_stretch"][:, 0].max(), pole, 0.1, "example: largest stretch")
    report.near(peak(example.history)[1], 4.0115, 0.01, "example: largest pressure in kPa, by shooting 4.0115")
    report.check("warning" not in example.text, "example: no warning")


@test
def rubber_balloons(report):
    """Paths of a sphere, also filled with a gas, and of a tube of fixed length, both limit points of which are passed."""
    law = LAWS["neo_hookean"][1]
    path = sphere("neo_hookean")
    h = solve("rubber_sphere", path).history
    height, factor = peak(h)
    report.percent(factor, 0.012, "sphere: largest pressure")
    report.near(1 + height, 7**(1 / 6), 0.03, "sphere: stretch there")
    report.near(h["negative_pivots"][-1], 1, 0, "sphere: unstable beyond")
    for pattern, times in ((0, 20), (1, 50)):  # a lower mode than that of the limit point is followed, or both one after the other
        thick = variant(sphere("neo_hookean", 6), {"mesh.parameters.pattern": pattern, "material.0.thickness": times * 1e-3})
        thick["load"][0]["magnitude"] *= times / 2.5
        thick["steps"] = {"control": "arc_length", "control_probe": "pole", "final_displacement": 1.0, "initial_step": 0.1}
        points = solve(f"rubber_sphere_{pattern}", thick).summary["critical_points"]
        report.check([c["kind"] for c in points] == ["limit point"], f"pattern {pattern}, long steps by arc length: {points}")
        report.percent(points[0]["load_factor"] / 2.5, 0.012, "its load")
    gas = {"type": "gas", "magnitude": 8e3, "ambient": 2e3, "exponent": 1.0, "apex": [0, 0, 0]}
    held = path | {"load": [gas], "steps": {"initial_step": 0.05, "max_step": 0.1}}
    stretch = brentq(lambda a: 1e4 / a**3 - 2e3 - sphere_pressure(law, a), 1.1, 3.0)
    h = solve("rubber_gas", held).history
    report.percent((1 + h["pole_z"][-1]) / stretch, 0.006, f"sphere with gas: stretch {stretch:.4g}")
    report.near(h["negative_pivots"][-1], 0, 0, "sphere with gas: stable")
    law = LAWS["ogden"][1]
    unit = largest(lambda a: tube_pressure(law, a), 1.05, 3.0)[1]
    h = solve("rubber_tube", tube("ogden")).history
    report.below(curve_error(lambda z: tube_pressure(law, 1 + z), h, unit, 0.3), 0.02, "tube: pressure along its path")
    report.check(h["negative_pivots"].max() == 1 and h["negative_pivots"][-1] == 0, "tube: unstable between its limit points")


@test
def rubber_motion(report):
    """A strip that a force stretches to twice its length in time, by both methods: energy; restarted on two ranks."""
    case = strip("mooney_rivlin", stretch=1.0) | {"analysis": "dynamic", "damping": {"membrane": 1e-3}}
    case["support"] = case["support"][:2]
    case["load"] = [{"type": "line", "group": "right", "vector": [600, 0, 0]}]
    case["probe"] = [{"name": "end", "type": "displacement", "group": "right", "components": ["x"]}]
    case.pop("steps")
    case["output"] = {"fields": ["displacement"], "energy_balance": True}
    ends = {}
    for method, steps in (("alpha", {"step": 5e-4, "max_step": 5e-4}), ("central_difference", {"step": 1e-4, "max_step": 1e-4})):
        result = solve(f"rubber_{method}", case | {"time": {"end": 0.05, "method": method} | steps})
        ends[method] = result.history["end_x"][-1]
        energy = result.summary["energy"]
        report.check(result.history["end_x"].max() > 0.95, f"{method}: stretched to {1 + result.history['end_x'].max():.3g}")
        report.below(energy["energy_unaccounted"] / energy["work_of_loads"], 1e-6, f"{method}: energy unaccounted for")
        report.below(energy["numerical_loss"] / energy["work_of_loads"], 0.01, f"{method}: numerical loss")
    report.percent(ends["central_difference"] / ends["alpha"], 0.01, "both methods")
    motion = case | {"time": {"end": 0.02, "step": 5e-4, "max_step": 5e-4, "checkpoint_steps": 20}}
    whole = solve("rubber_whole", motion)
    half = solve("rubber_half", variant(motion, {"time.end": 0.01}))
    again = solve("rubber_again", motion, 2, ("--restart", half.folder / "checkpoint.h5"))
    report.below(np.abs(again.displacement() - whole.displacement()).max(), 1e-7, "restarted on 2 ranks and unbroken")


@test
def rubber_states(report):
    """A strip with an initial strain, an inflated disc whose mesh is replaced."""
    # Half as long without force as between its supports, and free across.
    exact = LAWS["ogden"][1].forces(2.0, 2.0**-0.5)[0] * 2.0**-0.5
    shrunk = strip("ogden", stretch=1.0) | {"material": [LAWS["ogden"][0] | {
        "thickness": THICKNESS, "density": 1000, "direction": [1, 0, 0], "initial_strain": [-0.5, 2.0**-0.5 - 1.0]}]}
    del shrunk["support"][2]["value"]
    result = solve("rubber_shrunk", shrunk)
    report.percent(result.history["pull_x"][-1] / exact, 1e-9, f"shrunk: pull {exact:.6g} N")
    report.below(np.abs(result.results[-1]["principal_stretch"] - [2.0, 2.0**-0.5, 2.0**-0.5]).max(), 1e-9, "shrunk: stretches")
    inflated = drum("neo_hookean", pole=2.0, element={"type": "six_node"},
                    steps={"initial_step": 0.05, "max_step": 0.2, "final_load_factor": 0.9})
    plain = solve("rubber_plain", inflated)
    again = solve("rubber_remeshed", inflated | {"remesh": {"angle": 8, "largest": 0.2}})
    report.check(again.summary["remeshing"]["count"] > 0, f"remeshed {again.summary['remeshing']['count']} times")
    report.percent(again.history["pole_z"][-1] / plain.history["pole_z"][-1], 0.02, "height of the pole")


@test
def rubber_modes(report):
    """A square that is stretched alike in both directions rings as a membrane: omega^2 = 2 pi^2 f/(a rho h L^2), f the force at stretch a."""
    stretch = 1.8
    sides = {"left": [0, None], "right": [stretch - 1, None], "bottom": [None, 0], "top": [None, stretch - 1]}
    case = strip("ogden", cells=16, pattern=0, analysis="modal", eigen={"modes": 8, "load_factor": 1.0, "mass": "lumped"})
    case["support"] = [{"type": "displacement", "group": group, "components": [c for c, v in zip("xyz", (*value, 0)) if v is not None],
                        "value": [v or 0 for v in (*value, 0)]} for group, value in sides.items()]
    case.pop("probe")
    result = solve("rubber_modes", case)
    with open(result.folder / "modes.csv", encoding="utf-8") as table:
        found = max(csv.DictReader(table), key=lambda mode: float(mode["effective_mass_z"]))  # not in the plane
    force = LAWS["ogden"][1].forces(stretch, stretch)[0]
    exact = np.sqrt(force / (2 * stretch * 1000 * THICKNESS))
    report.percent(float(found["frequency_hz"]) / exact, 0.002, f"first frequency, {exact:.5g} Hz")
    # Smaller at rest instead of stretched by supports, and as thick where it is without force: sides of 1/stretch.
    smaller = strip("ogden", cells=16, pattern=0, analysis="modal", eigen={"modes": 8, "load_factor": 1.0, "mass": "lumped"}, stretch=1.0)
    smaller["support"] = [{k: v for k, v in s.items() if k != "value"} for s in case["support"]]
    smaller["material"] = [smaller["material"][0] | {"direction": [1, 0, 0], "initial_strain": [1 / stretch - 1, 1 / stretch - 1]}]
    smaller.pop("probe")
    with open(solve("rubber_smaller", smaller).folder / "modes.csv", encoding="utf-8") as table:
        again = max(csv.DictReader(table), key=lambda mode: float(mode["effective_mass_z"]))
    report.percent(float(again["frequency_hz"]) / float(found["frequency_hz"]) / stretch, 1e-6, "stretched from a smaller state without force")
    # A mode in the plane is a small change, whose size says nothing: its strains are none of a state.
    report.below(max(result.summary["eigenvalue_errors"]), 0.02, "errors by estimate, of modes in the plane too")
    report.check("cells do not resolve" not in result.text, "and no warning")


@test
def rubber_mistakes(report):
    """Keys that are wrong, and a law that no path can follow."""
    wrong = [
        ({"type": "neo_hookean", "shear_modulus": -1.0}, "shear_modulus"), ({"type": "neo_hookean"}, "give shear_modulus"),
        ({"type": "neo_hookean", "shear_modulus": 1e5, "young": 3e5}, "keep one"),
        ({"type": "neo_hookean", "shear_modulus": 1e5, "poisson": 0.3}, "poisson"),
        ({"type": "mooney_rivlin", "c10": 1e5}, "c01"), ({"type": "mooney_rivlin", "c10": 1e5, "c01": -1e5}, "above 0"),
        ({"type": "ogden", "mu": [1e5, 2e5], "alpha": [2.0]}, "one for each"), ({"type": "ogden", "mu": [1e5], "alpha": [-2.0]}, "check signs"),
        ({"type": "ogden", "mu": [1e5], "alpha": [0.0]}, "remove the term"),
        ({"type": "neo_hookean", "shear_modulus": 1e5, "prestress": [100, 100]}, "give initial_strain"),
        ({"type": "neo_hookean", "shear_modulus": 1e5, "expansion": 1e-5}, "expansion"),
    ]
    for given, word in wrong:
        file = write_case(strip("neo_hookean") | {"material": [given | {"thickness": THICKNESS}]}, OUT / "rubber_mistake.toml")
        code, text = invoke(["check", file])
        report.check(code == 2 and word in text and "material" in text, f"{word}: {text.strip().splitlines()[-1][:150]}")
    soft = {"type": "mooney_rivlin", "c10": 1e5, "c01": -3e4, "thickness": THICKNESS}
    case = variant(drum("neo_hookean", cells=4), {"steps": {"initial_step": 0.01, "min_step": 0.005}, "load.0.magnitude": 1e4}) | {"material": [soft | {"density": 1000}]}
    result = run(write_case(case, OUT / "rubber_soft.toml"), OUT / "rubber_soft")
    report.check(result.code == 3 and "largest stretch is" in result.text, "a failed step with its place and stretch")
    report.check("loses ellipticity" in result.text, "a note that the law loses ellipticity")
    pressed = variant(case, {"steps": None, "load": [{"type": "pressure", "magnitude": 3e3}]})
    for analysis, more in (("drape", {"drape": {"max_iterations": 60}}), ("dynamic", {"time": {"end": 1.0, "step": 1e-2, "min_step": 1e-3}})):
        result = run(write_case(pressed | {"analysis": analysis} | more, OUT / f"rubber_soft_{analysis}.toml"), OUT / f"rubber_soft_{analysis}")
        report.check(result.code == 3 and "the law has lost ellipticity in triangle" in result.text, f"{analysis}: failed where the law has lost ellipticity")
