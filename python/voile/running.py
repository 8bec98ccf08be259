"""Running the solver: the program is $VOILE, else `voile` in the path, else build/voile of the source folder."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from .case import Case
from .history import History
from .results import Results


def program() -> Path:
    """The solver to use; FileNotFoundError if there is none."""
    built = Path(__file__).resolve().parents[2] / "build" / "voile"
    found: str | None = os.environ.get("VOILE") or (str(built) if built.is_file() else shutil.which("voile"))
    if not found or not Path(found).is_file():
        raise FileNotFoundError(f"{found or 'voile'}: the solver is not there; build it, install it, or name it in the variable VOILE")
    return Path(found)


def environment(ranks: int = 2) -> dict[str, str]:
    """One thread per rank, more ranks than cores allowed, and root allowed to start ranks (containers)."""
    env = dict(os.environ)
    if "PMIX_RANK" in env:  # a rank itself: what mpirun sets for it would be taken for this program's
        launcher = ("PMIX_", "OMPI_COMM_", "OMPI_APP_", "OMPI_MCA_ess", "OMPI_MCA_orte_", "OMPI_MCA_pmix")
        env = {name: value for name, value in env.items() if not name.startswith(launcher)}
    env.setdefault("OMP_NUM_THREADS", "1")
    env.setdefault("OMPI_MCA_rmaps_base_oversubscribe", "1")
    env.setdefault("OMPI_MCA_hwloc_base_binding_policy", "none")
    # Waiting ranks would keep a shared core busy. A single rank has nobody to wait for, yet it would yield at every turn and
    # get next to nothing of a busy machine.
    env["OMPI_MCA_mpi_yield_when_idle"] = "1" if ranks > 1 else "0"
    if os.geteuid() == 0:
        env["OMPI_ALLOW_RUN_AS_ROOT"] = env["OMPI_ALLOW_RUN_AS_ROOT_CONFIRM"] = "1"
    return env


class Run:
    """What one run left: exit code, text, seconds and the files of its output folder (read when asked for)."""

    def __init__(self, folder: str | os.PathLike[str], code: int, text: str, wall: float, begin: float = 0.0) -> None:
        self.folder, self.code, self.text, self.wall, self.begin = Path(folder), code, text, wall, begin

    def _own(self, name: str) -> Path:
        """A file of the folder, if this run wrote it: one that was refused leaves what an earlier one did."""
        file = self.folder / name
        if self.code == 2 and file.is_file() and file.stat().st_mtime < self.begin - 0.05:
            raise FileNotFoundError(f"{file} is of an earlier run; this one was refused: {self.text.strip()[-300:]}")
        return file

    @property
    def history(self) -> History:
        return History(self._own("history.csv"))

    @property
    def summary(self) -> dict[str, Any]:
        summary: dict[str, Any] = json.loads(self._own("summary.json").read_text())
        return summary

    @property
    def results(self) -> Results:
        return Results(self._own("results.vtkhdf").parent)

    @property
    def modes(self) -> Results:
        return Results(self._own("modes/results.vtkhdf").parent)

    def stage(self, name: str) -> Run:
        """Of a run in stages."""
        return Run(self.folder / name, self.code, self.text, self.wall, self.begin)

    def check(self) -> Run:
        """Itself; RuntimeError with the last lines that the program wrote unless it has converged."""
        if self.code != 0:
            raise RuntimeError(f"voile ended with code {self.code}:\n" + "\n".join(self.text.splitlines()[-15:]))
        return self


def run(case: Mapping[str, Any] | str | os.PathLike[str], output: str | os.PathLike[str], ranks: int = 1,
        options: Sequence[Any] = (), timeout: float | None = None) -> Run:
    """Runs a case, a dictionary or a file, into a folder, replacing an earlier run there. A failed run raises nothing: look
    at `code`, or call check()."""
    if isinstance(case, Mapping):
        output = Path(output)
        case = Case(case).write(output.parent / f"{output.name}.toml")
    start = ["mpirun", "-n", str(ranks)] if ranks > 1 else []
    words = [*start, program(), "run", case, "--output", output, "--overwrite", *options]
    begin = time.time()
    done = subprocess.run([str(w) for w in words], env=environment(ranks), text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, timeout=timeout)
    return Run(output, done.returncode, done.stdout, time.time() - begin, begin)
