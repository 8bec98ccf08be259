"""Strips and annuli whose cells are moved at random."""

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


def annulus_mesh(file, n_radial, n_circ, jitter, seed=1):
    """The slit annulus of meshes/annulus.geo, radii 6 and 10, inner vertices moved at random by up to a share of a cell along and across."""
    rng = np.random.default_rng(seed)
    i, j = (g.astype(float) for g in np.meshgrid(np.arange(n_radial + 1), np.arange(n_circ + 1), indexing="ij"))
    inside = (i > 0) & (i < n_radial) & (j > 0) & (j < n_circ)
    i += inside * rng.uniform(-jitter, jitter, i.shape)
    j += inside * rng.uniform(-jitter, jitter, j.shape)
    r, angle = 6 + 4 * i / n_radial, 2 * np.pi * j / n_circ
    points = np.column_stack([(r * np.cos(angle)).ravel(), (r * np.sin(angle)).ravel(), 0 * r.ravel()])
    at = lambda i, j: i * (n_circ + 1) + j
    cells = []
    for i in range(n_radial):
        for j in range(n_circ):
            a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
            cells += [(a, b, c), (a, c, d)]
    lip = lambda j: [(at(i, j), at(i + 1, j)) for i in range(n_radial)]
    return write_msh(file, points, [("A", 0, [(at(0, 0),)]), ("B", 0, [(at(n_radial, 0),)]), ("free_lip", 1, lip(0)),
                                    ("clamped_lip", 1, lip(n_circ)), ("plate", 2, np.array(cells))])
