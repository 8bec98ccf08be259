"""Regression tests of contact that look at the recorded states themselves: what pierces what, and the signs of forces."""

import json
import math

import numpy as np

from cloth import Surface
from common import fresh, strip
from harness import OUT, solve, test
from solver import ROOT, invoke, run, variant, write_case

GRAVITY = 9.81


def pierced(points, triangles, others=None, other_triangles=None):
    """How many edges of the first mesh go through triangles of the second (by default the first itself, without those that
    share a vertex). Edges and triangles in floating point: what just touches is not asked for."""
    same = others is None
    if same:
        others, other_triangles = points, triangles
    edges = np.unique(np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1), axis=0)
    a, b, c = (others[other_triangles[:, k]] for k in range(3))
    normal, low, high = np.cross(b - a, c - a), np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    count = 0
    for i, j in edges:
        p, q = points[i], points[j]
        near = np.all((np.minimum(p, q) <= high) & (np.maximum(p, q) >= low), axis=1)
        if same:
            near &= ~np.any((other_triangles == i) | (other_triangles == j), axis=1)
        if not near.any():
            continue
        u, v, w, n = a[near], b[near], c[near], normal[near]
        below, above = np.einsum("ij,ij->i", n, p - u), np.einsum("ij,ij->i", n, q - u)
        sides = [np.einsum("j,ij->i", q - p, np.cross(s - p, t - p)) for s, t in ((u, v), (v, w), (w, u))]
        inside = np.all(np.array(sides) > 0, axis=0) | np.all(np.array(sides) < 0, axis=0)
        count += int(np.sum(inside & (below * above < 0)))
    return count


def pierced_in_states(result, every=1):
    """Piercings of the sheet by itself in the recorded states, found independently of the program; and how many states."""
    steps = result.results[::every]
    return sum(pierced(step.positions, step.mesh.triangles) for step in steps), len(steps)


@test
def piercing_is_seen(report):
    """The count of intersections that other tests rely on finds them where a sheet is folded through itself."""
    x, y = np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9), indexing="ij")
    number = np.arange(81).reshape(9, 9)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    angle = 1.5 * np.pi * x.ravel()
    spiral = np.stack([(1 + 0.5 * angle) * np.cos(2 * angle), y.ravel(), (1 + 0.5 * angle) * np.sin(2 * angle)], axis=1)
    report.check(pierced(spiral, triangles) == 0, "a spiral that passes itself at a distance: 0")
    circle = np.stack([(1 + 0.1 * np.sin(y.ravel() * 3)) * np.cos(2 * angle), y.ravel() + 0.01 * angle, np.sin(2 * angle)], axis=1)
    report.check(pierced(circle, triangles) > 0, f"one that passes through itself: {pierced(circle, triangles)}")
    flat = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    report.check(pierced(flat, triangles, flat[:, [0, 2, 1]] + [0.03, 0.52, -0.43], triangles) > 0, "two crossing sheets")


@test
def contact_forces(report):
    """A sheet held by friction on a slope: contact carries its weight across the slope, friction along it, with their signs."""
    angle, mu, density = math.atan(0.3), 0.6, 0.3
    weight = density * GRAVITY * 0.1**2
    case = {
        "analysis": "dynamic",
        "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"side": 0.1, "n": 4, "pattern": 0}},
        "material": [{"type": "isotropic", "young": 1e6, "poisson": 0.3, "thickness": 1e-3, "density": 1e3 * density}],
        "load": [{"type": "gravity", "vector": [GRAVITY * math.sin(angle), 0, -GRAVITY * math.cos(angle)]}],
        "contact": {"distance": 1e-3, "stiffness": 1e4, "self": False, "slip_speed": 1e-4},
        "obstacle": [{"name": "slope", "type": "plane", "normal": [0, 0, 1], "friction": mu, "point": [0, 0, -0.9e-3]}],
        "damping": {"mass": 20.0},
        "time": {"end": 1.0, "step": 0.005}, "output": {"every": 1000},
    }
    for ranks in (1, 2):
        surface = Surface(solve(f"contact_forces_{ranks}", case, ranks))
        normal, friction, pressure = (surface.fields[name] for name in ("contact_force", "friction_force", "contact_pressure"))
        what = f"{ranks} rank(s): "
        report.percent(normal.sum(axis=0)[2] / (weight * math.cos(angle)), 0.01, what + "contact force upwards, of the weight across")
        report.below(np.abs(normal[:, :2]).max() / weight, 1e-9, what + "and nothing along the slope")
        report.percent(friction.sum(axis=0)[0] / (-weight * math.sin(angle)), 0.01, what + "friction up the slope, of the weight along")
        report.check(pressure.min() >= 0, what + f"pressures of {pressure.min():.3g} to {pressure.max():.3g} Pa")
        corners, area = surface.rest[surface.triangles], np.zeros(len(pressure))
        size = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
        np.add.at(area, surface.triangles.ravel(), np.repeat(size / 3, 3))
        report.percent((pressure * area).sum() / (weight * math.cos(angle)), 0.01, what + "pressure times area, of the weight across")


@test
def pressed_between(report):
    """A sheet between a floor and a lid that comes down: its contact pressure is that of either, though both forces cancel."""
    case = {
        "analysis": "static", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"side": 0.1, "n": 4}},
        "material": [{"type": "isotropic", "young": 1e7, "poisson": 0.3, "thickness": 1e-3, "density": 500}], "contact": {"distance": 1e-3},
        "support": [{"type": "displacement", "group": "plate", "components": ["x", "y"]}],
        "obstacle": [{"name": "floor", "type": "plane", "normal": [0, 0, 1], "point": [0, 0, -0.9e-3]},
                     {"name": "lid", "type": "plane", "normal": [0, 0, -1], "point": [0, 0, 0.9e-3], "motion": ["0", "0", "-0.5e-3 * t"]}],
        "steps": {"initial_step": 0.5}, "probe": [{"name": name, "type": "contact", "obstacle": name} for name in ("floor", "lid")],
    }
    for ranks in (1, 2):
        surface = Surface(result := solve(f"pressed_between_{ranks}", case, ranks))
        pressure, force = surface.fields["contact_pressure"].ravel(), abs(result.history["floor_z"][-1])
        report.percent(force / abs(result.history["lid_z"][-1]), 1e-6, f"{ranks} rank(s): both press alike, by {force:.3g} N")
        report.below(np.abs(surface.fields["contact_force"]).max() / force, 1e-6, "their sum at a vertex is nothing")
        report.percent(pressure.mean() / (force / 0.01), 1e-6, "pressure, of force over area")


@test
def tied_sheets(report):
    """A strip cut in two and joined again by springs between the cuts carries the load of the whole one."""
    lines = ['SetFactory("Built-in");']
    for k in (0, 1):
        x, p = 1.0 * k + (0.0 if k == 0 else 1e-3), 10 * k
        for n, (dx, y) in enumerate(((0, 0), (1, 0), (1, 0.2), (0, 0.2)), 1):
            lines.append(f"Point({p + n}) = {{{x + dx}, {y}, 0}};")
        for n in range(1, 5):
            lines.append(f"Line({p + n}) = {{{p + n}, {p + n % 4 + 1}}}; ")
        lines += [f"Curve Loop({p + 1}) = {{{p + 1}, {p + 2}, {p + 3}, {p + 4}}};", f"Plane Surface({p + 1}) = {{{p + 1}}};",
                  f"Transfinite Curve {{{p + 1}, {p + 3}}} = 11; Transfinite Curve {{{p + 2}, {p + 4}}} = 3;",
                  f"Transfinite Surface {{{p + 1}}};"]
    lines += ['Physical Surface("sheet") = {1, 11};', 'Physical Curve("clamp") = {4};', 'Physical Curve("cut") = {2};',
              'Physical Curve("other") = {14};', 'Physical Curve("tip") = {12};', "Mesh.MeshSizeMax = 1;"]
    OUT.mkdir(parents=True, exist_ok=True)
    (OUT / "tied.geo").write_text("\n".join(lines) + "\n")
    case = {
        "analysis": "static", "mesh": {"file": str(OUT / "tied.geo")},
        "material": [{"type": "isotropic", "young": 1e6, "poisson": 0.0, "thickness": 1e-2}],
        "support": [{"type": "clamped", "group": "clamp"}],
        "load": [{"type": "line", "group": "tip", "vector": [50.0, 0, 0]}],
        "spring": [{"type": "pair", "group": "cut", "to": "other", "stiffness": 1e5}],
        "probe": [{"name": "tip", "type": "displacement", "group": "tip"}],
    }
    # Out of plane the second piece hangs on its springs: the pull holds it.
    case["support"].append({"type": "displacement", "group": "tip", "components": ["y", "z"]})
    ends = []
    for ranks in (1, 2, 3):
        ends.append(solve(f"tied_{ranks}", case, ranks).history["tip_x"][-1])
    force, stiffness = 50.0 * 0.2, 3 * 1e5
    # Two strips in series with three springs; the forces of the ends spread like those of a uniform pull only nearly.
    expected = 2 * 50.0 / (1e6 * 1e-2) + force / stiffness
    report.below(ends[0] / expected - 1, 0.02, f"{ends[0]:.6f} m, strips and springs in series {expected:.6f} m, relative difference")
    report.below(max(abs(e / ends[0] - 1) for e in ends), 1e-8, "the same on 1, 2 and 3 ranks")


@test
def contact_last_iterations(report):
    """Steps that end by the residual: near the solution the exact tangent is taken again. With positive ones alone, forty at a time, the iteration
    converges linearly (702 iterations)."""
    case = {
        "analysis": "dynamic", "element": {"cst_fraction": 0.3},
        "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"side": 1, "n": 20}},
        "material": [{"type": "isotropic", "young": 1e6, "poisson": 0.3, "thickness": 5e-4, "density": 400}],
        "load": [{"type": "gravity", "vector": [0, 0, -GRAVITY]}],
        "contact": {"distance": 1e-3, "stiffness": 1e4, "friction": 0.2},
        "obstacle": [{"name": "ball", "type": "sphere", "point": [0.5, 0.5, -0.26], "radius": 0.25, "friction": 0.2}],
        "time": {"end": 0.4, "step": 0.01, "target_iterations": 200}, "output": {"every": 10},
    }
    result = solve("contact_last_iterations", case)
    iterations = result.summary["newton_iterations"]
    report.check(iterations < 560, f"{iterations} iterations for {result.summary['steps']} steps, allowed 560")
    report.check(result.history["residual"].max() < 1e-6 and pierced_in_states(result)[0] == 0, "in equilibrium, nothing intersects")


@test
def contact_follower(report):
    """A load that follows the sheet makes tangents unsymmetric: a motion that begins in contact, which fills the matrix before the first factor, goes on, the same on 1 and 2 ranks."""
    case = {"title": "A sheet is pressed on another", "analysis": "dynamic",
            "mesh": {"file": str(ROOT / "meshes" / "sheets.geo"), "parameters": {"sheets": 2, "n": 4, "gap": 0.008}},
            "material": [{"type": "isotropic", "young": 1e6, "poisson": 0.3, "thickness": 1e-3, "density": 1000.0}],
            "support": [{"type": "hinged", "group": side} for side in ("left 1", "right 1")],
            "load": [{"type": "follower_pressure", "group": "sheet 2", "magnitude": -50.0}],
            "contact": {"distance": 0.01}, "time": {"end": 0.05, "step": 5e-3}}
    ends = []
    for ranks in (1, 2):
        result = run(write_case(case, OUT / "contact_follower.toml"), fresh(f"contact_follower_{ranks}"), ranks)
        report.check(result.code == 0, f"{ranks} rank(s), code {result.code}: {result.text.strip().splitlines()[-1][:120]}")
        if result.code == 0:
            ends.append(result.history["kinetic_energy"][-1])
    report.check(len(ends) == 2 and abs(ends[1] / ends[0] - 1) < 1e-6, f"kinetic energy at the end: {ends}")


@test
def stages_in_contact(report):
    """A drape that falls moves no support, and a sheet that one stage lets out of a barrier is not thrown by the next."""
    mesh = {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"n": 6, "side": 0.2}}
    sheet = {"type": "isotropic", "young": 1e7, "poisson": 0.3, "thickness": 2e-3, "density": 200.0}
    case = {"title": "Moved later", "mesh": mesh, "material": [sheet], "contact": {}, "load": [{"type": "gravity", "vector": [0, 0, -GRAVITY]}],
            "support": [{"type": "clamped", "group": "left"}, {"type": "displacement", "group": "right", "components": ["z"], "motion": ["0", "0", "0.01*t"]}],
            "probe": [{"name": "right", "type": "displacement", "group": "right"}],
            "stage": [{"name": "a", "analysis": "drape"}, {"name": "b", "analysis": "dynamic", "time": {"end": 0.1, "step": 0.01}}]}
    result = solve("stages_fall", case)
    report.below(abs(result.stage("a").history["right_z"][-1]), 1e-15, "a support with a motion in the drape: way [m]")
    report.below(abs(result.stage("b").history["right_z"][-1] - 1e-3), 1e-12, "and after 0.1 s at 0.01 m/s: off [m]")
    stages = [{"name": n, "analysis": "dynamic", "time": {"end": end, "step": 1e-3}} for n, end in (("a", 0.02), ("b", 0.2))]
    case = {"title": "Let out", "mesh": mesh | {"translate": [0, 0, 8e-4]}, "material": [sheet], "contact": {"distance": 2e-3},
            "obstacle": [{"name": "table", "type": "plane", "point": [0, 0, 0], "normal": [0, 0, 1]}], "load": case["load"],
            "damping": {"mass": 5.0}, "probe": [{"name": "sheet", "type": "displacement", "group": "plate"}], "stage": stages}
    height = solve("stages_let_out", case).stage("b").history["sheet_z"]
    report.below(height.max() + 8e-4, 3e-3, "height of a sheet that begins 0.8 mm over a table with a barrier of 2 mm [m]")
    path = strip("static", nx=4, ny=1, support=[{"type": "displacement", "group": "plate", "components": ["x", "y", "z"], "motion": ["0", "0", "0.01*t"]}])
    del path["analysis"], path["time"]
    path["stage"] = [{"name": "a", "analysis": "static"}, {"name": "b", "analysis": "dynamic", "time": {"end": 0.1, "step": 0.05}}]
    path["material"][0]["expansion"] = 1e-5
    path["temperature"] = [{"group": "plate", "change": "10*t"}]
    said = solve("stages_two_clocks", path).text
    for what in ("support", "temperature"):
        report.check(f"note: [[{what}]] group 'plate' stays in stage 'b'" in said, f"a {what} by the load factor does not go on in time, and this is said")


@test
def fast_obstacle(report):
    """A ball that would go through where a sheet is within one step, so that the iteration slips off it, is followed in shorter ones."""
    for cells, speed, step in ((6, 10.0, 0.01), (12, 20.0, 0.005)):
        case = {"analysis": "dynamic", "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"length": 0.3, "width": 0.1, "nx": cells, "ny": cells // 3}},
                "material": [{"type": "isotropic", "young": 1e7, "poisson": 0.3, "thickness": 1e-3, "density": 1000.0}], "support": [{"type": "clamped", "group": "clamp"}],
                "contact": {"distance": 2e-3, "stiffness": 1e4}, "time": {"step": step, "end": 0.1 / speed}, "output": {"every": 1000},
                "obstacle": [{"name": "ball", "type": "sphere", "point": [0.25, 0.05, -0.03], "radius": 0.02, "motion": ["0", "0", f"{speed}*t"]}],
                "probe": [{"name": "sheet", "type": "height", "group": "all"}, {"name": "ball", "type": "contact", "obstacle": "ball"}]}
        case["probe"][0]["group"] = "plate"
        h = solve("fast_obstacle", case).history
        lifted = max(h[name].max() for name in h.names if name.startswith("sheet"))
        report.check(np.abs(h["ball_z"]).max() > 5.0 and lifted > 0.05, f"{cells} cells, {speed:g} m/s: thrown up by {lifted:.3g} m with {np.abs(h['ball_z']).max():.3g} N")


@test
def stages_in_impact(report):
    """A sheet that a stage leaves while it bounces keeps its barrier, which its own inertia balances, and comes off as fast as in one stage."""
    case = {"title": "Bounce", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"n": 4}}, "contact": {"distance": 0.01},
            "material": [{"type": "isotropic", "young": 1e6, "poisson": 0.3, "thickness": 2e-3, "density": 1e3}],
            "initial_velocity": [{"velocity": [0, 0, -0.5]}], "obstacle": [{"name": "floor", "type": "plane", "point": [0, 0, -0.02], "normal": [0, 0, 1]}]}
    steps = {"step": 2e-4, "max_step": 2e-4, "velocity_tolerance": 1e-6}
    whole = solve("impact_whole", case | {"analysis": "dynamic", "time": steps | {"end": 0.03}}).history["kinetic_energy"][-1]
    staged = case | {"time": steps, "stage": [{"name": n, "analysis": "dynamic", "time": {"end": end}} for n, end in (("a", 0.023), ("b", 0.03))]}
    for ranks in (1, 2):
        result = solve("impact_staged", staged, ranks)
        report.percent(result.stage("b").history["kinetic_energy"][-1] / whole, 0.005, f"{ranks} rank(s): kinetic energy after it")
    again = run(OUT / "impact_staged.toml", result.folder, 1, ["--from", "b"])
    report.check(again.code == 0, f"--from b: code {again.code}")
    stages = json.loads((result.folder / "summary.json").read_text())["stages"]
    report.check([(s["name"], s.get("of_an_earlier_run", False)) for s in stages] == [("a", True), ("b", False)], "the summary keeps the stage before")
    report.percent(again.stage("b").history["kinetic_energy"][-1] / whole, 0.005, "the same from the checkpoint of the stage before")
    # A barrier that is wider in the next stage begins where it presses as much.
    rests = {k: v for k, v in case.items() if k != "initial_velocity"} | {
        "load": [{"type": "gravity", "vector": [0, 0, -GRAVITY]}], "damping": {"mass": 40.0}, "mesh": case["mesh"] | {"translate": [0, 0, -0.0105]},
        "stage": [{"name": "a", "analysis": "dynamic", "time": {"end": 0.4, "step": 2e-3}},
                  {"name": "b", "analysis": "dynamic", "time": {"end": 0.5, "step": 2e-3}, "contact": {"distance": 0.015}}]}
    result = solve("rest_wider", rests)
    before, after = (result.stage(name).history["smallest_gap"] for name in "ab")
    report.check(after.min() > 0.997 * before[-1] and after[-1] > 1.1 * before[-1], f"lifted from a gap of {before[-1]:.4g} to {after[-1]:.4g} m, the least {after.min():.4g}")


@test
def passing_in_stages(report):
    """What passes through an obstacle does not pass through another one of the next stage, and an analysis without motion says that it cannot begin so."""
    ball = {"type": "sphere", "radius": 0.03, "on_pinch": "pass"}
    case = {"title": "Pinched", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"n": 6, "side": 0.1}},
            "material": [{"type": "isotropic", "young": 1e6, "poisson": 0.3, "thickness": 1e-3, "density": 300.0}],
            "support": [{"type": "clamped", "group": side} for side in ("left", "right", "bottom", "top")], "contact": {"distance": 1e-3}, "damping": {"mass": 50.0},
            "obstacle": [ball | {"name": "low", "point": [0.05, 0.05, -0.035], "stages": ["a"]},
                         ball | {"name": "high", "point": [0.05, 0.05, 0.035], "motion": ["0", "0", "-0.1*min(t, 0.1)"]}],
            "stage": [{"name": "a", "analysis": "dynamic", "time": {"end": 0.1, "step": 2e-3}}, {"name": "b", "analysis": "dynamic", "time": {"end": 0.11, "step": 2e-3}}]}
    result = solve("passing_other", case)
    report.check(result.stage("a").history["passing"][-1] > 0, "vertices pass through the ball below")
    report.check(max(result.stage("b").history["passing"]) == 0, "without it none passes")
    del case["obstacle"][0]["stages"]
    for analysis in ("static", "drape"):
        case["stage"][1] = {"name": "b", "analysis": analysis}
        result = run(write_case(case, OUT / "passing_rest.toml"), fresh("passing_rest"))
        report.check(result.code == 2 and "pass in a motion only" in result.text, f"{analysis}, code {result.code}: {result.text.strip().splitlines()[-1][:200]}")


@test
def friction_at_rest(report):
    """What friction holds on a slope stays there when a static analysis goes on from it, and a restart still shows what holds it."""
    case = {"title": "A sheet on a slope", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"n": 4}},
            "material": [{"type": "isotropic", "young": 1e7, "poisson": 0.3, "thickness": 0.01, "density": 1000.0}],
            "support": [{"type": "displacement", "group": side, "components": ["y"]} for side in ("bottom", "top")],
            "spring": [{"type": "line", "group": "left", "stiffness": 8.0, "direction": [1, 0, 0]}],
            "load": [{"type": "gravity", "vector": [2.0, 0, -9.0]}], "contact": {"distance": 0.02, "stiffness": 1e4},
            "obstacle": [{"name": "slope", "type": "plane", "point": [0, 0, -0.02], "normal": [0, 0, 1], "friction": 0.5}],
            "stage": [{"name": "lie", "analysis": "drape"}, {"name": "hold", "analysis": "static", "steps": {"initial_step": 1.0}}]}
    staged = solve("friction_at_rest", case, 2)
    constant = {k: v for k, v in case.items() if k != "stage"} | {"analysis": "static", "steps": {"initial_step": 1.0}}
    at_once = solve("friction_constant", constant | {"load": [case["load"][0] | {"constant": True}]})
    again = solve("friction_again", constant, options=["--restart", str(at_once.results.file)])
    for name, result in (("from a drape", staged), ("at load factor 0", at_once), ("a restart at the end", again)):
        last = (result.results if name != "from a drape" else result.stage("hold").results)[-1]
        report.below(last["displacement"][:, 0].max(), 5e-3, f"{name}: way down the slope [m], 2.5 without friction")
        report.percent(last["friction_force"][:, 0].sum() / -20.0, 0.01, f"{name}: friction up the slope, of the weight along")


@test
def start_inside(report):
    """A sheet that begins within the activation distance is let out gently; that its barrier grows is not taken for energy that steps create."""
    case = {"analysis": "dynamic", "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"side": 0.1, "n": 4}, "translate": [0, 0, 9e-4]},
            "material": [{"type": "isotropic", "young": 1e6, "poisson": 0.3, "thickness": 1e-3, "density": 200.0}],
            "load": [{"type": "gravity", "vector": [0, 0, -9.81]}], "contact": {"distance": 1e-3, "stiffness": 1e3},
            "obstacle": [{"name": "floor", "type": "plane", "point": [0, 0, 0], "normal": [0, 0, 1]}],
            "time": {"end": 0.12, "step": 1e-3, "velocity_tolerance": 1e-7}, "output": {"every": 120}}
    done = solve("start_inside", case)
    loss = done.history["numerical_loss"][-1]
    report.check(loss < -1e-6 and "has created" not in done.text, f"numerical loss {loss:.3g} J, that of the barrier, and no warning")
    corners = [(x, y, z) for z in (-0.5, 0.5) for y in (-0.5, 0.5) for x in (-0.5, 0.5)]
    faces = [(1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)]
    (OUT / "start_box.obj").write_text("".join("v {} {} {}\n".format(*c) for c in corners) + "".join("f {} {} {} {}\n".format(*f) for f in faces))
    for up, inside in ((0.0, True), (0.6, False)):
        boxed = variant(case, {"mesh.translate": [0, 0, up], "obstacle": [{"name": "box", "type": "mesh", "file": str(OUT / "start_box.obj")}]})
        code, said = invoke(["check", write_case(boxed, OUT / "start_box.toml")])
        report.check(code == 0 and ("the sheet lies inside of [[obstacle]] 'box'" in said) == inside, f"a box around it is said, one below is not: code {code}")


@test
def ring_between_plates(report):
    """An obstacle that moves by the load factor: a quarter of a ring under a plate, against the elastica (runs/contact/exact)."""
    width, distance, wanted = math.pi / 48, 1e-3, {0.2: 2.11530, 0.4: 3.98761}
    stiff = np.diag([1, 1, 0.5])
    case = {"analysis": "static",
            "mesh": {"file": str(ROOT / "meshes" / "cylinder.geo"),
                     "parameters": {"radius": 1.0, "length": 2 * width, "n_axial": 1, "n_circ": 24, "pattern": 1}},
            "material": [{"type": "matrices", "membrane": (1e5 * stiff).tolist(), "bending": stiff.tolist()}],
            "support": [{"type": "symmetry", "group": "crown", "normal": [1, 0, 0]}, {"type": "symmetry", "group": "flank", "normal": [0, 0, 1]},
                        {"type": "displacement", "group": "shell", "components": ["y"]}],
            "contact": {"distance": distance, "stiffness": 1e5, "self": False},
            "obstacle": [{"name": "plate", "type": "plane", "point": [0, 0, 1 + distance], "normal": [0, 0, -1],
                          "motion": ["0", "0", f"-{max(wanted) + 2 * distance}*t"]}],
            "probe": [{"name": "plate", "type": "contact", "obstacle": "plate"},
                      {"name": "crown", "type": "displacement", "group": "crown", "components": ["z"]}],
            "steps": {"max_step": 0.1}}
    for ranks in (1, 2):
        result = solve(f"ring_between_plates_{ranks}", case, ranks)
        way, force = -result.history["crown_z"], 2 * result.history["plate_z"] / width
        for d, exact in wanted.items():
            at = np.argsort(np.abs(way - d))[:4]
            report.percent(np.polyval(np.polyfit(way[at] - d, force[at], 3), 0) / exact, 0.003, f"{ranks} rank(s), d = {d:g}: force of a plate")
    staged = {key: value for key, value in case.items() if key not in ("analysis", "steps")}
    staged["stage"] = [{"name": "wait", "analysis": "drape"}, {"name": "press", "analysis": "static", "steps": case["steps"]},
                       {"name": "hold", "analysis": "static"}]
    held = solve("ring_between_plates_staged", staged)
    waits, pressed, holds = (held.stage(name).history["plate_z"] for name in ("wait", "press", "hold"))
    last = result.history["plate_z"][-1]
    report.check(abs(waits[-1]) < 1e-9 and abs(pressed[-1] / last - 1) < 1e-6 and np.all(abs(holds / last - 1) < 1e-6),
                 f"in stages it stands still, moves, and stays: {waits[-1]:.3g}, {pressed[-1]:.6g}, {holds[-1]:.6g} N, at once {last:.6g} N")
    places = [step.obstacles[0, 2] for step in result.results]
    report.check(places[-1] < places[0] - 0.4, f"its place is recorded: {places[0]:.4g} to {places[-1]:.4g}")


@test
def ball_turns_on_plate(report):
    """A ball pressed into a plate turns there by the load factor: the rim holds against what the ball bears, friction moves the plate, a restart keeps every bit."""
    case = {"analysis": "static", "mesh": {"file": str(ROOT / "meshes" / "disc.geo"), "parameters": {"n": 8}},
            "material": [{"type": "isotropic", "young": 1e9, "poisson": 0.3, "thickness": 1e-3}],
            "support": [{"type": "clamped", "group": "edge"}], "contact": {"distance": 1e-3, "stiffness": 1e6, "self": False},
            "probe": [{"name": "ball", "type": "contact", "obstacle": "ball"}, {"name": "rim", "type": "reaction", "group": "edge"}]}
    ball = {"name": "ball", "type": "sphere", "radius": 0.1, "point": [0, 0, 0.101], "friction": 0.5,
            "motion": ["0", "0", "-0.02*min(2*t, 1)"], "rotation_axis": [1, 0, 0], "rotation_centre": [0, 0, 0.08], "rotation_angle": "10*max(2*t - 1, 0)"}
    case["obstacle"] = [ball]
    done = solve("ball_turns", case)
    h = done.history
    force, rim = ([h[f"{name}_{k}"][-1] for k in "xyz"] for name in ("ball", "rim"))
    report.check(all(abs(f - r) < 2e-5 * abs(force[2]) for f, r in zip(force, rim)), f"the ball bears {np.round(force, 4)} N, the rim holds {np.round(rim, 4)} N")
    pressed = np.argmax(h["load_factor"] >= 0.5)
    report.check(abs(h["ball_y"][pressed]) < 0.02 * h["ball_z"][-1] and -h["ball_y"][-1] > 0.3 * h["ball_z"][-1], f"turned about x it is pulled back: {h['ball_y'][pressed]:.3g}, then {h['ball_y'][-1]:.3g} N")
    solve("ball_turns_half", case | {"steps": {"final_load_factor": 0.5}})
    again = solve("ball_turns_again", case, options=["--restart", str(OUT / "ball_turns_half" / "checkpoint.h5")])
    same = done.results[-1].positions - again.results[-1].positions
    report.check(np.all(same == 0), f"a restart at half of the way ends at the same places, to {abs(same).max():.1g} m")
    for keys, why in (({"analysis": "drape"}, "moves only with"), ({"analysis": "static", "steps": {"control": "arc_length"}}, "load"),
                      ({"obstacle": [ball | {"on_pinch": "pass"}]}, "obstacle.on_pinch"),
                      ({"probe": [case["probe"][0] | {"obstacle": "bal"}]}, "did you mean 'ball'")):
        refused = run(write_case(case | keys, OUT / "ball_refused.toml"), fresh("ball_refused"))
        report.check(refused.code == 2 and why in refused.text, f"{keys}: code {refused.code}: {refused.text.strip().splitlines()[-1][:150]}")


@test
def strip_between_jaws(report):
    """Two plates close on a strip with friction and nothing else acts, then its end is pulled out: forces of both sides cancel at each vertex."""
    gap, close, pull, mu = 1e-3, 5e-4, 1e-2, 0.3
    case = {"analysis": "static",
             "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"length": 0.2, "width": 0.04, "nx": 20, "ny": 4}},
             "material": [{"type": "isotropic", "young": 1e9, "poisson": 0.3, "thickness": 1e-3}],
             "contact": {"distance": gap, "stiffness": 1e4, "self": False},
             "support": [{"type": "displacement", "group": "tip", "components": ["x"], "motion": [f"{pull}*max(2*t - 1, 0)", "0", "0"]}],
             "obstacle": [{"name": "below", "type": "plane", "point": [0, 0, -0.95 * gap], "normal": [0, 0, 1], "friction": mu},
                          {"name": "above", "type": "plane", "point": [0, 0, 0.95 * gap], "normal": [0, 0, -1], "friction": mu,
                           "motion": ["0", "0", f"-{close / 2}*min(2*t, 1)"]}],
             "probe": [{"name": "below", "type": "contact", "obstacle": "below"}, {"name": "above", "type": "contact", "obstacle": "above"},
                       {"name": "pull", "type": "reaction", "group": "tip", "components": ["x"]}],
             "steps": {"initial_step": 0.1, "max_step": 0.1}}
    whole = solve("strip_between_jaws", case)
    h = whole.history
    report.check(h["above_z"][-1] > 0 and abs(h["above_z"][-1] + h["below_z"][-1]) < 1e-5 * h["above_z"][-1], f"pressed alike: {h['above_z'][-1]:.6g}, {h['below_z'][-1]:.6g} N")
    rubbed = h["above_x"][-1] + h["below_x"][-1]
    report.check(abs(rubbed - h["pull_x"][-1]) < 1e-4 * rubbed, f"what pulls is what rubs: {h['pull_x'][-1]:.6g}, {rubbed:.6g} N")
    report.percent(rubbed / (2 * mu * h["above_z"][-1]), 0.01, "which is mu times what both press")
    half = solve("strip_jaws_half", case | {"steps": case["steps"] | {"final_load_factor": 0.8}})
    again = solve("strip_jaws_again", case, options=["--restart", str(half.folder / "checkpoint.h5")])
    report.check(again.history["above_x"][0] == half.history["above_x"][-1] and again.history["above_x"][-1] == h["above_x"][-1],
                 f"a restart begins and ends with the friction of the unbroken run, to the last bit: {again.history['above_x'][0]:.12g}, {half.history['above_x'][-1]:.12g} N")
    jump = case | {"obstacle": [case["obstacle"][0], case["obstacle"][1] | {"motion": ["0", "0", "-10*(t>0.5)"]}]}
    result = run(write_case(jump, OUT / "strip_jaws_jump.toml"), fresh("strip_jaws_jump"))
    report.check(result.code == 3 and len(result.history["load_factor"]) < 30, f"a plate that jumps through: code {result.code}, {len(result.history['load_factor'])} rows: {result.text.strip().splitlines()[-1][:200]}")
