"""Cases and checks that several groups of tests share."""

import importlib.machinery
import importlib.util
import shutil
import subprocess
import time
import xml.etree.ElementTree as xml

import h5py
import numpy as np
import PIL.Image
from benchmarks import BENCHMARKS
from harness import OUT
from solver import ROOT, command, environment, load_case, variant


def pixels(png):
    """Red, green and blue of a picture, 0 to 1 (rows x columns x 3)."""
    with PIL.Image.open(png) as picture:
        return np.asarray(picture.convert("RGB")) / 255.0


def base(name, **changes):
    return variant(load_case(BENCHMARKS[name].case), {k.replace("__", "."): v for k, v in changes.items()})


def without_stops(case):
    return variant(case, {"steps.stops": None, "output": {"fields": ["displacement"], "every": 1000}})


def strip_case(file, **changes):
    case = variant(load_case(BENCHMARKS["cantilever_shear"].case), {k.replace("__", "."): v for k, v in changes.items()})
    return without_stops(case) | {"mesh": {"file": str(file)}}


def plate(cells, load, final=1.0):
    return {
        "title": "Clamped square plate",
        "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"n": cells}},
        "material": [{"type": "isotropic", "young": 210e9, "poisson": 0.3, "thickness": 0.01}],
        "support": [{"type": "clamped", "group": side} for side in ("left", "right", "bottom", "top")],
        "load": [{"type": "pressure", "magnitude": load}],
        "probe": [{"name": "centre", "type": "displacement", "group": "centre", "components": ["z"]}],
        "steps": {"initial_step": 1.0, "final_load_factor": final},
        "output": {"fields": ["displacement"], "every": 1000},
    }


def check_xdmf(report, file, steps):
    root = xml.parse(file).getroot()
    missing = []
    slabs = {slab[1]: slab for slab in root.iter("DataItem") if slab.get("ItemType") == "HyperSlab"}
    for item in root.iter("DataItem"):
        place, _, name = (item.text or "").strip().partition(":")
        if not name:
            continue
        with h5py.File(file.parent / place, "r") as data:
            have = data[name].shape if name in data else None
        size = tuple(int(n) for n in item.get("Dimensions").split())
        begin, _, count = np.reshape([int(n) for n in slabs[item][0].text.split()], (3, -1)) if item in slabs else (0, 1, size)
        # The dataset may have grown; a slab must end where the item says.
        if have is None or tuple(np.add(begin, count)) != size or size[0] > have[0] or size[1:] != have[1:] or (
                item not in slabs and size != have):
            missing.append(item.text.strip())
    report.check(not missing, f"{file.name} refers to data of the right shape" + (f"; not {missing[:3]}" if missing else ""))
    report.check(len(list(root.iter("Time"))) == steps, f"{file.name} lists every step")


def drape_script(name, folder="drape"):
    """A script of runs/drape as a module; the cases of the tests are the ones it documents."""
    loader = importlib.machinery.SourceFileLoader(f"{folder}_{name}", str(ROOT / "runs" / folder / name))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
    loader.exec_module(module)
    return module


def sheet_on_ball(**changes):
    return variant(load_case(ROOT / "runs" / "contact" / "ball" / "case.toml"), {
        "mesh.parameters.n": 20, "contact.distance": 2e-3, "time.end": 0.25, **{k.replace("__", "."): v for k, v in changes.items()}})


def strip(analysis="static", nx=20, ny=2, **changes):
    """A cantilever strip 10 x 1 x 0.1 under a load at its end."""
    return variant({
        "title": "Strip", "analysis": analysis,
        "mesh": {"file": str(ROOT / "meshes" / "cantilever.geo"), "parameters": {"nx": nx, "ny": ny}},
        "material": [{"type": "isotropic", "young": 1.2e6, "poisson": 0.0, "thickness": 0.1, "density": 100.0}],
        "support": [{"type": "clamped", "group": "clamp"}],
        "load": [{"type": "line", "group": "tip", "vector": [0, 0, 0.4]}],
        "probe": [{"name": "tip", "type": "displacement", "group": "tip"}],
        "time": {"end": 0.2, "step": 0.01},
    }, {k.replace("__", "."): v for k, v in changes.items()})


def fresh(name):
    shutil.rmtree(OUT / name, ignore_errors=True)
    return OUT / name


def started(file, folder, options=(), ranks=1):
    return subprocess.Popen(command(["run", file, "--output", folder, *options], ranks), env=environment(ranks), text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT)


def wait_for(condition, process, seconds=120):
    begin = time.time()
    while process.poll() is None and time.time() - begin < seconds and not condition():
        time.sleep(0.01)
    return process.poll() is None


def lines(file):
    return file.read_text().count("\n") if file.is_file() else 0
