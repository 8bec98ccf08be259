"""Regression tests of remeshing in motions: friction that holds, what a sheet comes near, and what the mass matrix keeps."""

import math

import numpy as np
from common import strip
from curves import Table
from harness import OUT, solve, test
from pattern_files import frames_file
from remeshing import at_steps, swinging
from results import Results
from solver import ROOT
from staging import end_of, stage

ANGLE, FRICTION, SLIP_SPEED, STEP, STAGES = math.radians(15), 0.4, 1e-3, 2e-3, 16


def on_slope(name, sizes, ranks):
    """A limp sheet that lies on a plane, gravity turned by 15 degrees: a stage in which it comes to rest, then one after the
    other with wanted sizes of their own, of two steps each. Returns how far its middle and its corner slip."""
    def motion(k, size):
        return stage(f"part_{k}", "dynamic", time={"end": 0.1 + 2 * k * STEP, "step": STEP, "velocity_tolerance": 1e-6},
                     **({"remesh": {"size": size, "smallest": 0.01, "largest": 0.04, "every": 1}} if size else {}))

    case = {"title": "A sheet on a slope", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"side": 0.2, "n": 8, "pattern": 2}},
            "material": [{"type": "isotropic", "young": 2e6, "poisson": 0.3, "thickness": 0.4e-3, "density": 400}],
            "load": [{"type": "gravity", "vector": [9.81 * math.sin(ANGLE), 0, -9.81 * math.cos(ANGLE)]}],
            "contact": {"distance": 1e-3, "stiffness": 1e4, "slip_speed": SLIP_SPEED},
            "obstacle": [{"name": "slope", "type": "plane", "normal": [0, 0, 1], "friction": FRICTION, "point": [0, 0, -0.9e-3]}],
            "damping": {"mass": 5.0}, "output": {"fields": ["displacement"], "every": 1000},
            "probe": [{"name": "middle", "type": "displacement", "point": [0.1, 0.1, 0]}, {"name": "corner", "type": "displacement", "point": [0, 0, 0]}],
            "stage": [motion(k, size) for k, size in enumerate([None, *sizes])]}
    result = solve(name, case, ranks)
    last, first = end_of(result, f"part_{len(sizes)}"), end_of(result, "part_1")
    changes = [end_of(result, f"part_{k}").summary["remeshing"]["count"] for k in range(1, len(sizes) + 1) if sizes[k - 1]]
    return [last.history[p][-1] - first.history[p][0] for p in ("middle_x", "corner_x")], changes, result


@test
def remesh_on_slope(report):
    """Friction that holds a sheet below the angle at which it would slide goes on holding it through a remeshing in every other step: it slips as on one mesh."""
    time = 2 * STAGES * STEP
    share = 1 - math.sqrt(1 - math.tan(ANGLE) / FRICTION)  # of the slip speed at which smoothed friction bears the weight
    still, _, _ = on_slope("remesh_slope_still", [None] * STAGES, 1)
    report.percent(still[0] / (share * SLIP_SPEED * time), 0.05, f"on one mesh it slips by {still[0]:.3g} m")
    for ranks in (1, 2):
        slips, changes, result = on_slope(f"remesh_slope_{ranks}", ["0.014", "0.03"] * (STAGES // 2), ranks)
        report.check(changes == [1] * STAGES and "refused" not in result.text.replace("0 refused", ""), f"{ranks} rank(s): {sum(changes)} remeshings in {2 * STAGES} steps")
        for slip, plain, what in zip(slips, still, ("middle", "corner")):
            report.percent(slip / plain, 1e-4, f"{ranks} rank(s): slip of the {what}, {slip:.3g} m, against one mesh")


def box(low, high):
    """An OBJ file of a box between two corners."""
    corners = [[(low, high)[i][0], (low, high)[j][1], (low, high)[k][2]] for k in (0, 1) for j in (0, 1) for i in (0, 1)]
    faces = [(1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)]
    return "".join("v {} {} {}\n".format(*c) for c in corners) + "".join(f"f {a} {b} {c}\nf {a} {c} {d}\n" for a, b, c, d in faces)


def cell_sizes(step, centre, within):
    """Longest edge of the triangles whose middle is at most so far from a vertical axis."""
    at, triangles = step.mesh.positions + step["displacement"], step.mesh.triangles
    middles = at[triangles].mean(axis=1)
    near = np.linalg.norm(middles[:, :2] - centre, axis=1) < within
    corners = at[triangles[near]]
    return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)


@test
def remesh_ahead(report):
    """A coarse sheet that falls on a knob of 6 mm, or on the edge of a box that comes up in frames, is fine there before it touches, on one rank and two; without the key it is not."""
    side, smallest, free = 0.2, 2e-3, 0.02
    text = box([0.07, -0.05, -0.1], [0.13, 0.25, -free])
    (OUT / "remesh_ahead.obj").write_text(text)
    corners = np.array([line.split()[1:] for line in text.splitlines() if line[0] == "v"], float)
    knob = {"name": "knob", "type": "sphere", "point": [0.11, 0.09, -free - 0.006], "radius": 0.006}
    edge = {"name": "edge", "type": "mesh", "file": str(OUT / "remesh_ahead.obj")} | frames_file("remesh_ahead.pc2", [corners + [0, 0, 2e-3 * k] for k in range(4)])
    for what, obstacle, places in (("knob", knob, [(0.11, 0.09)]), ("edge", edge, [(0.07, 0.1), (0.13, 0.05)])):
        first = None
        for on, ranks in ((True, 1), (True, 2), (False, 1)):
            case = {"title": "A sheet falls", "analysis": "dynamic", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"side": side, "n": 10, "pattern": 2}},
                    "material": [{"type": "isotropic", "young": 2e6, "poisson": 0.3, "thickness": 0.4e-3, "density": 400}],
                    "load": [{"type": "gravity", "vector": [0, 0, -9.81]}], "contact": {"distance": 1e-3, "stiffness": 1e4}, "obstacle": [obstacle],
                    "damping": {"mass": 1.0}, "time": {"end": 0.07, "step": 2e-3, "velocity_tolerance": 1e-5},
                    "remesh": {"smallest": smallest, "largest": 0.02, "near_obstacles": on}, "output": {"every": 1, "fields": ["displacement"]}}
            result = solve(f"remesh_ahead_{what}_{on}_{ranks}", case, ranks, timeout=300)
            h = result.history
            touches = int(h["step"][np.argmax(np.array(h["contact_pairs"]) > 0)])
            steps = {s.number: s for s in Results(result.folder)}
            report.check(max(h["contact_pairs"]) > 0 and sum(h["intersections"]) == 0, f"{what}, {ranks} rank(s): touches in step {touches}, with {h['vertices'][list(h['step']).index(touches)]:.0f} vertices")
            cells = np.concatenate([cell_sizes(steps[touches - 1], place, 0.004 if on else 0.012) for place in places])
            if on:
                report.check(cells.max() < 2.5 * smallest, f"{what}, {ranks} rank(s): one step before, cells of {cells.max():.3g} m there")
                first = first or steps
                report.check(all(np.array_equal(steps[n].mesh.positions, first[n].mesh.positions) for n in first if n < touches), f"{what}, {ranks} rank(s): the same meshes as on one")
            else:
                report.check(cells.max() > 5 * smallest, f"{what}: cells of {cells.max():.3g} m without")


@test
def remesh_flying(report):
    """A sheet that flies has stresses of nothing but round-off, whose error asks for no other mesh; one that is bent does."""
    case = {"analysis": "dynamic", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"side": 1, "n": 8}},
            "material": [{"type": "isotropic", "young": 1e6, "poisson": 0.3, "thickness": 5e-4, "density": 400.0}],
            "load": [{"type": "gravity", "vector": [0, 0, -9.81]}], "initial_velocity": [{"velocity": [1.0, 0.3, 2.0]}],
            "remesh": {"error": 0.02, "angle": 30.0, "smallest": 0.05, "largest": 0.3}, "time": {"end": 0.15, "step": 0.01},
            "output": {"every": 1000}}
    flies = solve("remesh_flying", case, 2)
    report.check(flies.summary["vertices"] <= 81, f"free: {flies.summary['vertices']} vertices")
    held = solve("remesh_flying_held", case | {"initial_velocity": [], "support": [{"type": "clamped", "group": "left"}]})
    report.check(held.summary["vertices"] > 100, f"held along an edge: {held.summary['vertices']} vertices")
    folds = {k: v for k, v in case.items() if k != "load"} | {
        "material": [case["material"][0] | {"thickness": 2e-3}], "remesh": {"angle": 8.0}, "time": {"end": 0.2, "step": 4e-3, "spectral_radius": 1.0},
        "initial_velocity": [{"velocity": [0.3, 0.1, -0.8]}, {"group": "left", "velocity": [0, 0, 1.6]}, {"group": "top", "velocity": [0, 0, 0.8]}],
        "output": {"fields": ["velocity"], "every": 1}}
    momenta, meshes = [], set()
    for step in Results(solve("remesh_flying_folds", folds).folder):
        mesh = step.mesh
        x, t = mesh.positions, mesh.triangles
        area = np.linalg.norm(np.cross(x[t[:, 1]] - x[t[:, 0]], x[t[:, 2]] - x[t[:, 0]]), axis=1) / 2
        mass = np.bincount(t.ravel(), np.repeat(area / 3 * 0.8, 3), len(x))
        momenta.append(mass @ step["velocity"])
        meshes.add(len(x))
    change = np.abs(np.array(momenta) - momenta[0]).max() / np.abs(momenta[0]).max()
    report.check(len(meshes) > 2, f"one that folds: {len(meshes)} meshes")
    report.below(change, 1e-9, "its momentum stays, in the steps after remeshings too")


ELLIPSE = """Point(1) = {0, 0, 0, 0.03}; Point(2) = {0.16, 0, 0, 0.03}; Point(3) = {0, 0.13, 0, 0.03}; Point(4) = {-0.16, 0, 0, 0.03}; Point(5) = {0, -0.13, 0, 0.03};
Ellipse(1) = {2, 1, 2, 3}; Ellipse(2) = {3, 1, 4, 4}; Ellipse(3) = {4, 1, 4, 5}; Ellipse(4) = {5, 1, 2, 2}; Curve Loop(1) = {1:4}; Plane Surface(1) = {1};
"""
GUTTER = """Point(1) = {0, 0, 0, 0.02}; Point(2) = {0.06, 0, 0, 0.02}; Point(3) = {0, 0, 0.06, 0.02}; Point(4) = {-0.06, 0, 0, 0.02};
Circle(1) = {2, 1, 3}; Circle(2) = {3, 1, 4}; s[] = Extrude{0, 0.2, 0}{ Curve{1, 2}; };
"""


@test
def remesh_curved_start(report):
    """A sheet with a curved rim and a curved shell, both without strain, get no energy from the mesh of their start, contact or not; where contact leaves no room for that the mesh is refused."""
    for what, text, ground, ranks in (("rim", ELLIPSE, -0.1, 1), ("shell", GUTTER, -0.1, 2), ("rim near the ground", ELLIPSE, -1.6e-3, 1)):
        path = OUT / f"remesh_curved_{what.split()[0]}.geo"
        path.write_text(text)
        case = {"analysis": "dynamic", "mesh": {"file": str(path)},
                "material": [{"type": "isotropic", "young": 2e6, "poisson": 0.3, "thickness": 4e-4, "density": 400}],
                "load": [{"type": "gravity", "vector": [0, 0, -9.81]}], "contact": {"distance": 1.5e-3, "stiffness": 1e4},
                "obstacle": [{"name": "ground", "type": "plane", "normal": [0, 0, 1], "point": [0, 0, ground]}],
                "remesh": {"smallest": 8e-3, "largest": 0.05}, "time": {"end": 8e-3, "step": 4e-3}, "output": {"fields": ["displacement"]}}
        result = solve(f"remesh_curved_{what.replace(' ', '_')}", case, ranks)
        h = result.history
        given = max(abs(e) for e in h["remeshing_gain"])
        room = "near" not in what
        report.check(given < 0.02 * h["work_of_loads"][-1], f"{what}: remeshing gives {given:.2g} J, gravity {h['work_of_loads'][-1]:.2g} J")
        report.check(sum(h["intersections"]) == 0 and (result.summary["remeshing"]["count"] > 0 or not room), f"{what}: {result.summary['remeshing']['count']} remeshings")


@test
def remesh_consistent_mass(report):
    """With the consistent mass matrix energy and momentum are those of that matrix: a new mesh of a strip that is hit neither gives nor takes energy, a plate that turns freely keeps its angular momentum."""
    for ranks in (1, 2):
        result = solve(f"remesh_consistent_{ranks}", swinging(time__mass="consistent", nx=10), ranks)
        h, table = result.history, Table(result.folder / "remeshing.csv")
        report.check(h["remeshings"][-1] >= 2, f"{ranks} rank(s): {h['remeshings'][-1]:.0f} remeshings")
        report.below(max(map(abs, h["remeshing_gain"])) / max(map(abs, h["work_of_loads"])), 1e-6, f"{ranks} rank(s): energy of remeshings, of the work")
        kinetic = at_steps(h, "kinetic_energy")
        report.below(max(abs(k / kinetic[s] - 1) for s, k in zip(table["step"], table["kinetic_before"])), 1e-10, f"{ranks} rank(s): remeshing.csv has the energy of the history")
    spin = [{"angular_velocity": [0, 0, 2.0], "centre": [5.0, 0.5, 0]}]
    plate = strip("dynamic", nx=4, ny=2, load=[], support=[], probe=[], initial_velocity=spin, time__mass="consistent", remesh={"size": "0.3", "smallest": 0.2, "largest": 2.0})
    result = solve("remesh_consistent_spin", plate, 1)
    turned = result.displacement(-1)
    kinetic = result.history["kinetic_energy"]
    report.check(result.history["remeshings"][-1] >= 1 and len(turned) > 100, "the plate got a mesh of many vertices")
    report.percent(kinetic[0] / (0.5 * 2.0**2 * 100.0 * (100 + 1) / 12), 1e-9, "kinetic energy of the plate, exact")
    report.percent(kinetic[-1] / kinetic[0], 1e-3, "and at the end")
