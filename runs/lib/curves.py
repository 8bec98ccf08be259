"""Load-deflection curves: reading them and measuring how far they are from published points.

Symbols   lambda  load factor, 1 at the published full load
          d       deflection
          P_i     published point (lambda_i, d_i)
Measure   e_i = distance from P_i to the polyline through the computed points, after dividing loads by the largest published
          load and deflections by the largest published deflection. The polyline starts at the origin.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))

from voile.history import History  # noqa: E402


class Table(History):
    """A table whose faults end a script."""

    def __init__(self, path):
        try:
            super().__init__(path)
        except ValueError as error:
            raise SystemExit(str(error)) from None

    def smallest(self, name):
        """Of the values that exist; inf if there are none (a gap is empty where nothing is near)."""
        return float(np.fmin.reduce(self[name], initial=np.inf))

    def __getitem__(self, name):
        try:
            return super().__getitem__(name)
        except KeyError as error:
            raise SystemExit(error.args[0]) from None


def distances(published, computed):
    """e_i of every published point. Both are arrays of rows (load factor, deflection)."""
    published, computed = np.asarray(published, float), np.asarray(computed, float)
    units = np.abs(published).max(axis=0)
    points = published / units
    line = np.vstack([np.zeros(2), computed / units])
    start, along = line[:-1], np.diff(line, axis=0)
    length2 = np.maximum((along**2).sum(axis=1), 1e-300)
    result = []
    for p in points:
        t = np.clip(((p - start) * along).sum(axis=1) / length2, 0.0, 1.0)
        result.append(np.linalg.norm(start + t[:, None] * along - p, axis=1).min())
    return np.array(result)


def at_load(computed, load):
    """Deflection at a load factor by linear interpolation, where the curve reaches that load last; nan if it never does."""
    line = np.vstack([np.zeros(2), np.asarray(computed, float)])
    for (l0, d0), (l1, d1) in zip(line[-2::-1], line[:0:-1]):
        low, high = min(l0, l1), max(l0, l1)
        slack = 1e-12 * max(1.0, abs(load))
        if low - slack <= load <= high + slack:
            return float(d1 if l1 == l0 else d0 + (d1 - d0) * (load - l0) / (l1 - l0))
    return float("nan")


def limit_loads(curve):
    """Loads at which the load turns along a tabulated curve: extrema of quartics through the five points around each
    turn, over the chord length. Fewer points, at the ends of the table, give lower polynomials."""
    line = np.vstack([np.zeros(2), np.asarray(curve, float)])
    units = np.abs(line).max(axis=0)
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line / units, axis=0), axis=1))])
    loads = line[:, 0]
    turns = [i for i in range(1, len(loads) - 1) if (loads[i] - loads[i - 1]) * (loads[i + 1] - loads[i]) < 0]
    result = []
    for i in turns:
        near = slice(max(i - 2, 0), i + 3)
        law = np.polynomial.Polynomial.fit(s[near], loads[near], len(s[near]) - 1)
        stationary = law.deriv().roots()
        stationary = stationary[np.abs(stationary.imag) < 1e-9].real
        result.append(float(law(stationary[np.argmin(np.abs(stationary - s[i]))])))
    return result


def sampled(published, computed, window=0.15):
    """The computed curve at the places of the published points: for each the nearest point of the polyline that lies as
    far along the path as the published one, give or take `window` (in units of `distances`)."""
    published, computed = np.asarray(published, float), np.asarray(computed, float)
    units = np.abs(published).max(axis=0)
    points, line = published / units, np.vstack([np.zeros(2), computed / units])
    start, along = line[:-1], np.diff(line, axis=0)
    length = np.maximum(np.linalg.norm(along, axis=1), 1e-150)
    begin = np.concatenate([[0.0], np.cumsum(length)])[:-1]
    steps = np.linalg.norm(np.diff(np.vstack([np.zeros(2), points]), axis=0), axis=1)
    place, result = 0.0, []
    for p, step in zip(points, steps):
        t = np.clip(((p - start) * along).sum(axis=1) / length**2, 0.0, 1.0)
        nearest = start + t[:, None] * along
        path = begin + t * length
        far = np.linalg.norm(nearest - p, axis=1) + np.where(np.abs(path - place - step) < window, 0.0, np.inf)
        best = np.argmin(far)
        place = path[best]
        result.append(nearest[best] * units)
    return np.array(result)


def fitted_order(sizes, errors):
    """Slope of log(error) over log(size) by least squares."""
    sizes, errors = np.asarray(sizes, float), np.abs(np.asarray(errors, float))
    usable = errors > 0
    if usable.sum() < 2:
        return float("nan")
    return float(np.polyfit(np.log(sizes[usable]), np.log(errors[usable]), 1)[0])


def observed_order(sizes, values):
    """Order p and limit w of w_h = w + C h^p through the three finest meshes; nan where they do not fit such a law."""
    order = np.argsort(sizes)[:3]
    if len(order) < 3:
        return float("nan"), float("nan")
    (h1, h2, h3), (w1, w2, w3) = np.asarray(sizes, float)[order], np.asarray(values, float)[order]
    if not (w3 - w2) * (w2 - w1) > 0:
        return float("nan"), float("nan")
    target = (w3 - w2) / (w2 - w1)
    ratio = lambda p: (h3**p - h2**p) / (h2**p - h1**p)
    low, high = 0.05, 8.0
    if not ratio(low) < target < ratio(high):
        return float("nan"), float("nan")
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if ratio(middle) < target else (low, middle)
    return low, float(w1 - (w2 - w1) * h1**low / (h2**low - h1**low))
