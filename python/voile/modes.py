"""Modes of two runs, compared."""

from __future__ import annotations

import os

import numpy as np

from .results import Array, Mesh, Results

Modes = Results | str | os.PathLike[str]
OTHER_SHAPE = 0.02  # distance of a vertex from the other mesh, over the extent, at which they still have one shape


def _weights(point: Array, corners: Array) -> Array:
    """Barycentric weights of points of triangles that are near a point, clipped to the triangles; a row each."""
    e, f, r = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], point - corners[:, 0]
    ee, ef, ff = (e * e).sum(1), (e * f).sum(1), (f * f).sum(1)
    er, fr = (e * r).sum(1), (f * r).sum(1)
    determinant = ee * ff - ef**2
    w = np.stack([np.zeros(len(r)), (ff * er - ef * fr) / determinant, (ee * fr - ef * er) / determinant], axis=1)
    w[:, 0] = 1 - w[:, 1] - w[:, 2]
    w = np.maximum(w, 0.0)
    weights: Array = w / w.sum(axis=1, keepdims=True)
    return weights


def _at_points(modes: Array, mesh: Mesh, points: Array) -> Array:
    """Modes at points, linearly in the triangles of their mesh."""
    x, triangles = mesh.positions, mesh.triangles
    around: list[list[int]] = [[] for _ in x]
    for t, corners in enumerate(triangles):
        for v in corners:
            around[v].append(t)
    extent = float(np.linalg.norm(np.ptp(x, axis=0)))
    found = np.empty((len(modes), len(points), 3))
    for p, point in enumerate(points):
        near = triangles[around[int(((x - point) ** 2).sum(axis=1).argmin())]]
        w = _weights(point, x[near])
        away = np.linalg.norm((w[:, :, None] * x[near]).sum(axis=1) - point, axis=1)
        best = int(away.argmin())
        if away[best] > OTHER_SHAPE * extent:
            raise ValueError(f"the two runs have meshes of other shapes: vertices are up to {away[best]:g} m apart")
        found[:, p] = (modes[:, near[best]] * w[best][None, :, None]).sum(axis=1)
    return found


def _products(first: Modes, second: Modes) -> tuple[Array, Array, Array, Array]:
    """a.Mb, Ma.b, a.Ma, b.Mb of all modes a and b."""
    one, two = (r if isinstance(r, Results) else Results(r) for r in (first, second))
    a, b = (np.array([step["mode"] for step in r]) for r in (one, two))
    ma, mb = a, b
    mesh, other = one.mesh(), two.mesh()
    x, y = mesh.positions, other.positions
    if mesh.unit != other.unit:
        raise ValueError(f"{one.file} has lengths in {mesh.unit}, {two.file} in {other.unit}; compare runs of one system of units")
    if np.array_equal(mesh.triangles, other.triangles) and np.allclose(x, y, rtol=0, atol=1e-9 * float(np.ptp(x, axis=0).max())):
        if all("mode_times_mass" in r[0] for r in (one, two)):
            ma, mb = (np.array([step["mode_times_mass"] for step in r]) for r in (one, two))
    else:  # each must lie on the other: a part of a shape is another shape
        a_there, b_here = _at_points(a, mesh, y), _at_points(b, other, x)
        if len(x) <= len(y):
            mb = b = b_here
        else:
            ma = a = a_there
    a, b, ma, mb = (m.reshape(len(m), -1) for m in (a, b, ma, mb))
    return a @ mb.T, ma @ b.T, a @ ma.T, b @ mb.T


def mac(first: Modes, second: Modes) -> Array:
    """Modal assurance criterion, (a.Mb)^2 / (a.Ma b.Mb), of the modes of two runs: a row for each of the first, a column for each
    of the second. M is the mass where both runs have it on the same mesh, else 1. Where meshes differ, the modes of the finer one
    are taken at the vertices of the other. Each run is its folder `modes` (Run.modes), opened or not.
    Source: R.J. Allemang, Sound Vib. 37 (2003) 14-23."""
    cross, back, of_a, of_b = _products(first, second)
    result: Array = cross * back / np.outer(of_a.diagonal(), of_b.diagonal())
    return result


def mac_span(first: Modes, second: Modes, modes: list[int]) -> Array:
    """How much of each mode of the first run lies in the span of some modes of the second, by their numbers from 1: 1 for each of a
    pair with one frequency, whatever basis of their plane either run has found."""
    cross, back, of_a, of_b = _products(first, second)
    chosen = [n - 1 for n in modes]
    c = 0.5 * (cross + back)[:, chosen]
    g = of_b[np.ix_(chosen, chosen)]
    result: Array = (c * np.linalg.solve(g, c.T).T).sum(axis=1) / of_a.diagonal()
    return result
