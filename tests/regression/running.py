"""Ranks, the files of a run, exit codes, options, and a run that is killed."""

import re
import shutil
import signal
import subprocess
import time
import xml.etree.ElementTree as xml
from pathlib import Path

import h5py
import numpy as np
from common import base, check_xdmf, fresh, plate, without_stops
from curves import Table
from harness import OUT, solve, test
from results import Results
from solver import ROOT, command, environment, invoke, run, variant, write_case


def compare_ranks(report, name, case, counts=(1, 2, 3, 4), limit=1e-9):
    reference = None
    for ranks in counts:
        result = solve(f"ranks_{name}_{ranks}", case, ranks)
        u = result.displacement()
        if reference is None:
            reference = u
            report.check(np.abs(u).max() > 0, f"{name}: {result.summary['triangles']} triangles, largest displacement "
                                              f"{np.abs(u).max():.6g}")
        else:
            report.check(u.shape == reference.shape, f"{name}, {ranks} ranks: same vertices")
            report.below(np.abs(u - reference).max() / np.abs(reference).max(), limit, f"{name}, {ranks} ranks: difference")


@test
def doctor(report):
    """voile doctor: well on 1 and 2 ranks; without the programs beside it, or where nothing can be written, it names what is wrong."""
    for ranks in (1, 2):
        code, text = invoke(["doctor"], ranks)
        report.check(code == 0 and "FAIL" not in text and "a strip bent into a hook" in text, f"{ranks} ranks: code {code}")
    alone = fresh("doctor_alone")
    alone.mkdir(parents=True)
    shutil.copy(command([])[-1], alone / "voile")
    done = subprocess.run([alone / "voile", "doctor"], env=environment(1), text=True, capture_output=True, timeout=60)
    report.check(done.returncode == 2 and "FAIL  " + str(alone / "voile-picture") in done.stdout and "voile-gmsh" in done.stdout,
                 f"a program alone: code {done.returncode}: {done.stdout[-300:]}")
    done = subprocess.run([*command(["doctor"])], env=environment(1) | {"TMPDIR": str(alone / "voile")}, text=True, capture_output=True, timeout=60)
    report.check(done.returncode == 2 and "TMPDIR" in done.stderr, f"no folder for temporary files: code {done.returncode}: {done.stderr[-200:]}")


@test
def ranks(report):
    """Same displacements to 1e-9: 1 000 triangles far into the nonlinear range on 1 to 4 ranks, 50 000 triangles on 1 and 4."""
    annulus = base("slit_annulus", mesh__parameters__n_radial=7, mesh__parameters__n_circ=72)
    compare_ranks(report, "annulus", without_stops(annulus))
    compare_ranks(report, "plate", plate(158, 2e5), (1, 4))


@test
def files(report):
    """The folder of results holds what the documentation says; the bending stiffness is assembled once."""
    view = OUT / "files.log_view.txt"
    OUT.mkdir(parents=True, exist_ok=True)
    view.unlink(missing_ok=True)
    case = base("hemisphere", mesh__parameters__n=12)
    result = solve("files", case, 2, ["-log_view", f":{view}"])
    for name in ("resolved_case.toml", "results.vtkhdf", "results.xdmf", "history.csv", "summary.json"):
        report.check((result.folder / name).is_file(), f"{name} exists")
    summary = result.summary
    for key in ("unknowns", "vertices", "triangles", "ranks", "steps", "newton_iterations", "factorisations", "cpu_seconds",
                "wall_seconds", "converged", "load_factor"):
        report.check(key in summary, f"summary.json has {key}")
    last = result.results[-1]
    report.check(not (result.folder / "steps").exists(), "steps/ is gone: the results are one file")
    report.check(last.mesh.positions.shape == (summary["vertices"], 3), "positions of all vertices")
    report.check(last.mesh.triangles.shape == (summary["triangles"], 3), "all triangles")
    report.check(last.obstacles.shape == (0, 3), "without obstacles there are none")
    report.check({"load_x", "load_y", "sym_x", "sym_y", "equator", "hole", "shell"} <= {name for name, _ in last.mesh.groups},
                 "groups by name")
    for field in ("displacement", "reaction", "membrane_force", "bending_moment", "curvature"):
        report.check(field in last and np.isfinite(last[field]).all(), f"{field} is there and finite")
    check_xdmf(report, result.folder / "results.xdmf", len(result.results))
    code, text = invoke(["check", result.folder / "resolved_case.toml"])
    report.check(code == 0, "the echoed case is a valid case" + ("" if code == 0 else f": {text.strip()}"))
    match = re.search(r"^VoileBendAssemble\s+(\d+)", view.read_text(), re.M)
    report.check(bool(match) and match.group(1) == "1", "-log_view shows one assembly of the bending stiffness")
    headers = [line for line in result.text.splitlines() if re.match(r"\s*step\b", line)]
    report.check(len(headers) == 1, f"only one rank prints ({len(headers)} header lines)")


@test
def exit_codes(report):
    """2 for the user's mistakes with a message that names them, 3 for no convergence with everything before on disk."""
    good = base("slit_annulus", mesh__parameters__n_radial=2, mesh__parameters__n_circ=16)
    for name, changes, words in (
        ("misspelt_key", {"material.0.yuong": 1.0, "material.0.young": None}, ["yuong", "young"]),
        ("unknown_section", {"meterial": {"young": 1.0}}, ["meterial", "material"]),
        ("unknown_group", {"support.0.group": "clamped_lap"}, ["clamped_lap", "clamped_lip"]),
        ("negative_thickness", {"material.0.thickness": -0.03}, ["thickness"]),
        ("wrong_poisson", {"material.0.poisson": 0.7}, ["poisson"]),
        ("wrong_type", {"material.0.young": "stiff"}, ["young"]),
        ("unknown_parameter", {"mesh.parameters.n_rdial": 3}, ["n_rdial", "n_radial"]),
        ("missing_mesh", {"mesh.file": str(ROOT / "meshes" / "no_such.geo")}, ["no_such.geo"]),
        ("no_material", {"material": []}, ["material"]),
        ("indefinite_stiffness", {"material": [{
            "type": "matrices", "membrane": [[1, 2, 0], [2, 1, 0], [0, 0, 1]], "bending": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
            "direction": [1, 0, 0]}]}, ["membrane"]),
        ("descending_stops", {"steps.stops": [0.5, 0.25]}, ["stops"]),
    ):
        file = write_case(variant(good, changes), OUT / "bad" / f"{name}.toml")
        for ranks in (1, 2) if name in ("misspelt_key", "unknown_group") else (1,):
            code, text = invoke(["check", file], ranks)
            report.check(code == 2, f"{name} on {ranks} rank(s): code {code}")
        missing = [w for w in words if w not in text]
        report.check(not missing, f"{name}: {' '.join(text.split())[:150]}" + (f" [does not name {missing}]" if missing else ""))
    for arguments in (["run", OUT / "no_such.toml"], ["sun"], ["check"], ["run", file, "--outptu", "x"]):
        code, text = invoke(arguments)
        report.check(code == 2, f"voile {' '.join(Path(str(a)).name for a in arguments)}: code {code}")
    for words, hint in ((["run", file, "--outpt", "x"], "did you mean --output?"), (["rum", file], "did you mean run?"),
                        (["render", OUT, "--ouput", "x.png"], "did you mean --output?")):
        code, text = invoke(words)
        report.check(code == 2 and hint in text, f"voile {words[0]} {words[-2]}: code {code}: {text.strip()[:100]}")
    for section in ("support", "load", "probe"):
        code, text = invoke(["check", write_case(variant(good, {f"{section}.0.group": "lft"}), OUT / "bad" / "group.toml")])
        report.check(code == 2 and f"[[{section}]]" in text, f"an unknown group of a {section} is named with its section: {text.strip()[:100]}")
    far = {"probe": [{"name": "far", "type": "displacement", "point": [500.0, 0.0, 0.0]}]}
    code, text = invoke(["check", write_case(variant(good, far), OUT / "bad" / "far.toml")])
    report.check(code == 0 and "away from the sheet" in text, "a probe far outside the sheet is warned of")
    for option in ("-snes_rtol", "-snes_stol", "-ksp_max_it"):
        result = run(write_case(good, OUT / "bad" / "good.toml"), OUT / "negative", 1, [option, "-1"])
        report.check(result.code == 2 and "must not be negative" in result.text, f"{option} -1: code {result.code}")
    for arguments in (["--help"], ["--version"], ["info", ROOT / "meshes" / "annulus.geo"], ["reference"]):
        code, text = invoke(arguments)
        report.check(code == 0 and text.strip() != "", f"voile {' '.join(Path(str(a)).name for a in arguments)}: code {code}")


@test
def not_converged(report):
    """A step that cannot converge and may not shrink ends the run with code 3, with the step before it on disk."""
    case = base("slit_annulus", mesh__parameters__n_radial=2, mesh__parameters__n_circ=16)
    case = variant(case, {"steps": {"initial_step": 1.0, "min_step": 0.9, "stops": [0.001], "fallback": False}})
    for ranks in (1, 2):
        folder = OUT / f"not_converged_{ranks}"
        shutil.rmtree(folder, ignore_errors=True)
        result = run(write_case(case, OUT / "not_converged.toml"), folder, ranks, ["-snes_max_it", "6"], 300)
        report.check(result.code == 3, f"{ranks} rank(s): code {result.code}")
        said = [line for line in result.text.splitlines() if "not converged" in line]
        report.check(bool(said), f"it says so: {said[0][:120] if said else result.text[-300:]}")
        if result.code == 3:
            summary = result.summary
            report.check(summary["converged"] is False and summary["load_factor"] == 0.001, "summary.json says so")
            report.near(result.history["load_factor"][-1], 0.001, 0, "last step in history.csv")
            report.check(np.abs(result.displacement()).max() > 0, "and it is in the results")


@test
def options(report):
    """PETSc's options: the command line beats the case file; unused ones are reported."""
    case = base("cantilever_shear", mesh__parameters__nx=10, mesh__parameters__ny=1, steps__stops=None)
    case["petsc"] = {"options": "-snes_max_it 1"}
    result = solve("options", case, 1, ["-snes_max_it", "40", "-no_such_option", "3"])
    report.check("no_such_option" in result.text, "an unused option is reported")
    code, text = invoke(["run", OUT / "options.toml", "--output", OUT / "options_quiet", "--overwrite", "--quiet", "-snes_max_it",
                         "40"])
    said = "\n".join(line for line in text.splitlines() if "voile" in line)  # other libraries may speak on stderr
    report.check(code == 0 and said == "" and " steps, " not in text, f"--quiet prints nothing: code {code} {text.strip()[:100]}")


@test
def killed(report):
    """kill -9 in mid-run leaves files that can be read, with all steps that history.csv lists."""
    folder = OUT / "killed"
    shutil.rmtree(folder, ignore_errors=True)
    file = write_case(base("hemisphere", mesh__parameters__n=24), OUT / "killed.toml")
    process = subprocess.Popen(command(["run", file, "--output", folder]), env=environment(), stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL)
    try:
        history, begin = folder / "history.csv", time.time()
        while process.poll() is None and time.time() - begin < 300:
            if history.is_file() and history.read_text().count("\n") >= 5:
                break
            time.sleep(0.02)
        running = process.poll() is None
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    report.check(running, "the run was still going when it was killed")
    table = Table(history)
    results = Results(folder)
    report.check(len(results) >= len(table.values) - 1 and len(results) >= 3 and results.named >= 1,
                 f"{len(results)} steps on disk, {results.named} of them in results.vtkhdf, {len(table.values)} in history.csv")
    report.check(all(np.isfinite(step["displacement"]).all() for step in results), "all are readable")
    with h5py.File(folder / "results.vtkhdf", "r") as data:
        points = data["VTKHDF/Points"][...]
        report.check(np.isfinite(points).all() and len(points) == (results.named + 1) * len(results.mesh().positions),
                     "and through the virtual datasets of results.vtkhdf")
    report.check(xml.parse(folder / "results.xdmf").getroot().tag == "Xdmf", "results.xdmf is complete")
