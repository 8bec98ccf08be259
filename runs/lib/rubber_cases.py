"""Cases of rubber membranes with their exact solutions in rubber.py."""

import numpy as np
from rubber import TRELOAR, Law, disc, largest, mooney_rivlin, neo_hookean, sphere_pressure, tube_pressure
from scipy.interpolate import CubicSpline
from solver import ROOT

THICKNESS, SHEAR = 1e-3, 4e5
LAWS = {
    "neo_hookean": ({"type": "neo_hookean", "shear_modulus": SHEAR}, neo_hookean(SHEAR, THICKNESS)),
    "mooney_rivlin": ({"type": "mooney_rivlin", "c10": 0.45 * SHEAR, "c01": 0.05 * SHEAR},
                      mooney_rivlin(0.45 * SHEAR, 0.05 * SHEAR, THICKNESS)),
    "ogden": ({"type": "ogden", **TRELOAR}, Law(TRELOAR["mu"], TRELOAR["alpha"], THICKNESS)),
}


def material(law, **more):
    return LAWS[law][0] | {"thickness": THICKNESS, "density": 1000} | more


def strip(law, stretch=3.0, cells=4, pattern=2, **more):
    """A square that is pulled to a multiple of its length; its sides are free."""
    return {
        "title": "Strip of rubber",
        "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"n": cells, "pattern": pattern}},
        "material": [material(law)],
        "support": [{"type": "displacement", "group": "left", "components": ["x", "z"]},
                    {"type": "displacement", "group": "bottom", "components": ["y", "z"]},
                    {"type": "displacement", "group": "right", "components": ["x", "z"], "value": [stretch - 1, 0, 0]}],
        "probe": [{"name": "pull", "type": "reaction", "group": "right", "components": ["x"]}],
        "steps": {"initial_step": 0.25, "max_step": 0.25},
        "output": {"fields": ["displacement", "principal_stretch", "membrane_force"], "every": 1000},
    } | more


def drum(law, pole=3.0, cells=12, **more):
    """A disc of 1 m, hinged at its edge, inflated; the path ends where its exact pole is stretched so much."""
    exact = disc(LAWS[law][1], pole)
    return {
        "title": "Inflated disc of rubber",
        "mesh": {"file": str(ROOT / "meshes" / "disc.geo"),
                 "parameters": {"radius": 1.0, "inner_radius": 0.4, "n": cells, "pattern": 2}},
        "material": [material(law)],
        "support": [{"type": "hinged", "group": "edge"}],
        "load": [{"type": "follower_pressure", "magnitude": exact["pressure"]}],
        "probe": [{"name": "pole", "type": "displacement", "group": "centre", "components": ["z"]}],
        "steps": {"control": "displacement", "control_probe": "pole", "final_displacement": exact["height"],
                  "initial_step": 0.02, "max_step": 0.1, "final_load_factor": 100.0},
        "output": {"fields": ["displacement", "principal_stretch"], "every": 1000},
    } | more


def sphere(law, cells=8, radius=1.0, final=2.0, **more):
    """An eighth of a sphere under the pressure of its limit point; the path ends where its radius is so many times as large."""
    pressure = largest(lambda a: sphere_pressure(LAWS[law][1], a, radius), 1.05, 3.0)[1]
    return {
        "title": "Spherical balloon",
        "mesh": {"file": str(ROOT / "meshes" / "sphere_octant.geo"), "parameters": {"radius": radius, "n": cells, "pattern": 2}},
        "material": [material(law)],
        "support": [{"type": "symmetry", "group": side} for side in ("equator", "sym_x", "sym_y")],
        "load": [{"type": "follower_pressure", "magnitude": pressure}],
        "probe": [{"name": "pole", "type": "displacement", "group": "pole", "components": ["z"]}],
        "steps": {"control": "arc_length", "control_probe": "pole", "final_displacement": (final - 1) * radius,
                  "initial_step": 0.3, "max_step": 0.3, "final_load_factor": 100.0},
        "output": {"fields": ["displacement", "principal_stretch"], "every": 1000},
    } | more


def tube(law, cells=8, radius=1.0, final=1.2, **more):
    """An eighth of a tube between walls that hold its length, to a multiple of the pressure of its limit point, on the far side."""
    pressure = largest(lambda a: tube_pressure(LAWS[law][1], a, 1.0, radius), 1.05, 3.0)[1]
    return {
        "title": "Cylindrical balloon",
        "mesh": {"file": str(ROOT / "meshes" / "cylinder.geo"),
                 "parameters": {"radius": radius, "length": 1.0 * radius, "n_axial": max(2, cells // 2), "n_circ": cells, "pattern": 0}},
        "material": [material(law)],
        "support": [{"type": "symmetry", "group": side, "normal": normal}
                    for side, normal in (("middle", [0, 1, 0]), ("crown", [1, 0, 0]), ("flank", [0, 0, 1]), ("end", [0, 1, 0]))],
        "load": [{"type": "follower_pressure", "magnitude": pressure}],
        "probe": [{"name": "pole", "type": "displacement", "group": "A", "components": ["z"]}],
        "steps": {"control": "arc_length", "initial_step": 0.01, "max_step": 0.1, "final_load_factor": final},
        "output": {"fields": ["displacement", "principal_stretch"], "every": 1000},
    } | more


def curve_error(exact, history, unit, least=0.1):
    """Largest relative error of the pressure where the pole has risen by more than `least`; load factor 1 is `unit`, exact(height) a pressure."""
    return max(abs(f * unit / exact(z) - 1) for z, f in zip(history["pole_z"], history["load_factor"]) if z > least)


def drum_curve(law):
    """Pressure of a disc of 1 m as a function of its height, up to a pole stretch of 3.2."""
    exact = [disc(LAWS[law][1], pole) for pole in np.geomspace(1.01, 3.2, 80)]
    return CubicSpline([e["height"] for e in exact], [e["pressure"] for e in exact])


def peak(history):
    """Height and load factor of the first limit point, by the parabola through the largest load factor and its neighbours."""
    z, f = np.array(history["pole_z"]), np.array(history["load_factor"])
    at = int(np.argmax((f[1:-1] > f[:-2]) & (f[1:-1] >= f[2:]))) + 1
    a, b, c = np.polyfit(z[at - 1:at + 2], f[at - 1:at + 2], 2)
    return -b / (2 * a), c - b * b / (4 * a)
