"""Modes of two runs, compared."""

from __future__ import annotations

import os

import numpy as np

from .results import Array, Results


def _nearest(points: Array, among: Array) -> Array:
    """Number of the nearest of `among` for each point, which must lie within a tenth of the extent."""
    found = np.empty(len(points), dtype=int)
    for first in range(0, len(points), 256):
        part = points[first:first + 256]
        distance = np.linalg.norm(part[:, None, :] - among[None, :, :], axis=2)
        found[first:first + 256] = distance.argmin(axis=1)
    away = float(np.linalg.norm(points - among[found], axis=1).max())
    if away > 0.1 * float(np.ptp(among, axis=0).max()):
        raise ValueError(f"the two runs have meshes of other shapes: vertices are up to {away:g} m apart")
    return found


def mac(first: Results | str | os.PathLike[str], second: Results | str | os.PathLike[str]) -> Array:
    """Modal assurance criterion, |a.b|^2 / (|a|^2 |b|^2), of the modes of two runs: a row for each of the first, a column for each
    of the second. Their meshes may differ: the vertices of the coarser one are compared with the nearest of the other.
    Each is the folder `modes` of a run (Run.modes), opened or not. Source: R.J. Allemang, Sound Vib. 37 (2003) 14-23."""
    one, two = (r if isinstance(r, Results) else Results(r) for r in (first, second))
    a, b = (np.array([step["mode"] for step in r]) for r in (one, two))
    x, y = one.mesh().positions, two.mesh().positions
    if len(x) <= len(y):
        b = b[:, _nearest(x, y)]
    else:
        a = a[:, _nearest(y, x)]
    a, b = a.reshape(len(a), -1), b.reshape(len(b), -1)
    result: Array = (a @ b.T) ** 2 / np.outer((a * a).sum(axis=1), (b * b).sum(axis=1))
    return result
