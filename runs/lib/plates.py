"""Square plates under uniform pressure with known centre deflection w = c q a^4 / D (thin plates, small deflections)."""

import math
from dataclasses import dataclass

from solver import ROOT

SIDE, THICKNESS, POISSON = 1.0, 0.01, 0.3
STIFFNESS = 1.0                       # D
PRESSURE = 2.5e-4                     # deflections of about 1e-4 of the thickness: membrane forces do not matter


def supported():
    """All edges simply supported: Navier's double series (Timoshenko & Woinowsky-Krieger, Theory of Plates and Shells)."""
    odd = range(1, 400, 2)
    return sum(16.0 / math.pi**6 * math.sin(m * math.pi / 2) * math.sin(n * math.pi / 2) / (m * n * (m * m + n * n) ** 2)
               for m in odd for n in odd)


def two_edges_supported(nu=POISSON):
    """Two opposite edges simply supported, two free; Levy's series, with the free-edge conditions
    Y'' - nu alpha^2 Y = 0 and Y''' - (2 - nu) alpha^2 Y' = 0 at the free edges (same book)."""
    total = 0.0
    for m in range(1, 100, 2):
        alpha = m * math.pi
        t = 0.5 * alpha
        particular = 4.0 / (m * math.pi * alpha**4)
        tanh = math.tanh(t)
        # Y = particular + A cosh(alpha y) + B alpha y sinh(alpha y); both conditions divided by cosh(t)
        ratio = ((1 + nu) * tanh - (1 - nu) * t) / ((1 - nu) * tanh)  # A / B
        b = nu * particular / ((ratio * (1 - nu) + 2 + (1 - nu) * t * tanh) * math.cosh(t))
        total += math.sin(m * math.pi / 2) * (particular + ratio * b)
    return total


@dataclass(frozen=True)
class Plate:
    name: str
    label: str
    supports: tuple  # (type, groups)
    exact: float     # c

    def coefficient(self, deflection):
        return deflection * STIFFNESS / (PRESSURE * SIDE**4)


EDGES = ("left", "right", "bottom", "top")
PLATES = (
    # Taylor & Govindjee, Commun. Numer. Meth. Engng 20 (2004) 757-765; a Ritz series of 10 x 10 polynomials
    # (1-x^2)^2 (1-y^2)^2 P_i(x) P_j(y) gives 0.00126531909 as well.
    Plate("clamped", "clamped edges", ("clamped", EDGES), 0.00126531908),
    Plate("supported", "supported edges", ("hinged", EDGES), supported()),
    Plate("free", "two edges free", ("hinged", ("left", "right")), two_edges_supported()),
)


def plate_case(plate, cells, pattern):
    kind, groups = plate.supports
    return {
        "title": f"Square plate, {plate.label}",
        "mesh": {"file": str(ROOT / "meshes" / "plate.geo"), "parameters": {"side": SIDE, "n": cells, "pattern": pattern}},
        "material": [{"type": "isotropic", "young": 12 * (1 - POISSON**2) * STIFFNESS / THICKNESS**3, "poisson": POISSON,
                      "thickness": THICKNESS}],
        "support": [{"type": kind, "group": group} for group in groups],
        "load": [{"type": "pressure", "magnitude": PRESSURE}],
        "steps": {"initial_step": 1.0},
        "probe": [{"name": "centre", "type": "displacement", "group": "centre", "components": ["z"]}],
        "output": {"fields": ["displacement"], "every": 1000},
    }
