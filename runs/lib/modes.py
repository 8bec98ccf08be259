"""Vibration and buckling: the case files of runs/modal and runs/buckling, their references and mesh series."""

from dataclasses import dataclass

from curves import Table
from ritz import CLAMPED, PANEL, panel_koiter, plate_frequencies, supported_frequencies
from solver import ROOT

import numpy as np


@dataclass(frozen=True)
class ModeProblem:
    name: str
    folder: str        # under runs
    title: str
    column: str        # of modes.csv
    reference: object  # function that returns the values of the modes compared, lowest first
    rigid: int         # modes before the first one compared
    source: str        # in full in the README.md of the folder
    parameters: tuple  # of the .geo at level 0; each level multiplies them by its factor
    factors: tuple = (1, 2, 4)
    published: tuple = ()  # figures in use elsewhere, where they are not the reference

    @property
    def case(self):
        return ROOT / "runs" / self.folder / f"{self.name}.toml"


def clamped_rhombus():
    return plate_frequencies(6, skew=45, left=CLAMPED, right=CLAMPED, bottom=CLAMPED, top=CLAMPED)


RITZ, EXACT, KOITER = "runs/lib/ritz.py, Ritz", "closed form", "runs/lib/ritz.py, Koiter's shell"
N8, PANEL8 = (("n", 8),), (("n_axial", 8), ("n_circ", 8))

MODES = {
    p.name: p
    for p in (
        ModeProblem("vibration_supported", "modal", "Vibration of a simply supported square plate", "frequency_hz",
                    lambda: supported_frequencies(6), 0, EXACT, N8),
        ModeProblem("fv12_free", "modal", "Vibration of a free square plate (FV12)", "frequency_hz",
                    lambda: plate_frequencies(6), 6, RITZ, N8, published=(1.622, 2.360, 2.922, 4.233, 4.233, 7.416)),
        ModeProblem("fv15_rhombic", "modal", "Vibration of a clamped rhombic plate (FV15)", "frequency_hz",
                    clamped_rhombus, 0, RITZ, N8, (1, 2, 4, 8),
                    published=(7.938, 12.835, 17.941, 19.133, 24.009, 27.922)),
        ModeProblem("fv16_cantilever", "modal", "Vibration of a square plate clamped at one edge (FV16)",
                    "frequency_hz", lambda: plate_frequencies(6, left=CLAMPED), 0, RITZ, N8,
                    published=(0.4205, 1.0265, 2.580, 3.291, 3.746, 6.555)),
        ModeProblem("buckling_supported", "buckling", "Buckling of a simply supported square plate",
                    "critical_load_factor", lambda: np.pi**2 * np.array([4.0, 6.25]), 0, EXACT, N8),
        ModeProblem("buckling_panel", "buckling", "Buckling of an axially compressed sector of a cylinder",
                    "critical_load_factor", lambda: panel_koiter(2, **PANEL), 0, KOITER, PANEL8),
    )
}


def computed_modes(problem, result):
    """The values that `reference` is compared with, from a run of the problem's case."""
    values = Table(result.folder / "modes.csv")[problem.column]
    return values[problem.rigid:problem.rigid + len(problem.reference())]
