"""Sheets that fold along hinges: one fold, the vertex of a Miura fold, a motion, mistakes."""

import math

import numpy as np
from common import fresh
from harness import OUT, solve, test
from panels import Panels
from solver import invoke, run, write_case

SHEET = {"type": "isotropic", "young": 2e9, "poisson": 0.3, "thickness": 0.003, "density": 1000.0}  # D = 4.9 N m


def strip(file, cells=4):
    """Two squares of 1 m with a hinge between them."""
    p = Panels()
    p.add("held", (-1, 0, 0), (1, 0, 0), (0, 1, 0), cells, cells)
    far = p.add("free", (0, 0, 0), (1, 0, 0), (0, 1, 0), cells, cells)
    p.point("corner", far[-1, 0])
    return p.write(file)


def strip_case(mesh, analysis="static", **hinge):
    return {"title": "A fold", "analysis": analysis, "mesh": {"file": str(mesh)}, "material": [SHEET],
            "support": [{"type": "clamped", "group": "held start"}],
            "hinge": [{"group": "free start", "stiffness": 0.05} | hinge],
            "probe": [{"name": "corner", "type": "displacement", "group": "corner"}, {"name": "shell", "type": "energy"}]}


@test
def hinge_fold(report):
    """Half a sheet folds by the angle of its hinge, without stress; a moment turns it by its stiffness, and stages hold it."""
    mesh = strip(OUT / "hinge_fold.msh")
    for angle in (120, -60):
        for ranks in (1, 2):
            h = solve("hinge_fold", strip_case(mesh, angle=str(angle)), ranks).history
            turn = math.radians(angle)
            report.below(math.hypot(h["corner_x"][-1] - (math.cos(turn) - 1), h["corner_z"][-1] - math.sin(turn)), 1e-6,
                         f"{angle} degrees on {ranks} ranks: the corner is where a rigid half is")
            report.below(h["shell_bending"][-1] / (0.05 * turn**2 / 2), 1e-9, "no energy is left")
    for angle in (45, 75, 170):
        h = solve("hinge_constant", strip_case(mesh, angle=str(angle), constant=True)).history
        turn = math.radians(angle)
        report.below(math.hypot(h["corner_x"][0] - (math.cos(turn) - 1), h["corner_z"][0] - math.sin(turn)), 1e-6, f"a constant fold of {angle} degrees at load 0")
    bent = strip_case(mesh)
    force = 0.05  # against 0.05 N m/rad: turn cos(turn) = 1 at 1 m would be far; a small one here
    bent["load"] = [{"type": "line", "group": "free end", "vector": [0, 0, force / 50]}]
    h = solve("hinge_moment", bent).history
    turn = 0.02
    for _ in range(20):
        turn = force / 50 * math.cos(turn) / 0.05
    beam = force / 50 * 8 / 3 / (2e9 * 0.003**3 / 12)
    report.near(h["corner_z"][-1], math.sin(turn) + beam, 0.1 * beam, "a force at the end turns it by moment over stiffness")
    staged = strip_case(mesh, angle="90")
    del staged["analysis"]
    staged["stage"] = [{"name": "fold", "analysis": "static"}, {"name": "hold", "analysis": "static"}]
    h = solve("hinge_stages", staged)
    report.check("corner_z" in (OUT / "hinge_stages/hold/history.csv").read_text(), "the second stage has run")
    last = (OUT / "hinge_stages/hold/history.csv").read_text().splitlines()
    column = last[0].split(",").index("corner_z")
    report.below(max(abs(float(line.split(",")[column]) - 1) for line in last[1:]), 1e-6, "it stays folded in a second stage")


@test
def hinge_let_go(report):
    """A soft fold that its load has bent far goes back when a stage takes it away; a sheet that only hangs on its hinge stays where nothing acts."""
    mesh = strip(OUT / "hinge_let_go.msh")
    bent = strip_case(mesh, stiffness=0.5)
    del bent["analysis"]
    bent |= {"material": [SHEET | {"young": 1e9, "thickness": 0.01}], "stage": [{"name": "load", "analysis": "static"}, {"name": "free", "analysis": "static"}],
             "load": [{"type": "gravity", "vector": [0, 0, -0.3], "stages": ["load"]}]}
    done = solve("hinge_let_go", bent)
    rows = [line.split(",") for line in (OUT / "hinge_let_go/free/history.csv").read_text().splitlines()]
    report.below(abs(float(rows[-1][rows[0].index("corner_z")])), 1e-9, "flat again [m]")
    report.check("of round-off" in done.text, "without forces the residual is not one of the forces")
    hangs = strip_case(mesh)
    del hangs["hinge"]
    hangs["support"] = [{"type": "hinged", "group": "held start"}]
    for analysis, more in (("static", {}), ("drape", {"contact": {"distance": 0.01}, "obstacle": [{"name": "floor", "type": "plane", "point": [0, 0, -0.5], "normal": [0, 0, 1]}]})):
        done = solve("hinge_nothing", hangs | {"analysis": analysis} | more)
        report.below(abs(done.history["corner_z"][-1]), 1e-9, f"{analysis}: nothing acts on a hanging sheet [m]")


def turned(v, axis, angle):
    """v, turned about a unit axis."""
    return v * math.cos(angle) + np.cross(axis, v) * math.sin(angle) + axis * np.dot(axis, v) * (1 - math.cos(angle))


def directions(sectors, folds):
    """Creases around a vertex, and one more: the first again, where the folds fit together. Folds close towards the normals."""
    way, normal = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    ways = [way]
    for sector, fold in zip(sectors, folds[1:] + folds[:1]):
        way = turned(way, normal, sector)
        normal = turned(normal, way, fold)
        ways.append(way)
    return ways


def miura(sectors, spine):
    """Folds of a vertex of a Miura sheet where the first is given: opposite ones at the spine, equal ones beside it [rad]."""
    side = -2 * math.atan(math.tan(spine / 2) / math.cos(sectors[0]))
    candidates = [(spine, s * side, -spine, s * side) for s in (1, -1)]
    side = -2 * math.atan(math.tan(spine / 2) * math.cos(sectors[0]))
    candidates += [(spine, s * side, -spine, s * side) for s in (1, -1)]
    wrong = [np.linalg.norm(w[-1] - w[0]) for w in (directions(sectors, f) for f in candidates)]
    return min(zip(wrong, candidates))


def fold_at(points, centre, end, before, after):
    """Fold between the plane of (centre, before, end) and that of (centre, end, after) [rad]."""
    e = (points[end] - points[centre]) / np.linalg.norm(points[end] - points[centre])
    n = [np.cross(points[before] - points[centre], e), np.cross(e, points[after] - points[centre])]
    return math.atan2(np.dot(np.cross(n[0], n[1]), e), np.dot(n[0], n[1]))


@test
def hinge_vertex(report):
    """Four parallelograms around a vertex fold as rigid panels do: a Miura vertex, driven at two of its four creases."""
    sector = math.radians(60)
    sectors = (sector, math.pi - sector, math.pi - sector, sector)
    begin, end = (miura(sectors, math.radians(a)) for a in (10, 80))
    report.below(max(begin[0], end[0]), 1e-12, "the folds that are expected fit together")
    ways = directions(sectors, begin[1])
    p, ends, far = Panels(), [], []
    for k, name in enumerate("abcd"):
        at = p.add(name, (0, 0, 0), ways[k], ways[k + 1], 6, 6)
        ends.append(at[-1, 0])
        far.append(at[-1, -1])
    centre = at[0, 0]
    p.point("centre", centre)
    p.join("side", ["b low", "d low"])
    turn = math.degrees(end[1][0] - begin[1][0])
    case = {"title": "A Miura vertex", "analysis": "static", "mesh": {"file": str(p.write(OUT / "hinge_vertex.msh"))},
            "material": [SHEET | {"direction": [1, 0, 0]}],
            "support": [{"type": "displacement", "group": "a low", "components": ["y", "z"]},
                        {"type": "displacement", "group": "centre", "components": ["x"]},
                        {"type": "displacement", "group": "c low", "components": ["y"]}],
            "hinge": [{"group": "a low", "stiffness": 0.02, "angle": str(turn)},
                      {"group": "c low", "stiffness": 0.02, "angle": str(-turn)}, {"group": "side", "stiffness": 1e-5}]}
    result = solve("hinge_vertex", case)
    x = np.array(p.points) + np.asarray(result.displacement())
    for k, name in enumerate(("spine", "side", "spine behind", "other side")):
        found = fold_at(x, centre, ends[k], ends[k - 1], ends[(k + 1) % 4])
        report.near(math.degrees(found), math.degrees(end[1][k]), 0.5, f"fold of the {name} [degree]")


@test
def hinge_motion(report):
    """A hinge that folds in time swings its half: the energy closes, and two ranks find the same."""
    mesh = strip(OUT / "hinge_motion.msh", 3)
    case = strip_case(mesh, "dynamic", angle="table(t, 0, 0, 0.5, 60, 2, 60)", stiffness=20.0)
    case["material"] = [SHEET | {"thickness": 0.01}]
    case["time"] = {"step": 0.01, "end": 1.5}
    case["output"] = {"every": 50}
    whole = solve("hinge_motion", case)
    h = whole.history
    report.below(h["energy_unaccounted"][-1] / h["work_of_supports"][-1], 1e-6, "energy that is not accounted for")
    two = solve("hinge_motion_2", case, 2).history
    report.below(np.abs(h["corner_z"] - two["corner_z"]).max(), 1e-6, "two ranks as one")
    report.check(np.abs(h["corner_z"]).max() > 0.5, "it swings")


@test
def hinge_mistakes(report):
    """What hinges cannot have ends with code 2, the file, the key and a remedy."""
    mesh = strip(OUT / "hinge_wrong.msh", 2)
    good = strip_case(mesh, angle="10")
    wrong = lambda **change: good | {"hinge": [good["hinge"][0] | change]}
    for name, case, expected in (
            ("group", wrong(group="fold") | {"mass": [{"group": "weight", "mass": 1.0}]}, ("[[hinge]]", "fold", "free start", "[[mass]]", "weight")),
            ("clamp", wrong(group="held start"), ("[[hinge]]", "holds the slope", "hinged")),
            ("surface", wrong(group="free"), ("[[hinge]]", "free")),
            ("stiffness", wrong(stiffness=0), ("hinge", "stiffness")),
            ("unit", wrong(stiffness="3 m"), ("stiffness", "N")),
            ("beyond", wrong(angle="200"), (".toml:", "[[hinge]]", "angle = 200 degrees", "180")),
            ("beyond in time", wrong(angle="100 + 100*t"), ("[[hinge]]", "degrees at (", "180")),
            ("angle", wrong(angle="10 m"), ("angle",)),
            ("constant", wrong(angle="10*t", constant=True), ("constant", "remove")),
            ("inner clamp", good | {"support": [{"type": "clamped", "group": g} for g in ("held start", "free start")]}, ("[[hinge]]", "holds the slope")),
            ("turning", good | {"support": [{"type": "hinged", "group": "held start", "rotation_axis": [0, 1, 0], "rotation_angle": "-40*t"}],
                                "hinge": [{"group": "held start", "stiffness": 1e6}]}, ("[[hinge]]", "turns", "clamped")),
            ("rigid", good | {"rigid": [{"name": "grip", "group": "free end"}], "hinge": [{"group": "free end", "stiffness": 1.0}]},
             ("[[hinge]]", "[[rigid]]")),
            ("twice", good | {"hinge": good["hinge"] * 2}, ("another hinge",)),
            ("element", good | {"element": {"type": "sze_zhou_2016"}}, ("[element] type", "corrected")),
            ("remesh", good | {"remesh": {"smallest": 0.1, "largest": 0.5}}, ("[remesh]", "remove the section"))):
        result = run(write_case(case, OUT / f"hinge_{name}.toml"), fresh(f"hinge_{name}"))
        report.check(result.code == 2 and all(e in result.text for e in expected), f"{name}: code {result.code}: {result.text.strip()[-200:]}")
    elastic = strip_case(mesh, "linear") | {"support": [{"type": "hinged", "group": "held start"}],
                                            "hinge": [{"group": "held start", "stiffness": 0.05}],
                                            "load": [{"type": "line", "group": "free end", "vector": [0, 0, 1e-5]}]}
    h = solve("hinge_elastic", elastic).history
    rigid = 1e-5 * 2 * 2 / 0.05  # and the sheet bends by 1e-5 * 8 / 3 / 4.9
    report.percent(h["corner_z"][-1] / rigid, 0.01, "an elastic edge is hold enough for one linear solution")
    code, text = invoke(["check", write_case(wrong(stiffness=1e-9), OUT / "hinge_lost.toml")])
    report.check(code == 0 and "'free start': stiffness = 1e-09 N" in text and "round-off" in text, f"a stiffness that round-off hides: {text[-400:]}")
    code, text = invoke(["check", write_case(good, OUT / "hinge_good.toml")])
    report.check("round-off" not in text, "not of a good one")
    report.check(code == 0 and "[[hinge]] parts the sheet at 2 edges" in text and "three or more" not in text, "check counts hinges")


@test
def clamped_surface(report):
    """The slope is held round a clamped piece of a sheet as at a clamped edge: under loads, in modes, in motion where the clamp turns, gone on with; a new mesh would lose that, which is said."""
    whole, part = Panels(), Panels()
    for p in (whole, part):
        if p is whole:
            p.add("held", (-0.5, 0, 0), (0.5, 0, 0), (0, 1, 0), 2, 4)
        far = p.add("free", (0, 0, 0), (1, 0, 0), (0, 1, 0), 4, 4)
        p.point("corner", far[-1, 0])
    turn = {"rotation_axis": [0, 1, 0], "rotation_centre": [0, 0, 0], "rotation_angle": "200*t"}
    ends = {}
    for name, p, group in (("surface", whole, "held"), ("edge", part, "free start")):
        mesh = str(p.write(OUT / f"clamped_{name}.msh"))
        support = {"type": "clamped", "group": group}
        case = {"mesh": {"file": mesh}, "material": [SHEET], "support": [support],
                "probe": [{"name": "corner", "type": "displacement", "group": "corner"}]}
        load = {"load": [{"type": "area", "group": "free", "vector": [0, 0, 20.0]}]}
        held = solve(f"clamped_{name}", case | load | {"analysis": "static", "contact": {"distance": 0.01}}, 2)
        modes = solve(f"clamped_{name}_modes", case | {"analysis": "modal", "eigen": {"modes": 3}})
        motion = case | {"analysis": "dynamic", "contact": {"distance": 0.01}, "time": {"end": 0.1, "step": 2e-3}, "support": [support | turn]}
        swung = solve(f"clamped_{name}_turn", motion)
        half = solve(f"clamped_{name}_half", motion | {"time": {"end": 0.05, "step": 2e-3}})
        again = solve(f"clamped_{name}_again", motion, options=("--restart", half.folder / "checkpoint.h5"))
        report.below(abs(again.history["corner_z"][-1] / swung.history["corner_z"][-1] - 1), 1e-10, f"{name}: gone on with, difference")
        ends[name] = [held.history["corner_z"][-1], swung.history["corner_x"][-1], swung.history["corner_z"][-1],
                      *np.loadtxt(modes.folder / "modes.csv", delimiter=",", skiprows=1)[:, 1]]
        code, text = invoke(["check", OUT / f"clamped_{name}.toml"])
        report.check(code == 0 and "at joints of sheets" not in text, f"{name}: a clamped border is no joint to check")
        if name == "surface":
            remeshed = solve("clamped_remeshed", case | load | {"analysis": "static", "remesh": {"largest": 0.3}})
            report.check("clamped ([remesh] keeps it whole)" in remeshed.text and "keeps it whole" not in held.text, "with [remesh] it is said that the slope is not held")
    report.below(max(abs(a / b - 1) for a, b in zip(*ends.values())), 1e-7, f"of the whole sheet and of the free part alone: {ends['surface'][0]:.5f} m, turned {ends['surface'][1]:.4f} m, {ends['surface'][3]:.4f} Hz: difference")
