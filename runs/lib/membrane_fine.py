"""runs/reference/membranes.csv: references of the test set of runs/membranes.

Where there is no series, they come from meshes far finer than those compared, with the six-node membrane: its error falls with
the second power of the cell and is extrapolated from two meshes. What the corrected membrane, treated alike, differs by is the uncertainty.
"""

import math
import shutil

import linear
import membrane_problems
from membrane_cases import OUT
from membrane_problems import ANNULUS_THIN, LINEAR, THIN, Setting, solved
from membrane_references import FILE, series_values
from tables import write_csv

FINE = {  # problem: its case, its quantities and the coarser of two meshes
    "twisted_beam": (lambda *a: membrane_problems.linear_case("twisted_beam", *a), LINEAR["twisted_beam"][3], {"nx": 192, "ny": 16}),
    "hemisphere": (membrane_problems.hemisphere_case, {"pulled_x": 1, "pushed_y": -1}, {"n": 48}),
    "slit_annulus": (membrane_problems.annulus_case, {"A_z": 1, "B_z": 1}, {"n_radial": 12, "n_circ": 120}),
    "pullout_cylinder": (membrane_problems.pullout_case, {"load_factor": 1, "B_x": -1, "C_x": -1}, {"n_axial": 24, "n_circ": 36}),
}
HYPAR = {1e-2: "hypar_100", 1e-3: "hypar_1000", 1e-4: "hypar_10000"}
HEADER = """# Source: computed by runs/membranes --references but for the saddle (Bathe, Iosilevich & Chapelle 2000, see runs/linear/README.md).
# How: series of runs/lib/series.py; von Karman's equations and the drum's characteristic equation, runs/lib/membrane_references.py;
# fine meshes, extrapolated, runs/lib/membrane_fine.py. Uncertainty: from truncation, or between two membranes.
# Thickness over the length that docs/membranes.md names; units are those of the cases.
"""


def final(name, membrane, size, thickness):
    """Quantities at the end of a run, nan if it failed."""
    case_of, columns, _ = FINE[name]
    folder = OUT / "fine"
    folder.parent.mkdir(parents=True, exist_ok=True)
    result = solved(case_of(Setting(membrane, "one way", size, thickness, 1), folder), folder, timeout=1800)
    values = [sign * result.history[c][-1] if result else math.nan for c, sign in columns.items()]
    shutil.rmtree(folder, ignore_errors=True)
    return values


def fine_values(name, thickness):
    """(quantity, value, uncertainty, source) of a problem, from two meshes with two membranes."""
    coarse = FINE[name][2]
    fine = {k: 2 * v for k, v in coarse.items()}
    limits = []
    for membrane in ("six_node", "corrected"):
        low, high = final(name, membrane, coarse, thickness), final(name, membrane, fine, thickness)
        limits.append([b + (b - a) / 3 for a, b in zip(low, high)])
        print(f"{name} {thickness:g} {membrane}: {low} {high}, extrapolated {limits[-1]}", flush=True)
    where = f"meshes {' x '.join(map(str, coarse.values()))} and {' x '.join(map(str, fine.values()))}"
    return [(q, a, abs(a - b), where) for q, a, b in zip(FINE[name][1], *limits)]


def write_references(problems=()):
    """All, or what the file lacks of some problems of FINE."""
    lines = FILE.read_text().splitlines() if problems and FILE.is_file() else []
    rows = [tuple(line.split(",")) for line in lines if not line.startswith(("#", "problem,"))]
    if not problems:
        rows = [(problem, f"{t:g}", q, f"{value:.7g}", f"{unsure:.2g}", source)
                for t in THIN for (problem, q), (value, unsure, source) in series_values(t).items()]
        rows += [("hypar", f"{t:g}", "A_z", f"{linear.LINEAR[name].reference:.7g}", "", "published") for t, name in HYPAR.items()]
    there = {row[:2] for row in rows}
    for name in problems or FINE:
        for t in ANNULUS_THIN if name == "slit_annulus" else THIN:
            if (name, f"{t:g}") not in there:
                rows += [(name, f"{t:g}", q, f"{value:.7g}", f"{unsure:.2g}", how) for q, value, unsure, how in fine_values(name, t)]
                save(rows)
    save(rows)


def save(rows):
    write_csv(FILE, ["problem", "thickness", "quantity", "value", "uncertainty", "how"], sorted(rows, key=lambda r: (r[0], -float(r[1]), r[2])))
    FILE.write_text(HEADER + FILE.read_text())
