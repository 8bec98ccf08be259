"""Periodic edges: a strip in plane strain, a cell that is stretched, modes of an infinite plate, a motion; ranks, restart, mistakes."""

import math

import numpy as np
from common import fresh, strip
from harness import OUT, solve, test
from solver import ROOT, run, write_case

YOUNG, POISSON, THICKNESS, DENSITY = 1.2e6, 0.3, 0.1, 100.0
PLATE = {"type": "isotropic", "young": YOUNG, "poisson": POISSON, "thickness": THICKNESS, "density": DENSITY}
BENDING = YOUNG * THICKNESS**3 / (12 * (1 - POISSON**2))
SIDES = {"from": "side_low", "to": "side_high", "name": "across"}
ENDS = {"from": "clamp", "to": "tip", "name": "along"}


def sheet(analysis, n, length, width, periodic, pattern=2, material=PLATE, **more):
    mesh = {"file": str(ROOT / "meshes" / "cantilever.geo"),
            "parameters": {"length": length, "width": width, "nx": n, "ny": max(1, round(n * width / length)), "pattern": pattern}}
    return {"title": "Periodic", "analysis": analysis, "mesh": mesh, "material": [material], "periodic": periodic,
            "output": {"every": 1000}} | more


@test
def periodic_strip(report):
    """One period of an infinitely wide cantilever is in plane strain, also one cell wide, on 1, 2 and 3 ranks."""
    length, load = 10.0, 0.04
    exact = load * length**3 / (3 * BENDING)
    clamp = [{"type": "clamped", "group": "clamp"}]
    probe = [{"name": "tip", "type": "displacement", "group": "tip"}, {"name": "low", "type": "reaction", "group": "side_low"},
             {"name": "clamp", "type": "reaction", "group": "clamp"}]
    more = {"support": clamp, "load": [{"type": "line", "group": "tip", "vector": [0, 0, load]}], "probe": probe}
    for pattern, n, width in ((0, 40, 1.0), (1, 40, 1.0), (2, 40, 1.0), (2, 40, 0.25), (0, 40, 0.25)):
        h = solve("periodic_strip", sheet("linear", n, length, width, [SIDES], pattern, **more)).history
        report.percent(h["tip_z"][-1] / exact, 0.003, f"pattern {pattern}, {width} m wide: deflection")
        report.near(h["clamp_z"][-1], -load * width, 1e-9, "the clamp holds the load")
    free = solve("periodic_free", sheet("linear", 40, length, 1.0, [], **more)).history
    report.check(free["tip_z"][-1] / exact > 1.05, "with free sides it is another one")
    large = more | {"load": [{"type": "line", "group": "tip", "vector": [0, 0, 10 * load]}]}
    shapes = [solve("periodic_large", sheet("static", 40, length, 1.0, [SIDES], **large), ranks).displacement() for ranks in (1, 2, 3)]
    for ranks, shape in zip((2, 3), shapes[1:]):
        report.below(np.abs(shape - shapes[0]).max() / length, 1e-7, f"{ranks} ranks")
    beam = PLATE | {"poisson": 0.0, "young": YOUNG / (1 - POISSON**2)}
    plain = solve("periodic_beam", sheet("static", 40, length, 1.0, [], material=beam, **large)).history["tip_z"][-1]
    wide = solve("periodic_large", sheet("static", 40, length, 1.0, [SIDES], **large)).history["tip_z"][-1]
    report.percent(wide / plain, 0.003, "at a large deflection as a beam of E/(1 - nu^2)")


@test
def periodic_cell(report):
    """A cell that is stretched and sheared has one stress; forces on free differences stretch it as far."""
    length, width, strain = 2.0, 1.0, 0.01
    stiffness = YOUNG * THICKNESS / (1 - POISSON**2)
    pairs = [ENDS | {"difference": [strain * length, 0, 0]}, SIDES | {"difference": [0, -0.5 * strain * width, 0]}]
    hold = {"support": [{"type": "displacement", "group": "clamp", "components": ["z"]}]}
    for ranks in (1, 2):
        h = solve("periodic_cell", sheet("linear", 12, length, width, pairs, support=[{"type": "hinged", "group": "corner"}])
                  if False else sheet("linear", 12, length, width, pairs, **hold), ranks).history
        report.near(h["along_force_x"][-1], stiffness * strain * (1 - 0.5 * POISSON) * width, 1e-6, f"{ranks} ranks: force along")
