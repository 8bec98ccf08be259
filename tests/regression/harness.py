"""What the regression tests share: the list of tests, assertions, and runs in fresh folders."""

import os
import shutil
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "runs" / "lib"))
sys.path.insert(1, str(Path(__file__).resolve().parents[2] / "runs" / "contact" / "lib"))

from solver import ROOT, run, write_case  # noqa: E402

# Tests that run side by side have a folder each.
OUT = Path(os.environ.get("VOILE_REGRESSION_FOLDER", ROOT / "results" / "regression"))
TESTS = {}


class Failure(Exception):
    pass


def test(function):
    TESTS[function.__name__] = function
    return function


class Report:
    """Collects assertions of one test; all of them are evaluated."""

    def __init__(self):
        self.failures = 0

    def check(self, good, what):
        print(f"  {'ok  ' if good else 'FAIL'} {what}", flush=True)
        self.failures += not good

    def below(self, value, limit, what):
        self.check(abs(value) <= limit, f"{what}: {value:.3g} (limit {limit:g})")

    def near(self, value, expected, tolerance, what):
        self.check(abs(value - expected) <= tolerance, f"{what}: {value:.8g}, expected {expected:g} within {tolerance:g}")

    def percent(self, ratio, limit, what):
        self.check(abs(ratio - 1) <= limit, f"{what}: {100 * (ratio - 1):+.3f} % (limit {100 * limit:g} %)")


def solve(name, case, ranks=1, options=(), timeout=1800):
    """Runs a case (dictionaries) in a fresh folder; any exit code but 0 fails the test."""
    folder = OUT / name
    shutil.rmtree(folder, ignore_errors=True)
    result = run(write_case(case, OUT / f"{name}.toml"), folder, ranks, options, timeout)
    if result.code != 0:
        raise Failure(f"{name} ended with code {result.code}:\n" + "\n".join(result.text.splitlines()[-15:]))
    return result
