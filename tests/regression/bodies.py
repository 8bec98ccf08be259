"""Bodies: the command `manikin`, and edges of a sheet that are held to a body which moves."""

import struct

import h5py
import numpy as np
from pattern_files import part, tube
from harness import OUT, solve, test
from common import fresh
from solver import ROOT, invoke, run, variant, write_case


def read_obj(file):
    rows = [line.split() for line in file.read_text().splitlines()]
    x = np.array([r[1:4] for r in rows if r[0] == "v"], float)
    return x, np.array([r[1:4] for r in rows if r[0] == "f"], int) - 1


def read_pc2(file):
    data = file.read_bytes()
    version, vertices, start, rate, samples = struct.unpack("<iiffi", data[12:32])
    assert data[:12] == b"POINTCACHE2\0" and version == 1 and start == 0 and rate == 1
    return np.frombuffer(data[32:], "<f4").reshape(samples, vertices, 3).astype(float)


def hull(points):
    """Perimeter of the convex hull: the width over all directions, integrated (Cauchy)."""
    angle = np.linspace(0, np.pi, 2000, endpoint=False)
    along = points @ np.stack([np.cos(angle), np.sin(angle)])
    return np.pi * np.mean(along.max(0) - along.min(0))


def tape(x, triangles, z):
    """Around the piece of the section that has the axis inside it."""
    edges = np.unique(np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1), axis=0)
    key = {tuple(e): k for k, e in enumerate(edges)}
    cut = (x[edges[:, 0], 2] > z) != (x[edges[:, 1], 2] > z)
    t = (z - x[edges[:, 0], 2]) / np.where(cut, x[edges[:, 1], 2] - x[edges[:, 0], 2], 1)
    points = (x[edges[:, 0]] + t[:, None] * (x[edges[:, 1]] - x[edges[:, 0]]))[:, :2]
    joined = {}
    for a, b, c in triangles:
        ends = [k for e in ((a, b), (b, c), (c, a)) if cut[k := key[tuple(sorted(e))]]]
        if ends:
            joined.setdefault(ends[0], []).append(ends[1])
            joined.setdefault(ends[1], []).append(ends[0])
    girth, left = 0.0, set(joined)
    while left:
        loop, front = [], [left.pop()]
        while front:
            k = front.pop()
            loop.append(k)
            for other in joined[k]:
                if other in left:
                    left.remove(other)
                    front.append(other)
        p = points[loop]
        if p[:, 0].min() < 0 < p[:, 0].max():
            girth = max(girth, hull(p))
    return girth


@test
def manikin(report):
    """A figure and a form with the girths that were asked for, measured independently; frames from rest; what is wrong is named."""
    asked = {"height": 1.68, "bust": 0.92, "waist": 0.74, "hip": 1.0, "inseam": 0.76}
    options = [word for name, value in asked.items() for word in (f"--{name}", str(value))]
    for kind in ("figure", "form"):
        file = OUT / f"manikin_{kind}.obj"
        OUT.mkdir(parents=True, exist_ok=True)
        code, text = invoke(["manikin", file, "--kind", kind, "--motion", "turn" if kind == "form" else "walk", "--seconds", "1", *options])
        report.check(code == 0, f"{kind}: made" + text * (code != 0))
        x, triangles = read_obj(file)
        words = text.split("girth of ")[1].split()
        heights = {"bust": words[5], "waist": words[9], "hip": words[13]}
        for name, z in heights.items():
            report.percent(tape(x, triangles, float(z.rstrip(","))) / asked[name], 0.01, f"{kind}: tape at {name}")
        marks = {name: float(z) for name, _, _, z in (line.split(",") for line in file.with_suffix(".landmarks.csv").read_text().splitlines())}
        report.check(all(f"{marks[n]:.4f}" == heights[n].rstrip(",") for n in heights), f"{kind}: the points of these names are at these heights")
        report.check(("left wrist" in marks) == (kind == "figure"), f"{kind}: points of arms")
        sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
        twins = {tuple(s) for s in sides}
        report.check(len(twins) == len(sides) and all((b, a) in twins for a, b in twins), f"{kind}: closed and oriented")
        report.check(len(x) - len(sides) // 2 + len(triangles) == 2, f"{kind}: no handle")
        report.check(np.sum(np.linalg.det(x[triangles])) > 0, f"{kind}: outwards")
        frames = read_pc2(file.with_suffix(".pc2"))
        report.check(frames.shape == (51, len(x), 3), f"{kind}: 51 frames")
        report.below(float(np.abs(frames[0] - x).max()), 1e-6, f"{kind}: the first is the mesh")
        report.below(50 * float(np.linalg.norm(frames[1] - frames[0], axis=1).max()), 0.03, f"{kind}: speed of the first frame [m/s]")
    for person, motion, height, hip in (("man", "sit", 1.8, 0.98), ("child", "run", 1.04, 0.605), ("child", "walk", 0.74, 0.485), ("woman", "lift", 1.74, 0.94)):
        file = OUT / f"manikin_{person}.obj"
        code, text = invoke(["manikin", file, "--person", person, "--height", height, "--motion", motion, "--arms", 5, "--seconds", 1.5, "--fps", 20])
        report.check(code == 0 and "none intersects itself" in text, f"{person} of {height} m: {motion}" + text * (code != 0))
        x, triangles = read_obj(file)
        report.percent(tape(x, triangles, float(text.split("hip ")[1].split()[2].rstrip(","))) / hip, 0.01, f"{person} of {height} m: tape at the hip")
        report.percent(x[:, 2].max() / height, 0.01, f"{person} of {height} m: height")
    once = (OUT / "manikin_form.obj").read_bytes()
    invoke(["manikin", OUT / "manikin_form.obj", "--kind", "form", *options])
    report.check((OUT / "manikin_form.obj").read_bytes() == once, "the same again")
    code, _ = invoke(["manikin", OUT / "manikin_two.obj", "--kind", "form", *options], ranks=2)
    report.check(code == 0 and (OUT / "manikin_two.obj").read_bytes() == once, "of two ranks the first makes it")
    for wrong, word in ((["--waist", "74"], "waist"), (["--kind", "form", "--motion", "walk"], "limbs"), (["--person", "child", "--height", "0.5"], "height of a child"),
                        (["--seconds", "2"], "--seconds"), (["--motion", "sit", "--speed", "2"], "--speed"), (["--motion", "walk", "--angle", "9"], "--angle"), (["--size", "1"], "size"),
                        (["--arms", "0"], "arms"), (["--motion", "walk", "--speed", "9"], "speed"), (["--bust", "nan"], "bust")):
        code, text = invoke(["manikin", OUT / "manikin_wrong.obj", *wrong])
        report.check(code == 2 and word in text, f"{' '.join(wrong)}: refused, and {word} is named")
    report.check(not (OUT / "manikin_wrong.obj").exists(), "nothing is left of those")


def block(name):
    """A box below the strip of `held`."""
    corners = [(x, y, z) for z in (-0.4, -0.1) for x, y in ((-0.3, -0.3), (0.6, -0.3), (0.6, 0.8), (-0.3, 0.8))]
    faces = [(1, 3, 2), (1, 4, 3), (5, 6, 7), (5, 7, 8), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 4, 8), (3, 8, 7), (4, 1, 5), (4, 5, 8)]
    OUT.mkdir(parents=True, exist_ok=True)
    (OUT / name).write_text("".join("v %g %g %g\n" % c for c in corners) + "".join("f %d %d %d\n" % f for f in faces))
    return str(OUT / name)


def held(nx=12, **changes):
    """A strip whose edge is held to a block that turns and rises; the rest hangs on it by its stiffness."""
    case = {
        "title": "Held", "analysis": "dynamic",
        "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"nx": nx, "ny": max(2, nx // 3), "length": 1.5, "width": 0.5}},
        "material": [{"type": "isotropic", "young": 1e6, "poisson": 0.0, "thickness": 5e-3, "density": 20.0}],
        "contact": {"distance": 5e-3},
        "obstacle": [{"name": "block", "type": "mesh", "file": block("attachment_block.obj"), "motion": ["0", "0", "0.2*t"],
                      "rotation_axis": [0, 0, 1], "rotation_angle": "60*t*t"}],
        "attachment": [{"groups": ["clamp"], "obstacle": "block", "stiffness": 2e4}],
        "damping": {"mass": 2.0},
        "time": {"end": 0.4, "step": 0.01, "velocity_tolerance": 1e-6},
    }
    return variant(case, {k.replace("__", "."): v for k, v in changes.items()})


def edge_error(step, time):
    """How far the held edge is from where the block would carry it."""
    held_edge = step.mesh.group("clamp", 1)
    angle = np.deg2rad(60 * time * time)
    x = step.mesh.positions[held_edge]
    c, s = np.cos(angle), np.sin(angle)
    carried = np.stack([c * x[:, 0] - s * x[:, 1], s * x[:, 0] + c * x[:, 1], x[:, 2] + 0.2 * time], axis=1)
    return float(np.linalg.norm(step.positions[held_edge] - carried, axis=1).max())


def in_block(step, edge):
    """Vertices as seen from a block that rises by 0.5 m/s and turns as that of held()."""
    angle = np.deg2rad(60 * step.time**2)
    x = step.positions[edge]
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * x[:, 0] + s * x[:, 1], -s * x[:, 0] + c * x[:, 1], x[:, 2] - 0.5 * step.time], axis=1)


@test
def attachment(report):
    """An edge follows a block that turns; the same on any number of ranks, from a checkpoint, on another mesh; it lets go in time."""
    whole = solve("attachment", held(), 1)
    report.check("nothing holds it" not in whole.text, "what it is attached to holds it")
    end = whole.results[-1]
    report.below(max(edge_error(s, s.time) for s in whole.results), 2e-3, "the edge goes where the block does [m]")
    report.check(float(np.abs(end["displacement"]).max()) > 0.08, "which is far")
    for ranks in (2, 3):
        other = solve(f"attachment_{ranks}", held(), ranks)
        report.below(float(np.abs(other.displacement() - whole.displacement()).max()), 1e-5, f"{ranks} ranks [m]")
    half = solve("attachment_half", held(time__end=0.2), 1)
    again = run(write_case(held(), OUT / "attachment_again.toml"), fresh("attachment_again"), 2, ["--restart", half.folder / "checkpoint.h5"])
    report.check(again.code == 0, "continues from a checkpoint" + again.text[-300:] * (again.code != 0))
    report.below(float(np.abs(again.displacement() - whole.displacement()).max()), 1e-5, "to the same end [m]")
    anew = run(write_case(held(), OUT / "attachment_again.toml"), fresh("attachment_anew"), 1, ["--restart", half.folder / "results.vtkhdf"])
    report.check(anew.code == 2 and "checkpoint.h5" in anew.text, f"results do not hold the places of attachments: code {anew.code}")
    finer = solve("attachment_finer", held(18), 1)
    report.below(max(edge_error(s, s.time) for s in finer.results), 2e-3, "a finer mesh is held alike [m]")
    soft = [solve(f"attachment_soft_{nx}", held(nx, attachment__0__stiffness=100.0, time__end=0.2), 1) for nx in (12, 24)]
    errors = [edge_error(s.results[-1], 0.2) for s in soft]
    report.check(errors[0] > 5e-3, f"a soft one lags behind: {errors[0]:.4f} m")
    report.percent(errors[1] / errors[0], 0.1, "as much on another mesh")
    free = solve("attachment_release", held(attachment__0__release=0.2, time__end=0.5), 2)
    before = [edge_error(s, s.time) for s in free.results if s.time <= 0.2 + 1e-9]
    report.below(max(before), 2e-3, "held until it lets go [m]")
    report.check(edge_error(free.results[-1], free.results[-1].time) > 0.02, "and not after that")


@test
def attachment_hard(report):
    """A hard attachment carries an edge exactly where the block takes it, and lets go; the same on 2 ranks, from a checkpoint and from a later stage."""
    hard = {"attachment__0__hard": True}
    whole = solve("attachment_hard", held(**hard), 1)
    report.below(max(edge_error(s, s.time) for s in whole.results), 1e-9, "the edge is where the block takes it [m]")
    two = solve("attachment_hard_2", held(**hard), 2)
    report.below(float(np.abs(two.displacement() - whole.displacement()).max()), 1e-5, "2 ranks [m]")
    half = solve("attachment_hard_half", held(time__end=0.2, **hard), 1)
    again = run(write_case(held(**hard), OUT / "attachment_again.toml"), fresh("attachment_again"), 2, ["--restart", half.folder / "checkpoint.h5"])
    report.check(again.code == 0, "continues from a checkpoint" + again.text[-300:] * (again.code != 0))
    report.below(float(np.abs(again.displacement() - whole.displacement()).max()), 1e-5, "to the same end [m]")
    free = solve("attachment_hard_release", held(attachment__0__release=0.2, time__end=0.5, **hard), 2)
    before = [edge_error(s, s.time) for s in free.results if s.time <= 0.2 + 1e-9]
    report.below(max(before), 1e-9, "held until it lets go [m]")
    report.check(edge_error(free.results[-1], free.results[-1].time) > 0.02, "and not after that")
    case = held(**hard)
    case.pop("analysis")
    case["attachment"][0]["stages"] = ["hold"]
    case["initial_velocity"] = [{"velocity": [0, 0, 0.5], "stages": ["fly"]}]
    case["obstacle"][0] |= {"motion": ["0", "0", "0.5*t"]}
    case["stage"] = [{"name": n, "analysis": "dynamic", "time": {"step": 0.01, "end": e}} for n, e in (("fly", 0.1), ("hold", 0.25))]
    later = part(solve("attachment_hard_later", case, 2), "hold").results
    ringing = held(**hard)
    ringing.pop("analysis")
    ringing["stage"] = [{"name": "still", "analysis": "dynamic", "time": {"step": 0.01, "end": 0.05}}, {"name": "ring", "analysis": "modal"}]
    code, text = invoke(["check", write_case(ringing, OUT / "attachment_ringing.toml")])
    report.check(code == 0 and "stage 'ring': [[attachment]] holds nothing" in text, f"modes know no attachment: code {code}: {text.strip()[-200:]}")
    edge = later[0].mesh.group("clamp", 1)

    report.below(max(float(np.abs(in_block(s, edge) - in_block(later[0], edge)).max()) for s in later), 1e-9, "a later stage holds it where it is [m]")


@test
def attachment_remesh(report):
    """Attachments go on while the sheet is remeshed: the held edge stays where the block takes it, soft ones as far behind as without."""
    remesh = {"remesh__smallest": 0.04, "remesh__largest": 0.3, "remesh__every": 2}
    for what, keys, limit in (("hard", {"attachment__0__hard": True}, 1e-3), ("soft", {}, 2e-3)):
        result = solve(f"attachment_remesh_{what}", held(**remesh, **keys), 2)
        counts = {len(s.mesh.positions) for s in result.results}
        report.check(len(counts) > 1, f"{what}: remeshed, {sorted(counts)} vertices")
        held_edges = {len(s.mesh.group("clamp", 1)) for s in result.results}
        report.below(max(edge_error(s, s.time) for s in result.results), limit, f"{what}: the edge, of {sorted(held_edges)} vertices, goes where the block does [m]")
    plain = edge_error(solve("attachment_remesh_plain", held(attachment__0__stiffness=100.0, time__end=0.2), 1).results[-1], 0.2)
    case = held(attachment__0__stiffness=100.0)
    case.pop("analysis")
    sizes = {"smallest": 0.04, "largest": 0.08, "every": 1}
    case["stage"] = [{"name": "still", "analysis": "dynamic", "time": {"step": 0.01, "end": 0.17}},
                     {"name": "remeshed", "analysis": "dynamic", "time": {"step": 0.01, "end": 0.2}, "remesh": sizes}]
    late = part(solve("attachment_remesh_late", case, 2), "remeshed").results
    vertices = len(late[-1].mesh.group("clamp", 1))
    report.check(vertices > 5, f"a soft edge of 5 vertices is given {vertices} while it lags behind")
    report.percent(edge_error(late[-1], 0.2) / plain, 0.1, "and lags as much as without remeshing")


@test
def attachment_stages(report):
    """It takes hold where the edge is when a stage first names it, goes on in the next, and through a weld."""
    case = held()
    case.pop("analysis")
    time = {"step": 0.01}
    case["attachment"][0]["stages"] = ["hold", "on"]
    case["initial_velocity"] = [{"velocity": [0, 0, 0.5], "stages": ["fly"]}]
    case["obstacle"][0] |= {"motion": ["0", "0", "0.5*t"]}
    case["stage"] = [{"name": n, "analysis": "dynamic", "time": time | {"end": e}} for n, e in (("fly", 0.1), ("hold", 0.25), ("on", 0.4))]
    whole = solve("attachment_stages", case, 2)
    hold, on = part(whole, "hold").results, part(whole, "on").results
    edge = hold[0].mesh.group("clamp", 1)

    start = in_block(hold[0], edge)
    report.below(max(float(np.abs(in_block(s, edge) - start).max()) for s in [*hold, *on]), 2e-3, "seen from the block the edge stays [m]")
    again = run(OUT / "attachment_stages.toml", whole.folder, 1, ["--from", "on"])
    report.check(again.code == 0, "--from goes on with what it held")
    report.below(float(np.abs(part(again, "on").results[-1]["displacement"] - on[-1]["displacement"]).max()), 1e-5, "to the same end [m]")
    sewn = tube(obstacle=[{"name": "core", "type": "cylinder", "point": [0, 0, -0.1], "end": [0, 0, 0.3], "radius": 0.07}],
                attachment=[{"groups": ["tube/0"], "obstacle": "core", "stiffness": 1.0}])
    welded = solve("attachment_weld", sewn, 2)
    with h5py.File(welded.folder / "rest" / "checkpoint.h5") as file:
        rows = file["anchors"][:]
    mesh = part(welded, "rest").results[-1].mesh
    report.check(sorted(rows[:, 1].astype(int)) == sorted(mesh.group("tube/0", 1)), "a weld leaves one anchor for each vertex of the edge")


@test
def attachment_mistakes(report):
    """What cannot be is named with section, key and value."""
    ball = {"name": "ball", "type": "sphere", "point": [0, 0, -5], "radius": 0.1}
    body = held()["obstacle"][0]
    cases = {
        "blok": held(attachment__0__obstacle="blok"), "no triangles": held(obstacle=[body, ball], attachment__0__obstacle="ball"),
        "nowhere": held(attachment__0__groups=["nowhere"]), "groups": held(attachment__0__groups=[]),
        "gap": held(attachment__0__hard=True, attachment__0__gap=0.01), "stiffness": held(attachment__0__stiffness=-1.0),
        "attachment_mistake.toml: [[attachment]] number 1 groups: there is no group 'clam' in": held(attachment__0__groups=["clam"]),
        "attachment.release: 0 s: it takes hold at 0 s, when the run begins": held(attachment__0__release=0.0),
        "length": held(spring=[{"type": "band", "group": "clamp", "stiffness": 1.0, "length": 0.0}])}
    for word, case in cases.items():
        code, text = invoke(["check", write_case(case, OUT / "attachment_mistake.toml")])
        report.check(code == 2 and word in text, f"'{word}' is named" + f": {code} {text[-300:]}" * (code != 2 or word not in text))
    case = held(attachment__0__release=0.1)
    case.pop("analysis")
    case["stage"] = [{"name": n, "analysis": "dynamic", "time": {"step": 0.01, "end": e}} for n, e in (("fly", 0.1), ("hold", 0.15))]
    for stages, good in ((["hold"], False), (["fly", "hold"], True)):
        case["attachment"][0]["stages"] = stages
        file = write_case(case, OUT / "attachment_mistake.toml")
        for arguments in (["check", file], ["run", file, "--output", OUT / "attachment_mistake", "--overwrite"]):
            if good and arguments[0] == "run":
                continue
            code, text = invoke(arguments, 2)
            told = "attachment.release: 0.1 s: it takes hold at 0.1 s, when stage 'hold', the first that names it, begins" in " ".join(text.split())
            report.check((code, told) == ((0, False) if good else (2, True)), f"{arguments[0]}: lets go at 0.1 s, held in {stages}: code {code}" + f": {text[-300:]}" * (told == good))
