"""Form finding in whole runs: films between rings and under pressure, cables, a tent under snow; and a Nastran deck in a cylinder's axes."""

import math
import re

import numpy as np
from common import fresh
from harness import OUT, solve, test
from solver import ROOT, invoke, load_case, run, variant, write_case

FORCE = 100.0
FILM = {"type": "isotropic", "young": 1e9, "poisson": 0.3, "thickness": 1e-4, "prestress": [FORCE, FORCE]}


def rings(height, around=64):
    rows = round(around * height / (2 * math.pi))
    return {"mesh": {"file": str(ROOT / "meshes" / "tube.geo"), "parameters": {"radius": 1.0, "length": height, "n_axial": rows, "n_circ": around}},
            "form": {}, "material": [FILM], "support": [{"type": "hinged", "group": end} for end in ("start", "end")],
            "probe": [{"name": "pull", "type": "reaction", "group": "end"}]}


def places(result):
    return result.results[-1].positions


@test
def forms(report):
    """Forms in equilibrium stay where they are found: catenoid and its collapse, a film under pressure, arcs of cables, a tent; ranks agree."""
    height = 1.2
    neck = 1.0
    for _ in range(500):
        neck = 0.5 * neck + 0.5 / math.cosh(height / 2 / neck)
    film = solve("form_rings", rings(height))
    x = places(film)
    report.percent(np.hypot(x[:, 1], x[:, 2]).min() / neck, 0.003, f"neck of the film, exact {neck:.5f}")
    report.percent(film.history["pull_x"][-1] / (2 * math.pi * neck * FORCE), 0.015, "its pull on a ring")
    report.below(film.history["largest_strain"][-1], 5e-4, "strain on the way to the equilibrium of the elements")
    two = solve("form_rings_2", rings(height), ranks=2)
    report.below(np.abs(two.displacement() - film.displacement()).max(), 1e-9, "two ranks")
    again = solve("form_again", load_case(OUT / "form_rings" / "resolved_case.toml"))
    report.below(np.abs(again.displacement() - film.displacement()).max(), 1e-12, "the resolved case")
    low, high = 1.30, 1.40  # where the film collapses
    for _ in range(7):
        middle = 0.5 * (low + high)
        code, text = invoke(["check", write_case(rings(middle), OUT / "form_collapse.toml")])
        low, high = (middle, high) if code == 0 else (low, middle)
        report.check(code == 0 or (code == 2 and "[form]: no equilibrium" in text), f"{middle:.4f} radii: code {code}")
    report.percent(low / 1.32549, 0.003, f"collapse at {low:.4f} radii")

    report.check("[form]: in equilibrium the sheet pulls with" in film.text, "says how far its tension is from the prestress")
    stiff = solve("form_stiff", rings(height, 16) | {"material": [FILM | {"thickness": 1e-2}]})
    report.check("warning: [form]: in equilibrium the sheet pulls with" in stiff.text, f"a stiff film on coarse cells: {[line for line in stiff.text.splitlines() if '[form]' in line]}")
    force = np.asarray(stiff.results[-1]["membrane_force"]) - [FORCE, FORCE, 0]
    off = np.abs(0.5 * (force[:, 0] + force[:, 1])) + np.hypot(0.5 * (force[:, 0] - force[:, 1]), force[:, 2])
    said = float(re.search(r"it is off by ([\d.]+) % at", stiff.text)[1]) / 100
    report.percent(said / (off.max() / FORCE), 0.03, f"the largest difference of its tension, {off.max() / FORCE:.3f} of the prestress")

    pressure = 150.0
    cap = {"mesh": {"file": str(ROOT / "meshes" / "disc.geo"), "parameters": {"radius": 1.0, "inner_radius": 0.5, "n": 24}}, "form": {"pressure": pressure},
           "material": [FILM], "support": [{"type": "hinged", "group": "edge"}], "load": [{"type": "follower_pressure", "magnitude": pressure, "constant": True}]}
    x = places(solve("form_cap", cap))
    radius = 2 * FORCE / pressure
    report.percent(x[:, 2].max() / (radius - math.sqrt(radius**2 - 1)), 0.003, "height of a film under pressure")

    tent = load_case(ROOT / "runs" / "tent" / "case.toml")
    flat = variant(tent, {"mesh.parameters.height": 0.0})
    flat.pop("load")
    result = solve("form_flat", flat)
    x = places(result)
    arc = 25e3 / 3000
    report.percent((4 + x[np.abs(x[:, 0]) < 0.2, 1].min()) / (arc - math.sqrt(arc**2 - 16)), 0.01, "sag of a cable along a flat sheet")
    result = solve("form_tent", tent)
    plan = -result.history["corner_z"][-1] / -600
    report.check(30 < plan < 45, f"a tent of 8 m in plan carries the snow of {plan:.3g} m^2")


@test
def form_mistakes(report):
    """Films that have no form and cases that cannot have one end with code 2 before the first step, with remedy."""
    cases = (("no prestress", {"material": [FILM | {"prestress": [0, 0]}]}, "does not pull in all directions"),
             ("held along", {"support": [{"type": "displacement", "group": "start", "components": ["y", "z"]}]}, "nothing holds the piece"),
             ("remesh", {"remesh": {"smallest": 0.1, "largest": 0.3}}, "remove [remesh]"),
             ("no group", {"support": [{"type": "hinged", "group": "middle"}]}, "middle"),
             ("band", {"spring": [{"type": "band", "group": "end", "stiffness": 1e3, "length": 5}]}, "give it `force` instead"),
             ("far apart", {"mesh": rings(1.5)["mesh"]}, "bring the supports closer together"))
    for name, sections, words in cases:
        code, text = invoke(["run", write_case(rings(0.8, 24) | sections, OUT / "form_mistake.toml"), "--output", fresh("form_mistake")])
        report.check(code == 2 and words in text, f"{name}: code {code}, {text.strip()[-200:]}")
