"""The published problems under runs/: which column of history.csv is compared with which published column."""

from dataclasses import dataclass
from pathlib import Path

from curves import Table, at_load, distances, limit_loads

import numpy as np

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Curve:
    history: str    # column of history.csv
    sign: int       # published = sign * computed
    reference: str  # column of the published table
    label: str


@dataclass(frozen=True)
class Benchmark:
    name: str
    title: str
    load_label: str
    deflection_label: str
    curves: tuple
    source: str = "Sze, Liu & Lo (2004)"
    table: str = ""  # file of the published points, where several problems share one

    @property
    def case(self):
        return ROOT / "runs" / self.name / "case.toml"

    @property
    def reference_file(self):
        return ROOT / "runs" / "reference" / f"{self.table or self.name}.csv"

    @property
    def reference(self):
        return Table(self.reference_file)

    def points(self, curve):
        table = self.reference
        return np.column_stack([table["load_fraction"], table[curve.reference]])


LAYUPS = {"isotropic": "isotropic", "0_90_0": "plies at 0/90/0 degrees", "90_0_90": "plies at 90/0/90 degrees"}

BENCHMARKS = {
    b.name: b
    for b in (
        Benchmark(
            "cantilever_shear", "Cantilever strip under an end shear force", "load / largest load", "tip displacement",
            (Curve("tip_x", -1, "minus_u_tip_s4r", "−u, tip"), Curve("tip_z", 1, "w_tip_s4r", "w, tip")),
        ),
        Benchmark(
            "cantilever_moment", "Cantilever strip rolled into a circle by an end moment", "moment / largest moment",
            "tip displacement",
            (Curve("tip_x", -1, "minus_u_tip", "−u, tip"), Curve("tip_z", 1, "w_tip", "w, tip")), "closed form",
        ),
        Benchmark(
            "slit_annulus", "Slit annular plate lifted at one lip of the slit", "line load / largest load", "deflection",
            (Curve("A_z", 1, "w_a_inner", "w, inner point A"), Curve("B_z", 1, "w_b_outer", "w, outer point B")),
        ),
        Benchmark(
            "hemisphere", "Hemisphere with an 18° hole under four alternating forces", "force / largest force",
            "radial displacement",
            (Curve("pulled_x", 1, "u_outward_point", "pulled point"),
             Curve("pushed_y", -1, "u_inward_point", "pushed point, inward")),
        ),
        Benchmark(
            "pullout_cylinder", "Cylinder with free ends pulled by two forces", "force / largest force", "displacement",
            (Curve("A_z", 1, "w_a", "w, under the force"), Curve("B_x", -1, "minus_u_b", "−u, B"),
             Curve("C_x", -1, "minus_u_c", "−u, C")),
        ),
        Benchmark(
            "pinched_cylinder", "Cylinder with end diaphragms pinched by two forces", "force / largest force",
            "displacement",
            (Curve("A_z", -1, "minus_w_a", "−w, under the force"), Curve("B_x", 1, "u_b", "u, B")),
        ),
        *(Benchmark(
            f"semicylinder_{name}", f"Semi-cylinder pressed at its free end, {label}", "force / largest force",
            "deflection under the force", (Curve("A_z", -1, f"w_{name}", "−w, under the force"),), table="semicylinder",
        ) for name, label in LAYUPS.items()),
        *(Benchmark(
            f"roof_{name}_{thickness}", f"Hinged cylindrical roof, {label}, {thickness} thick", "force / largest force",
            "deflection of the centre", (Curve("C_z", -1, "minus_w_c", "−w, centre"),),
        ) for thickness in ("12.7", "6.35") for name, label in LAYUPS.items()),
    )
}


def column_of(history, curve):
    """Name of its column; a probe of one component may have none in its name."""
    name = curve.history
    return name.rsplit("_", 1)[0] if name not in history and name.rsplit("_", 1)[0] in history else name


def computed_points(history, curve):
    """Rows (load factor, deflection with the published sign) of one column of history.csv."""
    return np.column_stack([history["load_factor"], curve.sign * history[column_of(history, curve)]])


def diagram(benchmark, file, labels=None, legend_of_points=False):
    """What runs/lib/drawing.py draws of a history, and the published points; only these if `file` is None."""
    names = labels or [c.label for c in benchmark.curves]
    source = lambda name: f"{name}: {benchmark.source}" if legend_of_points else ""
    history = Table(file) if file else None
    return {
        "curves": [(file, ("-" if c.sign < 0 else "") + column_of(history, c), "load_factor", name)
                   for c, name in zip(benchmark.curves, names)] if file else [],
        "points": [(benchmark.reference_file, c.reference, "load_fraction", source(name)) for c, name in zip(benchmark.curves, names)],
        "x_label": benchmark.deflection_label, "y_label": benchmark.load_label}


@dataclass(frozen=True)
class Comparison:
    curve: Curve
    final: float           # computed deflection at the largest published load
    published: float       # the published one
    ratio: float
    curve_error: float     # largest distance of a published point from the computed curve, see curves.distances
    limits: tuple = ()     # pairs (computed, published) of the loads at which the curve turns


def computed_limits(history):
    """Loads of the limit points that the solver found and interpolated, in the order of the path."""
    if "critical" not in history:
        return []
    return [float(load) for kind, load in zip(history["critical"], history["critical_load_factor"]) if kind in (1, 3)]


def pair_limits(points, history):
    """Each published limit load with the computed one: in order if there are as many of both, else the nearest."""
    published, found = limit_loads(points), computed_limits(history)
    if len(found) == len(published):
        return tuple(zip(found, published))
    return tuple((min(found, key=lambda x: abs(x - load)), load) for load in published) if found else ()


def compare(benchmark, history):
    """One Comparison for each curve of the benchmark."""
    result = []
    for curve in benchmark.curves:
        points, computed = benchmark.points(curve), computed_points(history, curve)
        load, published = points[-1]
        final = at_load(computed, load)
        ratio = final / published if published != 0 else float("nan")
        result.append(Comparison(curve, final, published, ratio, float(distances(points, computed).max()),
                                 pair_limits(points, history)))
    return result
