"""The published problems under runs/: which column of history.csv is compared with which published column."""

from dataclasses import dataclass
from pathlib import Path

from curves import Table, at_load, distances

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

    @property
    def case(self):
        return ROOT / "runs" / self.name / "case.toml"

    @property
    def reference(self):
        return Table(ROOT / "runs" / "reference" / f"{self.name}.csv")

    def points(self, curve):
        table = self.reference
        return np.column_stack([table["load_fraction"], table[curve.reference]])


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
    )
}


def computed_points(history, curve):
    """Rows (load factor, deflection with the published sign) of one column of history.csv."""
    name = curve.history
    if name not in history and name.rsplit("_", 1)[0] in history:
        name = name.rsplit("_", 1)[0]
    return np.column_stack([history["load_factor"], curve.sign * history[name]])


@dataclass(frozen=True)
class Comparison:
    curve: Curve
    final: float           # computed deflection at the largest published load
    published: float       # the published one
    ratio: float
    curve_error: float     # largest distance of a published point from the computed curve, see curves.distances


def compare(benchmark, history):
    """One Comparison for each curve of the benchmark."""
    result = []
    for curve in benchmark.curves:
        points, computed = benchmark.points(curve), computed_points(history, curve)
        load, published = points[np.argmax(points[:, 0])]
        final = at_load(computed, load)
        ratio = final / published if published != 0 else float("nan")
        result.append(Comparison(curve, final, published, ratio, float(distances(points, computed).max())))
    return result
