"""The slit annular plate for CalculiX (https://www.calculix.de): writes a deck of S8R shells, runs ccx, reads the result."""

import math
import re
import shutil
from dataclasses import dataclass
from pathlib import Path

from measure import measure


@dataclass
class CalculixResult:
    elements: str        # e.g. "4x32"
    unknowns: int        # equations that CalculiX solves
    cpu_seconds: float   # user + system of the child process
    wall_seconds: float
    increments: int
    iterations: int
    w_a: float           # at the inner end of the free lip
    w_b: float           # at the outer end


def deck(n_radial, n_circ, first_increment=0.05, largest_increment=0.1):
    """Input deck: S8R, NLGEOM, free lip at angle 0 lifted by a line load, clamped lip at 360 degrees.
    Returns (text, node A, node B). CalculiX picks its increments between these limits; other limits (first 0.025 to 0.1,
    largest 0.05 to 1) changed its time by less than 10 % on 2x16 and 4x32 elements."""
    ri, ro, thickness, young, load = 6.0, 10.0, 0.03, 21e6, 0.8
    number = lambda i, j: 1 + i + j * (2 * n_radial + 1)  # half-cell grid: i along the radius, j along the angle
    # A coordinate of 1e-15 instead of 0 makes ccx 2.20 less exact: -1.30 instead of -0.95 % on 2x16, whatever its tolerance.
    rounded = lambda x: round(x, 9) + 0.0
    nodes, elements = [], []
    for j in range(2 * n_circ + 1):
        angle = 2 * math.pi * j / (2 * n_circ)
        for i in range(2 * n_radial + 1):
            if i % 2 and j % 2:
                continue  # S8R has no node in the middle
            r = ri + (ro - ri) * i / (2 * n_radial)
            nodes.append(f"{number(i, j)}, {rounded(r * math.cos(angle))}, {rounded(r * math.sin(angle))}, 0.")
    for b in range(n_circ):
        for a in range(n_radial):
            i, j = 2 * a, 2 * b
            corners = [(i, j), (i + 2, j), (i + 2, j + 2), (i, j + 2)]
            middles = [(i + 1, j), (i + 2, j + 1), (i + 1, j + 2), (i, j + 1)]
            elements.append(", ".join(str(x) for x in [1 + a + b * n_radial, *(number(*p) for p in corners + middles)]))
    clamped = [number(i, 2 * n_circ) for i in range(2 * n_radial + 1)]
    force = [0.0] * (2 * n_radial + 1)  # consistent with quadratic edges: 1/6, 4/6, 1/6 of the load on each
    for a in range(n_radial):
        for k, share in enumerate((1 / 6, 4 / 6, 1 / 6)):
            force[2 * a + k] += share * load * (ro - ri) / n_radial
    loads = [f"{number(i, 0)}, 3, {f:.15g}" for i, f in enumerate(force)]
    a, b = number(0, 0), number(2 * n_radial, 0)
    return "\n".join([
        "*NODE, NSET=ALL", *nodes,
        "*ELEMENT, TYPE=S8R, ELSET=PLATE", *elements,
        "*NSET, NSET=CLAMPED", *(f"{n}," for n in clamped),
        "*NSET, NSET=ENDS", f"{a}, {b}",
        "*MATERIAL, NAME=M", "*ELASTIC", f"{young:.15g}, 0.",
        "*SHELL SECTION, ELSET=PLATE, MATERIAL=M", f"{thickness}",
        "*BOUNDARY", "CLAMPED, 1, 6",
        "*STEP, NLGEOM, INC=1000", "*STATIC", f"{first_increment}, 1., 1e-6, {largest_increment}",
        "*CLOAD", *loads,
        "*NODE PRINT, NSET=ENDS", "U",
        "*END STEP", ""]), a, b


def run(n_radial, n_circ, folder, **increments):
    """Runs ccx on one thread in `folder`. Returns a CalculixResult; raises SystemExit if ccx fails."""
    program = shutil.which("ccx")
    if not program:
        raise SystemExit("ccx is not installed (Debian: apt-get install calculix-ccx)")
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    name = f"annulus_{n_radial}x{n_circ}"
    for old in folder.glob(f"{name}.*"):
        old.unlink()
    text, a, b = deck(n_radial, n_circ, **increments)
    (folder / f"{name}.inp").write_text(text)
    used = measure([program, name], folder / f"{name}.log", cwd=folder, CCX_NPROC_EQUATION_SOLVER="1")
    log = (folder / f"{name}.log").read_text(errors="replace")
    data = (folder / f"{name}.dat").read_text()
    deflections = {}
    for line in data.splitlines():
        words = line.split()
        if len(words) == 4 and words[0] in (str(a), str(b)):
            deflections[int(words[0])] = float(words[3])  # the last increment stays
    times = re.findall(r"and time +(\S+)", data)
    if used.code != 0 or not times or abs(float(times[-1]) - 1.0) > 1e-6:
        raise SystemExit(f"ccx did not reach full load on {n_radial}x{n_circ} elements; see {folder / name}.log")
    equations = re.findall(r"number of equations\s+(\d+)", log)
    increments = len(re.findall(r"^ *increment +\d+ +attempt", log, re.M))
    iterations = len(re.findall(r"^ *iteration +\d+", log, re.M))
    return CalculixResult(f"{n_radial}x{n_circ}", int(equations[-1]) if equations else 0, used.cpu_seconds,
                          used.wall_seconds, increments, iterations, deflections[a], deflections[b])
