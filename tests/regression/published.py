"""Published load paths, modes and limit loads against their sources, and what they cost."""

import math
import re

import h5py
import numpy as np
from benchmarks import BENCHMARKS, compare
from common import base, drape_script, fresh, plate, without_stops
from curves import at_load
from harness import OUT, run, solve, test, write_case
from linear import LINEAR, answer
from modes import MODES, computed_modes
from solver import load_case, variant


def published(report, name, result, end, whole):
    for c in compare(BENCHMARKS[name], result.history):
        if abs(c.published) > 0:
            report.percent(c.ratio, end, f"{c.curve.label} at full load, {c.final:.5g} against {c.published:g}")
        report.below(c.curve_error, whole, f"{c.curve.label}, whole curve")


def with_mesh(case, **parameters):
    return variant(case, {f"mesh.parameters.{k}": v for k, v in parameters.items()}
                   | {"output": {"fields": ["displacement"], "every": 1}})


def mesh_of(name, **parameters):
    return with_mesh(load_case(BENCHMARKS[name].case), **parameters)


@test
def cantilever_shear(report):
    """40 x 4 cells: 0.2 % at full load against the published element and the elastica, 1 % along the curve."""
    result = solve("cantilever_shear", base("cantilever_shear"))
    published(report, "cantilever_shear", result, 0.002, 0.01)
    reference = BENCHMARKS["cantilever_shear"].reference
    history = result.history
    report.percent(-history["tip_x"][-1] / reference["minus_u_tip_elastica"][-1], 0.002, "-u, tip, against the elastica")
    report.percent(history["tip_z"][-1] / reference["w_tip_elastica"][-1], 0.002, "w, tip, against the elastica")
    report.near(abs(history["clamp_force_z"][-1]), 4.0, 1e-5, "size of the reaction along z")
    report.near(history["clamp_force_x"][-1], 0.0, 1e-5, "reaction along x")


@test
def cantilever_moment(report):
    """Rolled up into a full circle: the tip returns to the clamp within 1 % of the length."""
    result = solve("cantilever_moment", base("cantilever_moment"))
    published(report, "cantilever_moment", result, 0.01, 0.01)
    history, length = result.history, 12.0
    report.near(history["load_factor"][-1], 1.0, 1e-12, "load factor reached")
    report.below(math.hypot(history["tip_x"][-1] + length, history["tip_z"][-1]) / length, 0.01, "gap of the circle / length")


@test
def annulus(report):
    """12 x 120 cells one way, about 2400 vertices unstructured: 0.5 % at full load; union jack: 1 %; curves 1 %."""
    for name, pattern, end in (("one_way", 0, 0.005), ("unstructured", 2, 0.005), ("union_jack", 1, 0.01)):
        print(f" {name}")
        result = solve(f"annulus_{name}", base("slit_annulus", mesh__parameters__pattern=pattern), ranks=2)
        published(report, "slit_annulus", result, end, 0.01)
        report.near(abs(result.history["lip_force_z"][-1]), 3.2, 1e-5, "size of the reaction along z")
        if name == "unstructured":
            report.near(result.summary["vertices"], 2400, 100, "vertices")


@test
def hemisphere(report):
    """48 x 48 cells: 0.6 % at full load, 1 % along the curve."""
    result = solve("hemisphere", base("hemisphere"))
    published(report, "hemisphere", result, 0.006, 0.01)
    report.near(result.history["vertical_force_z"][-1], 0.0, 1e-4, "force of the support that only stops a rigid motion")


# Errors in % on the second mesh of runs/lib/linear.py: parallel diagonals, unstructured.
LINEAR_ERRORS = {
    "scordelis_lo": (0.15, 0.02),
    "pinched_cylinder_diaphragm": (17.48, 23.16),
    "pinched_cylinder_free_100": (0.56, 0.67),
    "pinched_cylinder_free_10000": (0.28, 0.27),
    "hemisphere_hole": (0.47, 1.10),
    "hemisphere_closed": (0.34, 0.62),
    "twisted_beam_thick_y": (-4.75, -4.82),
    "twisted_beam_thick_z": (-0.69, -0.75),
    "twisted_beam_thin_y": (0.04, -0.01),
    "twisted_beam_thin_z": (0.07, 0.01),
    "raasch_hook": (-6.77, -6.03),
    "hypar_100": (0.05, 1.60),
    "hypar_1000": (0.62, 3.56),
    "hypar_10000": (-14.80, 0.72),
    "skew_plate": (-0.85, 0.28),
    "circular_plate_clamped": (1.79, 1.63),
    "circular_plate_supported": (0.27, 0.20),
    "triangular_plate": (1.99, 1.43),
    "square_plate_uniform": (0.54, 0.57),
    "square_plate_centre": (3.04, 2.91),
    "cook_membrane": (-0.47, -0.25),
    "slit_cylinder_torque": (-0.27, 0.01),
}


# Largest errors in % at 16 cells per side on the three patterns; about a sixth more than measured, half for Gmsh's.
MODE_LIMITS = {
    "vibration_supported": (0.13, 0.37, 0.45),
    "fv12_free": (0.44, 0.05, 0.25),
    "fv15_rhombic": (4.1, 7.7, 7.5),
    "fv16_cantilever": (0.6, 0.95, 0.75),
    # Bending is too soft by as much; what chords take from the slopes with six_node hides it (0.85 % and 0.4 %).
    "buckling_supported": (3.5, 3.9, 3.8),
    "buckling_panel": (1.6, 2.1, 2.1),
}


@test
def mixed_statics(report):
    """Factors in single precision see what those in double see: the pivots of every step of a snap-through, its limit points, and
    large plates, which have them by default."""
    case = mesh_of("roof_isotropic_6.35", n_axial=8, n_circ=8)
    double, mixed = (solve(f"mixed_roof_{pc}", case, 1, ("-pc_type", pc)).history for pc in ("cholesky", "voile_mixed"))
    report.check(len(double["step"]) == len(mixed["step"]) and all(double["negative_pivots"] == mixed["negative_pivots"])
                 and max(double["negative_pivots"]) > 0, f"negative pivots of {len(mixed['step'])} steps are the same")
    found = [h["critical_load_factor"][~np.isnan(h["critical_load_factor"])] for h in (double, mixed)]
    report.below(np.abs(found[0] - found[1]).max(), 1e-9, f"{len(found[1])} critical load factors")
    large = plate(102, 1e5) | {"analysis": "linear"}
    view = {name: solve(f"mixed_plate_{name}", large, ranks, (*options, "-ksp_view"))
            for name, ranks, options in (("default", 2, ()), ("double", 1, ("-pc_type", "cholesky")), ("tuned", 1, ("-mat_mumps_icntl_14", "80")))}
    report.check([("voile_mixed" in r.text) for r in view.values()] == [True, False, False],
                 "single precision by default, but not where the factor in double is tuned")
    w = [r.history["centre_z"][-1] for r in view.values()]
    report.below(w[0] / w[1] - 1, 1e-7, "the same deflection")
    report.check(view["default"].summary["negative_pivots"] == 0, "a clamped plate is stable")


@test
def roofs(report):
    """Whole snap-through and snap-back paths at 16 x 16 cells: curves and limit loads within 1 %, on three patterns."""
    for name in ("roof_isotropic_6.35", "roof_90_0_90_6.35", "roof_0_90_0_12.7"):
        for pattern in (0, 1, 2) if name == "roof_isotropic_6.35" else (0,):
            case = mesh_of(name, n_axial=16, n_circ=16, pattern=pattern)
            result = solve(f"{name}_{pattern}", variant(case, {"steps.max_step": 2 * case["steps"]["max_step"]}))
            comparison = compare(BENCHMARKS[name], result.history)[0]
            report.below(comparison.curve_error, 0.01, f"{name}, pattern {pattern}, whole curve")
            report.check(len(comparison.limits) == 2, f"{len(comparison.limits)} limit loads")
            for computed, expected in comparison.limits:
                # The published one of the 0/90/0 roof is itself off: 1.40, 1.26, 1.18 % at 16, 20, 24 cells.
                report.percent(computed / expected, 0.015 if name == "roof_0_90_0_12.7" else 0.01, f"limit load {computed:.5g} against {expected:.5g}")


@test
def snap_back_by_displacement(report):
    """Where the displacement that is prescribed turns back, the path ends there: what comes after is said to be another one, unbroken or gone on with."""
    case = mesh_of("roof_isotropic_6.35", n_axial=8, n_circ=8)
    arc = solve("snap_back_arc", case)
    case["steps"]["control"] = "displacement"
    result = solve("snap_back", case)
    jumps = re.findall(r"load factor (\S+): control_probe turns back", result.text)
    limits = re.findall(r"limit point at load factor (\S+)", result.text)
    report.check(len(jumps) == 1 and len(limits) == 1, f"jumps said at {jumps}, limit points at {limits}")
    way = -arc.history["C_z"]
    turn = int(np.argmax(way[:-1] > way[1:]))  # the last state before the path turns back
    last = int(np.argmin(abs(result.history["load_factor"] - float(jumps[0] if jumps else 0))))
    near = slice(turn + 7, turn - 7, -1)  # where the load falls
    on_path = np.interp(result.history["load_factor"][last], arc.history["load_factor"][near], way[near])
    report.percent(-result.history["C_z"][last] / on_path, 0.001, "the last state before is on the path by arc length")
    report.below(1 - way[turn] / -result.history["C_z"][last], 0.01, "and where that turns back, short of it by")
    for step in (0.03, 0.08):
        coarse = solve(f"snap_back_{step}", case | {"steps": case["steps"] | {"initial_step": step, "max_step": step}})
        found = re.findall(r"limit point at load factor (\S+)", coarse.text)
        report.check(len(found) == 1 and "turns back" in coarse.text, f"steps of {step}: limit points at {found}")
    case["steps"]["max_steps"] = 10
    part = run(write_case(case, OUT / "snap_back_part.toml"), fresh("snap_back_part"))
    with h5py.File(part.folder / "checkpoint.h5") as file:
        report.check(file["path"].size == 5 and file["path_doubted"][0] > 0, "a checkpoint remembers the doubt beside what others have of a path")
    del case["steps"]["max_steps"]
    rest = solve("snap_back_rest", case, options=["--restart", part.folder / "checkpoint.h5"])
    report.check(part.code == 3 and rest.history["C_z"][-1] == result.history["C_z"][-1] and rest.history["load_factor"][-1] == result.history["load_factor"][-1],
                 f"gone on with after 10 steps: load factor {rest.history['load_factor'][-1]!r}, unbroken {result.history['load_factor'][-1]!r}")


@test
def cylinders(report):
    """Coarse meshes under displacement control: laminate semi-cylinder 20 x 20, cylinder pulled open 20 x 30."""
    for name, mesh, whole in (("semicylinder_90_0_90", {"n_axial": 20, "n_circ": 20}, 0.02),
                              # Points B of the published curve are off by 1.18 % here, by 1.15 % at 24 x 36 cells.
                              ("pullout_cylinder", {"n_axial": 20, "n_circ": 30}, 0.0125)):
        case = mesh_of(name, **mesh)
        result = solve(name, variant(case, {"steps.max_step": 2 * case["steps"]["max_step"]}))
        for c in compare(BENCHMARKS[name], result.history):
            report.below(c.curve_error, whole, f"{name}, {c.curve.label}, whole curve")


@test
def linear_course(report):
    """Every problem of runs/linear on its second mesh: the error is the one measured when it was entered here."""
    for name, expected in LINEAR_ERRORS.items():
        problem = LINEAR[name]
        mesh = {k: v * problem.factors[1] for k, v in problem.parameters}
        for pattern, error in zip((0, 2), expected):
            case = with_mesh(load_case(problem.case), pattern=pattern, **mesh)
            computed = 100 * (answer(problem, solve(f"linear_{name}_{pattern}", case, 1)) / problem.reference - 1)
            # Another version of Gmsh makes another unstructured mesh.
            band = max(0.1, 0.02 * abs(error)) if pattern == 0 else max(0.5, 0.25 * abs(error))
            report.near(computed, error, band, f"{name}, pattern {pattern}, error in %")


@test
def modes(report):
    """Vibration and buckling at 16 cells per side on three patterns: the worst mode is off by no more than measured."""
    for name, limits in MODE_LIMITS.items():
        problem = MODES[name]
        for pattern, limit in enumerate(limits):
            case = with_mesh(load_case(problem.case), pattern=pattern, **{k: 2 * v for k, v in problem.parameters})
            result = solve(f"{name}_{pattern}", case, 1 + (pattern == 1))
            error = computed_modes(problem, result) / problem.reference() - 1
            report.below(100 * float(np.abs(error).max()), limit, f"{name}, pattern {pattern}, worst mode, error in %")


@test
def restart(report):
    """A roof followed to its end, and again from a middle step on another number of ranks: the same end to 1e-6."""
    case = mesh_of("roof_isotropic_6.35", n_axial=8, n_circ=8)
    whole = solve("restart_whole", case, 2)
    middle = whole.summary["steps"] // 2
    for ranks in (1, 3):
        again = solve(f"restart_again_{ranks}", case, ranks,
                      ["--restart", whole.results.file, "--restart-step", str(middle)])
        difference = np.abs(again.displacement() - whole.displacement()).max() / np.abs(whole.displacement()).max()
        steps = whole.summary["steps"]
        report.below(difference, 1e-6, f"from step {middle} of {steps} on {ranks} rank(s), displacements")
        report.below(again.history["load_factor"][-1] / whole.history["load_factor"][-1] - 1, 1e-6, "load factor")


@test
def corrected_restart(report):
    """The same with the corrected membrane on a laminate, whose limit load is near that of the six-node one."""
    case = variant(mesh_of("roof_90_0_90_12.7", n_axial=8, n_circ=8), {"element": {"type": "corrected"}})
    whole = solve("corrected_restart_whole", case, 2)
    middle = whole.summary["steps"] // 2
    again = solve("corrected_restart_again", case, 3, ["--restart", whole.results.file, "--restart-step", str(middle)])
    difference = np.abs(again.displacement() - whole.displacement()).max() / np.abs(whole.displacement()).max()
    report.below(difference, 1e-6, f"from step {middle} of {whole.summary['steps']} on 3 ranks, displacements")
    plain = solve("corrected_restart_plain", variant(case, {"element": None}), 1)
    first = [result.summary["critical_points"][0]["load_factor"] for result in (whole, plain)]
    report.percent(first[0] / first[1], 0.02, "first limit load, against the six-node membrane")


@test
def newton_cost(report):
    """With the default steps: hemisphere in at most 25 factorisations at every mesh size, annulus in at most 35."""
    for n in (16, 32, 48):
        result = solve(f"cost_hemisphere_{n}", without_stops(base("hemisphere", mesh__parameters__n=n)))
        report.check(result.summary["factorisations"] <= 25, f"hemisphere {n}: {result.summary['factorisations']} factorisations")
    result = solve("cost_annulus", without_stops(base("slit_annulus")))
    report.check(result.summary["factorisations"] <= 35, f"annulus: {result.summary['factorisations']} factorisations")
    report.below(at_load(np.column_stack([result.history["load_factor"], result.history["B_z"]]), 1.0) / 17.528 - 1, 0.005,
                 "and w_B with these steps")


@test
def koiter_cylinder(report):
    """Axial load at which a cylinder with an axisymmetric imperfection branches: Koiter's formula for small amplitudes, its series for all."""
    study = drape_script("knock_down", "koiter")
    report.percent(study.bifurcation(1e-4) / study.koiter(1e-4), 1e-3, "the series tends to the formula")
    perfect = study.found(solve("koiter_perfect", study.case(0.0, 16, 0.1)))
    found = study.found(solve("koiter_imperfect", study.case(0.1, 32, 0.1)))
    report.percent(found / study.bifurcation(0.1), 0.05, f"amplitude 0.1: {found:.4g}, formula {study.koiter(0.1):.4g}")
    report.percent(perfect, 0.05, "the perfect cylinder")
