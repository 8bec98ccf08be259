"""The library: programs that are built against what is installed, and simulations in Python's own process."""

import os
import re
import shlex
import subprocess

import numpy as np
from bodies import held
from common import fresh, strip
from harness import OUT, solve, test
from solver import ROOT, binary, environment, write_case

EXAMPLES = ROOT / "runs" / "library"
PACKAGE = binary().parent / "python"


def python(script, *words, ranks=1, cwd=None):
    """Output and code of a script in Debian's Python, with the package of the build."""
    start = ["mpirun", "-n", str(ranks)] if ranks > 1 else []
    env = environment(ranks) | {"PYTHONPATH": str(PACKAGE), "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run([*start, "/usr/bin/python3", str(script), *words], env=env, text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, timeout=300, cwd=cwd)


def has_module(name):
    return python("-c", f"import {name}").returncode == 0


def example(report, name, ranks=(1, 2)):
    if not any(PACKAGE.glob("voile/_core*.so")):
        return report.check(True, "SKIPPED: the binding is not built (packages pybind11-dev, python3-dev)")
    for count in ranks:
        done = python(EXAMPLES / f"{name}.py", ranks=count)
        last = done.stdout.strip().splitlines()[-1] if done.stdout.strip() else ""
        report.check(done.returncode == 0, f"{count} rank(s): {last if done.returncode == 0 else done.stdout[-800:]}")


@test
def library_parametric_study(report):
    """Simulations one after another in one process."""
    example(report, "parametric_study")


@test
def library_bending_stiffness(report):
    """A modulus found from a measured drop."""
    example(report, "bending_stiffness", (1,))


@test
def library_flag(report):
    """Forces by a law of the user's own, step by step."""
    example(report, "flag")


@test
def library_controller(report):
    """An obstacle that is moved by what is measured."""
    example(report, "controller")


@test
def library_newton(report):
    """Newton's method from residual and tangent as objects of petsc4py."""
    if not has_module("petsc4py"):
        return report.check(True, "SKIPPED: petsc4py is not there (package python3-petsc4py)")
    example(report, "newton")


@test
def library_coupling(report):
    """Implicit iterations with a partner whose exact motion is known: save, advance, restore."""
    example(report, "coupling")


SCRIPT = """
import os, subprocess, sys, numpy as np
sys.path.insert(0, {examples!r})
from strip import strip
import voile
from voile import Simulation, UserError
try:
    Simulation(strip("static", nosuch={{}}))
    raise SystemExit("no error")
except UserError as e:
    assert isinstance(e, ValueError) and "nosuch" in str(e), e
s = Simulation(strip("dynamic", time={{"end": 1000.0, "step": 0.01}}))
rows = []
s.observe(lambda step: rows.append(step.time))
saved = s.save()
subprocess.Popen(["sh", "-c", f"sleep 0.5; kill -INT {{os.getpid()}}"])
try:
    s.run()
    raise SystemExit("no interrupt")
except KeyboardInterrupt:
    pass
assert 0 < len(rows) < 99999, rows
s.restore(saved)
assert s.advance().number == 1
rows.pop()
assert voile.__version__[0].isdigit()
assert "[m]" in Simulation.positions.__doc__
history = s.history()
assert len(history["time"]) == 2 and rows
try:
    s.set_forces(np.zeros((2, 3)))
    raise SystemExit("no error")
except UserError:
    pass
try:
    s.set_forces(np.zeros((3, s.vertex_count)))
    raise SystemExit("no error")
except UserError as e:
    assert "n x 3" in str(e)
print("fine")
"""


@test
def library_python(report):
    """Mistakes become exceptions, Ctrl-C ends a run, help() tells units, half of the ranks of mpi4py are enough."""
    if not any(PACKAGE.glob("voile/_core*.so")):
        return report.check(True, "SKIPPED: the binding is not built (packages pybind11-dev, python3-dev)")
    done = python("-c", SCRIPT.format(examples=str(EXAMPLES)))
    report.check(done.returncode == 0 and "fine" in done.stdout, done.stdout[-800:])
    if not has_module("mpi4py"):
        return report.check(True, "SKIPPED: mpi4py is not there (package python3-mpi4py)")
    halves = (f"import sys; sys.path.insert(0, {str(EXAMPLES)!r})\nfrom mpi4py import MPI\nfrom strip import strip\nfrom voile import Simulation\n"
              "half = MPI.COMM_WORLD.rank % 2\ncomm = MPI.COMM_WORLD.Split(half)\n"
              "s = Simulation(strip('static', young=1e7 * (1 + half), load=[{'type': 'gravity', 'vector': [0, 0, -1e-3]}]), comm)\n"
              "assert s.run()\nu = MPI.COMM_WORLD.gather(s.displacements()[s.group('tip'), 2].mean())\n"
              "if u: assert abs(u[0] / u[1] - 2) < 1e-3, u\n")
    done = python("-c", halves, ranks=2)
    report.check(done.returncode == 0, f"two halves: {done.stdout[-800:]}")
    # Where objects lie differs between ranks, and with it any order by their addresses: ended so, ranks wait for each other.
    open_ones = (f"import ctypes, random, sys; sys.path.insert(0, {str(EXAMPLES)!r})\nfrom mpi4py import MPI\nfrom strip import strip\nimport voile\n"
                 "case = strip('static', nx=4, load=[{'type': 'gravity', 'vector': [0, 0, -1e-3]}])\nheap, kept = ctypes.CDLL(None), []\n"
                 "heap.malloc.restype, heap.free.argtypes = ctypes.c_void_p, [ctypes.c_void_p]\n"
                 "for k in range(12):\n    holes = [heap.malloc(size) for size in range(16, 256, 16) for _ in range(40)]\n"
                 "    random.shuffle(holes)\n    for hole in holes[::2]: heap.free(hole)\n"
                 "    kept.append(voile.Simulation(case))\n    kept[-1].run()\n"
                 f"done = voile.run(case, {str(OUT)!r} + f'/of_rank_{{MPI.COMM_WORLD.rank}}')\n"
                 "assert done.code == 0, done.text\n")
    done = python("-c", open_ones, ranks=2)
    report.check(done.returncode == 0, f"simulations that are still there at the end, runs of single ranks: {done.stdout[-800:]}")


FORCES = """
import sys, numpy as np
sys.path.insert(0, {examples!r})
from strip import strip
from voile import Simulation, UserError

def tip(s, total):
    f = np.zeros((s.vertex_count, 3))
    f[s.group("tip"), 2] = total / len(s.group("tip"))
    return f

base = strip("static", nx=6)
stages = {{**{{k: v for k, v in base.items() if k not in ("analysis", "time")}}, "load": [],
          "stage": [{{"name": "a", "analysis": "static"}}, {{"name": "b", "analysis": "modal"}}, {{"name": "c", "analysis": "static"}}]}}
seen = []
s = Simulation(stages)
s.observe(lambda step: seen.append((step.number, step.load_factor, np.abs(s.displacements()).max())))
s.set_forces(tip(s, 0.3))
s.run()
bent = np.abs(s.displacements()).max()
steps = [u for number, load_factor, u in seen if load_factor == 1.0]
assert bent > 0.01 and len(steps) == 2 and all(abs(u / bent - 1) < 1e-6 for u in steps), (bent, seen)

def modes(load_factor, outside):
    c = strip("modal", nx=6)
    c["eigen"] = {{"modes": 2, "load_factor": load_factor}}
    pull = 30.0
    c["load"] = [] if outside else [{{"type": "line", "group": "tip", "vector": [pull / 0.25, 0, 0], "constant": True}}]
    m = Simulation(c)
    if outside:
        f = np.zeros((m.vertex_count, 3))
        for v in m.group("tip"):  # half of the force in the middle, a quarter at each corner
            f[v, 0] = pull / (2 if 0 < m.positions()[v, 1] < 0.25 else 4)
        m.set_forces(f)
    m.run()
    return np.array(m.eigenvalues())

known = modes(0.0, False)
for load_factor in (0.0, 1.0):
    assert np.abs(modes(load_factor, True) / known - 1).max() < 1e-6, (load_factor, modes(load_factor, True), known)

def work(outside):
    c = strip("dynamic", nx=6)
    c["time"] = {{"end": 0.2, "step": 0.005, "spectral_radius": 1.0}}
    c["output"] = {{"energy_balance": True}}
    c["load"] = [] if outside else [{{"type": "point", "group": "tip", "vector": [0, 0, 0.1 / 3], "history": "cos(150*t)"}}]
    m = Simulation(c)
    while not m.finished:
        if outside:
            m.set_forces(tip(m, 0.1 * np.cos(150 * (m.time + 0.005))))
        m.advance()
    e = m.energy()
    return e.loads, e.numerical

key, forces = work(False), work(True)
assert abs(forces[0] / key[0] - 1) < 0.05 and abs(forces[1]) < 0.05 * key[0], (key, forces)

c = strip("drape", nx=6)
c["remesh"] = {{"angle": 8.0}}
try:
    m = Simulation(c)
    m.set_forces(tip(m, 0.3))
    raise SystemExit("forces on a path that is remeshed are taken")
except UserError as e:
    assert "[remesh]" in str(e)
both = {{**{{k: v for k, v in c.items() if k != "analysis"}}, "stage": [{{"name": "a", "analysis": "dynamic", "time": {{"end": 0.02, "step": 0.01}}}}, {{"name": "b", "analysis": "static"}}]}}
m = Simulation(both)
m.set_forces(tip(m, 0.01))
try:
    m.run()
    raise SystemExit("forces are carried into a path that is remeshed")
except UserError as e:
    assert "[remesh]" in str(e) and m.time == 0.02 and not m.finished
m.set_forces([])
assert m.run()
# A stage that cannot begin: nothing crashes afterwards.
wall = {{**stages, "contact": {{"distance": 1e-3}},
        "stage": [{{"name": "a", "analysis": "static"}}, {{"name": "b", "analysis": "static"}}],
        "obstacle": [{{"name": "wall", "type": "sphere", "point": [0.5, 0.125, 0.0], "radius": 0.05, "stages": ["b"]}}]}}
m = Simulation(wall)
for again in (False, True):
    try:
        m.run()
        raise SystemExit("a stage begins within an obstacle")
    except UserError as e:
        assert ("could not begin" in str(e)) == again, e
assert m.finished
m = Simulation(strip("dynamic", nx=6))
m.observe(lambda step: m.close())
try:
    m.run()
    raise SystemExit("closed while it runs")
except UserError as e:
    assert "taking steps" in str(e)
from voile import Case
assert "remesh" not in Case(c).changed({{"remesh.angle": 1}}).changed({{"contact.friction": None}}).get("contact", {{}})
assert "contact" not in Case(c).changed({{"contact.friction": None}})
assert len(Case(c).changed({{"support.0": None}})["support"]) == len(c["support"]) - 1
print("fine")
"""


@test
def library_forces(report):
    """Forces from outside stay through stages, count in modes and energies; the last state of a stage is seen; what cannot be is refused."""
    if not any(PACKAGE.glob("voile/_core*.so")):
        return report.check(True, "SKIPPED: the binding is not built (packages pybind11-dev, python3-dev)")
    for ranks in (1, 2):
        done = python("-c", FORCES.format(examples=str(EXAMPLES)), ranks=ranks)
        report.check(done.returncode == 0 and "fine" in done.stdout, f"{ranks} rank(s): {done.stdout[-800:]}")


SAME = """
import sys, tomllib, numpy as np
from voile import Simulation
s = Simulation(sys.argv[1])
assert s.run(), s.reason
np.savez(sys.argv[2], **s.history())
"""


@test
def library_same_as_program(report):
    """What the program writes and what the library finds are the same to the last digit: an edge held to a body that turns, with friction."""
    if not any(PACKAGE.glob("voile/_core*.so")):
        return report.check(True, "SKIPPED: the binding is not built (packages pybind11-dev, python3-dev)")
    case = held(nx=6, time={"end": 0.1, "step": 0.01})
    case["contact"]["friction"] = 0.3
    whole = solve("library_same", case, 1)
    file = OUT / "library_same.npz"
    done = python("-c", SAME, str(OUT / "library_same.toml"), str(file))
    report.check(done.returncode == 0, done.stdout[-500:])
    own = np.load(file)
    for name in whole.history.names:
        if name != "elapsed" and "seconds" not in name:
            finite = np.where(np.isfinite(own[name]), own[name], np.nan)  # the file leaves others out
            report.check(np.array_equal(finite, whole.history[name], equal_nan=True), name)


@test
def library_page(report):
    """The programs of docs/reference/library.md run as they stand there."""
    page = (ROOT / "docs" / "reference" / "library.md").read_text()
    code = {language: re.search(rf"```{language}\n(.*?)```", page, re.S)[1] for language in ("cpp", "python")}
    report.check(code["cpp"] == (EXAMPLES / "cpp" / "ten.cpp").read_text(), "the C++ program is that of runs/library/cpp")
    if not any(PACKAGE.glob("voile/_core*.so")):
        return report.check(True, "SKIPPED: the binding is not built (packages pybind11-dev, python3-dev)")
    folder = fresh("library_page")
    write_case(strip("dynamic", nx=6), folder / "case.toml")
    done = python("-c", code["python"], cwd=folder)
    report.check(done.returncode == 0 and done.stdout.startswith("0.2 "), done.stdout[-500:])
    report.check([p.name for p in folder.iterdir()] == ["case.toml"], "nothing is written")


@test
def library_without_binding(report):
    """`import voile` works where there is no binding, and says what to do when a simulation is asked for."""
    code = f"import sys; sys.path.insert(0, {str(ROOT / 'python')!r})\nimport voile\ntry:\n    voile.Simulation\nexcept ImportError as e:\n    print(e)"
    done = subprocess.run(["/usr/bin/python3", "-c", code], text=True, capture_output=True)
    report.check("pybind11-dev" in done.stdout, done.stdout + done.stderr)


@test
def library_installed(report):
    """A program of ten lines is built against the installed library by CMake and by pkg-config, and runs; so does Python."""
    prefix, build = fresh("library_prefix"), fresh("library_program")
    done = subprocess.run(["cmake", "--install", binary().parent, "--prefix", prefix], text=True, capture_output=True)
    report.check(done.returncode == 0, f"cmake --install: {done.stderr[-300:]}")
    case = write_case(strip(nx=6), OUT / "library_case.toml")
    made = subprocess.run(f"cmake -S {EXAMPLES / 'cpp'} -B {build} -DCMAKE_PREFIX_PATH={prefix} && cmake --build {build}", shell=True, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    report.check(made.returncode == 0, f"find_package(Voile): {made.stdout[-600:] if made.returncode else 'found'}")
    run = subprocess.run([build / "ten", case], text=True, capture_output=True, env=environment(1))
    report.check(run.returncode == 0 and "load factor 1" in run.stdout, f"it says: {run.stdout}{run.stderr[-500:]}")
    files = list(prefix.rglob("voile.pc"))
    flags = subprocess.run(["pkg-config", "--cflags", "--libs", "voile"], text=True, capture_output=True,
                           env=os.environ | {"PKG_CONFIG_PATH": str(files[0].parent) if files else ""})
    library = next(prefix.rglob("libvoile.so")).parent
    made = subprocess.run(["mpicxx", "-std=c++20", EXAMPLES / "cpp" / "ten.cpp", "-o", build / "by_pkg_config", *shlex.split(flags.stdout),
                           f"-Wl,-rpath,{library}"], text=True, capture_output=True)
    run = subprocess.run([build / "by_pkg_config", case], text=True, capture_output=True, env=environment(1))
    report.check(made.returncode == 0 and run.returncode == 0, f"pkg-config: {flags.stdout.strip()} {made.stderr[-600:]} {run.stdout}")
    files = {str(p.relative_to(prefix)) for p in prefix.rglob("*.hpp")}
    report.check(len(files) <= 12, f"{len(files)} headers are installed")
    package = next(prefix.rglob("voile/__init__.py"), None)
    if package is None or not any(package.parent.glob("_core*.so")):
        return report.check(True, "SKIPPED: the binding is not built")
    done = subprocess.run(["/usr/bin/python3", EXAMPLES / "parametric_study.py"], text=True,
                          capture_output=True, env=environment(1) | {"PYTHONPATH": str(package.parents[1])})
    report.check(done.returncode == 0, f"the installed package: {done.stdout[-300:]}{done.stderr[-300:]}")
