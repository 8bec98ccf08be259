"""Voile from Python: its results as arrays, its cases as dictionaries, and its runs. Needs NumPy and h5py only.

    from voile import Case, Results, run
"""

from .case import Case
from .history import History
from .results import Mesh, Results, Step
from .running import Run, run

__all__ = ["Case", "History", "Mesh", "Results", "Run", "Step", "run"]
