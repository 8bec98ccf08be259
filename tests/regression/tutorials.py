"""Each tutorial from an empty folder by its text alone: files are written, commands run, pictures come out."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import PIL.Image
from common import fresh
from harness import test
from solver import ROOT, environment
from voile import Results

PAGES = ROOT / "docs" / "tutorials"


def steps_of(page):
    """The blocks of a page in order: (name of a file, its text) or (None, commands). Output (text blocks without a name) is left out."""
    found, name = [], None
    for match in re.finditer(r"^```(\w+)\n(.*?)^```$|this as `([\w.-]+)`:\n\n(?=```)", page.read_text(), re.M | re.S):
        language, text, file = match.groups()
        if file:
            name = file
        elif name:
            found.append((name, text))
            name = None
        elif language == "sh":
            found.append((None, text))
    return found


def follow(report, name, changes=()):
    """The folder in which a tutorial ends; `changes`: pairs of texts that make its meshes smaller."""
    top = fresh(f"tutorial_{name}")
    top.mkdir(parents=True)
    folder = top
    environ = environment() | {"VOILE_SOURCE": str(ROOT), "PATH": f"{ROOT / 'build'}:{Path(sys.executable).parent}:{os.environ['PATH']}", "PYTHONPATH": str(ROOT / "python")}
    missing = [old for old, _ in changes]
    for file, text in steps_of(PAGES / f"{name}.md"):
        for old, new in changes:
            if old in text:
                text = text.replace(old, new)
                missing = [m for m in missing if m != old]
        if file:
            (folder / file).write_text(text)
            continue
        done = subprocess.run(["bash", "-ec", text], cwd=folder, env=environ, text=True, capture_output=True, timeout=1200)
        report.check(done.returncode == 0, f"{text.splitlines()[0]} ...: code {done.returncode} {done.stderr[-300:] if done.returncode else ''}")
        report.check(bool(changes) or "warning" not in done.stderr, f"{text.splitlines()[0]} ...: no warning on the page's own mesh")
        if entered := re.search(r"^mkdir (\w+) && cd \1$", text.strip()):
            folder = top / entered[1]
    report.check(not missing, f"all changes fit the page{'; not ' + str(missing) if missing else ''}")
    report.check(folder != top, "the page begins with a folder of its own")
    for picture in folder.glob("*.png"):
        with PIL.Image.open(picture) as image:
            report.check(len(image.convert("RGB").getcolors(1 << 24)) > 50, f"{picture.name} shows something")
    return folder


@test
def tutorial_plate(report):
    """Plate with a hole: the stress at the hole and the elongation that the page states."""
    folder = follow(report, "plate-with-hole")
    step = Results(folder / "run")[-1]
    report.near(step["stress_top"][:, 0].max(), 308.2, 3.0, "largest stress [MPa]")
    report.near(Results(folder / "run").history["right_x"][-1], 0.0499, 1e-4, "elongation [mm]")


@test
def tutorial_roof(report):
    """Snap-through: limit loads, and the same roof under a dead load."""
    folder = follow(report, "roof")
    history = Results(folder / "run").history
    loads = history["critical_load_factor"]
    report.near(np.nanmax(loads) * 3000, 582, 6, "first limit load [N]")
    report.near(np.nanmin(loads) * 3000, -386, 6, "second limit load [N]")
    report.near(Results(folder / "load").history["centre_z"][-1], -38.2, 0.4, "centre under 3000 N [mm]")


@test
def tutorial_drape(report):
    """Drape of a measured fabric, with larger cells: it is stable and has a coefficient."""
    folder = follow(report, "drape", [("size = {0.0022", "size = {0.008")])
    sag = -Results(folder / "run")[-1]["displacement"][:, 2].min()
    report.check(0.02 < sag < 0.06, f"the edge sinks by {1000 * sag:.0f} mm")


@test
def tutorial_skirt(report):
    """A skirt from two drawings, with larger cells: sewn, hung on the hips, without an intersection."""
    folder = follow(report, "skirt", [("size = 0.015 ", "size = 0.05 "), ("size = 0.015\n", "size = 0.05\n"), ("--arms 40", "--arms 40 --size 0.04"),
                                      ("--size 480x600", "--size 480x600 --quality draft")])
    for stage in ("sew", "settle"):
        report.check(Results(folder / "run" / stage).history["intersections"].max() == 0, f"{stage}: no intersection")
    x = Results(folder / "run" / "settle")[-1].positions
    report.check(1.0 < x[:, 2].max() < 1.1 and 0.62 < x[:, 2].min() < 0.7, f"it hangs from {x[:, 2].max():.3f} to {x[:, 2].min():.3f} m")


@test
def tutorial_study(report):
    """A study in Python: Peirce's rule finds the stiffness of the case."""
    folder = follow(report, "python-study")
    length, angle = np.loadtxt(folder / "angles.csv", delimiter=",", skiprows=1).T
    report.near((np.interp(41.5, angle, length) / 2000) ** 3 * 0.15 * 9.81 * 1e6, 10.04, 0.1, "D by Peirce's rule [uN m]")
