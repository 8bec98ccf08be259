"""Contact: exact answers, falls, starts, key frames."""

import copy
import math
import re
import sys
import time

import contacting
import numpy as np
from common import check_xdmf, drape_script, fresh, pixels, sheet_on_ball
from harness import OUT, solve, test
from panels import Panels
from pattern_files import frames_file
from solver import ROOT, invoke, run, variant, write_case


@test
def contact_exact(report):
    """Touchdown, drum, slope, capstan and the pushed strip against exact answers: 0.5 %."""
    script = drape_script("exact", "contact")
    script.FOLDER = OUT / "contact_exact"
    script.FOLDER.mkdir(parents=True, exist_ok=True)
    # All of them are runs/contact/exact.
    script.TOUCHDOWN = {height: script.TOUCHDOWN[height] for height in (0.5, 2.0)}
    script.DRUM = {shape: script.DRUM[shape] for shape in ((1, 4), (2, 4))}
    script.PUSH = {share: script.PUSH[share] for share in (0.1, 0.2, 0.3)}  # where it slips is found between these
    for name, rows in (("touchdown", 6), ("drum", 6), ("slope", 3), ("capstan", 2), ("push", 7)):
        found = getattr(script, name)()
        report.check(len(found) == rows, f"{name}: {len(found)} of {rows} figures")
        for _, case, what, computed, exact, error in found:
            if error != "-":
                # The slip is found to a step, which is 0.14 %.
                report.below(float(error), 0.8 if what == "slips at e" else 0.5, f"{name}, {case}, {what}: error in %")
            else:
                report.below(float(computed), 2e-3, f"{name}, {case}, {what}")


@test
def contact_not_yet(report):
    """A strip at rest above a ball: forces of round-off are no reason for small steps."""
    case = {
        "analysis": "dynamic", "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"nx": 8, "ny": 2, "length": 1, "width": 0.25}},
        "material": [{"type": "isotropic", "young": 1e7, "poisson": 0.0, "thickness": 0.01, "density": 100}],
        "support": [{"type": "clamped", "group": "clamp"}], "time": {"end": 0.1, "step": 0.02}, "contact": {"distance": 0.01},
        "obstacle": [{"name": "ball", "type": "sphere", "point": [0.8, 0.125, -0.12], "radius": 0.1}]}
    summary = solve("contact_not_yet", case).summary
    report.check(summary["steps"] == 5 and summary["newton_iterations"] <= 5, f"{summary['steps']} steps, {summary['newton_iterations']} iterations")


@test
def contact_ball(report):
    """A sheet falls on a ball: the same contacts and path on 1 and 2 ranks, no intersection, never a gap closed.

    Systems are solved as exactly as a step needs, so that its tolerance bounds the difference between ranks."""
    one, two = (solve(f"contact_ball_{n}", sheet_on_ball(time__velocity_tolerance=1e-4), n) for n in (1, 2))
    for n, result in ((1, one), (2, two)):
        h = result.history
        through, states = contacting.pierced_in_states(result, 5)
        report.check(through == 0, f"{n} rank(s): {through} edges pierce the sheet in {states} states")
        report.check(h.smallest("smallest_gap") > 0, f"{n} rank(s): smallest gap {h.smallest('smallest_gap'):.3g} m")
        report.check(max(h["contact_pairs"]) > 20, f"{n} rank(s): up to {max(h['contact_pairs']):.0f} contacts")
    same = min(len(one.history["time"]), len(two.history["time"]), 12)
    report.check(list(one.history["contact_pairs"][:same]) == list(two.history["contact_pairs"][:same]),
                 f"the same number of contacts, {one.history['contact_pairs'][same - 1]:.0f} at last, in the first {same} states")
    report.below(np.max(np.abs(one.history["corner_z"][:same] - two.history["corner_z"][:same])), 1e-6, "corner, difference [m]")


BOX = """v -0.1 -0.1 -0.5\nv 0.65 -0.1 -0.5\nv -0.1 1.1 -0.5\nv 0.65 1.1 -0.5
v -0.1 -0.1 -0.02\nv 0.65 -0.1 -0.02\nv -0.1 1.1 -0.02\nv 0.65 1.1 -0.02
f 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 8 7\nf 1 2 6\nf 1 6 5\nf 3 7 8\nf 3 8 4\nf 1 5 7\nf 1 7 3\nf 2 4 8\nf 2 8 6
"""


def check_fall(report, name, case, ranks):
    """A drape that begins with a fall: in equilibrium, stable, without intersection, at most at twice the fall's cost."""
    result = solve(name, case, ranks)
    falls = [int(n) for n in re.findall(r"fall: \d+ steps, (\d+) iterations, nearly at rest", result.text)]
    cost = result.summary["newton_iterations"]
    what = f"{name}, {ranks} rank(s)"
    report.check(result.summary["converged"] and result.summary["residual"] < 1e-6 and "; stable;" in result.text,
                 f"{what}: a stable equilibrium, residual {result.summary['residual']:.1e}")
    # 1.3 to 2.1 times as many, by where the fall ends.
    report.check(sum(falls) > 0 and cost <= 2.5 * sum(falls), f"{what}: {cost} iterations, {sum(falls)} of them falling")
    report.check(contacting.pierced_in_states(result)[0] == 0 and result.history["smallest_gap"][-1] > 0, f"{what}: nothing intersects")


@test
def drape_fall(report):
    """Sheets fall on a ball, over the edge of a box, and a skirt on a body: drape finds a stable equilibrium at once."""
    OUT.mkdir(parents=True, exist_ok=True)
    (OUT / "box.obj").write_text(BOX)
    ball = sheet_on_ball(analysis="drape", mesh__parameters__n=18)
    del ball["time"]
    box = copy.deepcopy(ball)
    box["obstacle"] = [{"name": "box", "type": "mesh", "file": str(OUT / "box.obj"), "friction": 0.3}]
    no_mass = copy.deepcopy(box)  # the weight as a load on an area, and no density
    del no_mass["material"][0]["density"]
    no_mass["load"] = [{"type": "area", "vector": [0, 0, -1.962]}]
    check_fall(report, "drape_ball", ball, 1)
    check_fall(report, "drape_box", box, 2)
    check_fall(report, "drape_no_mass", no_mass, 1)
    endless = copy.deepcopy(ball)
    endless["obstacle"][0]["point"] = [3, 3, -0.26]
    result = run(write_case(endless, OUT / "drape_endless.toml"), OUT / "drape_endless", 1, ["--overwrite"])
    report.check(result.code == 3 and "nothing holds it" in result.text, "a sheet that falls past the ball ends with code 3 and says so")
    assets = ROOT.parent / "shared" / "assets"
    if not assets.is_dir():
        print(f"  skip the skirt: no folder {assets}")
        return
    check_fall(report, "drape_skirt", {
        "analysis": "drape", "mesh": {"file": str(assets / "skirt_halfcircle.obj")}, "element": {"cst_fraction": 0.3},
        "material": [{"type": "fabric", "fabric": str(ROOT / "runs" / "fabrics" / "wool_plain.toml"), "texture_direction": [0, 1]}],
        "support": [{"type": "hinged", "group": "boundary-2"}], "load": [{"type": "gravity", "vector": [0, 0, -9.81]}],
        "contact": {"distance": 1e-3, "stiffness": 1e4, "friction": 0.3},
        "obstacle": [{"name": "body", "type": "mesh", "file": str(assets / "manikin_static.obj"), "friction": 0.3}]}, 1)


@test
def fabric_damping(report):
    """A flap of wool, three bending lengths long, let go flat: its own damping ends its swinging; without it, it swings on."""
    case = {
        "analysis": "dynamic", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"side": 0.04, "n": 8, "pattern": 1}},
        "material": [{"type": "fabric", "fabric": str(ROOT / "runs" / "fabrics" / "wool_tropical.toml"), "direction": [1, 0, 0]}],
        "support": [{"type": "clamped", "group": "left"}], "load": [{"type": "gravity", "vector": [0, 0, -9.81]}],
        "time": {"end": 4, "step": 0.01, "velocity_tolerance": 1e-3}, "output": {"every": 100}}
    speed = {}
    for damped in (True, False):
        h = solve(f"fabric_damping_{damped}", variant(case, {"damping.materials": damped}), 1).history
        late = np.asarray(h["time"]) > 3
        speed[damped] = math.sqrt(2 * np.mean(np.asarray(h["kinetic_energy"])[late]) / (0.1629 * 0.0016))
    report.check(speed[True] < 0.1 * speed[False],
                 f"root mean square speed in the fourth second: {100 * speed[True]:.2f} cm/s, without damping {100 * speed[False]:.2f}")


@test
def first_acceleration(report):
    """A motion begins alike whatever solves its systems: what is pulled along x and pressed along y, with a damped membrane, where the tangent is not surely positive."""
    mesh, random = Panels(), np.random.default_rng(1)
    mesh.add("plate", (0, 0, 0), (1, 0, 0), (0, 0.7, 0), 6, 6)
    mesh.points = [p if min(p[0], p[1], 1 - p[0], 0.7 - p[1]) < 1e-6 else tuple(np.add(p, [*random.uniform(-0.03, 0.03, 2), 0])) for p in mesh.points]
    case = {
        "analysis": "dynamic", "mesh": {"file": str(mesh.write(OUT / "first_acceleration.msh"))},
        "material": [{"type": "isotropic", "young": 2e11, "poisson": 0.3, "thickness": 2e-3, "density": 1000.0, "prestress": [1000.0, 500.0], "direction": [1, 0, 0]}],
        "support": [{"type": "clamped", "group": "plate start"}], "load": [{"type": "area", "vector": [0, 0, 100.0]}], "damping": {"membrane": 1e-3},
        "time": {"end": 0.02, "step": 0.02}, "petsc": {"options": "-snes_rtol 1e-11 -snes_stol 1e-10"}}
    ends = [solve("first_acceleration", case, options=words).displacement() for words in ((), ("-pc_type", "cholesky"))]
    report.below(np.abs(ends[0] - ends[1]).max() / np.abs(ends[1]).max(), 1e-7, "displacements after a step, with conjugate gradients and with a factor")


@test
def damped_start(report):
    """Bending that is damped, and a velocity on one edge alone: long steps end where short ones do, and store no more."""
    case = {
        "analysis": "dynamic",
        "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"length": 0.3, "width": 0.05, "nx": 15, "ny": 3, "pattern": 2}},
        "material": [{"type": "isotropic", "young": 70e9, "poisson": 0.0, "thickness": 1e-3, "density": 2700.0, "bending_damping": 2e-3}],
        "support": [{"type": "clamped", "group": "clamp"}], "initial_velocity": [{"group": "tip", "velocity": [0, 0, 0.05]}],
        "probe": [{"name": "tip", "type": "displacement", "group": "tip", "components": ["z"]}],
        "time": {"end": 0.01, "step": 1e-3}, "output": {"every": 100}}
    for name, changes in (("all", {"material.0.bending_damping": 0.0, "damping.bending": 2e-3}), ("material", {})):
        result = solve(f"damped_start_{name}", variant(case, changes), 1)
        h = result.history
        report.percent(h["tip_z"][-1] / 4.3117e-5, 0.01, f"{name}: the edge goes as in steps of 10 microseconds")
        report.percent(max(h["stored_energy"]) / 5.172e-8, 0.08, f"{name}: most that is stored, as in such steps")
        report.check(min(h["damping_loss"][1:]) > 0 and "damping has given" not in result.text, f"{name}: damping takes energy")
    solve("damped_start_once", variant(case, {"output.every": 1, "time.end": 1e-3}), 1)
    on = run(write_case(case, OUT / "damped_start_on.toml"), fresh("damped_start_on"), 1, ["--restart", OUT / "damped_start_once" / "checkpoint.h5"])
    report.percent(on.history["tip_z"][-1] / h["tip_z"][-1], 1e-9, "from a checkpoint after the first step")


@test
def contact_cylinder(report):
    """A sheet falls across a turning cylinder, over its flat ends too, without piercing it; an axis needs a length."""
    case = sheet_on_ball(time__end=0.25)
    case["obstacle"] = [{"name": "roll", "type": "cylinder", "point": [0.25, 0.5, -0.12], "end": [0.7, 0.5, -0.12], "radius": 0.1,
                         "friction": 0.3, "rotation_axis": [1, 0, 0], "rotation_centre": [0, 0.5, -0.12], "rotation_angle": "90*t"}]
    result = solve("contact_cylinder", case, 2)
    h = result.history
    report.check(contacting.pierced_in_states(result, 5)[0] == 0, f"nothing pierces the sheet in {len(h['time'])} states")
    report.check(h.smallest("smallest_gap") > 0 and max(h["contact_pairs"]) > 20, f"up to {max(h['contact_pairs']):.0f} contacts")
    top = result.displacement()[:, 2].max()
    report.check(-0.03 < top < 0.02, f"it lies on the top at -0.02 m: highest point {top:.4f} m")
    case["obstacle"][0]["end"] = case["obstacle"][0]["point"]
    code, text = invoke(["check", write_case(case, OUT / "contact_cylinder_wrong.toml")])
    report.check(code == 2 and "obstacle" in text and "end" in text, f"no length: exit code {code}: {text.strip()[-110:]}")


@test
def contact_starts(report):
    """A start that intersects is reported in full; what ignores each other may; a missing obstacle file is a user's error."""
    case = sheet_on_ball(time__end=0.02)
    case["obstacle"][0]["point"] = [0.5, 0.5, -0.2]
    result = run(write_case(case, OUT / "contact_start.toml"), OUT / "contact_start")
    report.check(result.code == 2 and "sheet and ball" in result.text, f"exit code {result.code}: {result.text.strip()[-200:]}")
    report.check((OUT / "contact_start" / "intersections.vtk").is_file(), "the triangles are in intersections.vtk")
    picture = pixels(OUT / "contact_start" / "intersections.png")
    red, blue = (picture[:, :, 0] > 2 * picture[:, :, 2]).mean(), (picture[:, :, 2] > 1.3 * picture[:, :, 0]).mean()
    report.check(picture.shape == (960, 1280, 3) and red > 1e-3 and blue > 1e-2, f"and drawn: {100 * red:.2f} % of the picture red, {100 * blue:.1f} % in the colour of the sheet")
    case["contact_rule"] = [{"first": "sheet", "second": "ball", "ignore": True}]
    case["contact"]["check"] = True
    ignored = run(write_case(case, OUT / "contact_ignored.toml"), OUT / "contact_ignored")
    report.check(ignored.code == 0, f"ignored: exit code {ignored.code}")
    case["obstacle"] = [{"name": "body", "type": "mesh", "file": "nobody.obj"}]
    case["contact_rule"] = []
    missing = run(write_case(case, OUT / "contact_missing.toml"), OUT / "contact_missing", 2)
    wrong = sheet_on_ball(contact_rule=[{"first": "ball", "second": "celling"}])
    code, text = invoke(["check", write_case(wrong, OUT / "contact_wrong.toml")])
    report.check(code == 2 and "'celling'" in text and "contact_rule" in text, f"a rule without a body: exit code {code}")
    code, text = invoke(["check", write_case(sheet_on_ball(analysis="modal"), OUT / "contact_wrong.toml")])
    report.check(code == 2 and "no contact with analysis" in text, f"contact in modal: exit code {code}: {text.strip()[-90:]}")
    report.check(missing.code == 2 and "nobody.obj" in missing.text, f"missing file: exit code {missing.code}")


def bulging_sheets(file):
    """Two sheets of side 1, the upper one flat, the lower one with a bulge that passes through it; and their mesh's groups."""
    sys.path.insert(0, str(ROOT / "runs" / "contact" / "lib"))
    from shapes import strip, write_msh
    n = 17
    x, y = (g.ravel() for g in np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij"))
    bulge = -0.02 + 0.05 * np.exp(-((x - 0.52)**2 + (y - 0.47)**2) / 0.02)
    points = np.vstack([np.column_stack([x, y, 0 * x]), np.column_stack([x + 0.013, y - 0.017, bulge])])
    return write_msh(file, points, [("upper", 2, strip(n, n)), ("lower", 2, strip(n, n) + n * n)])


@test
def contact_untangle(report):
    """Shallow intersections with a ball and of two sheets are repaired, alike on 1 and 2 ranks; a deep one still exits with 2."""
    case = sheet_on_ball(time__end=0.05, time__checkpoint_steps=1, contact__untangle=True)
    case["obstacle"][0]["point"] = [0.5, 0.5, -0.22]
    pair = variant(case, {"mesh.file": str(bulging_sheets(OUT / "contact_bulge.msh"))})
    del pair["mesh"]["parameters"]
    pair["obstacle"][0]["point"] = [0.5, 0.5, -0.4]
    for name, start in (("ball", case), ("pair", pair)):
        one, two = (solve(f"contact_untangle_{name}_{n}", start, n) for n in (1, 2))
        for n, result in ((1, one), (2, two)):
            said = [line for line in result.text.splitlines() if line.startswith("untangled:")]
            h = result.history
            report.check(len(said) == 1, f"{name}, {n} rank(s): {said}")
            report.check(h.smallest("smallest_gap") > 0 and contacting.pierced_in_states(result, 5)[0] == 0, f"nothing pierces the sheet, gaps stay, in {len(h['time'])} states")
        difference = np.abs(one.displacement(0) - two.displacement(0)).max()
        report.check(difference == 0 and np.abs(one.displacement(0)).max() > 0, f"the same start on 1 and 2 ranks: {difference:g}")
    again = solve("contact_untangle_again", variant(case, {"time.end": 0.06}), 1,
                  ["--restart", OUT / "contact_untangle_ball_1" / "checkpoint.h5"])
    report.check("untangled" not in again.text, "a restart goes on without it")
    case["obstacle"][0] |= {"point": [0.5, 0.5, -0.05], "radius": 0.4}
    deep = run(write_case(case, OUT / "contact_untangle_deep.toml"), OUT / "contact_untangle_deep")
    report.check(deep.code == 2 and "more than five cells" in deep.text and "sheet and ball" in deep.text,
                 f"too deep: exit code {deep.code}")
    report.check((OUT / "contact_untangle_deep" / "intersections.vtk").is_file(), "the triangles are in intersections.vtk")


@test
def contact_frames(report):
    """A tetrahedron that rises by key frames lifts a sheet off a floor, and takes it along without piercing it."""
    folder = OUT / "contact_frames"
    folder.mkdir(parents=True, exist_ok=True)
    corners = np.array([[0.35, 0.35, -0.3], [0.65, 0.35, -0.3], [0.5, 0.65, -0.3], [0.5, 0.45, -0.05]])
    for frame in range(6):
        lines = [f"v {x:.9g} {y:.9g} {z + 0.1 * frame:.9g}" for x, y, z in corners]
        lines += ["f 1 3 2", "f 1 2 4", "f 2 3 4", "f 3 1 4"]
        (folder / f"spike_{frame:04d}.obj").write_text("\n".join(lines) + "\n")
    case = sheet_on_ball(time__end=0.2, contact__distance=4e-3)
    case["obstacle"] = [{"name": "spike", "type": "mesh", "file": str(folder / "spike_0000.obj"),
                         "frames": str(folder / "spike_%04d.obj"), "frames_per_second": 25, "friction": 0.3}]
    result = solve("contact_frames_run", case, 2)
    h = result.history
    report.check(contacting.pierced_in_states(result, 5)[0] == 0, f"nothing pierces the sheet in {len(h['time'])} states")
    tip = -0.05 + 0.1 * 0.2 * 25
    top = (result.displacement()[:, 2]).max()
    report.check(top > tip - 0.02, f"the sheet reaches {top:.3f} m, the tip {tip:.3f} m")
    report.near(result.results[-1].obstacles[:, 2].max(), tip, 1e-6, "tip in the results [m]")


@test
def frames_that_tilt(report):
    """A sheet that friction holds on a table which tilts goes with it, whether key frames or an angle tell its motion."""
    corners = np.array([[x, y, 0.0] for x in (-0.2, 0.2) for y in (-0.2, 0.2)])
    table = OUT / "tilting_table.obj"
    table.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "f 1 3 4\nf 1 4 2\n")
    rate, begin, turn = 100, 0.1, math.radians(25)
    angles = [turn * min(max(k / rate - begin, 0) / 0.3, 1) for k in range(51)]
    frames = [[[x * math.cos(a), y, -x * math.sin(a)] for x, y, _ in corners] for a in angles]
    case = {"analysis": "dynamic", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"n": 4, "side": 0.1}, "translate": [0, -0.05, 3e-3]},
            "material": [{"type": "isotropic", "young": 1e7, "poisson": 0.3, "thickness": 1e-3, "density": 400.0}], "load": [{"type": "gravity", "vector": [0, 0, -9.81]}],
            "contact": {"distance": 4e-3, "self": False}, "damping": {"mass": 20.0}, "time": {"end": 0.5, "step": 5e-3, "velocity_tolerance": 1e-5},
            "output": {"fields": ["displacement"], "every": 1000}}
    body = {"name": "table", "type": "mesh", "file": str(table), "friction": 1.0}
    told = {"frames": frames_file("tilting_table.pc2", frames) | {"frames_per_second": rate},
            "angle": {"rotation_axis": [0, 1, 0], "rotation_angle": f"25*min(max(t-{begin},0)/0.3,1)"}}
    ends = {name: solve(f"tilting_{name}", case | {"obstacle": [body | motion]}).displacement() for name, motion in told.items()}
    report.check(abs(ends["angle"][:, 2]).max() > 0.03, "the sheet goes with the table")
    report.below(np.abs(ends["frames"] - ends["angle"]).max(), 1e-4, f"the gap times the angle would be {3.5e-3 * turn:.2g}: difference [m]")


@test
def contact_pictures(report):
    """Obstacles of every kind are in the results as triangles that move, a ball turns; those at rest are stored once."""
    folder = OUT / "contact_pictures"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "body.obj").write_text("v 0 0 -2\nv 1 0 -2\nv 0 1 -2\nf 1 2 3\n")
    case = sheet_on_ball(time__end=0.02, mesh__parameters__n=8)
    case["obstacle"] = [
        {"name": "body", "type": "mesh", "file": str(folder / "body.obj"), "motion": ["0", "0", "-t"]},
        {"name": "ball", "type": "sphere", "point": [0.5, 0.5, -0.3], "radius": 0.25, "rotation_axis": [0, 0, 1],
         "rotation_centre": [0.5, 0.5, 0], "rotation_angle": "4500*t"},
        {"name": "rod", "type": "capsule", "point": [0, 0, -1], "end": [1, 0, -1], "radius": 0.1},
        {"name": "floor", "type": "plane", "point": [0, 0, -3], "normal": [0, 0, 1], "motion": ["0", "0", "-2*t"]}]
    result = solve("contact_pictures_run", case, 2)
    results = result.results
    time, now = results[-1].time, results[-1].obstacles
    rest, triangles, body, names = (results.obstacles[name] for name in ("positions", "triangles", "obstacle", "names"))
    check_xdmf(report, result.folder / "obstacles.xdmf", len(results))
    report.check(names == ["body", "ball", "rod", "floor"], f"names: {names}")
    vertices = [np.unique(triangles[body == k]) for k in range(4)]
    by_time = [np.full((len(v), 3), [0, 0, z]) for v, z in zip(vertices, (-time, 0, 0, -2 * time))]
    turned = rest[vertices[1]] - [0.5, 0.5, 0]
    angle = math.radians(4500 * time)
    turned = np.column_stack([math.cos(angle) * turned[:, 0] - math.sin(angle) * turned[:, 1],
                              math.sin(angle) * turned[:, 0] + math.cos(angle) * turned[:, 1], turned[:, 2]]) + [0.5, 0.5, 0]
    by_time[1] = turned - rest[vertices[1]]
    for name, v, move in zip(names, vertices, by_time):
        report.below(np.abs(now[v] - rest[v] - move).max(), 1e-6, f"{name}, {len(v)} vertices: error of the positions [m]")
    report.below(np.abs(np.linalg.norm(now[vertices[1]] - [0.5, 0.5, -0.3], axis=1) - 0.25).max(), 1e-6, "ball: radius [m]")
    report.near(np.ptp(rest[vertices[3]][:, 0]), 1.5 * math.sqrt(2), 1e-5, "floor: side [m]")
    still = solve("contact_pictures_still", sheet_on_ball(time__end=0.02, mesh__parameters__n=8), 1)
    check_xdmf(report, still.folder / "obstacles.xdmf", 0)
    code, said = invoke(["render", result.folder, "--size", "160x120", "--quality", "draft"])
    report.check(code == 0 and (result.folder / "picture.png").is_file(), "voile render draws it" if code == 0 else said)


@test
def energy_left_open(report):
    """A fall whose steps are hardly solved says that its energy does not balance, and what mends it; solved well it says nothing."""
    for tolerance, warns in ((0.3, True), (1e-4, False)):
        result = solve(f"energy_left_open_{tolerance:g}", sheet_on_ball(time__velocity_tolerance=tolerance, mesh__parameters__n=12, time__end=0.2))
        said = [line for line in result.text.splitlines() if "of the energy is not accounted for" in line]
        report.check(len(said) == warns and all("time.velocity_tolerance below 0.3 m/s" in line for line in said), f"at {tolerance:g} m/s: {said}")


def driven_bar(**changes):
    """A bar with masses at its end, all of it held across: an oscillator of 500 N/m and 4 kg."""
    case = {
        "analysis": "dynamic",
        "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"length": 1.0, "width": 0.5, "nx": 4, "ny": 1}},
        "material": [{"type": "isotropic", "young": 1e6, "poisson": 0.0, "thickness": 1e-3, "density": 1e-6}],
        "support": [{"type": "clamped", "group": "clamp"}, {"type": "displacement", "group": "plate", "components": ["y", "z"]}],
        "mass": [{"group": "tip", "mass": 2.0}],
        "load": [{"type": "point", "group": "tip", "vector": [0.0025, 0, 0]}],
        "probe": [{"name": "u", "type": "displacement", "group": "tip", "components": ["x"]}],
        "time": {"end": 0.5, "step": 0.01, "spectral_radius": 1.0}, "petsc": {"options": "-snes_rtol 1e-11"}}
    return variant(case, changes)


@test
def ledger(report):
    """Works of loads and supports that change in time, damping whichever way forces are taken, steps below the limit of what is damped."""
    rate, natural = 25.0, math.sqrt(500.0 / 4.0)
    t = np.linspace(0, 0.5, 20001)
    # u = F/m (sin(rate t) - rate/natural sin(natural t)) / (natural^2 - rate^2)
    speed = 0.005 / 4.0 * rate * (np.cos(rate * t) - np.cos(natural * t)) / (natural**2 - rate**2)
    exact = np.trapezoid(0.005 * np.sin(rate * t) * speed, t) if hasattr(np, "trapezoid") else np.trapz(0.005 * np.sin(rate * t) * speed, t)
    swung = solve("ledger_load", driven_bar(**{"load.0.history": "sin(25*t)"}), 1)
    report.percent(swung.history["work_of_loads"][-1] / exact, 0.02, "work of a load that swings")
    report.check("has created" not in swung.text, "no energy is said to be created")
    moved = driven_bar(load=[])
    moved["support"][0] = {"type": "displacement", "group": "clamp", "components": ["x", "y", "z"], "motion": ["1e-5*sin(25*t)", "0", "0"]}
    h = solve("ledger_support", moved, 1).history
    gain = h["kinetic_energy"][-1] + h["stored_energy"][-1] - h["kinetic_energy"][0] - h["stored_energy"][0]
    report.percent(h["work_of_supports"][-1] / gain, 0.02, "work of a support that swings is what the bar has")
    tau = 0.01
    decay, ringing = 0.5 * tau * natural**2, natural * math.sqrt(1.0 - (0.5 * tau * natural) ** 2)
    # After a sudden load: v = F/(m ringing) e^(-decay t) sin(ringing t); damping takes tau k v^2
    lost = tau * 500.0 * np.sum((0.005 / (4.0 * ringing) * np.exp(-decay * t) * np.sin(ringing * t)) ** 2) * (t[1] - t[0])
    damped = solve("ledger_damped", driven_bar(**{"material.0.membrane_damping": tau, "time.step": 0.0025}), 1)
    report.percent(damped.history["damping_loss"][-1] / lost, 0.005, "what viscosity takes")
    strip = {
        "analysis": "dynamic",
        "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"length": 0.3, "width": 0.02, "nx": 30, "ny": 2}},
        "material": [{"type": "isotropic", "young": 70e9, "poisson": 0.0, "thickness": 1e-3, "density": 2700.0}],
        "support": [{"type": "clamped", "group": "clamp"}], "load": [{"type": "line", "group": "tip", "vector": [0, 0, 0.01]}],
        "probe": [{"name": "tip", "type": "displacement", "group": "tip", "components": ["z"]}],
        "time": {"end": 8e-4, "step": 2e-6, "mass": "lumped"}}
    for key, value in (("bending_damping", 1e-4), ("membrane_damping", 1e-6)):
        ends = [solve(f"ledger_{key}_{method}", variant(strip, {f"material.0.{key}": value, "time.method": method}), 1).history["tip_z"][-1]
                for method in ("alpha", "central_difference")]
        report.percent(ends[1] / ends[0], 0.01, f"{key}: central differences against implicit steps")
    turned = {"analysis": "dynamic", "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"length": 0.4, "width": 0.2, "nx": 12, "ny": 6}},
              "material": [{"type": "isotropic", "young": 5e5, "poisson": 0.3, "thickness": 1e-3, "density": 1000}], "damping": {"membrane": 1e-3},
              "support": [{"type": "clamped", "group": "clamp", "rotation_axis": [0, 0, 1], "rotation_centre": [0, 0, 0], "rotation_angle": "100*t-2*sin(50*t)"}],
              "probe": [{"name": "R", "type": "reaction", "group": "clamp"}], "time": {"end": 0.015, "step": 1.25e-4, "mass": "lumped"}}
    pulled = [np.interp(0.01, h["time"], h["R_x"]) for h in (solve(f"ledger_turned_{method}", variant(turned, {"time.method": method}), 1).history
                                                             for method in ("alpha", "central_difference"))]
    report.percent(pulled[1] / pulled[0], 0.02, "what a damped sheet that is turned pulls with, explicit against implicit")
    cloth = variant(strip, {"material.0.young": 1e8, "material.0.thickness": 1e-4, "material.0.density": 100.0, "time.method": "central_difference",
                            "time.step": 1e-6, "time.end": 2e-5})
    limits = []
    for wind in (0, 30):
        text = solve(f"ledger_wind_{wind}", variant(cloth, {"air": {"density": 1.2, "normal_drag": 1.3, "wind": [0, 0, wind]}}), 1).text
        limits.append(float(text.split("stability limit ")[1].split()[0]))
    # The wind damps with c = rho C w / 2 over the mass per area, 2340 1/s: less than a hundredth of omega = 2 / limit
    expected = 2 / (1170 + math.hypot(2 / limits[0], 1170))
    report.percent(limits[1] / expected, 0.02, "the limit of a light sheet in the wind")
    turning = variant(strip, {"mesh.parameters": {"length": 0.3, "width": 0.02, "nx": 15, "ny": 2}, "support": [], "load": [], "probe": [], "rigid": [{"group": "tip", "mass": 0.5, "point": [0.3, 0.01, 0.05]}],
                              "initial_velocity": [{"angular_velocity": [0, 5, 0], "centre": [0.3, 0.01, 0]}], "time.step": 1e-4})
    mass = 0.3 * 0.02 * 2.7
    report.percent(solve("ledger_rigid", turning, 1).history["kinetic_energy"][0] / (0.5 * 25 * (0.5 * 0.05**2 + mass * 0.3**2 / 3)), 0.01,
                   "a straight rigid edge turns with the sheet around it")


@test
def ledger_lifted(report):
    """A floor takes a sheet up and stops: it gives what lifts the sheet, and steps four times as long do not say otherwise."""
    lifted = {
        "analysis": "dynamic", "contact": {},
        "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"length": 0.3, "width": 0.2, "nx": 6, "ny": 4}},
        "material": [{"type": "isotropic", "young": 1e7, "poisson": 0.3, "thickness": 2e-3, "density": 500.0}],
        "load": [{"type": "gravity", "vector": [0, 0, -9.81]}],
        "obstacle": [{"name": "floor", "type": "plane", "point": [0, 0, -0.0015], "normal": [0, 0, 1],
                      "motion": ["0", "0", "t<0.1 ? 0 : 0.05*(1-cos(pi*(t-0.1)/0.3))"]}],
        "time": {"end": 0.4, "step": 2e-3}}
    long, short = (solve(f"ledger_lifted_{step:g}", variant(lifted, {"time.step": step}), 1).history for step in (2e-3, 5e-4))
    report.percent(long["work_of_obstacles"][-1] / short["work_of_obstacles"][-1], 5e-4, "work of the floor in long steps against short ones")
    report.percent(long["numerical_loss"][-1] / short["numerical_loss"][-1], 0.08, "what the first touch takes")
    # A sheet that begins within the activation distance, on a floor that rises at once: m (v^2 / 2 + g s), and its settling beside it.
    settling = variant(lifted, {"obstacle.0.point": [0, 0, -0.0007], "obstacle.0.motion": ["0", "0", "1.5*t*t"], "time.end": 0.15,
                                "contact": {"distance": 1e-3, "settle_time": 0.1}})
    corners = [(x, y, z) for z in (-0.1, -0.0007) for y in (-0.2, 0.4) for x in (-0.2, 0.5)]
    sides = ((1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6))
    (OUT / "ledger_block.obj").write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join(f"f {a} {b} {c}\nf {a} {c} {d}\n" for a, b, c, d in sides))
    block = {"name": "floor", "type": "mesh", "file": str(OUT / "ledger_block.obj"), "motion": settling["obstacle"][0]["motion"]}
    lifts = 0.3 * 0.2 * 2e-3 * 500 * (0.5 * 0.45**2 + 9.81 * 1.5 * 0.15**2)
    for name, step, change in (("plane", 5e-3, {}), ("plane", 1e-3, {}), ("block", 5e-3, {"obstacle": [block]})):
        work = solve(f"ledger_settling_{name}_{step:g}", variant(settling, {"time.step": step} | change), 1).history["work_of_obstacles"][-1]
        report.percent(work / lifts, 0.03, f"a start that settles on a {name}, steps of {1e3 * step:g} ms: work of the floor")


@test
def damped_ranks(report):
    """The acceleration after a first step of backward Euler is solved for exactly: ranks agree."""
    case = {
        "analysis": "dynamic",
        "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"length": 0.3, "width": 0.02, "nx": 30, "ny": 2}},
        "material": [{"type": "isotropic", "young": 70e9, "poisson": 0.0, "thickness": 1e-3, "density": 2700.0, "bending_damping": 2e-3}],
        "support": [{"type": "clamped", "group": "clamp"}], "initial_velocity": [{"group": "tip", "velocity": [0, 0, 0.01]}],
        "probe": [{"name": "tip", "type": "displacement", "group": "tip", "components": ["z"]}],
        "time": {"end": 0.01, "step": 1e-3}, "petsc": {"options": "-snes_rtol 1e-11"}}
    one, two = (solve(f"damped_ranks_{ranks}", case, ranks).history["tip_z"] for ranks in (1, 2))
    report.percent(two[-1] / one[-1], 1e-7, "end on 2 ranks")
