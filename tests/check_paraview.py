#!/usr/bin/python3
"""Checks results as others read them: by the rules of VTKHDF 2.0, and in ParaView through its XDMF reader.

    tests/check_paraview.py              solves small cases of every kind and compares all their steps
    tests/check_paraview.py FOLDER ...   compares those of other runs

Without ParaView (packages paraview, python3-paraview and xvfb of Debian 12) that part is skipped, with a message.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "runs" / "lib"))
OUT = ROOT / "results" / "check_paraview"


# ------------------------------------------------------------------------------------------------ inside ParaView's Python

def read_with_paraview(out, files):
    """Everything that ParaView gets from XDMF files, at every time; for pvpython, which has another HDF5 than h5py."""
    from paraview import servermanager, simple
    from vtk.util.numpy_support import vtk_to_numpy

    arrays = {}
    for k, file in enumerate(files):
        reader = simple.XDMFReader(FileNames=[file])
        reader.UpdatePipelineInformation()
        times = list(reader.TimestepValues)
        arrays[f"{k}/times"] = np.array(times)
        for i, time in enumerate(times or [0.0]):
            reader.UpdatePipeline(time)
            grid = servermanager.Fetch(reader)
            arrays[f"{k}/{i}/positions"] = vtk_to_numpy(grid.GetPoints().GetData())
            cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray())
            arrays[f"{k}/{i}/triangles"] = cells.reshape(-1, 3)
            for kind, data in (("vertex", grid.GetPointData()), ("triangle", grid.GetCellData())):
                for n in range(data.GetNumberOfArrays()):
                    if data.GetArray(n) is not None:
                        arrays[f"{k}/{i}/{kind}/{data.GetArrayName(n)}"] = vtk_to_numpy(data.GetArray(n))
        simple.Delete(reader)
    np.savez(out, **arrays)


# ------------------------------------------------------------------------------------------------------------ what is right

def shown(name, values, kind):
    """Name of a field in ParaView."""
    return f"{name}_11_22_12" if kind == "triangle" and values.ndim == 2 and values.shape[1] == 3 else name


def expected(step):
    """Positions, triangles and arrays (by kind and name) of a step as runs/lib/results.py reads it."""
    mesh, arrays = step.mesh, {}
    sizes = {len(mesh.positions): "vertex", len(mesh.triangles): "triangle"}
    for name in step.names():
        values = step[name]
        kind = sizes[len(values)]
        arrays[kind, shown(name, values, kind)] = values
    for (name, dimension), members in mesh.groups.items():
        kind = "triangle" if dimension == 2 else "vertex"
        mask = np.zeros(len(mesh.triangles if dimension == 2 else mesh.positions))
        mask[members["triangles" if dimension == 2 else "vertices"]] = 1
        arrays[kind, f"group:{name}"] = mask
    arrays["vertex", "partition"], arrays["triangle", "partition"] = mesh.partition["vertices"], mesh.partition["triangles"]
    u = step["displacement"] if "displacement" in step else 0.0
    return (mesh.positions + u).astype(np.float32), mesh.triangles, arrays


class Check:
    def __init__(self):
        self.failures = self.compared = 0

    def good(self, good, what):
        self.compared += 1
        if not good:
            self.failures += 1
            print(f"FAIL {what}", flush=True)

    def same(self, got, wanted, what):
        got, wanted = np.asarray(got), np.asarray(wanted)
        good = got.size == wanted.size and np.array_equal(got.reshape(wanted.shape), wanted)
        self.good(good, what + ("" if good else f": {got.shape} instead of {wanted.shape}, or other values"))


# ---------------------------------------------------------------------------------------------------------- VTKHDF 2.0 itself

def assemble(data, i):
    """Step i by the published rules: (time, points, connectivity, offsets, types, arrays by kind and name)."""
    root, steps = data["VTKHDF"], data["VTKHDF/Steps"]
    part, parts = int(steps["PartOffsets"][i]), int(steps["NumberOfParts"][i])
    assert parts == 1
    points, cells, ids = (int(root[f"NumberOf{what}"][part]) for what in ("Points", "Cells", "ConnectivityIds"))
    point, cell, index = int(steps["PointOffsets"][i]), int(steps["CellOffsets"][i, 0]), int(steps["ConnectivityIdOffsets"][i, 0])
    # Offsets holds one value more than cells for each part.
    offsets = root["Offsets"][cell + part:cell + part + cells + 1]
    arrays = {}
    for kind, group, count in (("vertex", "PointData", points), ("triangle", "CellData", cells)):
        for name in root[group]:
            begin = int(steps[f"{group}Offsets"][name][i])
            arrays[kind, name] = root[group][name][begin:begin + count]
    return (float(steps["Values"][i]), root["Points"][point:point + points], root["Connectivity"][index:index + ids], offsets,
            root["Types"][cell:cell + cells], arrays)


def check_rules(check, results):
    import h5py

    name = results.file
    with h5py.File(results.file, "r") as data:
        root = data["VTKHDF"]
        check.good(tuple(root.attrs["Version"]) == (2, 0) and root.attrs["Type"] in (b"UnstructuredGrid", "UnstructuredGrid"), f"{name}: header")
        check.good(root["Offsets"].dtype == root["Connectivity"].dtype, f"{name}: integers of one type")
        check.good(int(root["Steps"].attrs["NSteps"]) == results.named, f"{name}: NSteps")
        parts = root["NumberOfCells"][...]
        check.good(len(root["Offsets"]) == parts.sum() + len(parts) and len(root["Types"]) == parts.sum(), f"{name}: each mesh once")
        for i in range(results.named):
            step, what = results[i], f"{name}, step {results[i].number}"
            time, points, connectivity, offsets, types, arrays = assemble(data, i)
            positions, triangles, wanted = expected(step)
            check.good(time == step.time, f"{what}: time")
            check.same(points, positions, f"{what}: points")
            check.same(connectivity, triangles.ravel(), f"{what}: connectivity")
            check.same(offsets, 3 * np.arange(len(triangles) + 1), f"{what}: offsets")
            check.same(types, np.full(len(triangles), 5), f"{what}: types")
            for (kind, array), values in wanted.items():
                matching = [v for (k, n), v in arrays.items() if k == kind and
                            (n == array or root["PointData" if k == "vertex" else "CellData"][n].attrs["name"] in (array, array.encode()))]
                check.good(any(np.array_equal(v, values) for v in matching), f"{what}: {array}")


# ------------------------------------------------------------------------------------------------------------------- ParaView

def paraview():
    """Command that starts ParaView's Python, or None."""
    if not shutil.which("pvpython"):
        return None
    return (["xvfb-run", "-a"] if shutil.which("xvfb-run") else []) + ["pvpython"]


def check_xdmf(check, folders, start):
    from results import Results

    files = [file for folder in folders for file in (folder / "results.xdmf", folder / "obstacles.xdmf") if file.is_file()]
    with tempfile.TemporaryDirectory() as place:
        out = Path(place) / "read.npz"
        done = subprocess.run([*start, __file__, "--read", str(out), *map(str, files)], text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, cwd="/", env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})
        if not out.is_file():
            check.good(False, f"ParaView: {done.stdout[-2000:]}")
            return
        read = dict(np.load(out))
    for k, file in enumerate(files):
        results = Results(file.parent)
        if file.name == "results.xdmf":
            check_sheet(check, read, f"{k}/", file, results)
        else:
            check_obstacles(check, read, f"{k}/", file, results)


def check_sheet(check, read, key, file, results):
    check.same(read[f"{key}times"], results.times[:results.named], f"{file}: times")
    for i in range(results.named):
        what = f"{file}, step {results[i].number} in ParaView"
        positions, triangles, arrays = expected(results[i])
        check.same(read[f"{key}{i}/positions"], positions, f"{what}: positions")
        check.same(read[f"{key}{i}/triangles"], triangles, f"{what}: triangles")
        for (kind, name), values in arrays.items():
            got = read.get(f"{key}{i}/{kind}/{name}")
            check.good(got is not None, f"{what}: {name} is there")
            if got is not None:
                # A tensor is stored by rows, as VTK has it.
                check.same(got, values, f"{what}: {name}")


def check_obstacles(check, read, key, file, results):
    moving = len(read[f"{key}times"]) > 0
    check.good(not moving or list(read[f"{key}times"]) == results.times[:results.named], f"{file}: times")
    for i in range(results.named if moving else 1):
        what = f"{file}, step {results[i].number} in ParaView"
        check.same(read[f"{key}{i}/positions"], results[i].obstacles, f"{what}: positions")
        check.same(read[f"{key}{i}/triangles"], results.obstacles["triangles"], f"{what}: triangles")
        check.same(read[f"{key}{i}/triangle/obstacle"], results.obstacles["obstacle"], f"{what}: obstacle")


# ----------------------------------------------------------------------------------------------------------------------- runs

def cases():
    from solver import load_case, variant

    strip = {"title": "Strip", "analysis": "static",
             "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"nx": 20, "ny": 2}},
             "material": [{"type": "isotropic", "young": 1.2e6, "poisson": 0.0, "thickness": 0.1, "density": 100.0}],
             "support": [{"type": "clamped", "group": "clamp"}],
             "load": [{"type": "line", "group": "tip", "vector": [0, 0, 0.4]}],
             "output": {"stresses": "surface"}}
    ball = variant(load_case(ROOT / "runs" / "contact" / "ball" / "case.toml"),
                   {"mesh.parameters.n": 10, "contact.distance": 4e-3, "time.end": 0.12})
    for obstacle in ball["obstacle"]:
        obstacle["motion"] = ["0.1*t", "0", "0.2*t"]
    return {"static": strip, "dynamic": variant(strip, {"analysis": "dynamic", "time": {"end": 0.1, "step": 0.01}}),
            "modal": {**strip, "analysis": "modal", "load": [], "eigen": {"modes": 4}}, "contact": ball}


def solve_all(check):
    """Folders of results of every analysis, and of meshes that change, ended and killed."""
    from solver import binary, run, write_case

    folders = []
    for name, case in cases().items():
        shutil.rmtree(OUT / name, ignore_errors=True)
        result = run(write_case(case, OUT / f"{name}.toml"), OUT / name, 2)
        check.good(result.code == 0, f"{name}: code {result.code}: {result.text[-300:]}")
        folders += [OUT / name] + ([OUT / name / "modes"] if name == "modal" else [])
    tests = binary().parent / "unit_tests"
    if not tests.is_file():
        print(f"no {tests}: meshes that change are left out")
        return folders
    sample = OUT / "meshes"
    shutil.rmtree(sample, ignore_errors=True)
    subprocess.run([tests, "-tc=results of three meshes*"], env={**os.environ, "VOILE_SAMPLE_RESULTS": str(sample)}, check=True,
                   stdout=subprocess.DEVNULL)
    return folders + [sample / "ended", sample / "killed"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="*", type=Path, help="folders of results; by default small cases are solved")
    parser.add_argument("--read", metavar="OUT", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.read:
        read_with_paraview(options.read, [str(f) for f in options.folders])
        return 0
    from results import Results

    check = Check()
    OUT.mkdir(parents=True, exist_ok=True)
    folders = [f.resolve() for f in options.folders] or solve_all(check)
    for folder in folders:
        check_rules(check, Results(folder))
    start = paraview()
    if start:
        check_xdmf(check, folders, start)
    print(f"{len(folders)} results, {check.compared} comparisons, {check.failures} failures"
          + ("" if start else "; SKIPPED: ParaView is not installed (packages paraview python3-paraview xvfb)"))
    return 1 if check.failures else 0


if __name__ == "__main__":
    sys.exit(main())
