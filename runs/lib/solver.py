"""Running the solver from scripts: variants of case files, ranks, time used, and what it left behind."""

import subprocess
import sys
from pathlib import Path

from curves import Table

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))

from voile import Case, Run  # noqa: E402
from voile.running import environment, program  # noqa: E402
from voile.running import run as run_case  # noqa: E402


def binary():
    """The solver to use: VOILE if set, else the Release build."""
    try:
        return program()
    except FileNotFoundError as error:
        raise SystemExit(f"{error}; ./runs/quickstart builds it") from None


def command(arguments, ranks=1):
    start = ["mpirun", "-n", str(ranks)] if ranks > 1 else []
    return start + [str(binary())] + [str(a) for a in arguments]


class Result(Run):
    @property
    def history(self):
        return Table(self.folder / "history.csv")

    def displacement(self, step=-1):
        """Displacements (vertices x 3) of a recorded step; the last one by default."""
        return self.results[step]["displacement"]


def run(case, output, ranks=1, options=(), timeout=3600):
    """Runs a case file. Never raises for a failed run: look at `code`."""
    binary()
    done = run_case(case, output, ranks, options, timeout)
    return Result(output, done.code, done.text, done.wall)


def invoke(arguments, ranks=1, timeout=600):
    """Any other subcommand; returns (exit code, text)."""
    done = subprocess.run(command(arguments, ranks), env=environment(ranks), text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, timeout=timeout)
    return done.returncode, done.stdout


# --------------------------------------------------------------------------------------------- variants of case files

def load_case(path):
    """A case file as nested dictionaries, with the mesh file made absolute."""
    return Case.read(path)


def variant(case, changes):
    """A copy of the case with values replaced. Keys are paths such as "mesh.parameters.n" or "load.0.vector"; the value
    None removes the key."""
    return Case(case).changed(changes)


def to_toml(case):
    return Case(case).to_toml()


def write_case(case, path):
    return Case(case).write(path)
