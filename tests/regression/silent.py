"""Answers that would be wrong silently: strains beyond curves, tangents at zero, natural strains, supports that move, restarts, decks."""

import math
import re

import numpy as np
from common import fresh, strip
from harness import OUT, solve, test
from hinges import strip as folded
from hinges import strip_case
from meshing import strip_cells
from panels import Panels
from shapes import write_msh
from solver import ROOT, invoke, run, variant, write_case

CURVE = """
name = "a"
description = "Round figures of a knit."
areal_density = "200 g/m^2"
tension_warp = { units = ["%", "N/m"], points = [[10, 20], [20, 80], [30, 400]] }
tension_weft = { units = ["%", "N/m"], points = [[10, 20], [20, 80], [30, 400]] }
membrane_shear = "30 N/m"
bending_warp = "0.1 gf.cm^2/cm"
bending_weft = "0.1 gf.cm^2/cm"
[sources]
areal_density = "x"
tension_warp = "x"
tension_weft = "x"
membrane_shear = "x"
bending_warp = "x"
bending_weft = "x"
"""


def fabric():
    OUT.mkdir(parents=True, exist_ok=True)
    (OUT / "knit.toml").write_text(CURVE)
    return {"type": "fabric", "fabric": str(OUT / "knit.toml"), "direction": [1, 0, 0]}


def pulled(length, end, **material):
    """A strip of `length` along x that is pulled until it has the length `end`; its width is free."""
    p = Panels()
    at = p.add("sheet", (0, 0, 0), (length, 0, 0), (0, length / 4, 0), 4, 1)
    p.point("corner", at[0, 0])
    held = lambda group, axes, **more: {"type": "displacement", "group": group, "components": axes} | more  # noqa: E731
    return {"analysis": "static", "mesh": {"file": str(p.write(OUT / f"pulled_{length}.msh"))}, "material": [fabric() | material],
            "support": [held("sheet start", ["x"]), held("corner", ["y"]), held("sheet", ["z"]), held("sheet end", ["x"], value=[end - length, 0, 0])],
            "steps": {"initial_step": 0.1, "max_step": 0.1}, "probe": [{"name": "pull", "type": "reaction", "group": "sheet end", "components": ["x"]}]}


@test
def strain_range(report):
    """A strain is too large beyond the curve of its material, or beyond 10 % without one, in linear analyses too; those say where they take tangents."""
    for end, words in ((1.25, ""), (1.3, ""), (1.35, "a strain along the warp of 32 % at ")):
        text = solve("range", pulled(1.0, end)).text
        report.check(words in text and "its measured curve has ended" in text if words else "a strain" not in text and "membrane strain" not in text, f"pulled to {end}: {text[-300:] if words else 'no warning'}")
    stretched = strip("linear", nx=4, ny=1, load=[{"type": "line", "group": "tip", "vector": [2e4, 0, 0]}])
    report.check("a membrane strain of 17 %" in solve("range_linear", stretched).text, "a linear analysis warns of its strain")
    for analysis, more, expected in (("linear", {}, True), ("modal", {"eigen": {"modes": 1}}, True), ("static", {}, False),
                                     ("linear", {"material": [fabric() | {"initial_strain": [-0.02, -0.02]}]}, False)):
        code, text = invoke(["check", write_case(pulled(1.0, 1.1) | {"analysis": analysis} | more, OUT / "tangent.toml")])
        report.check(code == 0 and ("tangent at zero strain" in text) == expected, f"{analysis}: code {code}, tangent at zero {'said' if expected else 'not said'}")
    code, text = invoke(["check", write_case(pulled(1.0, 1.1) | {"output": {"stresses": "surface"}}, OUT / "stresses.toml")])
    report.check(code == 2 and "output.stresses" in text and "membrane_force" in text, f"stresses of a fabric: code {code}")


@test
def shrunk_curve(report):
    """A fabric that has shrunk by 4 % pulls as one that was cut 4 % smaller, along its steep curve."""
    small, shrunk = solve("cut_small", pulled(0.96, 1.2)), solve("cut_shrunk", pulled(1.0, 1.2, initial_strain=[-0.04, -0.04]))
    report.percent(shrunk.history["pull_x"][-1] / small.history["pull_x"][-1], 1e-6, f"force {small.history['pull_x'][-1]:.4g} N")
    free = pulled(1.0, 1.0, initial_strain=[-0.35, -0.35])
    free["support"].pop()
    free |= {"load": [{"type": "line", "group": "sheet end", "vector": [1, 0, 0]}], "probe": [{"name": "end", "type": "displacement", "group": "sheet end", "components": ["x"]}]}
    done = solve("shrunk_free", free)
    report.near(done.history["end_x"][0], -0.35, 1e-6, "nothing holds it: it shrinks before the first step")
    report.check("has ended" not in done.text, "and no strain of the way there is warned of")


@test
def explicit_stiffening(report):
    """Central differences follow a fabric that becomes 500 times as stiff while it is pulled."""
    case = strip("dynamic", nx=6, ny=2, load=[], time={"end": 0.4, "step": 1e-2, "method": "central_difference"}, material=[{
        "type": "matrices", "membrane": [[100, 0, 0], [0, 100, 0], [0, 0, 50]], "bending": [[1e-3, 0, 0], [0, 1e-3, 0], [0, 0, 1e-3]],
        "areal_density": 0.2, "direction": [1, 0, 0], "stiffening_warp": [0.0, 1e6, 0.05, -1e6]}])
    case["support"] = [{"type": "hinged", "group": "clamp"}, {"type": "displacement", "group": "tip", "components": ["x", "y", "z"], "motion": ["table(t, 0, 0, 0.4, 0.5)", "0", "0"]}]
    case["damping"] = {"mass": 20.0}
    case["output"] = {"every": 1000}
    result = solve("explicit_stiffening", case)
    report.check("has become stiffer" in result.text and result.history["time"][-1] == 0.4, f"{len(result.history['time'])} steps to the end")
    for steps in (6, 40):
        run(OUT / "explicit_stiffening.toml", fresh("explicit_part"), 1, ["-ts_max_steps", str(steps)])
        again = run(OUT / "explicit_stiffening.toml", fresh("explicit_again"), 1, ["--restart", OUT / "explicit_part" / "checkpoint.h5"]).history
        h = result.history
        other = [name for name in h.names if name != "wall_seconds" and not np.array_equal(again[name][1:], h[name][steps + 1:], equal_nan=True)]
        report.check(again["step"][0] == steps and not other, f"a restart at step {steps} is the unbroken run to the bit; other columns are {other}")


@test
def moving_supports(report):
    """What is held and moves has its energy, and supports carry the damping of what they hold."""
    case = strip("dynamic", nx=4, ny=1, load=[], time={"end": 1.0, "step": 0.05, "velocity_tolerance": 1e-9})
    case["support"] = [{"type": "displacement", "group": "plate", "components": ["x", "y", "z"], "motion": ["0.5*t^2", "0", "0"]}]
    case["damping"] = {"mass": 3.0}
    case["probe"] = [{"name": "hold", "type": "reaction", "group": "plate", "components": ["x"]}]
    mass = 10 * 0.1 * 100
    for method in ("alpha", "central_difference"):
        h = solve(f"moved_{method}", variant(case, {"time.method": method, "output": {"energy_balance": True}, "time.velocity_tolerance": 1e-9 if method == "alpha" else None})).history
        report.percent(h["kinetic_energy"][-1] / (mass / 2), 0.002, f"{method}: kinetic energy of what is held")
        report.percent(h["hold_x"][-1] / (mass * (1 + 3)), 0.01 if method == "alpha" else 0.03, "inertia and damping of what is held")
        if method == "alpha":
            report.below(h["energy_unaccounted"][-1] / (mass / 2), 1e-9, "energy unaccounted for")
    swung = variant(case, {"support.0.motion": ["0.1*sin(6*t)", "0", "0"], "damping": None, "time.step": 0.01, "output": {"every": 1}})
    h = solve("swung", swung).history
    for k, where in ((0, "first"), (-1, "last")):
        report.below(abs(h["hold_x"][k] + 3.6 * mass * math.sin(6 * h["time"][k])) / (3.6 * mass), 0.006, f"inertia of what is held in the {where} row")

    within = variant(swung, {"support.0.motion": ["(t < 0) || (t > 1.0000001) ? 1e9 : 0.1*t^2", "0", "0"]})
    h = solve("within", within).history
    for k, where in ((0, "first"), (-1, "last")):
        report.percent(h["hold_x"][k] / (0.2 * mass), 0.01, f"a motion that is not defined outside the run: {where} row")
    free = strip("dynamic", nx=4, ny=1, time={"end": 0.1, "step": 1e-3, "mass": "consistent", "velocity_tolerance": 1e-9}, output={"every": 1},
                 probe=[{"name": "hold", "type": "reaction", "group": "clamp", "components": ["z"]}])
    done = solve("coupled", free)
    mesh = done.results[-1].mesh
    corners = np.asarray(mesh.positions)[np.asarray(mesh.triangles)]
    areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    masses = np.zeros(len(mesh.positions))
    np.add.at(masses, np.asarray(mesh.triangles), (10 * areas / 3)[:, None])
    momentum = np.array([masses @ np.asarray(step["velocity"])[:, 2] for step in done.results])
    rate, hold = np.gradient(momentum, 1e-3)[2:-1], np.asarray(done.history["hold_z"])[2:-1]
    report.below(np.abs(hold + 0.4 - rate).max() / np.abs(rate).max(), 0.002, "consistent mass: load and reaction are the rate of momentum")


@test
def held_velocities(report):
    """What is held moves at the speed of its motion, from the first step, after corners too: so it flies on when it is let go."""
    def flies(name, motion, release, method=None, **changes):
        case = strip("dynamic", nx=4, ny=1, load=[], support=[{"type": "displacement", "group": "plate", "components": ["x", "y", "z"],
                                                             "motion": ["0", "0", motion], "release": release}],
                     time={"end": 0.02, "step": 0.001} | (method or {}), output={"energy_balance": True}, **changes)
        h = solve(f"held_{name}", case).history
        return (h["tip_z"][-1] - h["tip_z"][-2]) / (h["time"][-1] - h["time"][-2]), h

    for name, method in (("alpha", {}), ("undamped", {"spectral_radius": 1.0}), ("central", {"method": "central_difference"})):
        for steps in (1, 2, 3):
            speed, h = flies(f"{name}_{steps}", "t", 0.001 * steps, method)
            report.below(abs(speed - 1), 1e-6, f"{name}: speed after {steps} step(s) at 1 m/s")
        report.below(abs(h["energy_unaccounted"]).max() / h["kinetic_energy"][-1], 1e-9, f"{name}: energy that is not accounted for")
    for release, wanted in ((0.006, 0.0), (0.003, 2.0)):
        speed, h = flies("corner", "table(t, 0, 0, 0.005, 0.01, 1, 0.01)", release, {"spectral_radius": 1.0})
        report.below(abs(speed - wanted), 1e-6, f"released at {release} s, a corner at 0.005 s: speed")
    speed, h = flies("drag", "t", 1.0, {"spectral_radius": 1.0}, air={"normal_drag": 1.5})
    # All of a plate at 1 m/s: the power of the drag is that of a quadratic law.
    power = np.diff(h["drag_loss"]) / np.diff(h["time"])
    report.below(np.ptp(power) / power.mean(), 1e-9, f"power of the drag on a sheet that is moved, {power.mean():.4g} W in every step: spread")


@test
def said_differences(report):
    """A restart names what of the sheet is another one; results as a start say what they leave out."""
    case = strip("dynamic", nx=4, ny=1, output={"every": 1})
    first = solve("said_first", case)
    cloth = strip("dynamic", nx=4, ny=1, material=[fabric()])
    woven = solve("said_woven", cloth)
    done = solve("said_turned", variant(cloth, {"material.0.warp_angle": 45, "time.end": 0.25}), options=["--restart", woven.folder / "checkpoint.h5"])
    report.check("[material]: fabric or warp_angle, with" in done.text, "another warp_angle")
    hangs = strip("drape", nx=4, ny=1, time=None, load=[{"type": "gravity", "vector": [0, 0, -9.81]}], contact={}, drape={"max_iterations": 5})
    for name, limit, words in (("searching", 5, True), ("hung", 1000, False)):
        hangs["drape"]["max_iterations"] = limit
        part = run(write_case(hangs, OUT / f"said_{name}.toml"), fresh(f"said_{name}"))
        hangs["drape"]["max_iterations"] = 1000
        done = solve(f"said_{name}_on", hangs, options=["--restart", part.folder / "checkpoint.h5"])
        report.check(part.code == (3 if words else 0) and ("a drape searches anew" in done.text) == words, f"a drape, {name}: code {part.code}, {'said' if words else 'not said'}")
    for name, options, change, words in (("same", ["checkpoint.h5"], {}, ""), ("material", ["checkpoint.h5"], {"material.0.young": 2e6}, "[material]: young 1200000.0, here 2000000.0"),
                                         ("results", ["results.vtkhdf"], {}, "have no accelerations")):
        done = solve("said_again", variant(case, change | {"time.end": 0.25}), options=["--restart", first.folder / options[0]])
        report.check(words in done.text if words else "note: --restart" not in done.text, f"{name}: {[line for line in done.text.splitlines() if '--restart' in line]}")
    same = solve("said_same_units", variant(case, {"units": {"length": "m"}, "time.end": 0.25}), options=["--restart", first.folder / "checkpoint.h5"])
    report.check("another [units]" not in same.text, "SI in words is no other system")
    other = write_case(variant(case, {"units": {"time": "ms"}}), OUT / "said_units_of_time.toml")
    code, text = invoke(["run", other, "--output", OUT / "said_units_of_time", "--overwrite", "--restart", first.folder / "checkpoint.h5"])
    report.check(code == 2 and "its run had another [units]" in text, f"other units: code {code}: {text.strip()[-150:]}")


@test
def said_against(report):
    """A path that has to begin against its loads, because they move the probe away from the end that is wanted, says so."""
    for end, wanted in ((0.5, False), (-0.5, True)):
        case = strip(nx=8, ny=1, steps={"control": "displacement", "control_probe": "up", "final_displacement": end},
                     probe=[{"name": "up", "type": "displacement", "group": "tip", "components": ["z"]}])
        done = solve("said_against", case)
        report.check(("load factors decrease" in done.text) == wanted and done.history["load_factor"][-1] * end > 0, f"to {end}: load factor {done.history['load_factor'][-1]:.3g}")
    case["steps"] |= {"control": "arc_length", "max_steps": 3}
    done = run(write_case(case, OUT / "said_against_arc.toml"), fresh("said_against_arc"))
    report.check("reverse the loads" in done.text and min(done.history["load_factor"][1:]) > 0, f"by arc length they begin as they are given: {done.history['load_factor']}")


@test
def said_lowest_modes(report):
    """Modes about an unstable state are the lowest, not those nearest to zero; there are as many negative ones as negative pivots."""
    stiffness, n = 7e10 * 1e-6 / 12 / 0.91, 20
    force = 5 * 4 * math.pi**2 * stiffness
    case = {"analysis": "modal", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"side": 1, "n": n}},
            "material": [{"type": "isotropic", "young": 7e10, "poisson": 0.3, "thickness": 1e-2, "density": 2700.0}],
            "support": [{"type": "displacement", "group": ["left", "right", "top", "bottom"], "components": ["z"]},
                        {"type": "displacement", "group": "centre", "components": ["x", "y"]}, {"type": "displacement", "group": "right", "components": ["y"]}],
            "load": [{"type": "line", "group": side, "vector": [sign * force, 0, 0]} for side, sign in (("left", 1), ("right", -1))]}
    exact = sorted((stiffness * math.pi**4 * (i * i + k * k)**2 - force * math.pi**2 * i * i) / 27 for i in range(1, 9) for k in range(1, 9))
    for ranks, count in ((1, 1), (2, 8)):
        done = solve("said_lowest", case | {"eigen": {"modes": count, "load_factor": 1.0}}, ranks)
        values = np.loadtxt(done.folder / "modes.csv", delimiter=",", skiprows=1, ndmin=2)[:, 2]
        report.check(f"{sum(np.array(exact) < 0)} mode(s) grow" in done.text, "the equilibrium is said to be unstable")
        report.percent(values[0] / exact[0], 0.2, f"{count} mode(s) on {ranks} rank(s): the lowest eigenvalue, {values[0]:.4g} 1/s^2")
        if count == 8:
            report.check(sum(values < 0) == sum(np.array(exact) < 0) == done.history["negative_pivots"][-1], f"{sum(values < 0)} are negative")
    # A follower load of no size makes the matrix unsymmetric.
    turning = case | {"load": case["load"] + [{"type": "follower_pressure", "magnitude": 1e-9}], "eigen": {"modes": 2, "load_factor": 1.0}}
    done = solve("said_lowest_turning", turning)
    other = np.loadtxt(done.folder / "modes.csv", delimiter=",", skiprows=1, ndmin=2)[:, 2]
    report.percent(other[0] / values[0], 1e-6, f"the lowest beside a follower load, {other[0]:.4g} 1/s^2")
    report.check("at least 2 mode(s) grow" in done.text, "which is said to grow")


@test
def said_buckling(report):
    """Linear buckling is by the stress that a load makes: what bends before it buckles has no modes below those of its path."""
    rise, span, n = 0.03, 0.4, 40
    arch = OUT / "said_arch.msh"
    points, cells = strip_cells(n, 8, span, 0.1, 0.0)
    points[:, 2] = rise * np.sin(math.pi * points[:, 0] / span)  # on which an even load bends
    sides = [(name, 1, [(j * (n + 1) + i, (j + 1) * (n + 1) + i) for j in range(8)]) for name, i in (("left", 0), ("right", n))]
    write_msh(arch, points, [*sides, ("arch", 2, np.array(cells))])
    case = {"analysis": "static", "mesh": {"file": str(arch)}, "material": [{"type": "isotropic", "young": 7e10, "poisson": 0.3, "thickness": 1e-3}],
            "support": [{"type": "hinged", "group": ["left", "right"]}], "load": [{"type": "area", "vector": [0, 0, -5e3]}],
            "steps": {"control": "arc_length", "initial_step": 0.05, "max_step": 0.1, "final_load_factor": 1.0, "at_critical_point": "stop"}}
    path = solve("said_arch_path", case)
    first = path.summary["critical_points"][0]["load_factor"]
    for start, limit in ((0.0, 0.04), (0.9 * first, 0.002)):
        linear = solve("said_arch", case | {"analysis": "buckling", "eigen": {"modes": 1, "load_factor": start}, "steps": {}})
        report.percent(linear.summary["eigenvalues"][0] / first, limit, f"shallow arch from a factor of {start:.3g}: of its path's {first:.4g}")
        report.check(("out of proportion" in linear.text) == (start == 0.0), "a warning where it deflects far on the way")
    # With a hinge at its crown it deflects as much as its rise before it snaps through.
    crown = ("crown", 1, [(j * (n + 1) + n // 2, (j + 1) * (n + 1) + n // 2) for j in range(8)])
    write_msh(arch, points, [*sides, crown, ("arch", 2, np.array(cells))])
    case["hinge"] = [{"group": "crown", "stiffness": 1e-6}]
    first = solve("said_crown_path", case).summary["critical_points"][0]["load_factor"]
    for start in (0.0, 0.98 * first):
        linear = solve("said_crown", case | {"analysis": "buckling", "eigen": {"modes": 1, "load_factor": start}, "steps": {"max_step": 0.02, "initial_step": 0.02}})
        off = linear.summary["eigenvalues"][0] / first - 1
        report.check((abs(off) > 0.05) == ("out of proportion" in linear.text), f"with a hinge at its crown, from {start:.3g}: off by {100 * off:.1f} %, of {first:.4g}")
    bent = strip("buckling", load=[{"type": "line", "group": "tip", "vector": [0, 0, 0.4]}], eigen={"modes": 2})
    done = run(write_case(bent, OUT / "said_bent.toml"), fresh("said_bent"))
    report.check(done.code == 3 and "0 of 2 modes found" in done.text, f"a cantilever that only bends: code {done.code}, {done.text[-200:]}")
    # Turned in space its forces are not exact zeros, and the loads that they would make are none.
    leaning = bent | {"mesh": bent["mesh"] | {"rotate": [20, 30, 40]}, "load": [{"type": "pressure", "magnitude": 0.1}]}
    done = run(write_case(leaning, OUT / "said_leaning.toml"), fresh("said_leaning"))
    report.check(done.code == 3 and "0 of 2 modes found" in done.text, f"and turned in space: code {done.code}, {done.summary.get('eigenvalues')}")
    ply = {"type": "laminate", "young_1": 1e11, "young_2": 1e10, "poisson_12": 0.3, "shear_12": 5e9, "angles": [0, 90],
           "ply_thicknesses": [1e-3, 1e-3], "direction": [1, 0, 0]}
    bent["material"] = [ply]
    done = solve("said_bent", bent)
    # What its cells leave of forces that cancel.
    report.check(done.summary["eigenvalues"][0] > 5 and "cells do not resolve" in done.text, f"and one that stretches as it bends, far away: {done.summary['eigenvalues']}")
    # A force beside the axis of a column, on a rigid end: the same load as along the axis, and a moment that bends.
    rigid = {"group": "tip", "turn": "about", "turn_axis": [0, 1, 0], "force": [-1e-3, 0, 0]}
    column = strip("buckling", eigen={"modes": 1})
    del column["load"], column["probe"]
    loads = [solve("said_lever", column | {"rigid": [rigid | more]}).summary["eigenvalues"][0] for more in ({}, {"moment": [0, -1e-5, 0]})]
    report.below(abs(loads[1] / loads[0] - 1), 1e-4, f"a column with a lever: {loads}")
    tied = strip("buckling", load=[{"type": "line", "group": "tip", "vector": [0, 0, 0.4]}], eigen={"modes": 1},
                 spring=[{"type": "pair", "group": "tip", "to": "clamp", "stiffness": 1e4}])
    done = run(write_case(tied, OUT / "said_tied.toml"), fresh("said_tied"))
    report.check(done.code == 3 or done.summary["eigenvalues"][0] > 5, f"a cantilever with stiff springs along it only bends: code {done.code}")
    pulled = {"type": "pair", "group": "tip", "to": "clamp", "stiffness": 10.0, "length": 9.99}
    found = []
    for start in (0.0, 1e-6):
        column = strip("buckling", load=[{"type": "line", "group": "tip", "vector": [-1e-3, 0, 0]}], spring=[pulled], eigen={"modes": 1, "load_factor": start})
        found.append(solve("said_pulled", column).summary["eigenvalues"][0])
    report.below(abs(found[0] / found[1] - 1), 1e-5, f"a column that a spring presses: {found}")


@test
def said_flutter(report):
    """A moment of fixed direction at the end of a blade has no potential: its two lowest modes become one that grows, which is none of buckling."""
    blade = {"mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"nx": 20, "ny": 2, "length": 1.2, "width": 0.06}},
             "material": [{"type": "isotropic", "young": 7e10, "poisson": 0.3, "thickness": 2e-3, "density": 2700.0}],
             "support": [{"type": "clamped", "group": "clamp"}], "rigid": [{"group": "tip", "moment": [0, 0, 1]}]}
    for factor, complex_modes in ((1.0, 0), (15.0, 2)):
        done = solve("said_flutter", blade | {"analysis": "modal", "eigen": {"modes": 4, "load_factor": factor}, "steps": {"initial_step": factor / 4, "max_step": factor / 4}})
        report.check((f"{complex_modes} mode(s) are complex" in done.text) == (complex_modes > 0), f"at {factor:g} N m: {done.summary['eigenvalues']}")
    done = run(write_case(blade | {"analysis": "buckling", "eigen": {"modes": 2}}, OUT / "said_flutter_buckling.toml"), fresh("said_flutter_buckling"))
    report.check(done.code == 3 and "0 of 2 modes found" in done.text, f"no critical load: code {done.code}")


@test
def said_mirrors(report):
    """Edges of a flat sheet that run in two directions have no mirror plane; a mass weighs where gravity acts on its vertex; a restarted mesh has the lists of groups."""
    plate = {"analysis": "linear", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"side": 0.5, "n": 4}},
             "material": [{"type": "isotropic", "young": 7e10, "poisson": 0.3, "thickness": 5e-3, "density": 2700.0}],
             "support": [{"type": "clamped", "group": "right"}, {"type": "symmetry", "group": ["left", "bottom"]}],
             "load": [{"type": "pressure", "magnitude": 100.0}], "output": {"fields": ["displacement"]}}
    code, text = invoke(["run", write_case(plate, OUT / "said_mirrors.toml"), "--output", OUT / "said_mirrors", "--overwrite"])
    report.check(code == 2 and "write a [[support]] for each straight edge" in text, f"two edges in one mirror: code {code}, {text.strip()[-160:]}")
    heavy = variant(plate, {"support": [{"type": "clamped", "group": "right"}], "mass": [{"group": "centre", "mass": 1.0}],
                            "load": [{"type": "gravity", "group": "plate", "vector": [0, 0, -10.0]}], "output": {},
                            "probe": [{"name": "hold", "type": "reaction", "group": "right", "components": ["z"]}]})
    report.near(solve("said_weight", heavy).history["hold_z"][-1], 10 * (1 + 0.25 * 5e-3 * 2700), 1e-6, "weight of sheet and mass [N]")
    case = strip(nx=8, remesh={"angle": 5.0, "smallest": 0.1, "largest": 1.0})
    whole = solve("said_remeshed", case)
    more = write_case(variant(case, {"support.0.group": ["clamp"], "steps.final_load_factor": 1.1,
                                     "probe": [{"name": "ends", "type": "reaction", "group": ["tip", "clamp"]}]}), OUT / "said_listed.toml")
    again = run(more, fresh("said_listed"), 1, ["--restart", whole.folder / "results.vtkhdf"])
    report.check(again.code == 0, f"a list of groups on a remeshed mesh: code {again.code}" + again.text[-300:] * (again.code != 0))


@test
def said_created(report):
    """Energy that one step creates is reported although later steps have taken more than that."""
    case = {"analysis": "dynamic", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"side": 0.3, "n": 12}},
            "material": [{"type": "isotropic", "young": 5e6, "poisson": 0.3, "thickness": 5e-4, "density": 400.0, "initial_strain": [-0.02, -0.02, 0.0]}],
            "time": {"end": 0.06, "step": 2e-3}}
    done = solve("said_created", case)
    loss = done.history["numerical_loss"]
    created = max(np.maximum.accumulate(loss) - loss)
    told = re.search(r"has created ([\d.e+-]+) J", done.text)
    initial = done.summary["energy"]["initial_energy"]
    report.check(created > initial and abs(loss[-1]) < 0.05 * initial, f"created {created:.3g} J beside {initial:.3g} J, then taken again to {-loss[-1]:.3g} J")
    report.check(told and abs(float(told[1]) / created - 1) < 0.01, f"reported: {told and told[0]}")


@test
def said_names(report):
    """Names that the mesh does not have, with line and the nearest one, all at once; units; hinges that nothing holds; a turn beyond a whole one."""
    wrong = strip(nx=4, ny=1, support=[{"type": "clamped", "group": "clmap"}], contact={"distance": 1e-3},
                  contact_rule=[{"first": "tipp", "second": "sheet", "ignore": True}, {"first": "clamp", "second": "bal", "ignore": True}])
    code, text = invoke(["check", write_case(wrong, OUT / "said_names.toml")])
    report.check(code == 2 and all(w in text for w in ("did you mean 'clamp'?", "did you mean 'tip'?", "'bal'", ".toml:")), f"three names: code {code}, {text}")
    code, text = invoke(["check", write_case(strip(nx=4, ny=1) | {"units": {"mass": "tt"}}, OUT / "said_units.toml")])
    report.check(code == 2 and "ft" not in text and "valid: kg" in text, f"unit of mass: {text.strip()}")
    loose = strip_case(folded(OUT / "said_hinge.msh", 2))
    loose["hinge"].append({"group": "free end", "stiffness": 1.0})
    code, text = invoke(["check", write_case(loose, OUT / "said_hinge.toml")])
    report.check(code == 0 and "'free end': 2 of its edges lie on the boundary where nothing holds" in text, f"a hinge that nothing holds: code {code}")
    turned = strip(nx=4, ny=1, load=[], steps={"initial_step": 0.05, "max_step": 0.05}, support=[],
                   rigid=[{"group": "plate", "name": "plate", "translation": [0, 0, 0], "turn": "about", "turn_axis": [0, 0, 1], "turn_angle": "500*t"}], probe=[])
    report.near(solve("said_turn", turned).history["plate_turn_z"][-1], math.radians(500), 1e-9, "a prescribed turn")


@test
def rigid_inertia(report):
    """A strip whose end is a rigid line takes part in turning as one with a free end."""
    case = strip("modal", nx=8, ny=2, load=[], probe=[], eigen={"modes": 2})
    tables = [np.genfromtxt(solve("rigid_inertia", case | more).folder / "modes.csv", delimiter=",", names=True)
              for more in ({}, {"rigid": [{"group": "tip", "name": "end"}]})]
    for column in ("effective_mass_z", "effective_inertia_y"):
        free, rigid = (table[column][0] for table in tables)
        report.percent(rigid / free, 0.01, f"{column} of the first mode, {free:.4g} without")


SHELL = ("SOL 106\nCEND\nBEGIN BULK\nGRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\n"
         "CQUAD4,1,5,1,2,3,4,30.\nSPC1,1,123456,1,4\nFORCE,1,2,,1.,0.,0.,1.\n")
PLY = "MAT8,7,140.+9,10.+9,.3,5.+9,,,1600.\n"


def converted(deck):
    file, folder = OUT / "silent.bdf", fresh("silent_deck")
    file.write_text(deck + "ENDDATA\n")
    code, text = invoke(["init", folder, "--from", file])
    return code, text + ((folder / "case.toml").read_text() if code == 0 else "")


@test
def nastran_silent(report):
    """Decks: twofold cards, offsets and thicknesses of elements are refused; MAT8 and PCOMP are read in the axes of elements; LGDISP decides."""
    shell = "PSHELL,5,7,.001,7\n"
    OUT.mkdir(parents=True, exist_ok=True)
    for name, deck, expected, words in (
            ("material", SHELL + shell + PLY + PLY, 2, ("MAT8: material 7 is there twice, first in", ".bdf:12")),
            ("property", SHELL + shell + shell + PLY, 2, ("PSHELL: property 5 is there twice",)),
            ("offset", SHELL.replace(",30.\n", ",30.,.01\n") + shell + PLY, 2, ("ZOFFS = .01",)),
            ("thickness", SHELL.replace(",30.\n", ",30.\n,,,.002,.002,.002,.002\n") + shell + PLY, 2, ("T1 = .002", "PSHELL")),
            ("eight nodes", SHELL.replace("CQUAD4,1,5,1,2,3,4,30.", "CQUAD8,1,5,1,2,3,4\n,,,,,,,30.,.01") + shell + PLY, 2, ("CQUAD8: ZOFFS = .01",)),
            ("their thickness", SHELL.replace("CQUAD4,1,5,1,2,3,4,30.", "CQUAD8,1,5,1,2,3,4\n,,,.002,.002,.002,.002,30.") + shell + PLY, 2, ("CQUAD8: T1 = .002",)),
            ("own thickness", SHELL.replace(",30.\n", ",30.\n,,,.001,.001,.001,.001\n") + shell + PLY, 0, ('type = "orthotropic"',)),
            ("shell", SHELL + shell + PLY, 0, ('analysis = "linear"', "without PARAM,LGDISP,1", 'type = "orthotropic"', "direction = [0.866", "shear_12 = 5000000000")),
            ("large", SHELL + shell + PLY + "PARAM,LGDISP,1\n", 0, ('analysis = "static"',)),
            ("laminate", SHELL + "PCOMP,5,,,,,,,SYM\n,7,.00025,0.,,7,.00025,90.\n" + PLY, 0, ('type = "laminate"', "angles = [0, 90, 90, 0]", "ply_thicknesses = [0.00025")),
            ("strengths", SHELL + shell + PLY + ",,,,1500.+6,1500.+6,40.+6,246.+6,68.+6\n", 0, ("MAT8 7: strengths",)),
            ("beside", SHELL + "PCOMP,5,0.\n,7,.00025,0.,,7,.00025,90.\n" + PLY, 2, ("Z0 = 0.",)),
            ("axes", SHELL.replace("CQUAD4,1,5,1,2,3,4,30.", "CTRIA3,1,5,1,2,3,0.\nCTRIA3,2,5,1,3,4,0.") + shell + PLY, 0, ("material axes (THETA, MCID) that differ",))):
        code, text = converted(deck)
        report.check(code == expected and all(w in text for w in words), f"{name}: code {code}{'' if code == expected and all(w in text for w in words) else ', ' + text}")


@test
def deck_loads(report):
    """Decks: loads on one place add up; what is selected and missing is refused; plies of elements that are turned round are named."""
    head = "SOL 101\nCEND\nSPC = 1\nLOAD = 2\nBEGIN BULK\n" + SHELL[SHELL.index("GRID,1"):] + "PSHELL,5,7,.001,7\n" + PLY
    for name, deck, expected, words in (
            ("twice", head + "FORCE,2,3,0,1.,0.,0.,1.\n" * 2, 0, ("vector = [0, 0, 2]",)),
            ("together", head.replace("LOAD = 2", "LOAD = 9") + "LOAD,9,1.,1.,2,2.,3\nFORCE,2,3,0,1.,0.,0.,1.\nFORCE,3,3,0,1.,0.,0.,1.\n", 0, ("vector = [0, 0, 3]",)),
            ("pressures", head + "PLOAD4,2,1,.5\nPLOAD4,2,1,.5\n", 0, ("magnitude = 1 ",)),
            ("drilling left free", head.replace("123456,1,4", "12345,1,4") + "GRAV,2,0,1.,0.,0.,1.\n", 0, ('type = "clamped"',)),
            ("the turn about an edge left free", head.replace("123456,1,4", "12346,1,4") + "GRAV,2,0,1.,0.,0.,1.\n", 0, ('type = "hinged"', "rotations held in part")),
            ("the turn across an edge left free", head.replace("123456,1,4", "12356,1,4") + "GRAV,2,0,1.,0.,0.,1.\n", 0, ('type = "symmetry"', 'components = ["y", "z"]')),
            ("no load", head.replace("LOAD = 2", "LOAD = 99"), 2, ("LOAD: there is no card LOAD of set 99",)),
            ("no part", head + "LOAD,2,1.,1.,77\n", 2, ("no card LOAD of set 77",)),
            ("no support", head.replace("SPC = 1", "SPC = 99") + "GRAV,2,0,1.,0.,0.,1.\n", 2, ("SPC: there is no card SPC of set 99",)),
            ("three constants", head.replace(PLY, "MAT1,7,70.+9,20.+9,.3\n") + "GRAV,2,0,1.,0.,0.,1.\n", 0, ("MAT1 7, G = 20.+9: E and NU are taken, which give 2.692e+10",)),
            ("a band of modes", head.replace("SOL 101", "SOL 103").replace("LOAD = 2", "METHOD = 8") + "EIGRL,8,10.,500.,3\n", 0, ("EIGRL, a bound of 10.", "EIGRL, a bound of 500.", "modes = 3")),
            ("turned", (head + "GRAV,2,0,1.,0.,0.,1.\nGRID,5,,2.,0.,0.\nGRID,6,,2.,1.,0.\nCQUAD4,2,5,2,3,6,5,30.\n").replace(",30.", ",0").replace("PSHELL,5,7,.001,7\n", "PCOMP,5,,,,,,,\n,7,.00025,0.,,7,.00025,90.\n"),
             0, ("plies and angles are reversed",))):
        code, text = converted(deck)
        report.check(code == expected and all(w in text for w in words), f"{name}: code {code}{'' if code == expected and all(w in text for w in words) else ', ' + text}")
