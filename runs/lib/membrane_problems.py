"""The test set of runs/membranes: each problem on three cell sizes, with three thicknesses and, on meshes at random, three seeds.

Where shells bend without stretching, loads grow with the cube of the thickness, so that deflections stay the same; the linear problems
need no such scaling. Errors are in % of the references of runs/reference/membranes.csv (membrane_references.py) or of closed forms.
"""

import math
import shutil
import subprocess
from dataclasses import dataclass
from typing import Callable

import numpy as np
import random_meshes
from benchmarks import BENCHMARKS, compare
from cloth import Surface, outline
from jittered import annulus_mesh, strip_mesh
from membrane_cases import FABRICS, element
from membrane_references import PLATE_LOAD, drum_case, reference
from problems import PATTERNS
from solver import ROOT, load_case, run, variant, write_case

SEEDS = {"one way": (1,), "union jack": (1,), "random": (1, 2, 3), "gmsh": (1, 2, 3)}
SHELL = tuple(SEEDS)
THIN = (1e-2, 1e-3, 1e-4)
ANNULUS_THIN = (1e-2, 3e-3, 1e-3)  # at 1e-4 a load step takes hundreds of Newton iterations
TIMEOUT = 300  # seconds for one run
SAID = "said.txt"  # what a run wrote, in its folder
STEPS = {"initial_step": 0.1, "max_step": 0.25}
EDGE_LENGTHS = {1: 1.0, 2: 0.98, 3: 1.02}  # a seed of Gmsh is another edge length: its own draws of random numbers seldom change a mesh


@dataclass(frozen=True)
class Setting:
    """One run."""
    membrane: str
    kind: str         # of mesh
    size: dict        # parameters of the .geo
    thickness: float  # over the length that the problem names
    seed: int

    @property
    def mesh_name(self):
        return " x ".join(str(v) for v in self.size.values())

    @property
    def key(self):
        return f"{self.kind}|{self.mesh_name}|{self.thickness:g}|{self.seed}|{self.membrane}"


@dataclass(frozen=True)
class CubeProblem:
    title: str
    over: str          # what the thickness is divided by; "" where columns are no thicknesses
    note: str
    sizes: tuple
    kinds: tuple
    solve: Callable    # (Setting, folder) -> {quantity: error [%]}; empty if it failed
    thicknesses: tuple = THIN
    compared_with: str = ""  # problem of runs/reference/membranes.csv
    seeds_of: Callable = lambda kind, size: SEEDS[kind]

    def settings(self, membranes):
        for size in self.sizes:
            for kind in self.kinds:
                for thickness in self.thicknesses:
                    for seed in self.seeds_of(kind, size):
                        for membrane in membranes:
                            yield Setting(membrane, kind, size, thickness, seed)


def sizes(**parameters):
    return tuple(dict(zip(parameters, values)) for values in zip(*parameters.values()))


def on_mesh(case, setting, shape, folder):
    """The case on the setting's mesh with its membrane."""
    if setting.kind == "random":
        cells, place, groups = shape(setting.size)
        mesh = {"file": str(random_meshes.grid_mesh(folder.with_suffix(".msh"), cells, place, groups, seed=setting.seed))}
    else:
        pattern = "unstructured" if setting.kind == "gmsh" else setting.kind.replace(" ", "_")
        finer = EDGE_LENGTHS[setting.seed] if setting.kind == "gmsh" else 1
        mesh = case["mesh"] | {"parameters": case["mesh"]["parameters"] | {k: v * finer for k, v in setting.size.items()}
                               | {"pattern": PATTERNS[pattern]}}
    return case | {"mesh": mesh, "element": element(setting.membrane)}


def solved(case, folder, timeout=TIMEOUT):
    """The result of a case, None if it failed or took too long. The folder is the caller's to remove."""
    shutil.rmtree(folder, ignore_errors=True)
    case = case | {"output": {"fields": ["displacement"], "every": 1000}}
    try:
        result = run(write_case(case, folder.with_suffix(".toml")), folder, timeout=timeout)
    except subprocess.TimeoutExpired:
        return None
    if not folder.is_dir():
        raise SystemExit(f"{folder.name} was refused: {result.text}")
    (folder / SAID).write_text(result.text)
    return result if result.code == 0 else None


def errors(problem, setting, result, columns):
    """Errors of columns of the history against the reference of the thickness. `columns`: name -> sign."""
    if result is None:
        return {}
    exact = reference(problem, setting.thickness)
    return {name: 100 * (sign * result.history[name][-1] / exact[name] - 1) for name, sign in columns.items()}


def as_thin(case, thickness, published, at_same_stiffness):
    """The case with another thickness: its bending stiffness kept by Young's modulus, or its loads scaled with the cube."""
    material = case["material"][0]
    ratio = thickness / published
    if at_same_stiffness:
        changed = {"material": [material | {"thickness": thickness, "young": material["young"] / ratio**3}]}
    else:
        changed = {"material": [material | {"thickness": thickness}],
                   "load": [load | {"vector": [x * ratio**3 for x in load["vector"]]} for load in case["load"]]}
    return case | changed


# ------------------------------------------------------------------------------------------------- strips and plates

def strip(setting, folder):
    case = as_thin(load_case(BENCHMARKS["cantilever_shear"].case), 10 * setting.thickness, 0.1, True)
    mesh = strip_mesh(folder.with_suffix(".msh"), setting.size["nx"], setting.size["ny"], 0.25, seed=setting.seed)
    result = solved(case | {"mesh": {"file": str(mesh)}, "element": element(setting.membrane),
                            "steps": {"initial_step": 0.05, "max_step": 0.1}}, folder)
    if result is None:
        return {}
    table = BENCHMARKS["cantilever_shear"].reference
    return {column: 100 * (sign * result.history[column][-1] / table[name][-1] - 1)
            for column, sign, name in (("tip_x", -1, "minus_u_tip_elastica"), ("tip_z", 1, "w_tip_elastica"))}


def annulus_case(setting, folder):
    case = as_thin(load_case(BENCHMARKS["slit_annulus"].case), 10 * setting.thickness, 0.03, True)
    case["steps"] = {"initial_step": 0.025, "max_step": 0.1}
    if setting.kind == "random":
        mesh = annulus_mesh(folder.with_suffix(".msh"), setting.size["n_radial"], setting.size["n_circ"], 0.25, setting.seed)
        return case | {"mesh": {"file": str(mesh)}, "element": element(setting.membrane)}
    return on_mesh(case, setting, None, folder)


def annulus(setting, folder):
    return errors("slit_annulus", setting, solved(annulus_case(setting, folder), folder), {"A_z": 1, "B_z": 1})


def rolled(setting, folder):
    """Errors in % of the length, since the tip comes back to where w is zero."""
    case = as_thin(load_case(BENCHMARKS["cantilever_moment"].case), 12 * setting.thickness, 0.1, True)
    case["steps"] = {"initial_step": 0.05, "max_step": 0.1}
    result = solved(on_mesh(case, setting, random_meshes.cantilever, folder), folder)
    if result is None:
        return {}
    return {"tip_x": 100 * (-result.history["tip_x"][-1] / 12 - 1), "tip_z": 100 * result.history["tip_z"][-1] / 12}


def clamped_disc(setting, folder):
    case = variant(load_case(ROOT / "runs" / "linear" / "circular_plate_clamped.toml"),
                   {"analysis": "static", "load.0.magnitude": PLATE_LOAD, "material.0.thickness": setting.thickness,
                    "material.0.young": 10.92e9})
    return errors("clamped_disc", setting, solved(on_mesh(case, setting, None, folder), folder), {"centre_z": 1})


def drum(setting, folder):
    result = solved(on_mesh(drum_case(setting.thickness), setting, None, folder), folder)
    if result is None:
        return {}
    found = np.loadtxt(folder / "modes.csv", delimiter=",", skiprows=1, ndmin=2)[:6, 1]
    exact = [reference("drum", setting.thickness)[f"mode_{k}"] for k in range(1, 7)]
    return {"worst of six": 100 * max(found / exact - 1, key=abs)}


# ------------------------------------------------------------------------------------------------------ curved shells

def hemisphere_case(setting, folder):
    case = as_thin(load_case(BENCHMARKS["hemisphere"].case), 10 * setting.thickness, 0.04, False)
    return on_mesh(case | {"steps": STEPS}, setting, random_meshes.hemisphere, folder)


def hemisphere(setting, folder):
    return errors("hemisphere", setting, solved(hemisphere_case(setting, folder), folder), {"pulled_x": 1, "pushed_y": -1})


LINEAR = {  # case, its length, shape at random, column and sign
    "hypar": ("hypar_100", 1.0, random_meshes.hypar, {"A_z": -1}),
    "pinched_free": ("pinched_cylinder_free_100", 4.953, random_meshes.cylinder(4.953, 10.35), {"A_z": -1}),
    "pinched_diaphragm": ("pinched_cylinder_diaphragm", 300.0, random_meshes.cylinder(300.0, 600.0), {"A_z": -1}),
    "scordelis_lo": ("scordelis_lo", 25.0, random_meshes.panel(25.0, 50.0, math.radians(40)), {"A_z": -1}),
    "twisted_beam": ("twisted_beam_thin_y", 12.0, random_meshes.twisted_strip, {"tip_y": 1}),
}


def linear_case(name, setting, folder):
    case_name, length, shape, _ = LINEAR[name]
    case = load_case(ROOT / "runs" / "linear" / f"{case_name}.toml")
    case["material"][0]["thickness"] = length * setting.thickness
    if name == "hypar":
        case["load"][0]["vector"] = [0, 0, -8000 * setting.thickness]
    return on_mesh(case, setting, shape, folder)


def linear(name):
    def solve(setting, folder):
        return errors(name, setting, solved(linear_case(name, setting, folder), folder), LINEAR[name][3])
    return solve


def pullout_case(setting, folder):
    """Pulled until A has moved by a quarter of the radius, where the cylinder still bends without stretching; loads are scaled."""
    case = as_thin(load_case(BENCHMARKS["pullout_cylinder"].case), 4.953 * setting.thickness, 0.094, False)
    case["steps"] = case["steps"] | {"final_displacement": 1.25, "initial_step": 0.002, "max_step": 0.05}
    return on_mesh(case, setting, random_meshes.cylinder(4.953, 10.35), folder)


def pullout(setting, folder):
    return errors("pullout_cylinder", setting, solved(pullout_case(setting, folder), folder), {"load_factor": 1, "B_x": -1, "C_x": -1})


def pinched_path(setting, folder):
    benchmark = BENCHMARKS["pinched_cylinder"]
    result = solved(on_mesh(load_case(benchmark.case), setting, random_meshes.cylinder(100.0, 200.0), folder), folder)
    return {c.curve.label: 100 * c.curve_error for c in compare(benchmark, result.history)} if result else {}


# -------------------------------------------------------------------------------------------------------------- cloth

def cloth(setting, folder):
    """Of a square of 0.3 m over a disc of 0.12 m; the thickness is the number of the fabric, from 1."""
    fabric = FABRICS[round(setting.thickness) - 1]
    case = {"analysis": "drape", "element": element(setting.membrane),
            "mesh": {"file": str(ROOT / "meshes" / "cloth.geo"),
                     "parameters": {"side": 0.3, "radius": 0.06, "n": setting.size["n"] * EDGE_LENGTHS[setting.seed]}},
            "material": [{"type": "fabric", "fabric": str(ROOT / "runs" / "fabrics" / f"{fabric}.toml"),
                          "direction": [1, 0, 0], "warp_angle": 0}],
            "support": [{"type": "hinged", "group": "disc"}], "load": [{"type": "gravity", "vector": [0, 0, -9.81]}],
            "probe": [{"name": "stored", "type": "energy"}]}
    result = solved(case, folder)
    if result is None:
        return {}
    surface = Surface(result)
    edge = surface.groups["edge"]
    return {"largest dihedral [degrees]": float(surface.inner_edges()[1].max()),
            "sharpest turn of the free edge [degrees]": float((turns(outline(surface, edge)) - turns(outline(surface, edge, at_rest=True))).max()),
            "mean drop [mm]": -1e3 * float(surface.fields["displacement"][:, 2].mean()),
            "Newton iterations": result.summary["newton_iterations"]}


def turns(points):
    """Angles between neighbouring sides of a closed polygon [degrees]."""
    sides = np.roll(points, -1, axis=0) - points
    along = sides / np.linalg.norm(sides, axis=1)[:, None]
    return np.degrees(np.arccos(np.clip(np.einsum("ki,ki->k", along, np.roll(along, -1, axis=0)), -1, 1)))
