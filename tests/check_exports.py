#!/usr/bin/python3
"""Checks exported files as other programs read them: VTK's readers (in ParaView's Python), Gmsh, Blender and Khronos' glTF validator.

Two small runs, one of them remeshed on the way, are exported in every format; what each program reads is compared with the results:
positions to single precision, triangles, axes, numbers of frames and their times. USD, which none of them reads in Debian 12, is read
by the few lines below. A program that is missing is left out, with a message: packages paraview python3-paraview xvfb, python3-gmsh, blender; nodejs and, from
npm, gltf-validator where node finds it (NODE_PATH).

    tests/check_exports.py
"""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

TESTS = Path(__file__).resolve().parent
sys.path[:0] = [str(TESTS), str(TESTS / "regression"), str(TESTS.parent / "runs" / "lib")]

from check_paraview import Check, paraview  # noqa: E402
from results import Results  # noqa: E402
from solver import ROOT, binary, environment, run, write_case  # noqa: E402

OUT = ROOT / "results" / "check_exports"
PACKAGES = {"vtk": "paraview python3-paraview xvfb", "gmsh": "python3-gmsh", "blender": "blender"}
FPS = 100  # the steps of the run that keeps its mesh are 1/100 s
Y_UP = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])  # x, z, -y of rows


# ---------------------------------------------------------------------------------------------------------------- what is right

class Frame:
    """The sheet at a step, and the bodies after it unless they are left out: the ball, which comes before the floor."""

    def __init__(self, step, bodies=True):
        self.positions, self.triangles, self.time, self.step = step.positions, step.mesh.triangles, step.time, step
        if bodies:
            obstacles = step.results.obstacles
            ball = obstacles["triangles"][obstacles["obstacle"] == 0]
            assert len(np.unique(ball)) == ball.max() + 1
            self.triangles = np.vstack([self.triangles, ball + len(self.positions)])
            self.positions = np.vstack([self.positions, step.obstacles[:ball.max() + 1]])


def same_frame(check, read, key, frame, what, axes=None, vertices=True):
    """Triangles one by one, by where their corners are; and how many vertices there are."""
    if f"{key}/positions" not in read:
        check.good(False, f"{what}: it is there")
        return
    positions, triangles = read[f"{key}/positions"].astype(float), read[f"{key}/triangles"]
    wanted = frame.positions if axes is None else frame.positions @ axes
    check.good(not vertices or len(positions) == len(wanted), f"{what}: {len(positions)} vertices, not {len(wanted)}")
    check.good(triangles.shape == frame.triangles.shape, f"{what}: {len(triangles)} triangles, not {len(frame.triangles)}")
    if triangles.shape == frame.triangles.shape:
        # A position is rounded, and so is a motion that is added to it.
        limit = 2 * np.finfo(np.float32).eps * np.abs(wanted).max()
        away = np.abs(positions[triangles] - wanted[frame.triangles]).max()
        check.good(away <= limit, f"{what}: positions differ by {away:.2g} m, more than {limit:.2g}")


# ----------------------------------------------------------------------------------------------------------------------- exports

def cases():
    from picturing import thrown

    remeshed = thrown()
    remeshed["mesh"]["parameters"] |= {"nx": 9, "ny": 3}
    remeshed["time"] = {"end": 0.2, "step": 0.01}
    remeshed["remesh"] = {"smallest": 0.006, "largest": 0.05, "every": 3, "energy_change": 1.0}
    return {"one_mesh": thrown(), "remeshed": remeshed}


def export(check, folder, file, *words):
    """Files written."""
    done = subprocess.run([binary(), "export", folder, "--output", file, "--rate", str(FPS), *words], env=environment(), text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    check.good(done.returncode == 0, f"{file.name}: {done.stdout}")
    return re.findall(r"^wrote (.*)$", done.stdout, re.M)


def export_all(check, name, results):
    """What readers are told of a run."""
    out = OUT / f"{name}_files"
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    folder, files = results.file.parent, {}
    caches = ("pc2", "mdd") if len(results.epochs) == 1 else ()
    for kind in ("glb", "obj", "stl", "ply", "usda", *caches):
        files[kind] = str(out / f"{kind}.{kind}")
        export(check, folder, Path(files[kind]))
    caches = {kind: str(out / f"{kind}_mesh.obj") for kind in caches}
    return {"files": files, "caches": caches, "times": [s.time for s in results], "msh": export(check, folder, out / "run.msh"),
            "sequence": export(check, folder, out / "sequence.obj", "--steps", "all", "--no-obstacles")}


# ----------------------------------------------------------------------------------------------------------------------- readers

def read_with(check, name, start, job):
    """What a program reads, as arrays by name; None if it fails."""
    file, out = OUT / f"{name}.json", OUT / f"{name}.npz"
    out.unlink(missing_ok=True)
    file.write_text(json.dumps({**job, "out": str(out)}))
    done = subprocess.run([*start, str(file)], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, cwd=OUT,
                          env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})
    check.good(out.is_file(), f"{name}: {done.stdout[-2000:]}")
    return dict(np.load(out)) if out.is_file() else None


def programs():
    """Command of each reader; None where its program is missing."""
    readers = TESTS / "readers"
    gmsh = subprocess.run([sys.executable, "-c", "import gmsh"], capture_output=True).returncode == 0
    return {"vtk": [*paraview(), str(readers / "with_vtk.py")] if paraview() else None,
            "gmsh": [sys.executable, str(readers / "with_gmsh.py")] if gmsh else None,
            "blender": ["blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python", str(readers / "with_blender.py"), "--"]
            if shutil.which("blender") else None}


def check_vtk(check, read, runs):
    for name, results in runs.items():
        for i, step in enumerate(results):
            same_frame(check, read, f"{name}/glb/{i}", Frame(step), f"VTK, {name}, GLB, frame {i}", Y_UP)
            same_frame(check, read, f"{name}/sequence/{i}", Frame(step, False), f"VTK, {name}, OBJ, frame {i}")
        for kind in ("obj", "stl", "ply"):
            same_frame(check, read, f"{name}/{kind}/0", Frame(results[-1]), f"VTK, {name}, {kind}", vertices=kind != "stl")
        check.good(abs(read[f"{name}/glb/times"][-1] - results.times[-1]) < 1e-7, f"VTK, {name}, GLB: the last time")


def check_blender(check, read, runs):
    for name, results in runs.items():
        for i, step in enumerate(results):
            same_frame(check, read, f"{name}/glb/{i}", Frame(step), f"Blender, {name}, GLB, frame {i}")
            for kind in ("pc2", "mdd", "mdd_times", "mdd_shapes") if len(results.epochs) == 1 else ():
                same_frame(check, read, f"{name}/{kind}/{i}", Frame(step, False), f"Blender, {name}, {kind}, frame {i}")
        for kind in ("obj", "stl", "ply"):
            same_frame(check, read, f"{name}/{kind}/0", Frame(results[-1]), f"Blender, {name}, {kind}", vertices=kind != "stl")
        ends = read[f"{name}/glb/frames"] / FPS
        check.good(np.abs(ends - [0, results.times[-1]]).max() < 1e-6, f"Blender, {name}, GLB: from {ends[0]} to {ends[1]} s")


def check_gmsh(check, read, runs):
    for name, results in runs.items():
        steps = list(results)
        for k, epoch in enumerate(results.epochs):
            own, what = [s for s in steps if s.epoch == epoch], f"Gmsh, {name}, mesh {k}"
            mesh = own[0].mesh
            check.same(read.get(f"{name}/msh/{k}/positions", []), mesh.positions, f"{what}: positions")
            check.same(read.get(f"{name}/msh/{k}/triangles", []), mesh.triangles, f"{what}: triangles")
            for (group, dimension), members in mesh.groups.items():
                check.same(read.get(f"{name}/msh/{k}/group/{group}/{dimension}", []), np.sort(members["vertices"]), f"{what}: group {group}")
            for i, step in enumerate(own):
                for field in step.names():
                    check.same(read.get(f"{name}/msh/{k}/field/{field}/{i}", []), step[field], f"{what}, frame {i}: {field}")
                    check.good(abs(read.get(f"{name}/msh/{k}/field/{field}/{i}/time", -1) - step.time) < 1e-12, f"{what}, frame {i}: time of {field}")
        check.good(f"{name}/msh/{len(results.epochs)}/positions" not in read, f"Gmsh, {name}: no more meshes than the run has")


# ------------------------------------------------------------------------------------------------------------------------- glTF

def has_gltf_validator():
    return bool(shutil.which("node")) and subprocess.run(["node", "-e", "require('gltf-validator')"], capture_output=True).returncode == 0


def check_gltf(check, file, name, results):
    """No error and no warning by the rules of glTF 2.0; animated, with as many triangles as were drawn."""
    done = subprocess.run(["node", str(TESTS / "readers" / "with_gltf_validator.js"), file], text=True, capture_output=True)
    check.good(done.returncode == 0, f"glTF validator, {name}: {done.stderr[-300:]}")
    if done.returncode != 0:
        return
    report = json.loads(done.stdout)
    bad = [m for m in report["issues"]["messages"] if m["severity"] <= 1]
    check.good(not bad and not report["issues"]["truncated"], f"glTF validator, {name}: {len(bad)} errors and warnings: {bad[:3]}")
    info = report["info"]
    check.good(info["version"] == "2.0" and info["animationCount"] >= 1 and info["hasMorphTargets"], f"glTF validator, {name}: {info}")
    triangles = sum(len(Frame([s for s in results if s.epoch == epoch][0], False).triangles) for epoch in results.epochs)
    check.good(info["totalTriangleCount"] >= triangles, f"glTF validator, {name}: {info['totalTriangleCount']} triangles, the sheets alone have {triangles}")


# --------------------------------------------------------------------------------------------------------------------------- USD

def usd_samples(prim, name):
    """Values of an attribute by time code: (codes, list of arrays); one without samples is at code 0."""
    number = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
    found = re.search(rf" {name}\.timeSamples = {{(.*?)\n        }}", prim, re.S)
    if not found:
        return [0.0], [np.array(number.findall(re.search(rf" {name} = (.*)", prim)[1]), float)]
    pairs = re.findall(r"^ *(\S+): (\[.*\]),$", found[1], re.M)
    return [float(code) for code, _ in pairs], [np.array(number.findall(values), float) for _, values in pairs]


def check_usd(check, file, name, results):
    """Points and faces held from the code where they are given; codes are seconds times the rate."""
    text, read = Path(file).read_text(), {}
    for what in ("metersPerUnit = 1", 'upAxis = "Z"', f"timeCodesPerSecond = {FPS}", 'defaultPrim = "World"', "startTimeCode = 0"):
        check.good(f"    {what}\n" in text, f"USD, {name}: {what}")
    end = float(re.search(r"endTimeCode = (\S+)", text)[1])
    check.good(abs(end / FPS - results.times[-1]) < 1e-9, f"USD, {name}: it ends at code {end}")
    prims = {m[1]: m[2] for m in re.finditer(r'def Mesh "(\w+)"\n    {(.*?)\n    }', text, re.S)}
    for prim, body in prims.items():
        check.good('subdivisionScheme = "none"' in body, f"USD, {name}: {prim} is not subdivided")
    for i, step in enumerate(results):
        positions, triangles, first = [], [], 0
        for prim in ("sheet", "bodies"):
            x, counts, faces = [held(*usd_samples(prims[prim], attribute), step.time * FPS)
                                for attribute in ("points", "faceVertexCounts", "faceVertexIndices")]
            check.good((counts == 3).all() and 3 * len(counts) == len(faces), f"USD, {name}, {prim}, frame {i}: counts are those of triangles")
            positions.append(x.reshape(-1, 3))
            triangles.append(faces.astype(int).reshape(-1, 3) + first)
            first += len(positions[-1])
        read[f"{i}/positions"], read[f"{i}/triangles"] = np.vstack(positions), np.vstack(triangles)
        same_frame(check, read, str(i), Frame(step), f"USD, {name}, frame {i}")


def held(codes, values, code):
    return values[max(0, np.searchsorted(codes, code + 1e-6, side="right") - 1)]


# -------------------------------------------------------------------------------------------------------------------------- all

def main():
    check, runs, job = Check(), {}, {"fps": FPS, "runs": {}}
    OUT.mkdir(parents=True, exist_ok=True)
    for name, case in cases().items():
        shutil.rmtree(OUT / name, ignore_errors=True)
        done = run(write_case(case, OUT / f"{name}.toml"), OUT / name, 1)
        check.good(done.code == 0, f"{name}: code {done.code}: {done.text[-300:]}")
        runs[name] = Results(OUT / name)
        job["runs"][name] = export_all(check, name, runs[name])
        check_usd(check, job["runs"][name]["files"]["usda"], name, runs[name])
        if has_gltf_validator():
            check_gltf(check, job["runs"][name]["files"]["glb"], name, runs[name])
            cloth = OUT / f"{name}_cloth.glb"
            export(check, OUT / name, cloth, "--cloth", "twill", "--print", "checks:10mm")
            check_gltf(check, cloth, f"{name} as cloth", runs[name])
    check.good(len(runs["remeshed"].epochs) > 1, "a run was remeshed")
    checks, missing = {"vtk": check_vtk, "gmsh": check_gmsh, "blender": check_blender}, []
    if not has_gltf_validator():
        missing.append("glTF validator (package nodejs; npm install gltf-validator)")
    for name, start in programs().items():
        if start is None:
            missing.append(f"{name} (packages {PACKAGES[name]})")
            continue
        read = read_with(check, name, start, job)
        if read is not None:
            checks[name](check, read, runs)
    print(f"{check.compared} comparisons, {check.failures} failures" + (f"; SKIPPED, not installed: {', '.join(missing)}" if missing else ""))
    return 1 if check.failures else 0


if __name__ == "__main__":
    sys.exit(main())
