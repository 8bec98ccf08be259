"""Running the solver from scripts: variants of case files, ranks, time used, and what it left behind."""

import copy
import json
import os
import subprocess
import time
import tomllib
from pathlib import Path

from curves import Table
from results import Results

ROOT = Path(__file__).resolve().parents[2]


def binary():
    """The solver to use: VOILE if set, else the Release build."""
    path = Path(os.environ.get("VOILE", ROOT / "build" / "voile"))
    if not path.is_file():
        raise SystemExit(f"{path}: the solver is not built yet; run ./runs/quickstart or build it first")
    return path


def environment(ranks=2):
    """One thread per rank, more ranks than cores allowed, and root allowed to start ranks (containers)."""
    env = dict(os.environ)
    env.setdefault("OMP_NUM_THREADS", "1")
    env.setdefault("OMPI_MCA_rmaps_base_oversubscribe", "1")
    env.setdefault("OMPI_MCA_hwloc_base_binding_policy", "none")
    # Waiting ranks would keep a shared core busy. A single rank has nobody to wait for, yet it would yield at every turn and
    # get next to nothing of a busy machine.
    env["OMPI_MCA_mpi_yield_when_idle"] = "1" if ranks > 1 else "0"
    if os.geteuid() == 0:
        env["OMPI_ALLOW_RUN_AS_ROOT"] = env["OMPI_ALLOW_RUN_AS_ROOT_CONFIRM"] = "1"
    return env


def command(arguments, ranks=1):
    start = ["mpirun", "-n", str(ranks)] if ranks > 1 else []
    return start + [str(binary())] + [str(a) for a in arguments]


class Result:
    """What one run left: exit code, text, seconds and the files of its output folder (read when asked for)."""

    def __init__(self, folder, code, text, wall):
        self.folder, self.code, self.text, self.wall = Path(folder), code, text, wall

    @property
    def history(self):
        return Table(self.folder / "history.csv")

    @property
    def summary(self):
        return json.loads((self.folder / "summary.json").read_text())

    @property
    def results(self):
        return Results(self.folder)

    @property
    def modes(self):
        return Results(self.folder / "modes")

    def displacement(self, step=-1):
        """Displacements (vertices x 3) of a recorded step; the last one by default."""
        return self.results[step]["displacement"]


def run(case, output, ranks=1, options=(), timeout=3600):
    """Runs a case file. Never raises for a failed run: look at `code`."""
    begin = time.time()
    done = subprocess.run(command(["run", case, "--output", output, "--overwrite", *options], ranks), env=environment(ranks), text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, timeout=timeout)
    return Result(output, done.returncode, done.stdout, time.time() - begin)


def invoke(arguments, ranks=1, timeout=600):
    """Any other subcommand; returns (exit code, text)."""
    done = subprocess.run(command(arguments, ranks), env=environment(ranks), text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, timeout=timeout)
    return done.returncode, done.stdout


# --------------------------------------------------------------------------------------------- variants of case files

def load_case(path):
    """A case file as nested dictionaries, with the mesh file made absolute."""
    path = Path(path)
    with open(path, "rb") as file:
        case = tomllib.load(file)
    case["mesh"]["file"] = str((path.parent / case["mesh"]["file"]).resolve())
    return case


def variant(case, changes):
    """A copy of the case with values replaced. Keys are paths such as "mesh.parameters.n" or "load.0.vector"; the value
    None removes the key."""
    result = copy.deepcopy(case)
    for path, value in changes.items():
        *parents, last = path.split(".")
        node = result
        for name in parents:
            node = node[int(name)] if isinstance(node, list) else node.setdefault(name, {})
        if value is None:
            node.pop(last, None)
        elif isinstance(node, list):
            node[int(last)] = value
        else:
            node[last] = value
    return result


def _toml_value(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml_value(v) for v in value) + "]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {_toml_value(v)}" for k, v in value.items()) + " }"
    return repr(value)


def to_toml(case):
    """TOML text of a case: plain keys, then one section per table."""
    lines = [f"{k} = {_toml_value(v)}" for k, v in case.items() if not isinstance(v, (dict, list))]
    for name, value in case.items():
        for header, table in (
            [(f"[{name}]", value)] if isinstance(value, dict) else
            [(f"[[{name}]]", entry) for entry in value] if isinstance(value, list) else []
        ):
            lines += ["", header] + [f"{k} = {_toml_value(v)}" for k, v in table.items()]
    return "\n".join(lines) + "\n"


def write_case(case, path):
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(to_toml(case))
    return path
