"""Simulations in this process: a case advanced step by step, with its arrays.

    from voile import Simulation
    s = Simulation("case.toml")
    while not s.finished:
        s.advance()
    print(s.time, s.positions().max(axis=0))

Units are SI. Arrays have one row per vertex, in the order in which the mesh was read, whatever the number of ranks. Under mpirun
all functions are collective over the communicator, and every rank receives the whole arrays.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from . import _core
from ._core import InternalError, OutOfMemory, State, Step, UserError
from .case import Case

__version__ = str(_core.version)
__all__ = ["InternalError", "OutOfMemory", "Simulation", "State", "Step", "UserError"]


def _case(case: Mapping[str, Any] | str | os.PathLike[str], folder: str | os.PathLike[str]) -> _core.Case:
    if isinstance(case, Mapping):
        return _core.Case.parse(Case(case).to_toml(), folder)
    return _core.Case.read(os.fspath(case))


class Simulation(_core.Simulation):
    """A simulation of a case.

    case       a case file, or a dictionary of its sections (voile.Case)
    comm       communicator of mpi4py; None: all ranks
    folder     where files are looked for that a dictionary names
    output     folder of results, as `voile run` writes them; None: nothing is written
    overwrite  an earlier run in that folder may be replaced
    verbose    prints what `voile run` prints
    petsc      options of PETSc for this simulation alone, as on its command line

    UserError, a ValueError, for a case that cannot be run: it names file, key, value and remedy."""

    def __init__(self, case: Mapping[str, Any] | str | os.PathLike[str], comm: Any = None, *, folder: str | os.PathLike[str] = ".",
                 output: str | os.PathLike[str] | None = None, overwrite: bool = False, verbose: bool = False,
                 petsc: str = "") -> None:
        super().__init__(_case(case, folder), comm, "" if output is None else output, overwrite, verbose, petsc)

    def history(self) -> dict[str, Any]:
        """What history.csv of a run has, as an array per column: a row for the start of the stage and for each accepted step."""
        history: dict[str, Any] = self._history()
        return history
