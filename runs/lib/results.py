"""Results of a run for scripts in runs/ and tests/: the package in python/voile, which is found from here."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))

from voile.results import NAME, Mesh, Results, Step  # noqa: E402

__all__ = ["NAME", "Mesh", "Results", "Step"]
