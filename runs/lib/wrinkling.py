"""Round plate that overhangs a disc on which it is clamped, under its own weight: cases, and waves along its outer edge."""

import math

import numpy as np

from cloth import PATTERNS
from curves import Table
from solver import ROOT

REFERENCE = {0.5: (1526.7, 4), 0.6: (3884.9, 5), 0.75: (28954.0, 8)}  # a/R: P_c, waves
POISSON, THICKNESS, YOUNG, DENSITY = 0.3, 1e-3, 1e9, 1000.0
CELLS = {0.5: 32, 0.6: 36, 0.75: 60}  # edges along a quarter of the circumference


def plate_case(inner, factor, cells, pattern):
    """Modes of a plate of radius 1; load factor 1 is the critical load of the reference."""
    bending = YOUNG * THICKNESS**3 / (12 * (1 - POISSON**2))
    weight = REFERENCE[inner][0] * bending * THICKNESS / math.sqrt(12 * (1 - POISSON**2))
    return {
        "analysis": "modal",
        "mesh": {"file": str(ROOT / "meshes" / "disc.geo"),
                 "parameters": {"radius": 1.0, "inner_radius": inner, "n": cells, "pattern": PATTERNS[pattern],
                                "hole": 1}},
        "material": [{"type": "isotropic", "young": YOUNG, "poisson": POISSON, "thickness": THICKNESS, "density": DENSITY}],
        "support": [{"type": "clamped", "group": "inner_edge"}],
        "load": [{"type": "area", "vector": [0, 0, -weight]}],
        "steps": {"fallback": False},
        # Enough to see all negative ones: those nearest to zero are found first.
        "eigen": {"modes": 14, "load_factor": factor},
        "probe": [{"name": "edge", "type": "displacement", "group": "edge", "components": ["z"]}],
    }


class Rim:
    """Fourier coefficients of a displacement along the outer edge."""

    def __init__(self, mesh):
        rest, vertices = mesh.positions, mesh.group("edge")
        angle = np.arctan2(rest[vertices, 1], rest[vertices, 0])
        self.order = vertices[np.argsort(angle)]
        self.angle = np.sort(angle)
        self.even = np.linspace(-np.pi, np.pi, 512, endpoint=False)

    def waves(self, field):
        """Complex amplitudes of cos(n theta) and sin(n theta), n = 0 to 63, of the vertical displacement."""
        along = np.interp(self.even, self.angle, field[self.order, 2], period=2 * np.pi)
        return 2 * np.fft.rfft(along)[:64] / len(along)


def spectrum(result):
    """Lowest omega^2 for each number of waves along the outer edge, the largest Fourier coefficient of a mode."""
    lowest = {}
    rim = Rim(result.modes.mesh())
    waves = [int(np.argmax(np.abs(rim.waves(step["mode"])))) for step in result.modes]
    for value, n in zip(Table(result.folder / "modes.csv")["eigenvalue"], waves):
        lowest[n] = min(value, lowest.get(n, math.inf))
    return lowest
