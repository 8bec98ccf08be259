"""Tables of the test set of runs/membranes: a row for each mesh, columns for membranes and thicknesses."""

import math
from dataclasses import dataclass

from membrane_cases import FABRICS
from membrane_cube import CUBE, stored
from membrane_problems import Setting
from tables import markdown

KINDS = {"one way": "one way", "union jack": "union jack", "random": "at random", "gmsh": "Gmsh"}
FLAT_FACTOR, FLAT_FLOOR = 1.5, 1.0  # errors below the floor [%] count as it


@dataclass(frozen=True)
class Worst:
    """The error of largest size among quantities and seeds, and by how much the seeds of that quantity differ."""
    value: float
    spread: float
    failed: int   # seeds
    seeds: int

    @property
    def size(self):
        return math.inf if self.failed else abs(self.value)

    def __str__(self):
        if self.failed == self.seeds:
            return "-"
        short = lambda x: f"{x:.2f}" if abs(x) < 20 else f"{x:.0f}"
        text = ("+" if self.value >= 0 else "") + short(self.value) + (f" ({short(self.spread)})" if self.seeds - self.failed > 1 else "")
        return text + (f", {self.failed} of {self.seeds} failed" if self.failed else "")


def worst(found, problem, kind, size, thickness, membrane):
    """Of the runs of one mesh; None if they were not made."""
    keys = [Setting(membrane, kind, size, thickness, seed).key for seed in problem.seeds_of(kind, size)]
    runs = [found[k]["values"] for k in keys if k in found]
    if not runs:
        return None
    solved = [r for r in runs if r]
    if not solved:
        return Worst(math.nan, math.nan, len(runs), len(runs))
    value, name = max(((v, q) for r in solved for q, v in r.items()), key=lambda pair: abs(pair[0]))
    of_it = [r[name] for r in solved]
    return Worst(value, max(of_it) - min(of_it), len(runs) - len(solved), len(runs))


def rows_of(name, membranes):
    """(kind, mesh, {(membrane, thickness): Worst}) of every mesh that has been solved."""
    problem, found = CUBE[name], stored(name)
    for kind in problem.kinds:
        for size in problem.sizes:
            cells = {(m, t): w for m in membranes for t in problem.thicknesses
                     if (w := worst(found, problem, kind, size, t, m)) is not None}
            if cells:
                yield kind, " x ".join(str(v) for v in size.values()), cells


def power(thickness):
    return f"{thickness:.0e}".replace("e-0", "e-")


def cube_table(name, membranes):
    problem = CUBE[name]
    columns = [(m, t) for m in membranes for t in problem.thicknesses]
    header = ["mesh", "cells", *(f"`{m}` {power(t)}" if t == problem.thicknesses[0] else power(t) for m, t in columns)]
    return markdown(header, [[KINDS[kind], mesh, *(str(cells.get(c, "")) for c in columns)] for kind, mesh, cells in rows_of(name, membranes)])


def cloth_table(name, membranes):
    """A row for each fabric, mesh and quantity: mean over the seeds, and by how much they differ."""
    problem, found, rows = CUBE[name], stored(name), []
    for number, fabric in enumerate(FABRICS, 1):
        for size in problem.sizes:
            of = {m: [r for seed in (1, 2, 3) if (r := found.get(Setting(m, "gmsh", size, number, seed).key, {}).get("values"))] for m in membranes}
            for quantity in dict.fromkeys(q for runs in of.values() for r in runs for q in r):
                values = {m: [r[quantity] for r in runs] for m, runs in of.items()}
                rows.append([fabric, f"{size['n']} edges", quantity,
                             *(f"{sum(v) / len(v):.0f} ({max(v) - min(v):.0f})" if v else "-" for v in values.values())])
    return markdown(["fabric", "mesh", "quantity", *(f"`{m}`" for m in membranes)], rows)


# ------------------------------------------------------------------------------------------- flat over the thickness

def is_flat(errors):
    """`errors` from thick to thin: the largest is no more than 1.5 times the first, where what is below 1 % counts as 1 %."""
    sizes = [max(e.size, FLAT_FLOOR) for e in errors]
    return max(sizes) <= FLAT_FACTOR * sizes[0]


def flat_table(membranes):
    """How many meshes have an error that is flat over the thickness, by problem and membrane: of the coarse, middle and fine ones."""
    rows = []
    for name, problem in CUBE.items():
        if len(problem.thicknesses) < 2 or name == "cube_cloth":
            continue
        places = [" x ".join(str(v) for v in size.values()) for size in problem.sizes]  # coarse, middle, fine, coarse ...
        counts = {m: [[], [], []] for m in membranes}
        for _, mesh, cells in rows_of(name, membranes):
            for m in membranes:
                errors = [cells.get((m, t)) for t in problem.thicknesses]
                if None not in errors:
                    counts[m][places.index(mesh) % 3].append(is_flat(errors))
        if any(counts[membranes[0]]):
            rows.append([problem.title, *(", ".join(f"{sum(c)} of {len(c)}" if c else "-" for c in counts[m]) for m in membranes)])
    return markdown(["problem", *(f"`{m}`: coarse, middle, fine" for m in membranes)], rows)


# ------------------------------------------------------------------------------------------------- what runs said

def told_counts(name, membrane, limit=5.0):
    """(wrong runs that warned, wrong runs, right runs that warned, right runs); wrong: a deflection is off by more than the limit [%]."""
    runs = [(largest(r), r["warned"]) for r in runs_told(name, membrane)]
    wrong = [warned for error, warned in runs if error > limit]
    right = [warned for error, warned in runs if error <= limit / 2]
    return sum(wrong), len(wrong), sum(right), len(right)


def effectivity(name, membrane, least=2.0):
    """The larger one of a run's two estimates over its error, of errors of at least `least` [%], ascending."""
    return sorted(100 * max(r["estimates"].values()) / largest(r) for r in runs_told(name, membrane) if largest(r) >= least)


def runs_told(name, membrane):
    return [r for key, r in stored(name).items() if key.split("|")[-1] == membrane and r["values"] and r.get("estimates")]


def largest(run):
    return max(abs(v) for v in run["values"].values())


def told_table(membranes):
    """What is missing of a wrong deflection's warning, warnings without need, and how good the estimate is, by problem."""
    rows = []
    for name, problem in CUBE.items():
        if name in ("cube_cloth", "cube_drum", "cube_pinched_path", "cube_pullout", "cube_rolled"):
            continue
        row = [problem.title]
        for m in membranes:
            a, b, c, d = told_counts(name, m)
            ratios = effectivity(name, m)
            good = sum(0.5 <= r <= 2 for r in ratios)
            row += [f"{a} of {b}", f"{c} of {d}", f"{good} of {len(ratios)}, {ratios[len(ratios) // 2]:.2g}" if ratios else "-"]
        if any(runs_told(name, m) for m in membranes):
            rows.append(row)
    header = [text for m in membranes for text in (f"`{m}`: wrong, told", "right, told all the same", "estimate 0.5 to 2 times the error, median")]
    return markdown(["problem", *header], rows) if rows else ""


# --------------------------------------------------------------------------------------------------------- iterations

def iterations_table(membranes):
    """Newton iterations over the runs of which all membranes have them, by problem, where a run needs more than one; with a heading, or nothing."""
    rows = []
    for name, problem in CUBE.items():
        of = [{key.rpartition("|")[0]: r["iterations"] for key, r in stored(name).items() if key.split("|")[-1] == m and r["values"] and r.get("iterations")}
              for m in membranes]
        common = set.intersection(*map(set, of))
        sums = [sum(found[key] for key in common) for found in of]
        if sums[0] > len(common):
            rows.append([problem.title, len(common), *sums])
    if not rows:
        return ""
    return "**Newton iterations**, over the runs that all of them finished.\n\n" + markdown(["problem", "runs", *(f"`{m}`" for m in membranes)], rows) + "\n"
