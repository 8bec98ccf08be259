#!/usr/bin/python3
"""Runs that are killed and go on: static, contact, remeshing, sewing; killed early, in the middle and late; on 1 to 3 ranks.

    tests/campaign/restarts.py                      everything, about 10 CPU minutes
    tests/campaign/restarts.py contact sewing       some of it

A run that continues from its checkpoint on one rank, after a run on one rank, must be the unbroken run to the last bit. On
other ranks sums are taken in another order: places must agree to the tolerance of the case, which is named beside it.
Exit code 1 if anything differs.
"""

import argparse
import shutil
import signal
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "regression"), str(ROOT / "runs" / "lib")]

from common import base, sheet_on_ball, started  # noqa: E402
from gathering import ruffle  # noqa: E402
from harness import OUT  # noqa: E402
from results import Results  # noqa: E402
from solver import run, variant, write_case  # noqa: E402

FOLDER = OUT / "campaign"


def sewing():
    case = ruffle(2.0)
    case["stage"] = case["stage"][:1]
    case["stage"][0]["time"] |= {"end": 0.4, "checkpoint_steps": 1}
    return case


def remeshing():
    return variant(sheet_on_ball(), {"time.end": 0.2, "time.checkpoint_steps": 1, "remesh": {"largest": 0.08, "smallest": 0.02}})


# Name: case, stage, distance by which ends may differ on other ranks [m].
CASES = {
    "static": (lambda: base("slit_annulus", mesh__parameters__n_radial=4, mesh__parameters__n_circ=40), None, 1e-6),
    "contact": (lambda: variant(sheet_on_ball(), {"time.end": 0.2, "time.checkpoint_steps": 1}), None, 1e-3),
    "remeshing": (remeshing, None, 1e-2),
    "sewing": (sewing, "sew", 1e-2),  # a ruffle: gathers fold elsewhere
}


def rows(folder):
    """Lines of history.csv by step, without the clock."""
    file = folder / "history.csv"
    lines = [line.split(",") for line in file.read_text().splitlines()] if file.is_file() else []
    lines = lines or [["wall_seconds"]]  # a run that begins
    clock = lines[0].index("wall_seconds")
    return {line[0]: line[:clock] + line[clock + 1:] for line in lines[1:] if len(line) == len(lines[0])}


def end_of(folder):
    """The probes at the end; without one the mean and the spread of all places, which other folds do not change."""
    file = folder / "history.csv"
    names, *_, last = [line.split(",") for line in file.read_text().splitlines()]
    probes = [float(value) for name, value in zip(names, last) if name[-2:] in ("_x", "_y", "_z")]
    if probes:
        return np.array(probes)
    step = Results(folder)[-1]
    places = step.mesh.positions + step["displacement"]
    return np.array([*places.mean(axis=0), *places.std(axis=0)])


def kill_after(file, folder, part, steps, ranks, how):
    shutil.rmtree(folder, ignore_errors=True)
    process = started(file, folder, (), ranks)
    begin = time.time()
    while process.poll() is None and len(rows(folder / part)) <= steps and time.time() - begin < 300:
        time.sleep(0.005)
    alive = process.poll() is None
    if alive:
        process.send_signal(how)
    process.communicate(timeout=120)
    return alive


def check(name):
    make, stage, tolerance = CASES[name]
    part = stage or ""
    file = write_case(make(), FOLDER / f"{name}.toml")
    shutil.rmtree(FOLDER / f"{name}_whole", ignore_errors=True)
    whole = run(file, FOLDER / f"{name}_whole", 1)
    known, end = rows(whole.folder / part), end_of(whole.folder / part)
    print(f"{name}: {len(known)} steps, code {whole.code}", flush=True)
    bad = 0
    for when, fraction in (("early", 0.1), ("middle", 0.5), ("late", 0.9)):
        # mpirun keeps SIGTERM for itself; SIGUSR2 it hands on.
        for before, after in ((1, 1), (1, 2), (2, 3), (3, 1)):
            folder, rest = FOLDER / f"{name}_killed", FOLDER / f"{name}_rest"
            how = signal.SIGTERM if before == 1 else signal.SIGUSR2
            if not kill_after(file, folder, part, int(fraction * len(known)), before, how):
                print(f"  skip {when}, {before} -> {after} ranks: it was over before", flush=True)
                continue
            shutil.rmtree(rest, ignore_errors=True)
            options = ["--restart", folder / part / "checkpoint.h5"] + (["--from", stage] if stage else [])
            done = run(file, rest, after, options)
            good, what = done.code == whole.code, f"code {done.code}"
            if good and before == after == 1:
                later = list(rows(rest / part).items())[1:]
                same = sum(known.get(step) == row for step, row in later)
                good, what = same == len(later) > 0, f"{same} of {len(later)} lines the same to the bit"
            elif good:
                off = np.abs(end_of(rest / part) - end).max()
                good, what = off <= tolerance, f"places differ by {off:.2g} m (limit {tolerance:g})"
            bad += not good
            print(f"  {'ok  ' if good else 'FAIL'} {when}, {before} -> {after} ranks: {what}", flush=True)
    return bad


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="*", help=f"any of {', '.join(CASES)}; all by default")
    names = parser.parse_args().cases or list(CASES)
    FOLDER.mkdir(parents=True, exist_ok=True)
    bad = sum(check(name) for name in names)
    print(f"{bad} differ" if bad else "all as the unbroken runs")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
