"""Imperfections by modes of a stage of the same case, in mirror planes, and of a cap that collapses."""

import math

import numpy as np
from common import drape_script, fresh, plate, strip
from harness import OUT, Failure, solve, test
from solver import ROOT, Result, invoke, run, write_case

AMPLITUDES = [1e-3, -2e-4]


MODES = {"type": "modes", "stage": "buckle", "modes": [1], "amplitudes": [1e-3]}
BUCKLE = {"name": "buckle", "analysis": "buckling", "eigen": {"modes": 2}}
PATH = {"name": "path", "analysis": "static"}


def column():
    return strip(nx=20, ny=2) | {
        "support": [{"type": "hinged", "group": "clamp"}, {"type": "displacement", "group": "tip", "components": ["y", "z"]}],
        "load": [{"type": "line", "group": "tip", "vector": [-1, 0, 0]}],
        "probe": [{"name": "middle", "type": "displacement", "point": [5, 0.5, 0], "components": ["z"]}]}


def path(end):
    return {"final_load_factor": end, "stops": [4.0], "initial_step": 2.0, "max_step": 2.0}


def staged(end=8.0, *later, **changes):
    """Buckling, then a path on the shape that is imperfect by two of its modes."""
    case = column() | {
        "imperfection": [{"type": "modes", "stage": "buckle", "modes": [1, 2], "amplitudes": AMPLITUDES}],
        "stage": [{"name": "buckle", "analysis": "buckling", "eigen": {"modes": 2}},
                  {"name": "path", "analysis": "static", "steps": path(end)}, *later]} | changes
    del case["analysis"]
    return case


def stage_of(result, name):
    return Result(result.folder / name, result.code, result.text, 0.0)


def largest(a, b):
    return float(np.abs(a - b).max() / np.abs(b).max())


def same_mesh(a, b):
    return largest(a.results[-1].mesh.positions, b.results[-1].mesh.positions)


@test
def imperfect_stages(report):
    """Buckling and a path on the imperfect shape as stages are the two runs by hand; ranks, --from, --restart and a stage more."""
    modes = solve("imperfect_buckle", column() | {"analysis": "buckling", "eigen": {"modes": 2}})
    by_hand = column() | {"steps": path(8.0), "imperfection": [
        {"type": "modes", "results": str(modes.folder), "modes": [1, 2], "amplitudes": AMPLITUDES}]}
    alone = solve("imperfect_path", by_hand)
    both = solve("imperfect_stages", staged())
    in_path = stage_of(both, "path")
    report.check([s["name"] for s in both.summary["stages"]] == ["buckle", "path"] and both.summary["converged"], "summary.json lists both stages")
    report.below(same_mesh(in_path, alone), 1e-12, "the imperfect shape and that of two runs by hand")
    report.below(largest(in_path.displacement(), alone.displacement()), 1e-12, "displacements and those by hand")
    report.check(list(in_path.history["load_factor"]) == list(alone.history["load_factor"]), "the load begins at 0, with the same steps")
    perfect = stage_of(both, "buckle").results[-1].mesh.positions
    report.near(np.abs(in_path.results[-1].mesh.positions - perfect)[:, 2].max(), 1e-3, 2.5e-4, "largest imperfection [m]")
    again = run(in_path.folder / "resolved_case.toml", fresh("imperfect_resolved"))
    report.below(largest(again.displacement(), alone.displacement()), 1e-12, "the resolved case of the stage alone")
    for ranks in (2, 3):
        other = stage_of(solve(f"imperfect_stages_{ranks}", staged(), ranks), "path")
        report.below(largest(other.displacement(), in_path.displacement()), 1e-6, f"{ranks} ranks and 1")


@test
def imperfect_restart(report):
    """--from and --restart of a path on a shape with modes of the stage before; a stage after it continues on its shape."""
    both = solve("imperfect_whole", staged())
    in_path = stage_of(both, "path")
    before = in_path.displacement()
    from_path = run(OUT / "imperfect_whole.toml", both.folder, 1, ["--from", "path", "--overwrite"])
    report.check(from_path.code == 0 and np.array_equal(in_path.displacement(), before), "--from path, bit by bit")
    by_hand = column() | {"imperfection": [
        {"type": "modes", "results": str(both.folder / "buckle"), "modes": [1, 2], "amplitudes": AMPLITUDES}]}
    # Half of the path, and the rest from its checkpoint: as by hand, and as unbroken.
    half = solve("imperfect_half", staged(4.0))
    rest = run(OUT / "imperfect_whole.toml", fresh("imperfect_rest"), 1, ["--from", "path", "--restart", half.folder / "path" / "checkpoint.h5"])
    hand_half = solve("imperfect_hand_half", by_hand | {"steps": path(4.0)})
    hand_rest = solve("imperfect_hand_rest", by_hand | {"steps": path(8.0)}, 1, ["--restart", hand_half.folder / "checkpoint.h5"])
    rest_of = stage_of(rest, "path").displacement()
    report.check(rest.code == 0 and np.array_equal(rest_of, hand_rest.displacement()), "a restart within the path, bit by bit as by hand")
    report.below(largest(rest_of, before), 1e-9, "and unbroken")
    # The second path holds the load of the first one, and nothing is left to do.
    steps = {"initial_step": 0.5, "max_step": 0.5}
    two = staged() | {"load": [{"type": "line", "group": "tip", "vector": [-4, 0, 0]}], "steps": steps, "stage": [BUCKLE, PATH, PATH | {"name": "on"}]}
    whole = solve("imperfect_on", two)
    report.below(same_mesh(stage_of(whole, "on"), in_path), 1e-12, "a stage after the path has its shape")
    end = stage_of(whole, "on").displacement()
    report.below(largest(end, stage_of(whole, "path").displacement()), 1e-6, "and begins where it ends")
    from_on = run(OUT / "imperfect_on.toml", whole.folder, 1, ["--from", "on", "--overwrite"])
    report.check(from_on.code == 0 and largest(stage_of(whole, "on").displacement(), end) < 1e-12, f"also with --from: code {from_on.code}")


MISTAKES = (
    ("no stages", {"stage": []}, MODES, "imperfection.stage: there is no stage 'buckle'"),
    ("unknown", {}, MODES | {"stage": "bukle"}, "[[imperfection]] stage: there is no stage 'bukle': did you mean 'buckle'"),
    ("later", {"stage": [PATH, BUCKLE]}, MODES, "no stage comes after 'buckle'"),
    ("no modes", {"stage": [PATH, PATH | {"name": "more"}]}, MODES | {"stage": "path"}, 'stage \'path\' has analysis = "static"'),
    ("too few", {}, MODES | {"modes": [3]}, "mode 3: stage 'buckle' finds 2"),
    ("both", {}, MODES | {"results": "x"}, "imperfection.stage: modes come from"),
    ("none", {}, {"type": "modes", "modes": [1], "amplitudes": [1e-3]}, "imperfection.results: modes come from"),
    ("time", {"stage": [{"name": "swing", "analysis": "dynamic", "time": {"end": 0.1, "step": 0.05}}, BUCKLE, PATH]}, MODES,
     "in stage 'swing' before it time has passed"),
    ("remesh", {"stage": [PATH, BUCKLE, PATH | {"name": "more"}], "remesh": {"smallest": 0.1, "largest": 1.0}}, MODES,
     "stage 'path' before it may have changed the mesh"),
)


@test
def imperfect_mistakes(report):
    """Stages that cannot give an imperfection its modes end with code 2, the key and a remedy; so does a mode across a mirror plane."""
    for k, (name, changes, imperfection, words) in enumerate(MISTAKES):
        case = staged(8.0) | {"stage": [BUCKLE, PATH]} | changes | {"imperfection": [imperfection]}
        if not case["stage"]:
            del case["stage"]
        code, text = invoke(["check", write_case(case, OUT / f"imperfect_mistake_{k}.toml")])
        report.check(code == 2 and words in text, f"{name}: code {code}, {text.strip()[-250:]}")
    few = staged(8.0) | {"stage": [BUCKLE | {"eigen": {"modes": 2}}, PATH], "load": [{"type": "line", "group": "tip", "vector": [1, 0, 0]}]}
    done = run(write_case(few, OUT / "imperfect_few.toml"), fresh("imperfect_few"))
    report.check(done.code != 0 and "modes found" in done.text, f"under tension nothing buckles: code {done.code}, {done.text.strip()[-200:]}")


def cap(mirrors=("sym_x", "sym_y"), **changes):
    """A quarter of a cap whose edges at the mirror planes are curved."""
    normals = {"sym_x": [1, 0, 0], "sym_y": [0, 1, 0]}
    return {
        "title": "Cap", "analysis": "modal",
        "mesh": {"file": str(ROOT / "meshes" / "cap.geo"), "parameters": {"radius": 1.0, "half_angle": 60, "n": 8}},
        "material": [{"type": "isotropic", "young": 1e9, "poisson": 0.3, "thickness": 0.01, "density": 1000.0}],
        "support": [{"type": "clamped", "group": "rim"}] + [{"type": "symmetry", "group": g, "normal": normals[g]} for g in mirrors],
        "eigen": {"modes": 2}} | changes


@test
def imperfect_mirror(report):
    """Heights leave vertices in the mirror planes of symmetry supports; modes that move them across are refused."""
    height = 0.02
    for kind in ({"type": "expression", "height": f"{height}"}, {"type": "random", "amplitude": height, "length": 0.3}):
        x = solve("imperfect_cap", cap(imperfection=[kind])).results[-1].mesh.positions
        given = solve("imperfect_perfect", cap()).results[-1].mesh.positions
        for axis, name in ((0, "x"), (1, "y")):
            on = np.abs(given[:, axis]) < 1e-12
            report.below(np.abs(x[on][:, axis]).max(), 1e-12, f"{kind['type']}: vertices of the plane {name} = 0 move across it by [m]")
        if kind["type"] == "expression":
            report.below(np.abs(np.linalg.norm(x, axis=1) - 1 - height).max(), 2e-3 * height + 1e-4, "the height is the same at the planes and inside, [m]")
    free = solve("imperfect_free", cap(("sym_y",)))
    wrong = run(write_case(cap(imperfection=[{"type": "modes", "results": str(free.folder), "modes": [1], "amplitudes": [height]}]), OUT / "imperfect_across.toml"),
                fresh("imperfect_across"))
    report.check(wrong.code == 2 and "across the mirror plane" in wrong.text, f"a mode without one of the supports: code {wrong.code}, {wrong.text.strip()[-250:]}")
    own = solve("imperfect_own", cap())
    right = run(write_case(cap(imperfection=[{"type": "modes", "results": str(own.folder), "modes": [1], "amplitudes": [height]}]), OUT / "imperfect_along.toml"),
                fresh("imperfect_along"))
    if right.code != 0:
        raise Failure(right.text)
    report.check(True, "a mode with the same supports")
    for height in (1e-9, 1e-7, 1e-6, 1e-5, 1e-3):
        flat = plate(8, 1.0) | {"support": [{"type": "hinged", "group": "left"}, {"type": "symmetry", "group": "bottom"}, {"type": "symmetry", "group": "top"}],
                                "imperfection": [{"type": "expression", "height": f"{height}*cos(2*x)"}]}
        code, said = invoke(["check", write_case(flat, OUT / "imperfect_strip.toml")])
        report.check(code == 0, f"straight edges that are {height:g} m off: code {code}, {said.strip()[-200:] if code else ''}")


@test
def imperfect_cap_collapse(report):
    """Pressure at which a shallow cap collapses, perfect and with a dimple, against Marguerre's equations (runs/imperfect_cap)."""
    study = drape_script("collapse", "imperfect_cap")
    report.near(study.collapse(4.0, 0.0), 0.5637, 1e-4, "theory, geometry 4")
    for mu in (0.0, 0.3):
        found = study.found(solve(f"imperfect_collapse_{mu}", study.case(5.0, mu, 12)), 5.0, mu)
        report.percent(found / study.collapse(5.0, mu), 0.02, f"dimple of {mu} h: {found:.4f} of the classical pressure")
    report.check(math.isnan(study.collapse(4.0, 0.5)), "theory: with half a thickness and geometry 4 it does not collapse")


@test
def arch_between(report):
    """A bifurcation whose mode is not the one that is followed is looked for in shorter steps: a sine arch under a sine load, load q = E I k^4 (a + 3 w) there (energy of a, w and the second wave)."""
    rise = 0.0125
    case = {
        "analysis": "static", "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"length": 1, "width": 0.1, "nx": 40, "ny": 4, "pattern": 1}},
        "material": [{"type": "isotropic", "young": 1e9, "poisson": 0, "thickness": 0.01}], "imperfection": [{"type": "expression", "height": f"{rise}*sin(pi*x)"}],
        "support": [{"type": "hinged", "group": ["clamp", "tip"]}], "load": [{"type": "area", "vector": [0, 0, -1000], "distribution": "sin(pi*x)"}],
        "probe": [{"name": "middle", "type": "displacement", "point": [0.5, 0.05, 0], "components": ["z"]}],
        "steps": {"control": "arc_length", "control_probe": "middle", "final_displacement": -0.013, "initial_step": 0.02, "max_step": 0.05}}
    between = solve("arch_between", case)
    found, history = between.summary["critical_points"], between.history
    at = history["critical_load_factor"][history["critical"] == 2]
    report.check(len(at) == 1, f"history.csv has one load factor for it: {at}")
    report.percent(at[0] / 0.2184, 0.002, "that by switch_branch")
    report.check([c["kind"] for c in found] == ["limit point", "bifurcation point"], f"what is passed: {[c['kind'] for c in found]}")
    located = solve("arch_located", case | {"steps": case["steps"] | {"at_critical_point": "switch_branch"}}).summary["critical_points"]
    report.percent(located[-1]["load_factor"] / 0.2180, 0.005, "located, against the formula")
    case["imperfection"][0]["height"] = "0.05*sin(pi*x)"
    case["steps"] |= {"final_displacement": -0.06, "initial_step": 0.2, "max_step": 1.0}
    passed = solve("arch_passed", case)
    stopped = solve("arch_stopped", case | {"steps": case["steps"] | {"at_critical_point": "stop"}})
    report.check(stopped.summary["critical_points"][-1]["kind"] == "bifurcation point", "a higher one stops at its bifurcation")
    for file in ("checkpoint.h5", "results.vtkhdf"):
        again = solve("arch_again", case, options=["--restart", stopped.folder / file])
        report.percent(again.history["load_factor"][-1] / passed.history["load_factor"][-1], 1e-6, f"and goes on with {file} on the path that it came along: load factor {passed.history['load_factor'][-1]:.5g}")


@test
def arch_restarted(report):
    """An arc length goes on from any step of its results, in steps like those before, also beside limit points."""
    case = {
        "analysis": "static", "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"length": 1, "width": 0.1, "nx": 20, "ny": 2}},
        "material": [{"type": "isotropic", "young": 1e9, "poisson": 0, "thickness": 0.01}], "imperfection": [{"type": "expression", "height": "0.1*sin(pi*x)"}],
        "support": [{"type": "hinged", "group": ["clamp", "tip"]}], "load": [{"type": "area", "vector": [0, 0, -1e4], "distribution": "sin(pi*x)"}],
        "probe": [{"name": "middle", "type": "displacement", "point": [0.5, 0.05, 0], "components": ["z"]}],
        "steps": {"control": "arc_length", "control_probe": "middle", "final_displacement": -0.21, "initial_step": 0.02, "max_step": 1.0}}
    whole = solve("arch_whole", case)
    steps = whole.summary["steps"]
    report.check(whole.summary["converged"] and np.sum(np.diff(np.sign(np.diff(whole.history["load_factor"]))) != 0) == 2, f"two limit points in {steps} steps")
    for n in (9, 42, 66, 84):
        again = run(whole.folder.parent / "arch_whole.toml", fresh("arch_goes_on"), 1, ["--restart", whole.results.file, "--restart-step", str(n)])
        ends = again.history["load_factor"][-1] / whole.history["load_factor"][-1] - 1 if again.code in (0, 5) else np.nan
        report.check(abs(ends) < 1e-10 and again.summary["steps"] == steps, f"from step {n}: code {again.code}, {again.summary['steps']} of {steps} steps, ends {ends:.1e} off")


@test
def arch_branches(report):
    """A step that runs over from the path of a symmetric arch to the branch that leaves it, where the load falls, has passed a bifurcation: both branches are found, each the mirror of the other."""
    points = [[x, 0.05, 0.06 * math.sin(math.pi * x)] for x in (0.25, 0.75)]
    case = {
        "analysis": "static", "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"length": 1, "width": 0.1, "nx": 24, "ny": 2, "pattern": 1}},
        "material": [{"type": "isotropic", "young": 1e7, "poisson": 0, "thickness": 0.01, "density": 1000.0}], "imperfection": [{"type": "expression", "height": "0.06*sin(pi*x)"}],
        "support": [{"type": "hinged", "group": ["clamp", "tip"]}],
        "load": [{"type": "area", "vector": [0, 0, -500.0], "distribution": "exp(-((x-0.5)/0.02)^2)"}, {"type": "gravity", "vector": [0, 0, -0.5], "constant": True}],
        "probe": [{"name": "middle", "type": "displacement", "point": [0.5, 0.05, 0.06], "components": ["z"]}]
                 + [{"name": name, "type": "displacement", "point": at, "components": ["z"]} for name, at in zip(("left", "right"), points)]}
    steps = {"control": "arc_length", "control_probe": "middle", "final_displacement": -0.02, "initial_step": 0.02, "max_step": 0.05, "at_critical_point": "switch_branch"}
    one, two = (solve(f"arch_branch_{k}", case | {"steps": steps | {"branch_step": b}}) for k, b in enumerate((1.0, -1.0)))
    for result in (one, two):
        report.check("bifurcation point" in [c["kind"] for c in result.summary["critical_points"]], f"what is passed: {[c['kind'] for c in result.summary['critical_points']]}")
    left, right = ([r.history[side][-1] for side in ("left_z", "right_z")] for r in (one, two))
    report.check(abs(left[0] - left[1]) > 0.01, f"the arch leans: {left[0]:.4f}, {left[1]:.4f} m")
    report.below(max(abs(left[0] - right[1]), abs(left[1] - right[0])), 1e-4, "the other branch is its mirror: difference [m]")
