"""Where things are: bodies moved by key frames, files put in place, starts that intersect or touch."""

import re
import struct

import numpy as np

from harness import OUT, solve, test
from solver import ROOT, invoke, run, variant, write_case

SPIKE = np.array([[0.35, 0.35, -0.9], [0.65, 0.35, -0.9], [0.5, 0.65, -0.9], [0.5, 0.45, -0.6]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


def write_obj(file, vertices, faces=FACES):
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("".join(f"v {x:.12g} {y:.12g} {z:.12g}\n" for x, y, z in vertices)
                    + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces))
    return str(file)


def write_pc2(file, frames, first=0.0):
    data = np.asarray(frames, "<f4")
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(struct.pack("<12siiffi", b"POINTCACHE2\0", 1, data.shape[1], first, 1.0, data.shape[0]) + data.tobytes())
    return str(file)


def sheet(obstacles, end=0.2, step=0.01, **changes):
    """A square sheet of 1 m with its lower left corner in the origin, its weight, and what it might touch."""
    return variant({
        "title": "Sheet", "analysis": "dynamic",
        "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"side": 1, "n": 4, "pattern": 0}},
        "material": [{"type": "isotropic", "young": 1e6, "poisson": 0.3, "thickness": 5e-4, "density": 400}],
        "load": [{"type": "gravity", "vector": [0, 0, -9.81]}],
        "contact": {"distance": 1e-3},
        "obstacle": obstacles,
        "time": {"end": end, "step": step},
    }, {k.replace("__", "."): v for k, v in changes.items()})


def body(folder, **keys):
    return {"name": "spike", "type": "mesh", "file": str(folder / "spike.obj"), "frames": str(folder / "spike.pc2"), "frames_per_second": 25} | keys


def obstacle_path(result):
    """Times and positions of the obstacles' vertices in all recorded states."""
    results = result.results
    return np.array(results.times), np.array([step.obstacles for step in results])


def rotation(degrees):
    x, y, z = np.radians(degrees)
    rx = np.array([[1, 0, 0], [0, np.cos(x), -np.sin(x)], [0, np.sin(x), np.cos(x)]])
    ry = np.array([[np.cos(y), 0, np.sin(y)], [0, 1, 0], [-np.sin(y), 0, np.cos(y)]])
    rz = np.array([[np.cos(z), -np.sin(z), 0], [np.sin(z), np.cos(z), 0], [0, 0, 1]])
    return rz @ ry @ rx


def between(times, frames, t):
    """Linear interpolation, the first and last frame outside."""
    flat = frames.reshape(len(frames), -1)
    return np.array([[np.interp(s, times, column) for column in flat.T] for s in t]).reshape(len(t), -1, 3)


def smoothed(times, frames, t, window):
    """The mean over the window before each time: fine midpoint sums of the linear interpolation."""
    shares = (np.arange(2000) + 0.5) / 2000
    return np.array([between(times, frames, s - window * shares).mean(axis=0) for s in t])


@test
def frames_clock(report):
    """Key frames begin at frames_start, repeat with frames_loop, closed or not, and lie where the mesh is put."""
    folder = OUT / "frames_clock"
    offsets = np.array([[0, 0, 0], [0.02, 0, 0.01], [0, 0.03, 0.02], [-0.02, 0.01, 0.03]])
    frames = np.array([SPIKE + d for d in offsets])
    closed = np.array([*frames, SPIKE])
    write_obj(folder / "spike.obj", SPIKE)
    flip = rotation([90, 0, 0])
    turned, shift = rotation([20, -35, 110]), np.array([0.3, -0.2, -0.5])
    for name, given, keys, where in (
        ("as_is", frames, {}, lambda t: between(np.arange(4) / 25, frames, t)),
        ("late", frames, {"frames_start": 0.06}, lambda t: between(0.06 + np.arange(4) / 25, frames, t)),
        ("early", frames, {"frames_start": -0.05}, lambda t: between(-0.05 + np.arange(4) / 25, frames, t)),
        ("closed", closed, {"frames_loop": True, "frames_start": -0.03},
         lambda t: between(np.arange(5) / 25, closed, (t + 0.03) % 0.16)),
        ("open", frames, {"frames_loop": True, "frames_start": 0.02},
         lambda t: between(np.arange(5) / 25, closed, np.maximum(t - 0.02, 0) % 0.16)),
        ("smooth", frames, {"frames_start": 0.02, "frames_smoothing": 0.1}, lambda t: smoothed(0.02 + np.arange(4) / 25, frames, t, 0.1)),
        ("smooth_loop", frames, {"frames_loop": True, "frames_smoothing": 0.09},
         lambda t: smoothed(np.arange(-40, 60) / 25, np.array([frames[k % 4 if k > 0 else 0] for k in range(-40, 60)]), t, 0.09)),
        ("placed", frames, {"scale": 0.5, "up_axis": "y", "rotate": [20, -35, 110], "translate": list(shift)},
         lambda t: between(np.arange(4) / 25, frames, t) * 0.5 @ flip.T @ turned.T + shift),
    ):
        write_pc2(folder / "spike.pc2", given, first=7.0)  # of its own clock, which does not count
        far = {"contact.distance": 1e-3, "mesh.translate": [5, 5, 5]}
        for ranks in (1, 3) if name in ("placed", "smooth_loop") else (2,):
            result = solve(f"frames_clock_{name}", variant(sheet([body(folder, **keys)], end=0.4), far), ranks)
            t, x = obstacle_path(result)
            report.check(len(t) > 30, f"{name}: {len(t)} states up to {t[-1]:.2f} s")
            report.below(np.abs(x - where(t)).max(), 1e-6, f"{name} on {ranks} rank(s): error of the positions [m]")


@test
def frames_notes(report):
    """What a user should know of key frames is said once by check and run: another mesh, an early end, a seam that jumps."""
    folder = OUT / "frames_notes"
    write_obj(folder / "spike.obj", SPIKE)
    path = [SPIKE + [0, 0, 0.01 * k] for k in range(4)]

    def said(keys=None, end=0.1, ranks=1):
        code, text = invoke(["check", write_case(sheet([body(folder, **(keys or {}))], end=end), folder / "case.toml")], ranks)
        return code, [line for line in text.splitlines() if line.startswith("note: [[obstacle]]")]

    write_pc2(folder / "spike.pc2", path)
    report.check(said() == (0, []), f"frames of this mesh that last as long as the run: {said()}")
    code, notes = said(end=0.3)
    report.check(code == 0 and len(notes) == 1 and "0.12 s" in notes[0] and "0.3 s" in notes[0] and "holds still" in notes[0], f"an early end: {notes}")
    code, notes = said({"frames_start": 0.1}, end=0.2)
    report.check(notes == [], f"frames_start moves the end: {notes}")
    code, notes = said({"frames_loop": True}, end=0.3)
    report.check(len(notes) == 1 and "goes back" in notes[0] and "0.03 m" in notes[0] and "0.01 m" in notes[0], f"a seam three times as long as a frame: {notes}")
    moved = [x.copy() for x in path]
    moved[0][2] += [0.03, 0.04, 0]
    write_pc2(folder / "spike.pc2", moved)
    code, notes = said()
    report.check(len(notes) == 2 and "from frame 1" in notes[1] and "vertex 3" in notes[1] and "goes 0.05" in notes[1], f"a leap: {notes[1:]}")
    for x in moved[1:]:
        x[2] += [0.03, 0.04, 0]
    write_pc2(folder / "spike.pc2", moved)
    for ranks in (1, 2, 3):
        code, notes = said(ranks=ranks)
        report.check(code == 0 and len(notes) == 1 and "vertex 3 (counted from 1) lies 0.05 m" in notes[0], f"another mesh, {ranks} rank(s): {notes}")
    write_pc2(folder / "spike.pc2", path, first=5.0)
    code, notes = said()
    report.check(len(notes) == 1 and "0.2 s" in notes[0] and "frames_start" in notes[0], f"a clock of its own: {notes}")
    for keys, word in (({"frames": None, "frames_loop": True}, "frames_loop"), ({"frames": None, "frames_start": 1.0}, "frames_start"),
                       ({"frames": None, "frames_smoothing": 0.1}, "frames_smoothing"), ({"frames_smoothing": -0.1}, "frames_smoothing"),
                       ({"frames_start": "soon"}, "frames_start"), ({"frames_loop": 1}, "frames_loop")):
        case = sheet([{k: v for k, v in body(folder, **keys).items() if v is not None}])
        code, text = invoke(["check", write_case(case, folder / "case.toml")])
        report.check(code == 2 and f"obstacle.{word}" in text, f"{keys}: code {code}: {text.strip()[-120:]}")


@test
def walking_manikin(report):
    """The walk stands for a second, and goes on round after round: what check says of it. Skipped without ../shared/assets."""
    assets = ROOT.parent / "shared" / "assets"
    if not (assets / "manikin_walk.pc2").is_file():
        report.check(True, f"skipped: there is no {assets.name}/manikin_walk.pc2 beside the repository")
        return
    walker = {"name": "manikin", "type": "mesh", "file": str(assets / "manikin_static.obj"), "frames": str(assets / "manikin_walk.pc2"),
              "frames_per_second": 25, "frames_start": 1.0}
    far = {"mesh.translate": [5, 5, 5]}
    code, text = invoke(["check", write_case(variant(sheet([walker], end=4.0), far), OUT / "walking.toml")])
    report.check(code == 0 and "[[obstacle]]" not in text, f"3 s from 1 s on fill a run of 4 s: {text.count('note')} note(s)")
    code, text = invoke(["check", write_case(variant(sheet([walker], end=6.0), far), OUT / "walking.toml")])
    report.check(code == 0 and "last frame" in text and "4 s" in text, "one of 6 s outlasts it")
    code, text = invoke(["check", write_case(variant(sheet([walker | {"frames_loop": True}], end=6.0), far), OUT / "walking.toml")])
    report.check(code == 0 and "[[obstacle]]" not in text, "a loop ends where it begins")


# -------------------------------------------------------------------------------------------------------- placement

def garment(**mesh):
    """A strip that hangs over a rod under a load across, held at one end; everything in the axes of its mesh."""
    return {
        "title": "Strip", "analysis": "static",
        "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"nx": 20, "ny": 2}} | mesh,
        "material": [{"type": "orthotropic", "young_1": 1.2e6, "young_2": 6e5, "poisson_12": 0.2, "shear_12": 4e5, "thickness": 0.1,
                      "direction": [1, 0.2, 0]}],
        "support": [{"type": "clamped", "group": "clamp"}],
        "load": [{"type": "line", "group": "tip", "vector": [0.3, 0.5, 4]}],
        "contact": {"distance": 0.02, "self": False},
        "obstacle": [{"name": "rod", "type": "capsule", "point": [5, -2, 1.2], "end": [5, 3, 1.2], "radius": 0.3}],
        "petsc": {"options": "-snes_rtol 1e-13 -snes_stol 1e-13"},
    }


@test
def placement(report):
    """A case whose mesh is turned and moved has the same answers in its own axes, contact and warp included."""
    plain = solve("placement_plain", garment(), 1)
    u = plain.displacement()
    degrees, shift = [35.0, -50.0, 160.0], np.array([3.0, -2.0, 1.0])
    for name, keys, r in (("turned", {"rotate": degrees}, rotation(degrees)),
                          ("y_up", {"up_axis": "y"}, rotation([90, 0, 0])),
                          ("both", {"up_axis": "y", "rotate": degrees}, rotation(degrees) @ rotation([90, 0, 0]))):
        case = garment(**keys, translate=list(shift))
        case["material"][0]["direction"] = list(r @ [1, 0.2, 0])
        case["load"][0]["vector"] = list(r @ [0.3, 0.5, 4])
        for end in ("point", "end"):
            case["obstacle"][0][end] = list(r @ np.array(case["obstacle"][0][end]) + shift)
        for ranks in (1, 2, 3) if name == "both" else (2,):
            result = solve(f"placement_{name}", case, ranks)
            report.below(np.abs(result.displacement() @ r - u).max() / np.abs(u).max(), 1e-10, f"{name} on {ranks} rank(s): difference")
            report.check(max(result.history["contact_pairs"]) > 0, f"{name}: it touches the rod")


@test
def placement_mistakes(report):
    """What is no place says which key, and what to write."""
    folder = OUT / "placement_mistakes"
    write_obj(folder / "spike.obj", SPIKE)
    spike = {"name": "spike", "type": "mesh", "file": str(folder / "spike.obj")}
    for changes, words in (
        ({"mesh.up_axis": "x"}, ("mesh.up_axis", "y, z")), ({"mesh.rotate": [0, 0]}, ("mesh.rotate", "three numbers")),
        ({"mesh.rotate": [0, float("nan"), 0]}, ("mesh.rotate", "finite")), ({"mesh.translate": [float("inf"), 0, 0]}, ("mesh.translate", "finite")),
        ({"mesh.translate": 1.0}, ("mesh.translate", "three numbers")), ({"mesh.translate": [1e300, 0, 0]}, ("plate.geo", "translate")),
        ({"obstacle": [spike | {"up_axis": "up"}]}, ("obstacle.up_axis", "y, z")),
        ({"obstacle": [spike | {"rotate": [0, float("inf"), 0]}]}, ("obstacle.rotate", "finite")),
        ({"obstacle": [spike | {"translate": [0, 0, 1e300]}]}, ("spike.obj", "translate")),
        ({"obstacle": [spike | {"frames": write_pc2(folder / "spike.pc2", [SPIKE]), "translate": [0, 0, 1e300]}]}, ("translate",)),
        ({"obstacle": [{"name": "ball", "type": "sphere", "point": [0, 0, -3], "radius": 1, "rotate": [0, 0, 1]}]}, ("rotate", "sphere")),
    ):
        code, text = invoke(["check", write_case(variant(sheet([spike]), changes), folder / "case.toml")])
        report.check(code == 2 and all(w in text for w in words), f"{changes}: code {code}: {' '.join(text.split())[-150:]}")


# ----------------------------------------------------------------------------------------------------------- starts

def check_start(name, obstacles, ranks=1, **changes):
    code, text = invoke(["check", write_case(sheet(obstacles, **changes), OUT / f"start_{name}.toml")], ranks)
    return code, " ".join(text.split())


def two_sheets(height, shift=(0.0, 0.0)):
    """A file with two square sheets, one over the other."""
    grid = np.array([[x, y, 0] for y in range(4) for x in range(4)]) / 3
    faces = np.array([f for j in range(3) for i in range(3)
                      for f in ([4 * j + i, 4 * j + i + 1, 4 * j + i + 5], [4 * j + i, 4 * j + i + 5, 4 * j + i + 4])])
    return write_obj(OUT / "two_sheets.obj", np.vstack([grid, grid + [*shift, height]]), np.vstack([faces, faces + 16]))


@test
def starts(report):
    """voile check tells a start that intersects, touches exactly, lies inside the activation distance, or doubles a sheet."""
    floor = {"name": "floor", "type": "plane", "normal": [0, 0, 1]}
    ball = {"name": "ball", "type": "sphere", "point": [0.5, 0.5, -0.3], "radius": 0.31}
    for ranks in (1, 2, 3):
        code, text = check_start("through", [ball], ranks)
        report.check(code == 2 and re.search(r"the start intersects: \d+ pair\(s\) of sheet and ball", text) and "untangle = true" in text
                     and "[[contact_rule]]" in text, f"{ranks} rank(s), a ball through the sheet: code {code}: {text[-230:]}")
        code, text = check_start("inside", [floor | {"point": [0, 0, -4e-4]}], ranks)
        report.check(code == 0 and "lies inside the activation distance of 0.001 m: 25 pair(s), smallest gap 0.0004 m" in text
                     and "floor" in text and "settle_time" in text, f"{ranks} rank(s), 0.4 mm over a floor: code {code}: {text[-400:][:250]}")
    for name, obstacles in (("plane", [floor | {"point": [0, 0, 0]}]), ("ball", [ball | {"radius": 0.3}]),
                            ("rod", [{"name": "rod", "type": "capsule", "point": [0.2, 0.5, -0.1], "end": [0.8, 0.5, -0.1], "radius": 0.1}]),
                            ("tip", [{"name": "tip", "type": "mesh", "file": write_obj(OUT / "tip.obj", SPIKE + [0, 0, 0.6])}])):
        code, text = check_start(f"touch_{name}", obstacles)
        report.check(code == 2 and ("touch exactly" in text or "the start intersects" in text) and "-0 m" not in text and "by 0 m" not in text,
                     f"{name} that touches exactly: code {code}: {text[-260:]}")
    code, text = check_start("overlap", [floor | {"point": [0, 0, 1e-3]}])
    report.check(code == 2 and ("the start intersects" in text or "by 0.001 m" in text) and "floor" in text, f"1 mm below a floor: code {code}: {text[-230:]}")
    code, text = check_start("thick", [floor | {"point": [0, 0, -1e-3], "thickness": 0.01}])
    report.check(code == 2 and "by 0.004 m" in text, f"nearer than thickness allows: code {code}: {text[-230:]}")
    mesh = {"mesh__parameters": None}
    for name, height, shift in (("alike", 0.0, (0, 0)), ("shifted", 0.0, (0.1, 0.05))):
        for ranks in (1, 2):
            code, text = check_start(f"double_{name}", [], ranks, mesh__file=two_sheets(height, shift), **mesh)
            report.check(code == 2 and "[contact]: " in text and "-0 m" not in text and ("intersects" in text or "touch exactly" in text),
                         f"two sheets in one place, {name}, {ranks} rank(s): code {code}: {text[-250:]}")
    code, text = check_start("double_near", [], mesh__file=two_sheets(5e-4), **mesh)
    report.check(code == 0 and "smallest gap 0.0005 m" in text, f"0.5 mm apart: code {code}: {text[-300:][:200]}")
    code, text = check_start("double_thick", [], mesh__file=two_sheets(5e-4), contact__thickness=1e-3, **mesh)
    report.check(code == 2 and "by 0.0005 m" in text, f"0.5 mm apart and 1 mm thick: code {code}: {text[-250:]}")
    code, text = check_start("double_apart", [], mesh__file=two_sheets(5e-3), **mesh)
    report.check(code == 0 and "activation distance" not in text, f"5 mm apart: code {code}")


# ----------------------------------------------------------------------------------------------------------- clamps

@test
def turned_clamp(report):
    """A clamp that turns takes a strip along as a rigid body: step by step, and in time until it is at rest; in between it bends."""
    def strip(**keys):
        return {"title": "Strip", "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"nx": 20, "ny": 2}},
                "material": [{"type": "isotropic", "young": 1.2e6, "poisson": 0.3, "thickness": 0.1, "density": 100}],
                "probe": [{"name": "tip", "type": "displacement", "group": "tip"}, {"name": "energy", "type": "energy"}]} | keys

    def stored(h):
        return np.abs(np.array(h["energy_membrane"]) + np.array(h["energy_bending"]))

    clamp = {"type": "clamped", "group": "clamp", "rotation_centre": [0, 0.5, 0.2]}
    axis = np.array([0.2, 1.0, 0.1]) / np.linalg.norm([0.2, 1.0, 0.1])
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    angle = np.radians(150)
    turn = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    still = strip(analysis="static", steps={"initial_step": 0.1, "max_step": 0.1},
                  support=[clamp | {"rotation_axis": list(axis), "rotation_angle": "150*t", "motion": ["t", "0", "-2*t"]}])
    for ranks in (1, 2, 3):
        result = solve("turned_clamp", still, ranks)
        rest = result.results.mesh().positions
        centre = np.array([0, 0.5, 0.2])
        rigid = (rest - centre) @ turn.T + centre + [1, 0, -2] - rest
        report.below(np.abs(result.displacement() - rigid).max(), 1e-7, f"{ranks} rank(s): distance from the rigid body [m]")
        report.below(stored(result.history).max(), 1e-7, f"{ranks} rank(s): energy [J]")
    moving = strip(analysis="dynamic", time={"end": 400, "step": 1.0}, damping={"mass": 0.2},
                   support=[clamp | {"rotation_axis": [0, 1, 0], "rotation_centre": [0, 0, 0], "rotation_angle": "t < 100 ? 0.6*t : 60"}])
    for ranks in (1, 2):
        h = solve("turned_clamp_in_time", moving, ranks).history
        report.near(h["tip_z"][-1], -10 * np.sin(np.radians(60)), 0.02, f"{ranks} rank(s): the tip, at rest again [m]")
        report.near(h["tip_x"][-1], 10 * np.cos(np.radians(60)) - 10, 0.02, f"{ranks} rank(s): the tip, at rest again [m]")
        report.check(stored(h).max() > 1e-2 > 1e3 * stored(h)[-1], f"it bends on the way: {stored(h).max():.3g} J, {stored(h)[-1]:.2g} J at the end")


def sheet_file(name, shape, cells=6):
    """An OBJ file of a unit square whose vertices `shape` puts in place."""
    lines = []
    for i in range(cells + 1):
        for j in range(cells + 1):
            lines.append("v {:.17g} {:.17g} {:.17g}".format(*shape(np.array([i / cells, j / cells, 0.0]))))
    number = lambda i, j: i * (cells + 1) + j + 1  # noqa: E731
    for i in range(cells):
        for j in range(cells):
            lines += [f"f {number(i, j)} {number(i + 1, j)} {number(i + 1, j + 1)}", f"f {number(i, j)} {number(i + 1, j + 1)} {number(i, j + 1)}"]
    OUT.mkdir(parents=True, exist_ok=True)
    (OUT / name).write_text("\n".join(lines) + "\n")
    return str(OUT / name)


@test
def start_shapes(report):
    """A sheet that starts in another place and direction than it was cut in falls without strain; its shape at rest stays the flat one."""
    c, s = np.cos(1.0), np.sin(1.0)
    placed = lambda x: np.array([c * x[0] - s * x[2], x[1], s * x[0] + c * x[2]]) + [0.3, -2.0, 1.0]  # noqa: E731
    flat, turned = sheet_file("start_flat.obj", lambda x: x), sheet_file("start_turned.obj", placed)
    case = {"analysis": "dynamic", "mesh": {"file": flat, "start": turned},
            "material": [{"type": "isotropic", "young": 1e6, "poisson": 0.3, "thickness": 1e-3, "density": 300.0}],
            "load": [{"type": "gravity", "vector": [0, 0, -9.81]}], "time": {"end": 0.1, "step": 0.01, "spectral_radius": 1.0},
            "probe": [{"name": "energy", "type": "energy"}]}
    corner = np.array([1.0, 1.0, 0.0])
    moved = placed(corner) - corner - [0, 0, 0.5 * 9.81 * 0.1**2]
    for ranks in (1, 2):
        result = solve(f"start_shape_{ranks}", case, ranks)
        strain = max(abs(result.history[name]).max() for name in ("energy_membrane", "energy_bending"))
        report.below(strain, 1e-12, f"{ranks} rank(s): energy of strain [J]")
        report.below(np.abs(result.displacement()[-1] - moved).max(), 1e-9, f"{ranks} rank(s): it falls from where it was put: difference [m]")
    # Springs pull it to where the file says: the equilibrium is that from the flat start.
    held = {key: case[key] for key in ("material", "load")} | {"analysis": "drape"}
    bent = sheet_file("start_bent.obj", lambda x: np.array([np.sin(x[0]), x[1], 0.3 * (1 - np.cos(x[0]))]))
    held["spring"] = [{"type": "area", "stiffness": 500.0}]
    ends = [solve(f"start_{name}", held | {"mesh": mesh}, 1).displacement()
            for name, mesh in (("flat", {"file": flat}), ("bent", {"file": flat, "start": bent}))]
    report.below(np.abs(ends[0] - ends[1]).max(), 1e-6, "drape on an elastic foundation, from flat and from bent: difference [m]")
    for what, mesh, words in (("another mesh", {"file": flat, "start": sheet_file("start_other.obj", lambda x: x, 5)}, "36 vertices and 50 triangles instead of 49 and 72"),
                              ("merged", {"file": flat, "start": turned, "merge": True}, "two places")):
        code, text = invoke(["check", write_case(case | {"mesh": mesh}, OUT / "start_wrong.toml")])
        report.check(code == 2 and "start" in text and words in text, f"{what}: code {code}: {text.strip()[-160:]}")
    code, text = invoke(["check", write_case(case | {"analysis": "modal"}, OUT / "start_wrong.toml")])
    report.check(code == 2 and "start" in text, f"modal: code {code}: {text.strip()[-110:]}")
    floor = case | {"contact": {"distance": 1e-3}, "obstacle": [{"name": "floor", "type": "plane", "normal": [0, 0, 1], "point": [0, 0, 1.2]}]}
    code, text = invoke(["check", write_case(floor, OUT / "start_floor.toml")])
    report.check(code == 2 and "floor" in text, f"a start through the floor: code {code}: {text.strip()[-110:]}")
