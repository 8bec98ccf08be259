"""Voile from Python: its results as arrays, its cases as dictionaries, its runs, and simulations in this process.

    from voile import Case, Results, run
    from voile import Simulation

Results need NumPy and h5py only. Simulation, UserError, InternalError, OutOfMemory and __version__ need the binding voile._core,
which is loaded when one of them is first asked for.
"""

from typing import Any

from .case import Case
from .history import History
from .modes import mac, mac_span
from .results import Mesh, Results, Step
from .running import Run, run

__all__ = ["Case", "History", "Mesh", "Results", "Run", "Step", "mac", "mac_span", "run"]
_IN_PROCESS = ("InternalError", "OutOfMemory", "Simulation", "UserError", "__version__")


def __getattr__(name: str) -> Any:
    if name not in _IN_PROCESS:
        raise AttributeError(f"module 'voile' has no attribute {name!r}")
    try:
        from . import simulation
    except ImportError as error:
        raise ImportError(f"voile.{name} needs the binding voile._core: build Voile with the packages pybind11-dev and python3-dev, "
                          f"and use the package in the folder `python` of the build, or install it ({error})") from error
    return getattr(simulation, name)
