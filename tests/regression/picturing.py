"""Regression tests of pictures and exchange: what is written is read back by readers that are not ours."""

import json
import os
import shutil
import struct
import subprocess
import sys
import xml.etree.ElementTree as xml

import h5py
import numpy as np
from harness import OUT, solve, test
from common import fresh, lines, pixels, started, strip, wait_for
from solver import ROOT, binary, environment, invoke, write_case
from voile import Case, Results
from voile import run as run_python

Y_UP = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])  # x, z, -y of rows


def thrown():
    """A strip that falls over a ball which moves, in time."""
    return {
        "analysis": "dynamic",
        "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"length": 0.3, "width": 0.1, "nx": 12, "ny": 4}},
        "material": [{"type": "isotropic", "young": 1e6, "poisson": 0.3, "thickness": 5e-4, "density": 300.0}],
        "support": [{"group": "clamp", "type": "hinged"}],
        "load": [{"type": "gravity", "vector": [0, 0, -9.81]}],
        "contact": {"distance": 2e-3},
        "obstacle": [{"name": "ball", "type": "sphere", "point": [0.2, 0.05, -0.06], "radius": 0.05, "motion": ["0", "0", "0.1*t"]},
                     {"name": "floor", "type": "plane", "point": [0, 0, -0.3], "normal": [0, 0, 1]}],
        "time": {"end": 0.1, "step": 0.01},
        "output": {"fields": ["displacement", "velocity", "membrane_force", "contact_pressure"]},
    }


def ball(step):
    """Vertices of the ball, which are exported; not those of the floor, which come after them."""
    return step.obstacles[:-4]


def draw(*words, timeout=300):
    """(exit code, text) of voile with no display to draw on."""
    env = environment()
    env.pop("DISPLAY", None)
    done = subprocess.run([str(binary()), *map(str, words)], env=env, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=timeout)
    return done.returncode, done.stdout


def glb(path):
    """JSON and a function that reads accessors of a GLB, by the rules of glTF 2.0 and nothing else."""
    data = path.read_bytes()
    magic, version, size = struct.unpack("<4sII", data[:12])
    length, kind = struct.unpack("<I4s", data[12:20])
    text = json.loads(data[20:20 + length])
    begin = 20 + length
    binary_length, binary_kind = struct.unpack("<I4s", data[begin:begin + 8])
    assert (magic, version, size, kind, binary_kind) == (b"glTF", 2, len(data), b"JSON", b"BIN\0") and begin % 4 == 0
    content = data[begin + 8:begin + 8 + binary_length]

    def accessor(number):
        a = text["accessors"][number]
        view = text["bufferViews"][a["bufferView"]]
        columns = {"VEC4": 4, "VEC3": 3, "VEC2": 2, "SCALAR": 1}[a["type"]]
        values = np.frombuffer(content, {5126: "<f4", 5125: "<u4"}[a["componentType"]], a["count"] * columns, view["byteOffset"])
        values = values.reshape(-1, columns)
        if "min" in a:
            assert np.array_equal(values.min(axis=0), np.array(a["min"], np.float32)) and np.array_equal(values.max(axis=0), np.array(a["max"], np.float32))
        return values

    return text, accessor


def glb_positions(text, accessor, node, time):
    """Where the vertices of a node are at a time: weights run linearly; None where its scale is 0."""
    mesh = text["meshes"][text["nodes"][node]["mesh"]]["primitives"][0]
    position = accessor(mesh["attributes"]["POSITION"]).astype(float)
    for channel in text["animations"][0]["channels"]:
        if channel["target"]["node"] != node:
            continue
        sampler = text["animations"][0]["samplers"][channel["sampler"]]
        times, values = accessor(sampler["input"]).ravel(), accessor(sampler["output"])
        if channel["target"]["path"] == "scale":
            if values[max(0, np.searchsorted(times, time + 1e-7, side="right") - 1)][0] == 0:
                return None
        else:
            weights = values.reshape(len(times), -1)
            for k, target in enumerate(mesh["targets"]):
                position = position + np.interp(time, times, weights[:, k]) * accessor(target["POSITION"])
    return position


def vtu_arrays(file):
    """Name -> numbers, by the announcements in the text."""
    data = file.read_bytes()
    at = data.index(b"_", data.index(b"<AppendedData"))
    root = xml.fromstring(data[:data.index(b"<AppendedData")] + b"</VTKFile>")
    kinds = {"Float64": "<f8", "Int64": "<i8", "UInt8": "u1"}
    arrays = {}
    for item in root.iter("DataArray"):
        begin = at + 1 + int(item.get("offset"))
        length = struct.unpack("<Q", data[begin:begin + 8])[0]
        arrays[item.get("Name")] = np.frombuffer(data[begin + 8:begin + 8 + length], kinds[item.get("type")]).reshape(-1, int(item.get("NumberOfComponents")))
    return arrays


def vtu_difference(out, results):
    steps = list(results)
    files = sorted(out.glob("run_*.vtu"))
    worst = abs(len(files) - len(steps))
    for file, step in zip(files, steps):
        have = vtu_arrays(file)
        worst = max(worst, abs(have["positions"] - step.positions).max(), abs(have["TimeValue"][0, 0] - step.time),
                    abs(have["connectivity"].reshape(-1, 3) - step.mesh.triangles).max(),
                    abs(have["offsets"].ravel() - 3 * np.arange(1, 1 + len(step.mesh.triangles))).max(), abs(have["types"] - 5).max(),
                    abs(have["contact_pressure"].ravel() - step["contact_pressure"].ravel()).max())
    return worst


@test
def exports(report):
    """Every format holds the vertices, to single precision, the frames and the times of the run."""
    results = solve("pictures_thrown", thrown(), 2).results
    out = fresh("pictures_exports")
    out.mkdir(parents=True)
    steps, last = list(results), results[-1]
    count = len(last.mesh.positions)
    for name in ("obj", "stl", "ply", "pc2", "mdd", "glb", "usda", "msh", "vtu", "csv"):
        code, said = draw("export", results.file.parent, "--to", name, "--output", out / f"run.{name}")
        report.check(code == 0, f"{name} is written" if code == 0 else said)

    code, said = draw("export", results.file.parent, "--to", "vtu", "--steps", "last", "--output", out / "bare")
    report.check(code == 0 and (out / "bare.vtu").is_file(), "a name without an ending gets that of the format")

    data = (out / "run.pc2").read_bytes()
    head = struct.unpack("<12siiffi", data[:32])
    frames = np.frombuffer(data, "<f4", offset=32).reshape(head[5], head[2], 3)
    report.check(head == (b"POINTCACHE2\0", 1, count, 0.0, 1.0, len(steps)), "PC2: its head")
    report.below(max(abs(x - s.positions).max() for x, s in zip(frames, steps)), 1e-7, "PC2: positions [m]")
    report.check((out / "run_bodies.pc2").is_file(), "PC2: a body that moves has a cache of its own")
    data = (out / "run.mdd").read_bytes()
    n, points = struct.unpack(">ii", data[:8])
    times = np.frombuffer(data, ">f4", n, 8)
    frames = np.frombuffer(data, ">f4", offset=8 + 4 * n).reshape(n, points, 3)
    report.below(max(abs(x - s.positions).max() for x, s in zip(frames, steps)), 1e-7, "MDD: positions [m]")
    report.below(abs(times - results.times).max(), 1e-7, "MDD: times [s]")

    text, accessor = glb(out / "run.glb")
    report.below(max(abs(glb_positions(text, accessor, 0, s.time) - s.positions @ Y_UP).max() for s in steps), 2e-7, "GLB: positions, y upwards [m]")
    half = 0.5 * (steps[3].time + steps[4].time)
    middle = 0.5 * (steps[3].positions + steps[4].positions) @ Y_UP
    report.below(abs(glb_positions(text, accessor, 0, half) - middle).max(), 2e-7, "GLB: between two steps it moves straight on [m]")
    report.below(max(abs(glb_positions(text, accessor, 1, s.time) - ball(s) @ Y_UP).max() for s in steps), 2e-7, "GLB: the body, without the floor [m]")

    obj = (out / "run.obj").read_text().splitlines()
    vertices = np.array([line.split()[1:] for line in obj if line.startswith("v ")], float)
    faces = np.array([[w.split("/")[0] for w in line.split()[1:]] for line in obj if line.startswith("f ")], int) - 1
    report.below(abs(vertices[:count] - last.positions).max(), 1e-6, "OBJ: positions [m]")
    report.check(np.array_equal(faces[:len(last.mesh.triangles)], last.mesh.triangles), "OBJ: triangles")
    stl = np.frombuffer((out / "run.stl").read_bytes()[84:], np.dtype([("x", "<f4", (4, 3)), ("more", "<u2")]))
    corners = stl["x"][:len(last.mesh.triangles), 1:]
    report.below(abs(corners - last.positions[last.mesh.triangles]).max(), 1e-7, "STL: positions [m]")
    table = np.genfromtxt(out / "run_vertices.csv", delimiter=",", names=True)
    report.below(abs(np.column_stack([table[k] for k in "xyz"]) - last.positions).max(), 0, "CSV: positions, all digits")
    report.below(abs(table["contact_pressure"] - last["contact_pressure"].ravel()).max(), 0, "CSV: a field, all digits")
    report.below(vtu_difference(out, results), 0, "VTU: numbered files with positions, triangles, times and a field, all digits")
    # Gmsh's library reads its own format, and others.
    for name in ("msh", "stl", "ply", "obj"):
        code, said = invoke(["info", out / f"run.{name}"])
        expected = len(last.mesh.triangles) + (0 if name == "msh" else len(faces) - len(last.mesh.triangles))
        report.check(code == 0 and f" {expected} triangles" in said or name == "obj" and code == 0, f"{name} is a mesh for voile info")


@test
def exports_in_pieces(report):
    """GLB keeps to 200 frames a node."""
    case = thrown()
    case["time"] = {"end": 0.0625, "step": 0.00025, "max_step": 0.00025}
    case.pop("obstacle")
    case.pop("contact")
    case["output"] = {"fields": ["displacement"]}
    results = solve("pictures_long", case, 1).results
    file = OUT / "pictures_long.glb"
    report.check(draw("export", results.file.parent, "--output", file)[0] == 0, "the ending of --output says the format")
    text, accessor = glb(file)
    report.check(len(results) > 201 and len(text["nodes"]) == 2, f"{len(results)} frames are {len(text['nodes'])} nodes")
    report.check(max(len(m["primitives"][0]["targets"]) for m in text["meshes"]) <= 200, "of 200 targets at most")
    worst, shown = 0.0, []
    for s in [results[i] for i in (0, 100, 199, 200, 220, -1)]:
        found = [x for x in (glb_positions(text, accessor, node, s.time) for node in range(2)) if x is not None]
        shown.append(len(found))
        worst = max(worst, abs(found[0] - s.positions @ Y_UP).max())
    report.check(shown == [1] * 6, "one of which is seen at any time")
    report.below(worst, 1e-6, "positions [m]")


def away(points, corners):
    """Largest distance of points from a surface of triangles (triangles x 3 corners x 3): the nearest of points over triangles and of vertices."""
    a, e, f = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(e, f)
    area = (normal**2).sum(axis=1)
    worst = 0.0
    for p in points:
        u = (np.cross(p - a, f) * normal).sum(axis=1) / area
        v = (np.cross(e, p - a) * normal).sum(axis=1) / area
        inside = (u > -0.05) & (v > -0.05) & (u + v < 1.05)
        above = abs(((p - a) * normal).sum(axis=1))[inside] / np.sqrt(area[inside])
        worst = max(worst, min(above.min(initial=np.inf), np.sqrt(((corners - p)**2).sum(axis=2)).min()))
    return worst


@test
def remeshed_on_one_mesh(report):
    """A run that was remeshed leaves as PC2, GLB and OBJ with one mesh for all frames, near the surfaces of the run."""
    case = thrown()
    case["mesh"]["parameters"] |= {"nx": 9, "ny": 3}
    case["time"] = {"end": 0.2, "step": 0.01}
    case["remesh"] = {"smallest": 0.006, "largest": 0.05, "every": 3, "energy_change": 1.0}
    results = solve("pictures_remeshed", case, 1).results
    folder, counts = results.file.parent, {len(s.positions) for s in results}
    report.check(len(counts) > 1, f"meshes of {sorted(counts)} vertices")
    file = OUT / "remeshed.pc2"
    code, said = draw("export", folder, "--output", file)
    report.check(code == 0 and "one mesh of" in said and "nothing intersects" in said, said.splitlines()[-1])
    data = file.read_bytes()
    vertices, frames = struct.unpack("<i", data[16:20])[0], struct.unpack("<i", data[28:32])[0]
    x = np.frombuffer(data, "<f4", offset=32).reshape(frames, vertices, 3).astype(float)
    mesh = [line.split() for line in (OUT / "remeshed_mesh.obj").read_text().splitlines()]
    triangles = np.array([[int(w.split("/")[0]) - 1 for w in words[1:]] for words in mesh if words and words[0] == "f"])
    report.check(frames == len(results) and vertices >= max(counts), f"{frames} frames of {vertices} vertices")
    worst = max(away(s.positions, x[i][triangles]) for i, s in list(enumerate(results))[::5])
    near = float(said.split("at most ")[1].split(" mm")[0])
    report.check(near <= 0.5, f"{near} mm by the program's own account")
    report.below(worst, 5e-4, "distance of the run's vertices from the one mesh [m]")
    glb_file = OUT / "remeshed.glb"
    for words, several in (((), True), (("--one-mesh",), False)):
        code, said = draw("export", folder, "--output", glb_file, "--no-obstacles", *words)
        text, _ = glb(glb_file)
        told = f"{len(text['meshes'])} meshes one after another" in said
        report.check(code == 0 and (len(text["meshes"]) > 1) == several == told, f"GLB {' '.join(words)}: {len(text['meshes'])} meshes")
    for old in OUT.glob("remeshed_0*.obj"):
        old.unlink()
    code, said = draw("export", folder, "--output", OUT / "remeshed.obj", "--steps", "all", "--one-mesh", "--no-obstacles")
    faces = {tuple(line for line in f.read_text().splitlines() if line.startswith("f ")) for f in OUT.glob("remeshed_0*.obj")}
    report.check(code == 0 and len(faces) == 1, "OBJ: the same faces in all frames")


@test
def pictures(report):
    """Pictures are drawn without a display and without X or OpenGL, of runs that are done, go on or were killed."""
    links = subprocess.run(["ldd", binary().parent / "voile-picture"], text=True, capture_output=True).stdout
    report.check(not any(name in links for name in ("libX11", "libGL", "libEGL", "libxcb", "fltk")), "voile-picture needs neither X nor OpenGL")
    done = solve("pictures_strip", strip("dynamic", time__end=0.1), 1)
    png = OUT / "pictures_strip.png"
    small = ("--size", "160x120", "--quality", "draft")
    for words in ((), ("--field", "displacement:z", "--mesh"), ("--steps", "2", "--partition"), ("--view", "top/front/30,20", "--panels", "--title", "Größe"),
                  ("--eye", "3,3,3", "--target", "0,0,0", "--contours"), ("--scale", "2", "--no-ground", "--range", "-1,1", "--field", "displacement:x"), ("--creases", "20", "--palette")):
        png.unlink(missing_ok=True)
        code, said = draw("render", done.folder, "--output", png, *small, *words)
        report.check(code == 0 and png.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n", f"render {' '.join(words)}" if code == 0 else said)
    for size in ("160x112", "160x40", "40x160"):
        draw("render", done.folder, "--output", png, "--size", size, "--quality", "draft", "--no-stamp")
        right = pixels(png)[:, -int(size.split("x")[0]) // 3:]
        report.check(np.ptp(right) > 0.0, f"the right part of a picture of {size} is not blank")
    draw("render", done.folder, "--output", png, "--field", "displacement:z", "--range", "-4.905e-06,-4.901e-06", *small)
    report.check(np.ptp(pixels(png)[:, -2:], axis=1).max() < 0.02, "long numbers at the colour bar end before the border")
    code, said = draw("render", done.folder, "--steps", "1:3", "--output", png, *small)
    report.check(code == 0 and (OUT / "pictures_strip_000002.png").is_file(), "several steps get numbers")
    for ending in ("webp", "gif"):
        file = OUT / f"pictures_strip.{ending}"
        code, said = draw("render", done.folder, "--animation", file, *small)
        report.check(code == 0 and file.stat().st_size > 1000, f"an animation as {ending}")
    killed = started(write_case(strip("dynamic", time__end=100.0), OUT / "pictures_killed.toml"), fresh("pictures_killed"))
    wait_for(lambda: lines(OUT / "pictures_killed" / "history.csv") > 4, killed)
    report.check(draw("render", OUT / "pictures_killed", "--output", png, *small)[0] == 0, "a run that goes on")
    killed.kill()
    killed.wait()
    report.check(draw("render", OUT / "pictures_killed", "--output", png, *small)[0] == 0, "a run that was killed")


def polyline(svg):
    """Points of the first curve of a diagram [pixels]."""
    text = next(line.get("points") for line in xml.parse(svg).getroot().iter("{http://www.w3.org/2000/svg}polyline") if line.get("stroke-width") == "2.2")
    return np.array([pair.split(",") for pair in text.split()], float)


@test
def diagrams(report):
    """Expressions of columns, scales and several tables in one diagram: an XML reader finds the curve where it should be; diagrams beside each other."""
    done = solve("pictures_strip", strip("dynamic", time__end=0.1), 1)
    svg, png, table = OUT / "diagram.svg", OUT / "diagram.png", OUT / "diagram.csv"
    time, energy = np.array(done.history["time"]), np.array(done.history["kinetic_energy"])
    for words, y in ((("--log", "y"), np.log10(energy[1:])), ((), 0.5 - 1000 * energy)):
        wanted = "kinetic_energy" if words else "0.5 - 1000*kinetic_energy"
        code, said = draw("plot", "--curve", f"{done.folder}:time:{wanted}:energy", *words, "--output", svg)
        x = time[1:] if words else time
        found = polyline(svg) if code == 0 else np.zeros((len(x), 2))
        fit = [np.polynomial.Polynomial.fit(a, b, 1)(a) - b for a, b in zip((x, y), found.T)]
        report.below(max(abs(f).max() for f in fit), 0.02, f"{wanted} {' '.join(words)}: places [pixels]" if code == 0 else said)
    table.write_text("# points\nt, a value\n0, 1e-9\n0.1, 1e-8\n")
    code, said = draw("plot", done.folder, "--y", "kinetic_energy", "--points", f"{table}:t:a value:given", "--dashed", f"{table}:t:a value:", "--legend", "top-left",
                      "--size", "400x300", "--output", png)
    report.check(code == 0 and pixels(png).shape == (300, 400, 3), "a run, points and dashes in one diagram" if code == 0 else said)
    code, said = draw("sheet", png, png, png, "--columns", "2", "--palette", "--output", OUT / "sheet.png")
    sheet = pixels(OUT / "sheet.png") if code == 0 else np.zeros((1, 1, 3))
    report.check(sheet.shape == (600, 800, 3) and np.array_equal(sheet[300:, 600:], np.ones((300, 200, 3))), "three of them on one sheet" if code == 0 else said)
    report.below(abs(sheet[:300, :400] - pixels(png)).mean(), 0.01, "in nearly the same colours")


@test
def pictures_by_ranks(report):
    """Ranks divide pictures and frames, which are the same to the last bit, and leave nothing else behind."""
    done = solve("pictures_by_ranks", strip("dynamic", time__end=0.1), 1)
    small = ("--size", "160x120", "--quality", "draft", "--field", "displacement:z")
    files = {}
    for ranks in (1, 3):
        folder = fresh(f"pictures_by_{ranks}")
        folder.mkdir()
        for words in (("--steps", "all", "--output", folder / "step.png"), ("--animation", folder / "steps.gif")):
            code, said = invoke(["render", done.folder, *words, *small], ranks)[:2]
            report.check(code == 0, f"{words[0]} on {ranks} rank(s)" if code == 0 else said)
        files[ranks] = {file.name: file.read_bytes() for file in folder.iterdir()}
    report.check(len(files[1]) > 3 and files[1] == files[3], f"{len(files[1])} files are the same by one and three ranks")
    # As two ranks of one job, beside frames that another of the same name has left.
    file = fresh("pictures_by_hand") / "steps.gif"
    left = file.parent / "steps.gif.frames_job"
    left.mkdir(parents=True)
    for number in range(1, 11, 2):
        shutil.copy(OUT / "pictures_by_1" / "step_000000.png", left / f"{number:06d}.png")
        os.utime(left / f"{number:06d}.png", (1e9, 1e9))
    ranks = [subprocess.Popen([binary(), "render", done.folder, "--animation", file, *small, "--quiet"],
                              env=environment() | {"OMPI_COMM_WORLD_RANK": str(rank), "OMPI_COMM_WORLD_SIZE": "2", "PMIX_NAMESPACE": "job"}) for rank in (0, 1)]
    report.check([rank.wait() for rank in ranks] == [0, 0] and file.read_bytes() == files[1]["steps.gif"], "frames that a killed run has left are not shown")
    report.check(not left.exists(), "and go")
    code, said = invoke(["render", done.folder, "--field", "nothing"], 3)[:2]
    report.check(code == 2 and said.count("voile: error") == 1, "a mistake is said once")


def film_of(file):
    """Size, rate and frames (frames x rows x columns x 3) of a film, by ffmpeg."""
    said = subprocess.run(["ffprobe", "-v", "error", "-show_entries", "stream=width,height,r_frame_rate", "-of", "json", file], text=True, capture_output=True).stdout
    stream = json.loads(said)["streams"][0]
    raw = subprocess.run(["ffmpeg", "-v", "error", "-i", file, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"], capture_output=True).stdout
    return stream["r_frame_rate"], np.frombuffer(raw, np.uint8).reshape(-1, stream["height"], stream["width"], 3)


@test
def film(report):
    """An MP4 has every step at the rate and size that were asked for (skipped without ffmpeg)."""
    if not shutil.which("ffprobe"):
        print("  skip: there is no ffmpeg")
        return
    results = solve("pictures_thrown", thrown(), 2).results
    file, still = OUT / "pictures it's a film.mp4", OUT / "pictures_still.png"
    small = ("--size", "161x121", "--quality", "draft")
    for old in OUT.glob("pictures_still_*.png"):
        old.unlink()
    code, said = draw("render", results.file.parent, "--animation", file, "--rate", "12.5", *small)
    report.check(code == 0, "the film is made" if code == 0 else said)
    draw("render", results.file.parent, "--steps", "all", "--output", still, *small)
    rate, frames = film_of(file)
    report.check(rate == "25/2", f"{rate} frames a second")
    report.check(frames.shape == (len(results), 122, 162, 3), f"frames x rows x columns: {frames.shape}, sides made even")
    stills = [255 * pixels(png) for png in sorted(OUT.glob("pictures_still_*.png"))]
    worst = max(np.abs(frame[:121, :161] - picture).mean() for frame, picture in zip(frames, stills))
    report.check(len(stills) == len(results), f"{len(stills)} stills")
    report.below(worst, 3, "difference of a frame from its still, of 255")
    report.check(np.abs(stills[0] - stills[-1]).mean() > 6, "which is less than frames differ")


def raised(kind, call):
    """What an exception of that kind says; empty if there is none."""
    try:
        call()
    except kind as error:
        return str(error)
    return ""


@test
def python_package(report):
    """Cases go to TOML and back; a case from a dictionary runs; results and history are arrays; pyvista gets the surface."""
    case = Case.read(ROOT / "runs" / "stages" / "case.toml")
    report.check(Case.from_toml(case.to_toml()) == case, "a case goes to TOML and back")
    changed = case.changed({"mesh.parameters.n": 4, "stage.0.name": "first", "title": None})
    report.check(case["mesh"]["parameters"]["n"] == 36 and changed["mesh"]["parameters"]["n"] == 4 and "title" not in changed, "changes are those of a copy")
    done = run_python(strip("dynamic", time__end=0.1), OUT / "python_strip", ranks=2).check()
    last = done.results[-1]
    report.check(last.positions.shape == last.mesh.positions.shape and last.unit("displacement") == "m", "fields and their units")
    report.check(len(done.history["time"]) == len(done.history) and done.results.history.names == done.history.names, "the history as arrays")
    bad = run_python({"mesh": {"file": "no.msh"}}, OUT / "python_bad")
    try:
        bad.check()
        report.check(False, "check() raises")
    except RuntimeError as error:
        report.check(bad.code == 2 and "voile: error" in str(error), "check() says what the program said")

    refused = run_python(strip("dynamic", time__end=-1.0), OUT / "python_strip")
    try:
        report.check(refused.summary["converged"] is None, "what an earlier run left is not of the one that was refused")
    except FileNotFoundError as error:
        report.check(refused.code == 2 and "of an earlier run" in str(error), "what an earlier run left is not of the one that was refused")
    there = fresh("python_files")
    Case({"mesh": {"file": "m.msh"}, "material": [{"fabric": "cotton_broad"}, {"fabric": "own.toml"}], "obstacle": [{"file": "box.obj"}, {"name": "plane"}],
          "stage": [{"name": "a", "remesh": {"background": "b.pos"}}]}).write(there / "case.toml")
    (there / "own.toml").touch()
    moved, at = Case.read(there / "case.toml"), str(there.resolve())
    report.check([moved["mesh"]["file"], *(m["fabric"] for m in moved["material"]), moved["obstacle"][0]["file"], moved["stage"][0]["remesh"]["background"]] ==
                 [f"{at}/m.msh", "cotton_broad", f"{at}/own.toml", f"{at}/box.obj", f"{at}/b.pos"], "names of files become absolute, those of shipped fabrics stay")

    staged = fresh("python_stages")
    shutil.copytree(OUT / "python_strip", staged / "first")
    try:
        Results(staged)
        report.check(False, "a folder of stages is no result")
    except FileNotFoundError as error:
        report.check("has results of: first" in str(error), f"a folder of stages names them: {error}")

    damaged = fresh("python_damaged") / "results.vtkhdf"
    damaged.parent.mkdir()
    whole = (OUT / "python_strip" / "results.vtkhdf").read_bytes()
    for content in (b"no results", whole[:len(whole) // 2], b""):
        damaged.write_bytes(content)
        report.check(str(damaged) in raised(ValueError, lambda: Results(damaged)), f"a damaged file of {len(content)} bytes is named")
    with h5py.File(damaged, "w") as file:
        file.create_group("voile")
    report.check(str(damaged) in raised(ValueError, lambda: Results(damaged)), "so is one that lacks what it should hold")
    report.check("list of" in raised(IndexError, lambda: done.results[99]) and len(done.results[:2]) == 2, "a place behind the end is named")
    report.check("it has" in raised(KeyError, lambda: last.unit("nosuch")), "a unit of no field says which fields there are")

    class Sheet:
        def __init__(self, points, faces):
            self.points, self.faces, self.point_data, self.cell_data = points, faces, {}, {}

    sys.modules["pyvista"] = type(sys)("pyvista")
    sys.modules["pyvista"].PolyData = Sheet
    sheet = last.to_pyvista()
    del sys.modules["pyvista"]
    report.check(np.array_equal(sheet.faces.reshape(-1, 4)[:, 1:], last.mesh.triangles) and "displacement" in sheet.point_data and "membrane_force" in sheet.cell_data,
                 "pyvista gets points, triangles and fields")
    prefix = fresh("python_installed")
    code = subprocess.run(["cmake", "--install", binary().parent, "--prefix", prefix], capture_output=True).returncode
    package = next(prefix.rglob("voile/results.py"), None)
    report.check(code == 0 and package is not None and shutil.which("voile-picture", path=prefix / "bin"), "cmake --install puts package and programs in place")
    if package:
        done = subprocess.run([sys.executable, "-c", f"import voile; print(len(voile.Results({str(OUT / 'python_strip')!r})))"], cwd=prefix, text=True,
                              env={"PYTHONPATH": str(package.parents[1]), "PATH": os.environ["PATH"]}, capture_output=True)
        report.check(done.stdout.strip() == str(len(Results(OUT / "python_strip"))), "where Python finds it" if done.returncode == 0 else done.stderr)


@test
def exported_times(report):
    """Stages of a motion, exported together, keep the times that they have: steps of another size, and one frame where they meet."""
    support = [{"type": "clamped", "group": "clamp"}]
    case = strip(nx=4, ny=1, support=support) | {"stage": [{"name": "a", "analysis": "static", "steps": {"initial_step": 1.0}},
                                                           {"name": "b", "analysis": "dynamic", "time": {"end": 0.03, "step": 0.01}},
                                                           {"name": "c", "analysis": "dynamic", "time": {"end": 0.05, "step": 0.005}}]}
    del case["analysis"], case["time"]
    result = solve("exported_times", case)
    code, text = invoke(["export", result.folder, "--output", OUT / "exported_times.mdd"])
    data = (OUT / "exported_times.mdd").read_bytes()
    frames = int.from_bytes(data[:4], "big")
    times = np.frombuffer(data[8:8 + 4 * frames], ">f4")
    # Two frames of the path, 1/25 s each before the motion; then 0, 10, 20 ms, and what begins at 30 ms.
    wanted = np.concatenate([[0.0, 0.04], 0.08 + np.concatenate([[0, 0.01, 0.02], 0.03 + 0.005 * np.arange(5)])])
    report.check(code == 0 and frames == len(wanted), f"{frames} frames: {times}")
    report.below(np.abs(times - wanted).max() if frames == len(wanted) else 1.0, 1e-6, "their times")
