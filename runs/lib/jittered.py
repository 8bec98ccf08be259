"""Strips whose cells are moved at random."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "contact" / "lib"))

from shapes import write_msh  # noqa: E402


def strip_mesh(file, nx, ny, jitter, split=None, seed=1):
    """A strip of 10 x 1 of nx x ny cells, inner vertices moved at random by up to a share of a cell; `split`: column of vertices
    that is doubled."""
    rng = np.random.default_rng(seed)
    x, y = (g.astype(float) for g in np.meshgrid(np.arange(nx + 1), np.arange(ny + 1), indexing="ij"))
    inside = (x > 0) & (x < nx) & (y > 0) & (y < ny)
    x += inside * rng.uniform(-jitter, jitter, x.shape)
    y += inside * rng.uniform(-jitter, jitter, y.shape)
    points = np.column_stack([(10 * x / nx).ravel(), (y / ny).ravel(), 0 * x.ravel()])
    at = lambda i, j: i * (ny + 1) + j
    double = lambda i, j: len(points) + j if i == split else at(i, j)  # vertices of the cells to the right
    cells = []
    for i in range(nx):
        for j in range(ny):
            a, b, c, d = double(i, j), at(i + 1, j), at(i + 1, j + 1), double(i, j + 1)
            cells += [(a, b, c), (a, c, d)]
    if split is not None:
        points = np.vstack([points, points[[at(split, j) for j in range(ny + 1)]]])
    edge = lambda i: [(at(i, j), at(i, j + 1)) for j in range(ny)]
    return write_msh(file, points, [("clamp", 1, edge(0)), ("tip", 1, edge(nx)), ("plate", 2, np.array(cells))])
